//! The f64 reference: an independent renderer of the same choices of skip, sample and mode, the oracle of tests.
//!
//! It draws what the scene's baked table says ([`render`], [`render_f64`]), as every backend does; or what the transfer
//! function itself says, without the table's f32 entries and the interpolation between them ([`render_exact`]), which
//! is what closed-form answers are compared with.
//!
//! Both samplers interpolate exactly here: how coarse an adapter's filter is, is what the reference measures.

mod classes;
mod march;
mod modes;
#[cfg(test)]
mod tests;

use rayon::prelude::*;

use crate::error::Result;
use crate::scene::{CountedPicture, Counters, Picture, Progress, Scene};
use crate::skip::Plan;
use crate::transfer::TransferFunction;
use crate::with_voxels;
use classes::{Baked, Classes, Unbaked};
use march::Marcher;

/// The scene in f64, rounded to f32 at the end, with the work it took. The same whatever the number of threads.
///
/// # Errors
/// [`crate::Error::Cancelled`] where `progress` was told to stop.
pub fn render(scene: &Scene, plan: &Plan, progress: &Progress) -> Result<CountedPicture> {
    let size = scene.frame.size;
    let [width, pixels] = [size[0] as usize, size[0] as usize * size[1] as usize];
    let mut rgba = vec![[0.0; 4]; pixels];
    let mut samples = vec![0; pixels];
    let mut first_hit = vec![0.0; pixels];
    let rows = rgba
        .par_chunks_mut(width)
        .zip(samples.par_chunks_mut(width))
        .zip(first_hit.par_chunks_mut(width))
        .enumerate();
    let classes = Baked::new(scene.table);
    let counters = with_voxels!(&scene.volume.voxels, voxels => {
        let marcher = Marcher::new(scene, plan, voxels, &classes);
        rows.map(|(y, ((rgba, samples), first_hit))| {
            let mut counters = Counters::default();
            for x in 0..width {
                let pixel = marcher.pixel(x, y);
                rgba[x] = pixel.rgba.map(|c| c as f32);
                samples[x] = pixel.counters.samples as u32;
                first_hit[x] = pixel.first_hit as f32;
                counters += pixel.counters;
            }
            progress.finish_row()?;
            Ok(counters)
        })
        .try_reduce(Counters::default, |mut a, b| {
            a += b;
            Ok(a)
        })?
    });
    Ok(CountedPicture {
        picture: Picture { size, rgba },
        counters,
        samples,
        first_hit,
    })
}

/// What marching one ray takes.
#[derive(Debug, Clone)]
pub struct RayWork {
    /// The work.
    pub counters: Counters,
    /// Of modes that keep the highest place in the window: the samples that raised it, and to what.
    pub rises: Vec<(u32, f64)>,
}

/// The work of some pixels (column, row) of [`render`]'s picture, without drawing the others.
pub fn work_of(scene: &Scene, plan: &Plan, pixels: &[[u32; 2]]) -> Vec<RayWork> {
    let classes = Baked::new(scene.table);
    let keeps_highest = scene.mode.keeps_highest();
    with_voxels!(&scene.volume.voxels, voxels => {
        let marcher = Marcher::new(scene, plan, voxels, &classes);
        let work_of = |&[x, y]: &[u32; 2]| {
            let mut rises = Vec::new();
            let pixel = marcher.pixel_told([f64::from(x), f64::from(y)], |k, state| {
                if keeps_highest {
                    rises.push((k, state[0]));
                }
            });
            RayWork { counters: pixel.counters, rises }
        };
        pixels.par_iter().map(work_of).collect()
    })
}

/// What is seen at one place of a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Traced {
    /// Linear, premultiplied.
    pub rgba: [f64; 4],
    /// Distance along the ray, from its start, to the first contributing sample, in local units; infinite where there is
    /// none.
    pub first_hit: f64,
    /// Whether two samples in a row show nothing although the transfer function shows values between theirs: the ray has
    /// stepped over something.
    pub steps_over: bool,
}

/// What is seen at places (column, row) of the picture, of which whole numbers are the middles of pixels: there it is what
/// [`render_f64`] has. `plan` must not be beam masks, which know whole pixels only.
///
/// # Errors
/// [`crate::Error::Cancelled`] where `progress` was told to stop.
pub fn trace(
    scene: &Scene,
    plan: &Plan,
    places: &[[f64; 2]],
    progress: &Progress,
) -> Result<Vec<Traced>> {
    let classes = Baked::new(scene.table);
    let may_step_over = scene.mode.takes_table() && scene.table.has_peaks();
    with_voxels!(&scene.volume.voxels, voxels => {
        let marcher = Marcher::new(scene, plan, voxels, &classes);
        places
            .par_iter()
            .map(|&place| {
                if progress.is_cancelled() {
                    return Err(crate::Error::Cancelled);
                }
                let pixel = marcher.pixel_at(place);
                Ok(Traced {
                    rgba: pixel.rgba,
                    first_hit: pixel.first_hit,
                    steps_over: may_step_over && marcher.steps_over(place, scene.table),
                })
            })
            .collect()
    })
}

/// The pixels of [`render`] before they are rounded: linear, premultiplied, row by row from the top left.
///
/// # Errors
/// [`crate::Error::Cancelled`] where `progress` was told to stop.
pub fn render_f64(scene: &Scene, plan: &Plan, progress: &Progress) -> Result<Vec<[f64; 4]>> {
    pixels(scene, plan, &Baked::new(scene.table), progress)
}

/// The same with `function` evaluated in f64 at every sample, in place of the scene's table (whose domain still says
/// what a voxel's value is, and whose visibility says what `plan` may leave out).
///
/// # Errors
/// [`crate::Error::Cancelled`] where `progress` was told to stop.
pub fn render_exact(
    scene: &Scene,
    function: &TransferFunction,
    plan: &Plan,
    progress: &Progress,
) -> Result<Vec<[f64; 4]>> {
    let classes = Unbaked::new(function, *scene.table.domain(), scene.frame.step);
    pixels(scene, plan, &classes, progress)
}

fn pixels(
    scene: &Scene,
    plan: &Plan,
    classes: &impl Classes,
    progress: &Progress,
) -> Result<Vec<[f64; 4]>> {
    let [width, height] = scene.frame.size.map(|n| n as usize);
    let mut rgba = vec![[0.0; 4]; width * height];
    with_voxels!(&scene.volume.voxels, voxels => {
        let marcher = Marcher::new(scene, plan, voxels, classes);
        rgba.par_chunks_mut(width).enumerate().try_for_each(|(y, row)| {
            for (x, rgba) in row.iter_mut().enumerate() {
                *rgba = marcher.pixel(x, y).rgba;
            }
            progress.finish_row()
        })?;
    });
    Ok(rgba)
}
