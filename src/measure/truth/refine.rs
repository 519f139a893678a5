//! Halving the step until a picture stands still, pixel by pixel.
//!
//! Steps go from [`COARSEST_STEP`] to [`FINEST_STEP`] by halves. The first three are taken in every pixel. From then on a
//! pixel is settled when its last refinement moved no channel by as much as [`BOUND`] and the one before by no more than four
//! times that, which is what errors of second order leave of themselves (so that two refinements that agree by chance after
//! a large change do not count), and when its ray steps over nothing: where the transfer function shows values between those
//! of two samples that show nothing, pictures stand still because all of them miss it. Only pixels that are not settled, and
//! those next to them, are refined further.
//!
//! Composites of smooth fields converge with the square of the step: their changes fall to a quarter from one refinement to
//! the next. Where the last change of every channel is a third to a fifth of the one before, the pixel is extrapolated to
//! a step of 0 (Richardson 1911): a third of the last change is added. Elsewhere (at edges of the data, where the order is
//! one, or lower) it is taken as it is.
//!
//! Pixels at a discontinuity are masked: those that the last halving, down to [`FINEST_STEP`], still moves by more than can
//! be seen, or that still step over something; and in modes that show the first surface, those that change abruptly from one eighth of a pixel to the next,
//! where a sample more or less along the ray decides what is seen.

use crate::error::Result;
use crate::measure::metrics::VISIBLE;
use crate::mode::Mode;
use crate::reference::Traced;
use crate::render::{Renderer, Settings};
use crate::scene::Picture;

use super::Truth;

/// Two refinements that differ by less than this in every channel count as one.
pub const BOUND: f64 = 1e-4;
/// The first step, in voxels of the smallest spacing.
pub const COARSEST_STEP: f64 = 0.25;
/// The last.
pub const FINEST_STEP: f64 = 1.0 / 1024.0;
/// Refinements, with the first picture, that every pixel has.
const AT_LEAST: usize = 3;
/// By how much of a pixel rays are moved to find discontinuities.
const SHIFT: f64 = 0.125;
/// A jump of a channel, or of the first hit's depth in voxels of the smallest spacing, over that: a discontinuity.
const JUMP: [f64; 2] = [0.125, 2.0];
/// Rays that are traced at once: progress is told after each lot.
const LOT: usize = 8192;

/// A pixel on its way.
#[derive(Clone, Copy, Default)]
struct Pixel {
    rgba: [f64; 4],
    /// What the last refinement added, and the one before.
    change: [f64; 4],
    change_before: [f64; 4],
    steps_over: bool,
}

impl Pixel {
    fn refine(&mut self, seen: &Traced) {
        self.change_before = self.change;
        self.change = std::array::from_fn(|c| seen.rgba[c] - self.rgba[c]);
        self.rgba = seen.rgba;
        self.steps_over = seen.steps_over;
    }

    fn is_settled(&self) -> bool {
        let stands_still =
            largest(self.change) < BOUND && largest(self.change_before) <= 4.0 * BOUND;
        stands_still && !self.steps_over
    }

    /// After the last refinement: whether it is at a discontinuity.
    fn is_masked(&self) -> bool {
        largest(self.change) > VISIBLE || self.steps_over
    }

    /// At a step of 0, where the last changes are those of an error of second order.
    fn extrapolated(&self) -> [f64; 4] {
        // Below this, changes are rounding.
        let is_still = |c: usize| self.change[c].abs() < 1e-12;
        let is_second_order = |c: usize| {
            let ratio = self.change_before[c] / self.change[c];
            (3.0..=5.0).contains(&ratio)
        };
        if (0..4).all(|c| is_still(c) || is_second_order(c)) {
            std::array::from_fn(|c| self.rgba[c] + self.change[c] / 3.0)
        } else {
            self.rgba
        }
    }
}

fn largest(change: [f64; 4]) -> f64 {
    change.into_iter().fold(0.0, |most, c| most.max(c.abs()))
}

/// The truth of these settings, whose step is not read.
pub(super) fn refine(
    renderer: &mut Renderer,
    settings: &Settings,
    progress: &mut dyn FnMut(f64),
) -> Result<Truth> {
    let [width, height] = settings.size.map(|n| n as usize);
    let mut pixels = vec![Pixel::default(); width * height];
    let mut active: Vec<usize> = (0..pixels.len()).collect();
    let mut step_voxels = COARSEST_STEP;
    let mut work = Work::default();
    for refinement in 0.. {
        let settings = Settings {
            step_voxels,
            ..*settings
        };
        let cost = 1.0 / step_voxels;
        let mut after = active.len() as f64 * cost;
        for lot in active.chunks(LOT) {
            let places: Vec<_> = lot.iter().map(|&i| place(i, width)).collect();
            let traced = renderer.trace(&settings, &places)?;
            for (&i, seen) in lot.iter().zip(traced) {
                pixels[i].refine(&seen);
            }
            let cost = lot.len() as f64 * cost;
            after -= cost;
            progress(work.done(cost, after));
        }
        if refinement + 1 >= AT_LEAST {
            active = unsettled(&pixels, &active, [width, height]);
        }
        if active.is_empty() || step_voxels <= FINEST_STEP {
            break;
        }
        step_voxels *= 0.5;
    }

    let mut masked: Vec<bool> = pixels.iter().map(Pixel::is_masked).collect();
    if shows_first_surface(&settings.mode) {
        mark_jumps(renderer, settings, &mut masked)?;
    }
    let kept = pixels.iter().zip(&masked).filter(|(_, masked)| !**masked);
    let bound = kept.map(|(p, _)| largest(p.change)).fold(0.0, f64::max);
    let rgba = pixels.iter().map(|p| p.extrapolated().map(|c| c as f32));
    Ok(Truth {
        picture: Picture {
            size: settings.size,
            rgba: rgba.collect(),
        },
        masked,
        step_voxels,
        bound,
    })
}

/// How much of the work is done: every refinement costs twice the last on every pixel that it is made on.
#[derive(Default)]
struct Work {
    done: f64,
    told: f64,
}

impl Work {
    /// `cost` more was done, and `left` of this refinement is left. What comes after is taken to be as much as all so far,
    /// until the third refinement shows better.
    fn done(&mut self, cost: f64, left: f64) -> f64 {
        self.done += cost;
        let all = self.done + left;
        self.told = self.told.max(self.done / (all * 1.5)).min(1.0);
        self.told
    }
}

/// The middle of pixel `i`.
fn place(i: usize, width: usize) -> [f64; 2] {
    [(i % width) as f64, (i / width) as f64]
}

/// Which of the active pixels are not settled, or lie next to one that is not.
fn unsettled(pixels: &[Pixel], active: &[usize], [width, height]: [usize; 2]) -> Vec<usize> {
    let mut restless = vec![false; pixels.len()];
    for &i in active {
        if !pixels[i].is_settled() {
            let (x, y) = (i % width, i / width);
            for y in y.saturating_sub(1)..(y + 2).min(height) {
                for x in x.saturating_sub(1)..(x + 2).min(width) {
                    restless[y * width + x] = true;
                }
            }
        }
    }
    // A pixel that was left out of a refinement would be compared over two halvings at once.
    active.iter().copied().filter(|&i| restless[i]).collect()
}

/// Whether what a ray sees hangs on where it first meets a surface.
fn shows_first_surface(mode: &Mode) -> bool {
    matches!(
        mode,
        Mode::Normals { .. } | Mode::Phong { .. } | Mode::TwoSurfaces { .. }
    )
}

/// Masks pixels whose picture jumps within an eighth of a pixel.
fn mark_jumps(renderer: &mut Renderer, settings: &Settings, masked: &mut [bool]) -> Result<()> {
    let width = settings.size[0] as usize;
    let settings = Settings {
        step_voxels: 0.25 * COARSEST_STEP,
        ..*settings
    };
    let shifts = [
        [0.0, 0.0],
        [SHIFT, 0.0],
        [-SHIFT, 0.0],
        [0.0, SHIFT],
        [0.0, -SHIFT],
    ];
    let places: Vec<_> = (0..masked.len())
        .flat_map(|i| {
            let [x, y] = place(i, width);
            shifts.map(|[dx, dy]| [x + dx, y + dy])
        })
        .collect();
    for (lot, masked) in places
        .chunks(LOT * shifts.len())
        .zip(masked.chunks_mut(LOT))
    {
        let traced = renderer.trace(&settings, lot)?;
        for (seen, masked) in traced.chunks(shifts.len()).zip(masked) {
            *masked |= seen[1..].iter().any(|moved| is_jump(&seen[0], moved));
        }
    }
    Ok(())
}

fn is_jump(a: &Traced, b: &Traced) -> bool {
    let color: [f64; 4] = std::array::from_fn(|c| a.rgba[c] - b.rgba[c]);
    // Where both rays hit nothing, both depths are infinite, and no difference is a number.
    largest(color) > JUMP[0] || (a.first_hit - b.first_hit).abs() > JUMP[1]
}
