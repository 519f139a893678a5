//! What is chosen for one picture besides the volume and its transfer function.

use super::{DEFAULT_BLOCK, SliceCount};
use crate::camera::Camera;
use crate::error::Result;
use crate::lattice::{Clipping, RayFrame};
#[cfg(doc)]
use crate::mode::DepthCue;
use crate::mode::Mode;
use crate::sample::{Classification, Gradients, Sampler};
use crate::scene::Scene;
use crate::skip::{Cuts, Skip};
use crate::transfer::{TABLE_SIZES, Table};
use crate::volume::Volume;

/// Everything that is chosen for one picture besides the volume and its transfer function.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// WHERE samples are taken.
    pub skip: Skip,
    /// Where half-split and k-cuts cut; the others do not read it.
    pub cuts: Cuts,
    /// HOW; `None`: the backend's default.
    pub sampler: Option<Sampler>,
    /// When samples get their colour.
    pub classification: Classification,
    /// WHAT is done with them.
    pub mode: Mode,
    /// Where modes that light surfaces take gradients from; the others do not read it.
    pub gradients: Gradients,
    /// Share of light that colours lose at the farthest point of the box ([`DepthCue`]); 0: none.
    pub depth_cue: f64,
    /// Leaf block edge in voxels: a power of two, 2 to 64.
    pub block: usize,
    /// Distance of two samples in voxels of the smallest spacing.
    pub step_voxels: f64,
    /// Accumulated opacity at which a ray stops; 1 or more: never.
    pub ert: f32,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Where the picture is taken from.
    pub camera: Camera,
    /// What of the volume is not drawn.
    pub clipping: Clipping,
    /// Entries of the baked table: one of [`crate::transfer::TABLE_SIZES`].
    pub table_entries: usize,
    /// Blends so many slices across the view in place of casting rays: on the GPU, with [`Skip::Box`], and no ray stops
    /// early. Their distance is the step then. `None`: rays are cast.
    pub slices: Option<SliceCount>,
}

impl Settings {
    /// The bounding box in emission and absorption, half a voxel a step, stopped at an opacity of 0.98, on 512x512 pixels
    /// and through a table of 4,096 entries: what the command takes where nothing is said, before `auto` chooses.
    pub fn new(camera: Camera) -> Self {
        Self {
            skip: Skip::Box,
            cuts: Cuts::default(),
            sampler: None,
            classification: Classification::Post,
            mode: Mode::EmissionAbsorption,
            gradients: Gradients::Fly,
            depth_cue: 0.0,
            block: DEFAULT_BLOCK,
            step_voxels: 0.5,
            ert: 0.98,
            size: [512; 2],
            camera,
            clipping: Clipping::NONE,
            table_entries: TABLE_SIZES[1],
            slices: None,
        }
    }

    /// The rays through a volume.
    ///
    /// # Errors
    /// As [`Camera::ray_frame`].
    pub(super) fn ray_frame(&self, volume: &Volume) -> Result<RayFrame> {
        let frame = self.camera.ray_frame(volume, self.size, self.step_voxels)?;
        Ok(RayFrame {
            clipping: self.clipping,
            reach: self.classification.reach(),
            ..frame
        })
    }

    /// What a picture of a volume is made of along these rays, by the sampler that stands for the backend's default.
    pub(super) fn scene<'a>(
        &self,
        volume: &'a Volume,
        table: &'a Table,
        frame: &'a RayFrame,
        sampler: Sampler,
    ) -> Scene<'a> {
        Scene {
            volume,
            table,
            frame,
            sampler,
            classification: self.classification,
            mode: self.mode,
            gradients: self.gradients,
            depth_cue: self.depth_cue,
            ert: self.ert,
        }
    }
}
