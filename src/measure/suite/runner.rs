//! Runs a group of cases in turns, and holds their pictures against the truth.

use super::case::{Case, Group};
use super::record::{CaseRecord, ErrorRecord};
use crate::error::Result;
use crate::measure::metrics::{metrics, perceived};
use crate::measure::race::{Entrant, Outcome, race};
use crate::measure::statistics::noise;
use crate::measure::truth::{Truth, Truths};
use crate::render::{Choice, FrameTimes, MethodChoice, Renderer, Settings};
use crate::skip::Skip;

/// A case that is ready to be drawn.
#[derive(Debug, Clone)]
pub struct Contestant {
    /// The case.
    pub case: Case,
    /// The command that measures it again.
    pub command: String,
    /// Index of the renderer that draws it, whose volume and transfer function are set.
    pub renderer: usize,
    /// Its settings for each view.
    pub views: Vec<Settings>,
}

/// A group whose scene is loaded.
#[derive(Debug)]
pub struct Heat<'a> {
    /// The scene's name.
    pub scene: &'a str,
    /// What the cases share.
    pub group: &'a Group,
    /// Who takes part.
    pub contestants: Vec<Contestant>,
}

/// Measures all cases of a heat. Box runs along on every renderer, whether it is a case or not.
///
/// `progress` is told how much of the work is done, 0 to 1.
///
/// # Errors
/// Whatever a renderer reports.
///
/// # Panics
/// Never: box is added where it is missing.
pub fn run(
    renderers: &mut [Renderer],
    heat: &Heat,
    truths: &mut Truths,
    progress: &mut dyn FnMut(f64),
) -> Result<Vec<CaseRecord>> {
    let truth = heat.truth(truths)?;
    let entrants = heat.entrants();
    let rounds = heat.group.repeat as usize;
    let outcomes = race(renderers, &entrants, rounds, &mut |f| progress(0.9 * f))?;
    let mut records = Vec::new();
    for (contestant, outcome) in heat.contestants.iter().zip(&outcomes) {
        let base = entrants
            .iter()
            .position(|e| e.renderer == contestant.renderer && is_box(e))
            .expect("box runs along");
        let renderer = &mut renderers[contestant.renderer];
        let error = match &truth {
            Some(truth) => Some(error(renderer, &contestant.views[0], truth)?),
            None => None,
        };
        let box_ms = outcomes[base].mean(|t| t.frame_ms);
        let backend = renderer.info().backend;
        records.push(heat.record(contestant, outcome, backend, box_ms, error));
    }
    progress(1.0);
    Ok(records)
}

impl Heat<'_> {
    /// The truth of the first view, if the group asks for it.
    fn truth(&self, truths: &mut Truths) -> Result<Option<Truth>> {
        if self.group.truth == 0 {
            return Ok(None);
        }
        let settings = Settings {
            size: [self.group.truth; 2],
            ..self.contestants[0].views[0]
        };
        truths.of(&settings, |_| ()).map(Some)
    }

    /// The contestants, and box where a renderer would run without.
    fn entrants(&self) -> Vec<Entrant> {
        let entrant = |contestant: &Contestant| Entrant {
            renderer: contestant.renderer,
            views: contestant.views.clone(),
        };
        let mut entrants: Vec<Entrant> = self.contestants.iter().map(entrant).collect();
        for contestant in &self.contestants {
            let has_box = |e: &Entrant| e.renderer == contestant.renderer && is_box(e);
            if !entrants.iter().any(has_box) {
                let mut added = entrant(contestant);
                for settings in &mut added.views {
                    settings.skip = Skip::Box;
                }
                entrants.push(added);
            }
        }
        entrants
    }

    /// What the race saw of a contestant.
    fn record(
        &self,
        contestant: &Contestant,
        outcome: &Outcome,
        backend: &str,
        box_ms: f64,
        error: Option<ErrorRecord>,
    ) -> CaseRecord {
        let Contestant {
            case,
            command,
            views,
            ..
        } = contestant;
        let group = self.group;
        let settings = &views[0];
        let pixels = settings.size.map(f64::from).iter().product::<f64>() * views.len() as f64;
        let is_auto = case.method == MethodChoice::Auto.name();
        CaseRecord {
            command: command.clone(),
            scene: self.scene.to_owned(),
            backend: backend.to_owned(),
            method: case.method.clone(),
            chosen: is_auto.then(|| Choice::of(settings).words()),
            lossless: is_auto || settings.skip.method().lossless,
            block: case.block,
            step: group.step.clone(),
            step_voxels: settings.step_voxels,
            sampler: outcome.sampler.name().to_owned(),
            classification: group.classification.clone(),
            mode: group.mode.clone(),
            ert: group.ert.clone(),
            size: settings.size,
            views: views.len(),
            runs: outcome.runs[0].len(),
            frame_ms: outcome.quartiles(|t| t.frame_ms),
            raster_ms: outcome.mean(|t| t.raster_ms),
            cast_ms: outcome.mean(|t| t.cast_ms),
            gpu_ms: outcome.gpu_ms(),
            noise: noise_of(outcome),
            read_back_ms: outcome.read_back_ms,
            box_ms,
            preprocess_ms: outcome.preparation.preprocess_ms,
            cull_ms: outcome.preparation.cull_ms,
            structure_bytes: outcome.preparation.structure_bytes,
            samples: outcome.counters.samples as f64 / pixels,
            contributing: outcome.counters.contributing as f64 / pixels,
            skip_steps: outcome.counters.skip_steps as f64 / pixels,
            differing_pixels_vs_box: outcome.differing_pixels,
            max_abs_vs_box: outcome.max_abs,
            error,
        }
    }
}

fn is_box(entrant: &Entrant) -> bool {
    entrant.views.iter().all(|s| s.skip == Skip::Box)
}

/// The mean of the views' noise.
fn noise_of(outcome: &Outcome) -> Option<f64> {
    let of_view =
        |runs: &Vec<FrameTimes>| noise(&runs.iter().map(|t| t.frame_ms).collect::<Vec<_>>());
    let of_views: Option<Vec<f64>> = outcome.runs.iter().map(of_view).collect();
    let of_views = of_views?;
    Some(of_views.iter().sum::<f64>() / of_views.len() as f64)
}

/// How far a picture with these settings is from the truth.
fn error(renderer: &mut Renderer, settings: &Settings, truth: &Truth) -> Result<ErrorRecord> {
    let settings = Settings {
        size: truth.picture.size,
        ..*settings
    };
    let picture = renderer.render(&settings)?.picture;
    let measured = metrics([(&picture, truth)]);
    let seen = perceived((&picture, truth));
    let finite = |number: f64| number.is_finite().then_some(number);
    Ok(ErrorRecord {
        size: truth.picture.size,
        max_abs: measured.max_abs,
        mean_abs: measured.mean_abs,
        rms: measured.rms,
        off_share: measured.off_share,
        ssim: finite(seen.ssim),
        flip: finite(seen.flip),
        masked_share: truth.masked_share(),
        truth_bound: truth.bound,
    })
}
