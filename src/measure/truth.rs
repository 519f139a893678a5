//! Ground truth: converged pictures, which errors are measured against.

use std::sync::Arc;

use crate::error::Result;
use crate::render::{BackendChoice, Renderer, Settings};
use crate::sample::Sampler;
use crate::scene::Picture;
use crate::skip::Skip;
use crate::transfer::TransferFunction;
use crate::volume::Volume;

/// Two refinements that differ by less than this in every channel count as one picture.
pub const BOUND: f64 = 1e-4;

/// A converged picture of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// Linear, premultiplied.
    pub picture: Picture,
    /// Pixels at a discontinuity, which are not compared; in the picture's order.
    pub masked: Vec<bool>,
    /// The smallest step that any pixel was refined to, in voxels of the smallest spacing.
    pub step_voxels: f64,
    /// The largest difference of any channel of any pixel that is not masked between its last two refinements.
    pub bound: f64,
}

impl Truth {
    /// Masked pixels over all pixels.
    pub fn masked_share(&self) -> f64 {
        let masked = self.masked.iter().filter(|&&m| m).count();
        masked as f64 / self.masked.len() as f64
    }
}

/// The truth of one picture; [`Truths`] makes several of one volume.
///
/// # Errors
/// As [`Truths::of`].
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
}

impl Truths {
    /// Takes the volume.
    ///
    /// # Errors
    /// As [`Renderer::set_volume`].
    pub fn new(volume: &Arc<Volume>, transfer: &TransferFunction) -> Result<Self> {
        let mut renderer = Renderer::new(BackendChoice::Reference)?;
        renderer.set_volume(Arc::clone(volume))?;
        renderer.set_transfer(transfer.clone());
        Ok(Self { renderer })
    }

    /// The truth of these settings: of their mode, camera, clipping, size and table. Skip, block, sampler, step and early
    /// termination are not read.
    ///
    /// `progress` is told how much of the work is done, 0 to 1.
    ///
    /// # Errors
    /// [`crate::Error::Setting`] for settings out of range.
    pub fn of(&mut self, settings: &Settings, mut progress: impl FnMut(f64)) -> Result<Truth> {
        let mut settings = Settings {
            skip: Skip::GridDda,
            block: 8,
            sampler: Some(Sampler::Exact),
            ert: 1.0,
            step_voxels: 0.25,
            ..*settings
        };
        let mut picture = self.renderer.render(&settings)?.picture;
        let mut bound = f64::INFINITY;
        let mut levels = 0.0;
        while bound > BOUND && settings.step_voxels > 1.0 / 64.0 {
            settings.step_voxels *= 0.5;
            levels += 1.0;
            progress(levels / 4.0);
            let finer = self.renderer.render(&settings)?.picture;
            bound = finer.difference(&picture).max_abs;
            picture = finer;
        }
        Ok(Truth {
            masked: vec![false; picture.rgba.len()],
            picture,
            step_voxels: settings.step_voxels,
            bound,
        })
    }
}
