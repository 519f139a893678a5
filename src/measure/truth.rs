//! Ground truth: converged pictures, which errors are measured against.
//!
//! The truth of a scene (volume, transfer function in a table, mode, camera, clipping, size) is what its picture tends to as
//! the step goes to 0, in double precision, with exact interpolation and without early termination. Skipping is by a lossless
//! method, which changes no bit. It is never taken from a graphics adapter. How it is refined: see `truth/refine.rs`.
//!
//! Truths are kept in the user's cache folder under a hash of all that they depend on. Every file there is safe to delete,
//! and a damaged one is computed anew.

mod cache;
mod refine;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use self::cache::Key;
use crate::error::Result;
use crate::render::{self, BackendChoice, Renderer, Settings};
use crate::sample::{Classification, Gradients, Sampler};
use crate::scene::Picture;
use crate::skip::Skip;
use crate::transfer::TransferFunction;
use crate::volume::Volume;

pub use refine::{BOUND, COARSEST_STEP, FINEST_STEP};

/// A converged picture of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// Linear, premultiplied.
    pub picture: Picture,
    /// Pixels at a discontinuity, which are not compared; in the picture's order.
    pub masked: Vec<bool>,
    /// The smallest step that any pixel was refined to, in voxels of the smallest spacing.
    pub step_voxels: f64,
    /// The largest difference of any channel of any pixel that is not masked between its last two refinements. Where the
    /// error falls at least in proportion to the step, the last is no further than this from the limit.
    pub bound: f64,
}

impl Truth {
    /// Masked pixels over all pixels.
    pub fn masked_share(&self) -> f64 {
        let masked = self.masked.iter().filter(|&&m| m).count();
        masked as f64 / self.masked.len() as f64
    }
}

/// The truth of one picture, as [`Truths::of`] has it; [`Truths`] makes several of one volume in less time.
///
/// # Errors
/// As [`Truths::new`] and [`Truths::of`].
pub fn truth(
    volume: &Arc<Volume>,
    transfer: &TransferFunction,
    settings: &Settings,
    progress: impl FnMut(f64),
) -> Result<Truth> {
    Truths::new(volume, transfer)?.of(settings, progress)
}

/// Makes truths of one volume and transfer function, and keeps what stands for them.
pub struct Truths {
    renderer: Renderer,
    /// Of the volume and the transfer function.
    key: Key,
    folder: Option<PathBuf>,
}

impl Truths {
    /// Takes the volume; truths are kept in the user's cache folder.
    ///
    /// # Errors
    /// As [`Renderer::set_volume`].
    pub fn new(volume: &Arc<Volume>, transfer: &TransferFunction) -> Result<Self> {
        let mut renderer = Renderer::new(BackendChoice::Reference)?;
        renderer.set_volume(Arc::clone(volume))?;
        renderer.set_transfer(transfer.clone());
        Ok(Self {
            renderer,
            key: Key::new(volume, transfer),
            folder: render::cache::file("truth"),
        })
    }

    /// Takes volume and transfer function of a renderer, where both are set.
    ///
    /// # Errors
    /// [`crate::Error::Setting`] where one is not.
    pub fn like(renderer: &Renderer) -> Result<Self> {
        let (volume, transfer) = renderer.scene()?;
        Self::new(volume, transfer)
    }

    /// Keeps truths in this folder instead, or nowhere.
    pub fn kept_in(mut self, folder: Option<&Path>) -> Self {
        self.folder = folder.map(Path::to_owned);
        self
    }

    /// The truth of these settings: of their mode, camera, clipping, size and table. Skip, block, sampler, step and early
    /// termination are not read.
    ///
    /// `progress` is told how much of the work is done, 0 to 1: an estimate, since how far a picture must be refined shows
    /// as it is.
    ///
    /// # Errors
    /// [`crate::Error::Setting`] for settings out of range.
    pub fn of(&mut self, settings: &Settings, mut progress: impl FnMut(f64)) -> Result<Truth> {
        // A B-spline is another field, not a worse way to sample this one.
        let field = match settings.sampler {
            Some(Sampler::Tricubic | Sampler::TricubicExact) => Sampler::TricubicExact,
            _ => Sampler::Exact,
        };
        let settings = Settings {
            skip: Skip::GridDda,
            block: 4,
            sampler: Some(field),
            classification: Classification::Post,
            gradients: Gradients::Fly,
            ert: 1.0,
            ..*settings
        };
        let file = self
            .folder
            .as_ref()
            .map(|f| f.join(self.key.name(&settings)));
        if let Some(truth) = file
            .as_deref()
            .and_then(|file| cache::read(file, settings.size))
        {
            return Ok(truth);
        }
        let truth = refine::refine(&mut self.renderer, &settings, &mut progress)?;
        if let Some(file) = &file {
            cache::write(file, &truth);
        }
        Ok(truth)
    }
}

#[cfg(test)]
mod tests;
