//! Frames in interleaved runs: what every comparison of methods is made of.
//!
//! Times come from drawing alone, without read-back; counters and pictures from separate, untimed runs. What it takes to
//! build an entrant's structures is measured with nothing of the others' standing. Where medians are noisier than
//! [`NOISE_BOUND`], a view is run again, all entrants alike, at most [`AGAIN`] times.

use super::statistics::{Quartiles, interleaved, median, noise, quartiles};
use crate::error::{Error, Result};
use crate::render::{FrameTimes, Preparation, Renderer, Settings};
use crate::sample::Sampler;
use crate::scene::{Counters, Picture};
use crate::skip::Skip;

/// Noise of a view's medians ([`noise`], of its entrants the worst one's) above which its rounds are run again.
pub const NOISE_BOUND: f64 = 0.05;
/// How often, at most.
pub const AGAIN: usize = 2;

/// Who takes part.
#[derive(Debug, Clone)]
pub struct Entrant {
    /// Index of the renderer that draws.
    pub renderer: usize,
    /// What it draws: settings for each view, as many for every entrant.
    pub views: Vec<Settings>,
}

/// What was seen of an entrant.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// Building its structures for all views.
    pub preparation: Preparation,
    /// Times of every round, by view.
    pub runs: Vec<Vec<FrameTimes>>,
    /// Work of all views.
    pub counters: Counters,
    /// Pixels with any bit different from those of the same renderer's entrant that draws by box, over all views; 0 where
    /// there is none.
    pub differing_pixels: u64,
    /// Largest difference of any channel from its pictures.
    pub max_abs: f64,
    /// Fetching the picture of the first view, once, in ms.
    pub read_back_ms: f64,
    /// The sampler that was used.
    pub sampler: Sampler,
}

impl Outcome {
    /// The median of a view's rounds.
    pub fn median(&self, view: usize, time: impl Fn(&FrameTimes) -> f64) -> f64 {
        median(&self.runs[view].iter().map(time).collect::<Vec<_>>())
    }

    /// The median of each view's rounds, averaged over the views.
    pub fn mean(&self, time: impl Fn(&FrameTimes) -> f64) -> f64 {
        self.quartiles(time).median
    }

    /// The quartiles of each view's rounds, each averaged over the views.
    pub fn quartiles(&self, time: impl Fn(&FrameTimes) -> f64) -> Quartiles {
        let of_views: Vec<Quartiles> = self
            .runs
            .iter()
            .map(|runs| quartiles(&runs.iter().map(&time).collect::<Vec<_>>()))
            .collect();
        let mean = |of: fn(&Quartiles) -> f64| {
            of_views.iter().map(of).sum::<f64>() / of_views.len() as f64
        };
        Quartiles {
            q1: mean(|q| q.q1),
            median: mean(|q| q.median),
            q3: mean(|q| q.q3),
        }
    }

    /// What the adapter's own clock tells of a frame, as [`Self::mean`]; `None` where it has none.
    pub fn gpu_ms(&self) -> Option<f64> {
        let first = self.runs.first()?.first()?;
        first.gpu_ms?;
        Some(self.mean(|t| t.gpu_ms.unwrap_or(f64::NAN)))
    }

    /// How far the frame time of a view can be trusted ([`noise`]).
    fn noise(&self, view: usize) -> Option<f64> {
        noise(
            &self.runs[view]
                .iter()
                .map(|t| t.frame_ms)
                .collect::<Vec<_>>(),
        )
    }
}

/// How noisy a race was.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Noise {
    /// The standard error of a median frame time over it: the middle one of all views and entrants. `None` where there were
    /// fewer than three rounds.
    pub relative: Option<f64>,
    /// Rounds that were run beyond those asked for, over all views.
    pub extra_rounds: usize,
}

impl Noise {
    /// The noise of these outcomes of a race of `rounds`.
    pub fn of(outcomes: &[Outcome], rounds: usize) -> Self {
        let all: Vec<f64> = outcomes
            .iter()
            .flat_map(|o| (0..o.runs.len()).filter_map(|view| o.noise(view)))
            .collect();
        let extra = outcomes.first().map_or(0, |o| {
            o.runs
                .iter()
                .map(|runs| runs.len().saturating_sub(rounds))
                .sum()
        });
        Self {
            relative: (!all.is_empty()).then(|| median(&all)),
            extra_rounds: extra,
        }
    }

    /// In words, in one line.
    pub fn words(&self) -> String {
        let mut words = match self.relative {
            Some(relative) => {
                format!(
                    "noise: medians are good to {:.1} % (standard error)",
                    100.0 * relative
                )
            }
            None => "noise: unknown, of fewer than three runs each".to_owned(),
        };
        if self.extra_rounds > 0 {
            words = format!("{words}, after {} more rounds", self.extra_rounds);
        }
        if self.relative.is_some_and(|r| r > NOISE_BOUND) {
            words = format!("{words}; the machine is busy");
        }
        words
    }
}

/// Whether a view's medians are too noisy to stop at.
fn is_noisy(outcomes: &[Outcome], view: usize) -> bool {
    let mut all = outcomes.iter().filter_map(|o| o.noise(view));
    all.any(|noise| noise > NOISE_BOUND)
}

/// Lets all entrants draw all views, `rounds` times each, in turns.
///
/// `progress` is told how much of the work is done, 0 to 1.
///
/// # Errors
/// Whatever a renderer reports; [`Error::Gpu`] where a counted picture is not the drawn one.
pub fn race(
    renderers: &mut [Renderer],
    entrants: &[Entrant],
    rounds: usize,
    progress: &mut dyn FnMut(f64),
) -> Result<Vec<Outcome>> {
    let mut outcomes = entrants
        .iter()
        .map(|entrant| Outcome::prepared(&mut renderers[entrant.renderer], entrant))
        .collect::<Result<Vec<_>>>()?;
    let views = entrants.first().map_or(0, |e| e.views.len());
    for view in 0..views {
        // Counting, warming up and the rounds of every entrant.
        let steps = (views * entrants.len() * (2 + rounds)) as f64;
        let before = (view * entrants.len() * (2 + rounds)) as f64;
        let mut pictures = Vec::new();
        for (i, (entrant, outcome)) in entrants.iter().zip(&mut outcomes).enumerate() {
            let renderer = &mut renderers[entrant.renderer];
            pictures.push(outcome.look(renderer, &entrant.views[view], view)?);
            progress((before + 2.0 * (i + 1) as f64) / steps);
        }
        compare_with_box(entrants, &mut outcomes, &pictures);
        drop(pictures);
        let before = before + 2.0 * entrants.len() as f64;
        for again in 0..=AGAIN {
            if again > 0 && !is_noisy(&outcomes, view) {
                break;
            }
            for (run, i) in interleaved(entrants.len(), rounds).enumerate() {
                let entrant = &entrants[i];
                let times = renderers[entrant.renderer].draw(&entrant.views[view])?;
                outcomes[i].runs[view].push(times);
                if again == 0 {
                    progress((before + (run + 1) as f64) / steps);
                }
            }
        }
    }
    Ok(outcomes)
}

impl Outcome {
    /// Builds the entrant's structures from nothing.
    fn prepared(renderer: &mut Renderer, entrant: &Entrant) -> Result<Self> {
        renderer.drop_structures();
        let mut preparation = Preparation::default();
        for settings in &entrant.views {
            // More axes may be built with every view, and what stands is reported by all of its times.
            let seen = renderer.prepare(settings)?;
            preparation.preprocess_ms = preparation.preprocess_ms.max(seen.preprocess_ms);
            preparation.cull_ms = preparation.cull_ms.max(seen.cull_ms);
            preparation.structure_bytes = preparation.structure_bytes.max(seen.structure_bytes);
        }
        Ok(Self {
            preparation,
            runs: vec![Vec::new(); entrant.views.len()],
            counters: Counters::default(),
            differing_pixels: 0,
            max_abs: 0.0,
            read_back_ms: 0.0,
            sampler: renderer.sampler(&entrant.views[0]),
        })
    }

    /// Counts a view's work, draws it once to warm up, and gives its picture.
    fn look(
        &mut self,
        renderer: &mut Renderer,
        settings: &Settings,
        view: usize,
    ) -> Result<Picture> {
        let counted = renderer.count(settings)?;
        self.counters += counted.counters;
        if view == 0 {
            let rendered = renderer.render(settings)?;
            self.read_back_ms = rendered.read_back_ms;
            let difference = rendered.picture.difference(&counted.picture);
            if difference.pixels > 0 {
                return Err(Error::Gpu(format!(
                    "{}: {} pixels of the counted picture differ from the drawn one",
                    settings.skip.method().name,
                    difference.pixels
                )));
            }
        } else {
            // The counting run warms up nothing but itself.
            renderer.draw(settings)?;
        }
        Ok(counted.picture)
    }
}

/// Holds each picture of one view against box's on the same renderer.
fn compare_with_box(entrants: &[Entrant], outcomes: &mut [Outcome], pictures: &[Picture]) {
    for (i, entrant) in entrants.iter().enumerate() {
        let base = entrants.iter().position(|other| {
            other.renderer == entrant.renderer
                && (other.views.iter()).all(|s| s.skip == Skip::Box && s.slices.is_none())
        });
        if let Some(base) = base {
            let difference = pictures[i].difference(&pictures[base]);
            outcomes[i].differing_pixels += difference.pixels;
            outcomes[i].max_abs = outcomes[i].max_abs.max(difference.max_abs);
        }
    }
}
