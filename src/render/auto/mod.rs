//! `auto`: the method, block size and cuts that will draw a frame in least time, told before anything is drawn.
//!
//! What a frame will be to each method is counted along a bundle of its rays (`work`), through the occupancy of small
//! blocks and larger ones that follow from it. What that takes on this adapter is known from a few probe frames
//! (`probes`) in the same mode, classification and sampler, to which one line of costs per method was fitted (`cost`). Methods that are lossy, that failed the
//! self-check, or of whose segments nothing is known beforehand are never chosen.

mod choice;
mod cost;
mod fit;
mod probes;
mod work;

use std::sync::Arc;

use rayon::prelude::*;

pub use self::choice::{Choice, MethodChoice};
use self::cost::Calibration;
use self::probes::Kind;
use self::work::{Bundle, Level, Work};
use super::block_words::cell_rule;
use super::{Renderer, Settings};
use crate::error::{Error, Result};
use crate::mode::Mode;
use crate::sample::Classification;
use crate::skip::{Cuts, HalfCut, METHODS, Skip, SlabCount};
use crate::transfer::Table;

/// Block sizes that are chosen from, in voxels.
pub const BLOCKS: [usize; 4] = [4, 8, 16, 32];

/// The block size of methods that read none.
pub const DEFAULT_BLOCK: usize = 8;

/// A method is taken in place of box only where it promises to take less than this of box's time.
const WORTH_IT: f64 = 0.9;

/// The same where it leaves out less than [`NEXT_TO_NOTHING`] of box's samples, and what is promised can be little but the
/// noise of the calibration: the CPU's cell bits can make good on it. On other backends nothing can.
const WORTH_IT_FOR_NOTHING: f64 = 0.8;

/// The share of box's samples that is next to nothing.
const NEXT_TO_NOTHING: f64 = 0.05;

/// The least gain over box that is worth a structure, in ms.
const LEAST_GAIN_MS: f64 = 0.05;

/// Of choices within this of the least time, the simplest is taken: the first method of the table, in the largest blocks.
const AS_FAST: f64 = 1.02;

/// A turning camera stays with what was chosen unless something else promises to take less than this of its time.
const WORTH_TURNING: f64 = 0.85;

/// The most leaves that are built only to choose: 128 MiB of them. Larger volumes are chosen for in larger blocks.
const MAX_LEAVES: usize = 1 << 24;

/// What choosing keeps from picture to picture.
#[derive(Default)]
pub(super) struct Chooser {
    /// Those that were asked for, each with what it holds for.
    calibrations: Vec<(Kind, Calibration)>,
    active: Option<Active>,
    /// Whether what is drawn tells of the adapter, and so must not ask what is known of it.
    pub(super) is_probing: bool,
    /// The last choice, and the settings that it was made for.
    last: Option<(Settings, Choice)>,
}

/// What is active under one table, mode, classification and sampler's reach, from the smallest blocks up.
struct Active {
    table: Arc<Table>,
    mode: Mode,
    classification: Classification,
    /// How far blocks are closed over their neighbours ([`crate::sample::Sampler::apron`]).
    apron: usize,
    levels: Vec<Level>,
}

impl Chooser {
    /// Forgets what holds for one volume alone.
    pub(super) fn forget_volume(&mut self) {
        self.active = None;
        self.last = None;
    }

    /// Forgets what holds for one transfer function alone.
    pub(super) fn forget_transfer(&mut self) {
        self.last = None;
    }
}

impl Renderer {
    /// Everything that this backend can draw the exact picture with, in these blocks: every lossless method that its
    /// self-check did not withdraw. Box, which reads no block, is there once.
    pub fn candidates(&self, blocks: &[usize]) -> Vec<Choice> {
        let mut choices = Vec::new();
        for method in METHODS {
            // The oracle is told by a first pass what to sample: a limit, and no way to draw.
            let is_candidate = method.lossless && !method.is_limit;
            let is_there = self.has(method.skip) && self.holds(method.skip);
            if !is_candidate || !is_there || self.withdrawn.contains(&method.skip) {
                continue;
            }
            let best_too = method.skip == Skip::HalfSplit && self.info.backend != "cpu";
            let halves = if best_too {
                HalfCut::ALL
            } else {
                &HalfCut::ALL[..1]
            };
            let blocks = if method.skip == Skip::Box {
                &[DEFAULT_BLOCK]
            } else {
                blocks
            };
            for &block in blocks {
                choices.extend(halves.iter().map(|&half| Choice {
                    skip: method.skip,
                    block,
                    cuts: Cuts {
                        half,
                        ..Cuts::default()
                    },
                }));
            }
        }
        choices
    }

    /// The method, block size and cuts that will draw these settings' picture in least time; theirs are not read.
    ///
    /// The first call on an adapter in a mode, classification and sampler draws probe frames for about a second, whose
    /// outcome is kept in the user's cache folder. After that a choice takes some milliseconds; it is kept as long as the settings, the volume and the
    /// transfer function are the same, and where the camera alone has changed, so is the block size.
    ///
    /// # Errors
    /// As [`Self::draw`].
    pub fn choose(&mut self, settings: &Settings) -> Result<Choice> {
        let settings = Settings {
            sampler: Some(self.sampler(settings)),
            ..Choice::BOX.in_settings(settings)
        };
        let last = self.chooser.last;
        if let Some((same, choice)) = last
            && same == settings
        {
            return Ok(choice);
        }
        let calibration = self.calibrate(&settings)?;
        let turned = last.filter(|(before, _)| {
            let same_view = Settings {
                camera: settings.camera,
                ..*before
            };
            same_view == settings
        });
        let kept = turned.map(|(_, choice)| choice);
        let candidates = self.candidates(&BLOCKS);
        let candidates: Vec<Choice> = match kept {
            Some(kept) if kept.skip != Skip::Box => candidates
                .into_iter()
                .filter(|c| c.skip == Skip::Box || c.block == kept.block)
                .collect(),
            _ => candidates,
        };
        let promised: Vec<Promise> = self
            .works(&settings, &candidates)?
            .into_iter()
            .zip(candidates)
            .filter_map(|(work, choice)| {
                let work = work?;
                Some(Promise {
                    choice,
                    ms: calibration.line(choice.skip).ms(&work),
                    samples: work.samples,
                })
            })
            .collect();
        for Promise { choice, ms, .. } in &promised {
            tracing::debug!("auto: {} would take {ms:.2} ms", choice.words());
        }
        let choice = pick(&promised, kept, self.info.backend == "cpu");
        self.chooser.last = Some((settings, choice));
        Ok(choice)
    }

    /// Takes what a cut costs on this adapter in the settings' mode, classification and sampler, where their method cuts by
    /// that; found out first where it is not known, which takes about a second.
    ///
    /// # Errors
    /// As [`Self::draw`].
    pub(super) fn learn_cut_cost(&mut self, settings: &Settings) -> Result<()> {
        let asks = settings.skip == Skip::KCuts && settings.cuts.slabs == SlabCount::Auto;
        // Without a transfer function there is nothing to draw, which is told soon enough.
        if asks && !self.chooser.is_probing && self.transfer.is_some() {
            self.calibrate(settings)?;
        }
        Ok(())
    }

    /// The calibration for the settings' mode, classification and sampler: as known, as the cache has it, or fitted to probe
    /// frames that are drawn now.
    fn calibrate(&mut self, settings: &Settings) -> Result<Calibration> {
        let kind = Kind::of(settings, self.sampler(settings));
        let known = self.chooser.calibrations.iter().find(|(k, _)| *k == kind);
        let calibration = match known {
            Some((_, calibration)) => calibration.clone(),
            // Nobody waits for the reference to be fast.
            None if self.info.backend == "reference" => Calibration::assumed(),
            None => {
                // The probes cut by what is assumed.
                self.structures.set_cut_samples(None);
                self.chooser.is_probing = true;
                let calibration = probes::calibration(self, &kind);
                self.chooser.is_probing = false;
                let calibration = calibration?;
                self.chooser.calibrations.push((kind, calibration.clone()));
                calibration
            }
        };
        self.structures.set_cut_samples(calibration.cut_samples());
        Ok(calibration)
    }

    /// What each choice will have to do for a frame; `None` where that is not known.
    fn works(&mut self, settings: &Settings, choices: &[Choice]) -> Result<Vec<Option<Work>>> {
        let volume = self
            .volume
            .as_ref()
            .ok_or_else(|| Error::setting("volume", "none was set"))?;
        let volume = Arc::clone(volume);
        let table = self.table(settings, &volume)?;
        let pairs = self
            .classes
            .pairs(settings, &table, self.structures.range());
        let shown = pairs.as_ref().map_or(&table, |p| p.content.nodes());
        let frame = settings.ray_frame(&volume)?;
        let scene = settings.scene(&volume, &table, &frame, self.sampler(settings));
        let is_current = self.chooser.active.as_ref().is_some_and(|a| {
            (a.mode, a.classification, a.apron)
                == (
                    settings.mode,
                    settings.classification,
                    scene.sampler.apron(),
                )
                && a.table.shows_the_same_as(shown)
        });
        if !is_current {
            let leaves =
                |block: usize| -> usize { volume.dims.iter().map(|n| n.div_ceil(block)).product() };
            let smallest = BLOCKS.into_iter().find(|&b| leaves(b) <= MAX_LEAVES);
            let smallest = Settings {
                // It reads the occupancy of the whole, and what blocks are bounded by where the mode keeps the highest.
                skip: Skip::DistanceMap,
                block: smallest.unwrap_or(BLOCKS[BLOCKS.len() - 1]),
                ..*settings
            };
            let (occupancy, majorants) = self.structures.occupancy(&smallest, &scene, shown)?;
            let mut level = Level::new(occupancy.clone(), majorants.as_deref().cloned());
            let mut levels = Vec::new();
            while level.occupancy.block < BLOCKS[BLOCKS.len() - 1] {
                let coarser = level.coarser();
                levels.push(std::mem::replace(&mut level, coarser));
            }
            levels.push(level);
            self.chooser.active = Some(Active {
                table: Arc::clone(shown),
                mode: settings.mode,
                classification: settings.classification,
                apron: scene.sampler.apron(),
                levels,
            });
        }
        let active = self.chooser.active.as_ref().expect("made just above");
        let rule = cell_rule(settings, &scene, shown);
        let bundle = Bundle::new(&scene, rule, settings.camera.forward());
        let coarse = &active.levels[active.levels.len().saturating_sub(2)];
        let cut_samples = self.structures.cut_samples();
        let backend = self.info.backend;
        Ok(choices
            .par_iter()
            .map(|choice| {
                let level = active
                    .levels
                    .iter()
                    .find(|l| l.occupancy.block == choice.block)?;
                bundle.work(backend, choice, level, coarse, cut_samples)
            })
            .collect())
    }
}

/// What a choice promises for a frame.
#[derive(Debug, Clone, Copy)]
struct Promise {
    choice: Choice,
    ms: f64,
    /// Samples marched.
    samples: f64,
}

impl Promise {
    /// Whether it is worth more than box, which is simplest; `has_cell_bits`, whether the backend can leave out samples
    /// that are counted here.
    fn beats(&self, base: &Self, has_cell_bits: bool) -> bool {
        let left_out = 1.0 - self.samples / base.samples;
        let worth_it = match (left_out < NEXT_TO_NOTHING, has_cell_bits) {
            (false, _) => WORTH_IT,
            (true, true) => WORTH_IT_FOR_NOTHING,
            (true, false) => return false,
        };
        self.ms < base.ms * worth_it && base.ms - self.ms > LEAST_GAIN_MS
    }
}

/// The choice to make of these, where `kept` was made for another view of the same.
fn pick(promised: &[Promise], kept: Option<Choice>, has_cell_bits: bool) -> Choice {
    let of = |choice: &Choice| promised.iter().find(|p| p.choice == *choice);
    let Some(base) = of(&Choice::BOX) else {
        return Choice::BOX;
    };
    let worthy = || promised.iter().filter(|p| p.beats(base, has_cell_bits));
    let least = worthy().map(|p| p.ms).fold(f64::INFINITY, f64::min);
    // Candidates come in the order of the table, blocks ascending.
    let simplest = worthy().filter(|p| p.ms <= least * AS_FAST).reduce(|a, b| {
        let is_simpler = b.choice.skip == a.choice.skip && b.choice.block > a.choice.block;
        if is_simpler { b } else { a }
    });
    let best = simplest.unwrap_or(base);
    match kept.and_then(|kept| of(&kept)) {
        Some(kept) if best.ms > kept.ms * WORTH_TURNING => kept.choice,
        _ => best.choice,
    }
}

#[cfg(test)]
mod tests;
