//! Hazards drawn and judged.

use super::contestant::Contestant;
use super::scenery::{Judged, Scenery};
use super::truths;
use super::{Hazard, LOSSY_MAX_ABS, REFERENCE_MAX_ABS, REFERENCE_PSNR_DB, Row, SLOW, Verdict};
use crate::error::{Error, Result};
use crate::measure::metrics::{Metrics, metrics};
use crate::measure::race::{Entrant, race};
use crate::measure::truth::Truth;
use crate::render::{BackendChoice, Renderer, Settings};
use crate::scene::Picture;
use crate::skip::Skip;

/// Pictures whose brightest channel is below this are held to bounds relative to it.
const FAINT: f64 = 1.0 / 16.0;
/// Timed runs of every entrant.
const ROUNDS: usize = 5;

/// Draws hazards.
pub struct Atlas {
    renderers: Vec<Renderer>,
    reference: Renderer,
    contestants: Vec<Contestant>,
    measures_truth: bool,
}

/// What one hazard made of all contestants.
#[derive(Debug)]
pub struct Found {
    /// A row for each contestant on each backend, and one for each further backend against the first.
    pub rows: Vec<Row>,
    /// The worst picture that is not box's nor near enough to it.
    pub worst: Option<Worst>,
}

/// A picture that went wrong.
#[derive(Debug)]
pub struct Worst {
    /// Who drew it.
    pub method: &'static str,
    /// Where.
    pub backend: String,
    /// Largest difference of any channel from `expected`.
    pub max_abs: f64,
    /// The picture.
    pub picture: Picture,
    /// What it should be: box's, or the reference's where box is wrong.
    pub expected: Picture,
}

/// One renderer's pictures of all frames by one contestant.
type Pictures = Vec<Picture>;

impl Atlas {
    /// For these contestants, which box joins, on all renderers that have them.
    ///
    /// # Errors
    /// As [`Renderer::new`].
    pub fn new(renderers: Vec<Renderer>, contestants: &[Contestant]) -> Result<Self> {
        let by_box = Contestant::Method(Skip::Box);
        let others = contestants.iter().copied().filter(|&c| c != by_box);
        Ok(Self {
            renderers,
            reference: Renderer::new(BackendChoice::Reference)?,
            contestants: std::iter::once(by_box).chain(others).collect(),
            measures_truth: false,
        })
    }

    /// Holds every first frame against its ground truth too: seconds for a hazard whose truth is not in the cache yet.
    pub fn with_truths(mut self) -> Self {
        self.measures_truth = true;
        self
    }

    /// Draws one hazard with all contestants on all renderers.
    ///
    /// # Errors
    /// Whatever a renderer reports, with the hazard's name.
    pub fn run(&mut self, hazard: &Hazard) -> Result<Found> {
        self.try_run(hazard)
            .map_err(|e| Error::Gpu(format!("{}: {e}", hazard.name)))
    }

    fn try_run(&mut self, hazard: &Hazard) -> Result<Found> {
        let scenery = (hazard.make)()?;
        self.reference.set_volume(scenery.volume.clone())?;
        let by_box = Contestant::Method(Skip::Box);
        let reference = pictures(by_box, &mut self.reference, &scenery)?;
        let converged = self
            .measures_truth
            .then(|| truths::of_first_frame(&scenery))
            .flatten();
        let mut found = Found {
            rows: Vec::new(),
            worst: None,
        };
        let mut first: Option<(&'static str, Pictures)> = None;
        for renderer in &mut self.renderers {
            let backend = renderer.info().backend;
            renderer.set_volume(scenery.volume.clone())?;
            let boxes = pictures(by_box, renderer, &scenery)?;
            let taking_part: Vec<Contestant> = self
                .contestants
                .iter()
                .copied()
                .filter(|c| c.is_on(renderer))
                .collect();
            let times = times(renderer, &scenery, &taking_part)?;
            for (&contestant, time) in taking_part.iter().zip(times) {
                let judge = Judge {
                    hazard,
                    contestant,
                    backend,
                    scenery: &scenery,
                    boxes: &boxes,
                    reference: &reference,
                    truth: converged.as_ref(),
                    time,
                };
                if contestant == by_box {
                    found.add(judge.row(&boxes));
                } else {
                    found.add(judge.row(&pictures(contestant, renderer, &scenery)?));
                }
            }
            match &first {
                None => first = Some((backend, boxes)),
                Some((other, pictures)) => {
                    found
                        .rows
                        .push(between(hazard, [*other, backend], pictures, &boxes));
                }
            }
        }
        Ok(found)
    }
}

impl Found {
    fn add(&mut self, (row, worst): (Row, Worst)) {
        let is_worse = self
            .worst
            .as_ref()
            .is_none_or(|w| w.max_abs < worst.max_abs);
        if row.verdict == Verdict::Wrong && is_worse {
            self.worst = Some(worst);
        }
        self.rows.push(row);
    }
}

fn pictures(
    contestant: Contestant,
    renderer: &mut Renderer,
    scenery: &Scenery,
) -> Result<Pictures> {
    let frames = scenery.frames.iter();
    frames
        .map(|frame| contestant.draw(renderer, &scenery.volume, frame))
        .collect()
}

/// Each contestant's time over box's, where time is asked for and it is a method.
fn times(
    renderer: &mut Renderer,
    scenery: &Scenery,
    contestants: &[Contestant],
) -> Result<Vec<Option<f64>>> {
    if scenery.judged != Judged::Timed {
        return Ok(vec![None; contestants.len()]);
    }
    let [frame] = scenery.frames.as_slice() else {
        return Err(Error::setting("frames", "one frame is timed at a time"));
    };
    renderer.set_transfer(frame.transfer.clone());
    let entrants: Vec<Entrant> = contestants
        .iter()
        .filter_map(|c| c.settings(frame))
        .map(|settings: Settings| Entrant {
            renderer: 0,
            views: vec![settings],
        })
        .collect();
    let outcomes = race(
        std::slice::from_mut(renderer),
        &entrants,
        ROUNDS,
        &mut |_| (),
    )?;
    let mut frame_ms = outcomes.iter().map(|o| o.mean(|t| t.frame_ms));
    let of_box = outcomes[0].mean(|t| t.frame_ms);
    Ok(contestants
        .iter()
        .map(|c| c.settings(frame).and_then(|_| frame_ms.next()))
        .map(|ms| ms.map(|ms| ms / of_box))
        .collect())
}

/// All that a verdict is made of.
struct Judge<'a> {
    hazard: &'a Hazard,
    contestant: Contestant,
    backend: &'static str,
    scenery: &'a Scenery,
    boxes: &'a [Picture],
    reference: &'a [Picture],
    truth: Option<&'a Truth>,
    time: Option<f64>,
}

impl Judge<'_> {
    fn row(&self, pictures: &[Picture]) -> (Row, Worst) {
        let is_box = self.contestant == Contestant::Method(Skip::Box);
        let expected = if is_box { self.reference } else { self.boxes };
        let mut differing_pixels = 0;
        let mut max_abs = 0.0_f64;
        let mut worst = (0.0, 0);
        for (i, picture) in pictures.iter().enumerate() {
            let difference = picture.difference(&self.boxes[i]);
            differing_pixels += difference.pixels;
            max_abs = max_abs.max(difference.max_abs);
            let off = picture.difference(&expected[i]).max_abs;
            if off >= worst.0 {
                worst = (off, i);
            }
        }
        let off = metrics(pictures.iter().zip(self.reference));
        let in_sequence = self.scenery.judged == Judged::InSequence;
        let changed = in_sequence.then(|| worst_change(pictures, expected));
        let pops = changed.is_some_and(|[c, b]| c > b + LOSSY_MAX_ABS);
        let is_near = is_near(&off, self.reference);
        let is_finite = pictures
            .iter()
            .all(|p| p.rgba.as_flattened().iter().all(|c| c.is_finite()));
        let is_right = is_finite
            && !pops
            && if is_box {
                is_near
            } else if self.contestant.is_lossless() {
                differing_pixels == 0
            } else {
                max_abs <= LOSSY_MAX_ABS
            };
        let verdict = match self.time {
            _ if !is_right => Verdict::Wrong,
            Some(time) if time > SLOW => Verdict::Slow,
            _ => Verdict::Ok,
        };
        let row = Row {
            hazard: self.hazard.name.into(),
            group: self.hazard.group,
            method: self.contestant.name().into(),
            backend: self.backend.to_owned(),
            lossless: self.contestant.is_lossless(),
            verdict,
            differing_pixels_vs_box: differing_pixels,
            max_abs_diff_vs_box: max_abs,
            error_vs_reference: Some(off.max_abs),
            error_vs_truth: self.truth.map(|truth| truths::error(&pictures[0], truth)),
            time_vs_box: self.time,
            change: changed.map(|[change, _]| change),
            change_expected: changed.map(|[_, expected]| expected),
        };
        let (off, i) = worst;
        let worst = Worst {
            method: self.contestant.name(),
            backend: row.backend.clone(),
            max_abs: off,
            picture: pictures[i].clone(),
            expected: expected[i].clone(),
        };
        (row, worst)
    }
}

/// Whether pictures so far apart from `expected` are near enough. Where the brightest channel of all is faint, the bounds
/// are parts of that: black pictures would pass otherwise.
fn is_near(off: &Metrics, expected: &[Picture]) -> bool {
    let channels = expected.iter().flat_map(|p| p.rgba.as_flattened());
    let peak = f64::from(channels.fold(0.0_f32, |most, c| most.max(c.abs())));
    let scale = if peak < FAINT { peak } else { 1.0 };
    off.max_abs <= REFERENCE_MAX_ABS * scale
        && off.psnr_db() >= REFERENCE_PSNR_DB - 20.0 * scale.log10()
}

/// Largest change of any channel from one picture to the next, and how much is expected there: of the pair of neighbours
/// whose change is the most over what is expected. A pop in a small movement is not hidden by a large movement elsewhere.
fn worst_change(pictures: &[Picture], expected: &[Picture]) -> [f64; 2] {
    let changes = |of: &[Picture]| -> Vec<f64> {
        let neighbours = of.windows(2);
        neighbours
            .map(|pair| pair[1].difference(&pair[0]).max_abs)
            .collect()
    };
    let pairs = changes(pictures).into_iter().zip(changes(expected));
    pairs
        .max_by(|a, b| (a.0 - a.1).total_cmp(&(b.0 - b.1)))
        .map_or([0.0; 2], |(change, expected)| [change, expected])
}

/// Box on one backend against box on another: group 10.
fn between(hazard: &Hazard, backends: [&str; 2], a: &[Picture], b: &[Picture]) -> Row {
    let apart = metrics(b.iter().zip(a));
    let is_near = is_near(&apart, a);
    let pairs = b.iter().zip(a);
    Row {
        hazard: hazard.name.into(),
        group: 10,
        method: Skip::Box.method().name.into(),
        backend: backends.join(", "),
        lossless: false,
        verdict: if is_near { Verdict::Ok } else { Verdict::Wrong },
        differing_pixels_vs_box: pairs.map(|(b, a)| b.difference(a).pixels).sum(),
        max_abs_diff_vs_box: apart.max_abs,
        error_vs_reference: None,
        error_vs_truth: None,
        time_vs_box: None,
        change: None,
        change_expected: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn black_pictures_are_not_near_faint_ones() {
        let picture = |level: f32| Picture {
            size: [1, 1],
            rgba: vec![[level; 4]],
        };
        let near = |level: f32, expected: f32| {
            let [a, b] = [level, expected].map(picture);
            is_near(&metrics([(&a, &b)]), std::slice::from_ref(&b))
        };
        assert!(!near(0.0, 1e-4) && near(1e-4, 1e-4) && near(1.0001e-4, 1e-4));
        assert!(near(0.0, 0.0) && !near(1e-6, 0.0));
    }

    #[test]
    fn a_pop_in_a_small_movement_is_not_hidden_by_a_large_one() {
        let pictures = |levels: [f32; 3]| {
            levels.map(|level| Picture {
                size: [1, 1],
                rgba: vec![[level; 4]],
            })
        };
        let [change, expected] =
            worst_change(&pictures([0.0, 0.25, 0.75]), &pictures([0.0, 0.0, 0.75]));
        assert_eq!([change, expected], [0.25, 0.0]);
    }
}
