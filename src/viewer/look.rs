//! What a picture shows and how it is drawn: the two halves of the settings, and both together.

use crate::error::Result;
use crate::lattice::Clipping;
use crate::mode::Mode;
use crate::output::linear_from_srgb;
use crate::render::{BackendChoice, Choice, DEFAULT_BLOCK, MethodChoice, Settings, SliceCount};
use crate::sample::{Classification, Gradients, Sampler};
use crate::skip::{Cuts, Skip};
use crate::transfer::{PRESETS, TransferFunction};
use crate::volume::{Statistics, Volume};

use super::view::View;

/// WHAT is shown: the same for both pictures of a comparison.
#[derive(Debug, Clone, PartialEq)]
pub struct Look {
    /// Colour and opacity.
    pub transfer: TransferFunction,
    /// What is done with the samples.
    pub mode: Mode,
    /// The box that is shown, from and to in voxels along x, y, z; an open end is the volume's.
    pub clip_box: [[Option<f64>; 2]; 3],
    /// Planes: what has `nx * x + ny * y + nz * z >= d` is shown, in voxels.
    pub clip_planes: Vec<[f64; 4]>,
    /// Behind the picture, sRGB; `None`: nothing.
    pub background: Option<[u8; 3]>,
    /// Share of light that colours lose at the farthest point of the box; 0: none.
    pub depth_cue: f64,
}

impl Look {
    /// What the command shows of data of these statistics where nothing is said.
    ///
    /// # Errors
    /// None that finite statistics can cause.
    pub fn of(statistics: &Statistics) -> Result<Self> {
        Ok(Self {
            transfer: PRESETS[0].transfer_function(statistics)?,
            mode: Mode::EmissionAbsorption,
            clip_box: [[None; 2]; 3],
            clip_planes: Vec::new(),
            background: None,
            depth_cue: 0.0,
        })
    }

    /// The background in linear light, as `--background` reads it.
    pub fn linear_background(&self) -> Option<[f32; 3]> {
        self.background.map(linear)
    }
}

/// The linear colour of an sRGB one.
pub(super) fn linear(srgb: [u8; 3]) -> [f32; 3] {
    srgb.map(|c| linear_from_srgb(f64::from(c) / 255.0) as f32)
}

/// HOW it is drawn: what two pictures of a comparison may differ in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Way {
    /// WHERE samples are taken.
    pub method: MethodChoice,
    /// Leaf block edge in voxels; auto chooses its own.
    pub block: usize,
    /// Where half-split and k-cuts cut.
    pub cuts: Cuts,
    /// HOW a sample is taken; `None`: as suits the backend.
    pub sampler: Option<Sampler>,
    /// When samples get their colour; counts where the mode reads the table.
    pub classification: Classification,
    /// Where gradients come from; counts where the mode takes any.
    pub gradients: Gradients,
    /// Blends so many slices in place of casting rays, whatever the method.
    pub slices: Option<SliceCount>,
    /// Distance of samples, in voxels of the smallest spacing.
    pub step_voxels: f64,
    /// Opacity at which a ray stops; 1: never.
    pub ert: f32,
    /// What draws.
    pub backend: BackendChoice,
}

impl Default for Way {
    fn default() -> Self {
        Self {
            method: MethodChoice::Auto,
            block: DEFAULT_BLOCK,
            cuts: Cuts::default(),
            sampler: None,
            classification: Classification::Post,
            gradients: Gradients::Fly,
            slices: None,
            step_voxels: 0.5,
            ert: 0.98,
            backend: BackendChoice::Auto,
        }
    }
}

impl Way {
    /// The method that rays skip by; slices skip nothing.
    pub fn method(&self) -> MethodChoice {
        match self.slices {
            Some(_) => MethodChoice::Only(Skip::Box),
            None => self.method,
        }
    }

    /// In few words, for the heading of a picture.
    pub fn words(&self) -> String {
        let choice = match (self.slices, self.method) {
            (Some(count), _) => return format!("slices, {count}"),
            (None, MethodChoice::Auto) => "auto".to_owned(),
            (None, MethodChoice::Only(skip)) => Choice {
                skip,
                block: self.block,
                cuts: self.cuts,
            }
            .words(),
        };
        format!("{choice}, step {}", self.step_voxels)
    }

    /// The settings of one picture; of `auto`, what is left to choose is as it happens to be.
    ///
    /// # Errors
    /// [`crate::Error::Setting`] for clip planes that are out of range.
    pub fn settings(
        &self,
        look: &Look,
        view: &View,
        volume: &Volume,
        size: [u32; 2],
    ) -> Result<Settings> {
        let voxel_size = volume.voxel_size();
        Ok(Settings {
            skip: match self.method() {
                MethodChoice::Auto => Skip::Box,
                MethodChoice::Only(skip) => skip,
            },
            cuts: self.cuts,
            sampler: self.sampler,
            classification: if look.mode.takes_table() {
                self.classification
            } else {
                Classification::Post
            },
            mode: look.mode,
            gradients: if look.mode.takes_gradients() {
                self.gradients
            } else {
                Gradients::Fly
            },
            depth_cue: look.depth_cue,
            slices: self.slices,
            block: self.block,
            step_voxels: self.step_voxels,
            ert: self.ert,
            size,
            clipping: Clipping::in_voxels(&look.clip_box, &look.clip_planes, voxel_size)?,
            ..Settings::new(view.camera(voxel_size))
        })
    }
}
