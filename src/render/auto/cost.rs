//! What work costs on an adapter: one line per method, fitted to probe frames and kept in the cache folder.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::fit::{self, Row};
use super::work::{TERMS, Work};
use crate::render::cache;
use crate::skip::Skip;

/// The cost of each unit of a method's [`Work`], in ns; the first, what every frame costs, in ms.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CostLine {
    fixed_ms: f64,
    ns_per_cleared_pixel: f64,
    ns_per_launched_pixel: f64,
    ns_per_sample: f64,
    ns_per_contributing_sample: f64,
    ns_per_skip_step: f64,
    ns_per_fragment: f64,
    ns_per_element: f64,
}

/// The terms of [`Work::terms`] whose costs methods have in common, more or less.
const SHARED: std::ops::Range<usize> = 1..6;

/// What the squared relative distance of a cost from the common one counts beside a frame's squared relative error: a
/// third off weighs as much as one frame of a dozen that is off by a tenth.
const LEANING: f64 = 0.1;

impl CostLine {
    /// What is assumed where nothing was measured: samples and steps cost alike.
    const ASSUMED: Self = Self {
        fixed_ms: 0.1,
        ns_per_cleared_pixel: 1.0,
        ns_per_launched_pixel: 40.0,
        ns_per_sample: 40.0,
        ns_per_contributing_sample: 40.0,
        ns_per_skip_step: 40.0,
        ns_per_fragment: 4.0,
        ns_per_element: 4.0,
    };

    /// The line that fits these frames (work and time in ms) best. `all`, where given, is what frames of all methods have
    /// in common: most methods of a backend share one marcher, and a few probes on a busy machine tell its costs apart
    /// less well than all of them together.
    pub(super) fn fitted(frames: &[(Work, f64)], all: Option<&Self>) -> Self {
        let mut rows: Vec<Row<TERMS>> = frames
            .iter()
            .map(|(work, ms)| Row {
                x: work.terms(),
                y: *ms,
                weight: 1.0,
            })
            .collect();
        for (term, ns) in all
            .into_iter()
            .flat_map(|all| all.costs().into_iter().enumerate())
        {
            // What is common to methods is what pixels and samples cost; a cost of zero leans on nothing.
            if SHARED.contains(&term) && ns > 0.0 {
                let mut x = [0.0; TERMS];
                x[term] = 1.0;
                rows.push(Row {
                    x,
                    y: ns * 1e-6,
                    weight: LEANING,
                });
            }
        }
        let ns = |ms: f64| ms * 1e6;
        let [
            fixed,
            cleared,
            launched,
            samples,
            contributing,
            steps,
            fragments,
            elements,
        ] = fit::non_negative(&rows);
        Self {
            fixed_ms: fixed,
            ns_per_cleared_pixel: ns(cleared),
            ns_per_launched_pixel: ns(launched),
            ns_per_sample: ns(samples),
            ns_per_contributing_sample: ns(contributing),
            ns_per_skip_step: ns(steps),
            ns_per_fragment: ns(fragments),
            ns_per_element: ns(elements),
        }
    }

    fn costs(&self) -> [f64; TERMS] {
        [
            self.fixed_ms * 1e6,
            self.ns_per_cleared_pixel,
            self.ns_per_launched_pixel,
            self.ns_per_sample,
            self.ns_per_contributing_sample,
            self.ns_per_skip_step,
            self.ns_per_fragment,
            self.ns_per_element,
        ]
    }

    /// What this work takes, in ms.
    pub(super) fn ms(&self, work: &Work) -> f64 {
        let terms = work.terms();
        terms
            .iter()
            .zip(self.costs())
            .map(|(n, ns)| n * ns)
            .sum::<f64>()
            * 1e-6
    }

    fn is_sound(&self) -> bool {
        let costs = self.costs();
        costs.iter().all(|c| c.is_finite() && *c >= 0.0) && costs.iter().any(|c| *c > 0.0)
    }
}

/// The cost lines of an adapter, by method.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub(super) struct Calibration {
    lines: BTreeMap<String, CostLine>,
}

impl Calibration {
    /// The lines that fit each method's frames (work and time in ms).
    pub(super) fn fitted(methods: &[Skip], frames: &[Vec<(Work, f64)>]) -> Self {
        let all = CostLine::fitted(&frames.concat(), None);
        let lines = methods.iter().zip(frames);
        Self::new(lines.map(|(&skip, frames)| (skip, CostLine::fitted(frames, Some(&all)))))
    }

    fn new(lines: impl IntoIterator<Item = (Skip, CostLine)>) -> Self {
        let lines = lines.into_iter();
        Self {
            lines: lines
                .map(|(s, l)| (s.method().name.to_owned(), l))
                .collect(),
        }
    }

    /// What is assumed of every method where nothing was measured.
    pub(super) fn assumed() -> Self {
        Self::default()
    }

    pub(super) fn line(&self, skip: Skip) -> CostLine {
        let line = self.lines.get(skip.method().name);
        line.copied().unwrap_or(CostLine::ASSUMED)
    }

    /// What a cut of k-cuts costs, in samples on every pixel: two layers of depth to clear, and one more segment. `None`
    /// where the probes told nothing of it.
    pub(super) fn cut_samples(&self) -> Option<f64> {
        let line = self.lines.get(Skip::KCuts.method().name)?;
        let cut = 2.0 * line.ns_per_cleared_pixel + line.ns_per_skip_step;
        let samples = cut / line.ns_per_sample;
        // Noise in the probes is not to forbid cuts, nor to give them away.
        samples.is_finite().then(|| samples.clamp(0.5, 32.0))
    }

    /// Whether it has a sound line for each of these methods.
    fn serves(&self, methods: &[Skip]) -> bool {
        methods.iter().all(|skip| {
            let line = self.lines.get(skip.method().name);
            line.is_some_and(CostLine::is_sound)
        })
    }
}

/// Calibrations by what they hold for.
type Kept = BTreeMap<String, Calibration>;

/// What the cache holds for `key`, or what `measure` finds, which is then kept.
///
/// # Errors
/// Those of `measure`.
pub(super) fn kept_or<E>(
    path: Option<&Path>,
    key: &str,
    methods: &[Skip],
    measure: impl FnOnce() -> Result<Calibration, E>,
) -> Result<Calibration, E> {
    let read = || -> Kept { path.map(cache::read).unwrap_or_default() };
    if let Some(kept) = read().remove(key).filter(|k| k.serves(methods)) {
        return Ok(kept);
    }
    let measured = measure()?;
    if let Some(path) = path {
        // Read again: another process may have kept its own meanwhile.
        let mut all = read();
        all.insert(key.to_owned(), measured.clone());
        cache::write(path, &all);
    }
    Ok(measured)
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;
    use std::fs;

    use super::*;

    fn some() -> Calibration {
        Calibration::new([
            (Skip::Box, CostLine::ASSUMED),
            (Skip::Hull, CostLine::ASSUMED),
        ])
    }

    const METHODS: [Skip; 2] = [Skip::Box, Skip::Hull];

    /// Whether a file of this text is replaced by what is measured, which is then read back.
    fn is_rebuilt(text: &str) -> bool {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("deeper").join("calibration.json");
        fs::create_dir(path.parent().unwrap()).unwrap();
        fs::write(&path, text).unwrap();
        let mut measured = 0;
        let mut ask = || {
            kept_or(Some(&path), "this", &METHODS, || {
                measured += 1;
                Ok::<_, Infallible>(some())
            })
            .unwrap()
        };
        let _ = ask();
        assert_eq!(ask(), some());
        assert!(measured <= 1, "what was measured is kept");
        assert_eq!(fs::read_dir(path.parent().unwrap()).unwrap().count(), 1);
        measured == 1
    }

    #[test]
    fn what_is_no_calibration_is_measured_anew() {
        let scratch = tempfile::tempdir().unwrap();
        let scratch = scratch.path().join("calibration.json");
        cache::write(&scratch, &BTreeMap::from([("this", some())]));
        let whole = fs::read_to_string(scratch).unwrap();
        assert!(!is_rebuilt(&whole));
        for broken in [
            "",
            "no JSON",
            "[1, 2]",
            "{\"this\": {}}",
            "{\"this\": {\"box\": 3}}",
            &whole[..whole.len() / 2],
            &whole.replace("hull", "hulk"),
            &whole.replace("40.0", "-40.0"),
            &whole.replace("40.0", "1e999"),
            &whole.replace("ns_per_sample", "ns_per_example"),
            &whole.replace("this", "another adapter"),
        ] {
            assert!(is_rebuilt(broken), "{broken}");
        }
    }

    #[test]
    fn calibrations_of_other_adapters_stay() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("calibration.json");
        for key in ["one", "another"] {
            kept_or(Some(&path), key, &METHODS, || Ok::<_, Infallible>(some())).unwrap();
        }
        let kept: Kept = cache::read(&path);
        assert_eq!(kept.keys().collect::<Vec<_>>(), ["another", "one"]);
    }

    #[test]
    fn a_cache_that_cannot_be_written_is_no_error() {
        let path = Path::new("/proc/none/calibration.json");
        let measured = kept_or(Some(path), "this", &METHODS, || Ok::<_, Infallible>(some()));
        assert_eq!(measured.unwrap(), some());
        assert_eq!(
            kept_or(None, "this", &METHODS, || Ok::<_, Infallible>(some())).unwrap(),
            some()
        );
    }

    #[test]
    fn a_fitted_line_tells_the_frames_it_was_fitted_to() {
        let frame = |n: f64| Work {
            cleared: 100.0 * n,
            launched: 60.0 * n,
            samples: 900.0 * n * n,
            contributing: 30.0 * n,
            steps: 5.0 * n * n * n,
            ..Work::default()
        };
        let frames: Vec<(Work, f64)> = (1..12)
            .map(|n| {
                (
                    frame(f64::from(n)),
                    CostLine::ASSUMED.ms(&frame(f64::from(n))),
                )
            })
            .collect();
        let line = CostLine::fitted(&frames, None);
        assert!(line.is_sound());
        for (work, ms) in &frames {
            assert!((line.ms(work) / ms - 1.0).abs() < 0.02);
        }
    }

    /// Costs that a method's own frames do not tell are those of all; what they do tell stands.
    #[test]
    fn a_line_leans_on_what_methods_have_in_common() {
        let all = CostLine::ASSUMED;
        let dear = CostLine {
            ns_per_sample: 3.0 * all.ns_per_sample,
            ..all
        };
        let frames: Vec<(Work, f64)> = (1..12)
            .map(|n| {
                let n = f64::from(n);
                // Pixels and steps go together: which of the two costs cannot be told.
                let work = Work {
                    launched: 60.0 * n,
                    steps: 60.0 * n,
                    samples: 900.0 * n * n,
                    ..Work::default()
                };
                (work, dear.ms(&work))
            })
            .collect();
        let line = CostLine::fitted(&frames, Some(&all));
        assert!((line.ns_per_sample / dear.ns_per_sample - 1.0).abs() < 0.1);
        assert!((line.ns_per_skip_step / all.ns_per_skip_step - 1.0).abs() < 0.2);
        assert!((line.ns_per_launched_pixel / all.ns_per_launched_pixel - 1.0).abs() < 0.2);
    }
}
