//! What a picture shows and how it is drawn: the two halves of the settings, and both together.

use crate::error::Result;
use crate::lattice::Clipping;
use crate::mode::Mode;
use crate::output::linear_from_srgb;
use crate::render::{BackendChoice, Choice, DEFAULT_BLOCK, MethodChoice, Settings};
use crate::sample::Sampler;
use crate::skip::{Cuts, HalfCut, Skip};
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
            step_voxels: 0.5,
            ert: 0.98,
            backend: BackendChoice::Auto,
        }
    }
}

impl Way {
    /// In few words, for the heading of a picture.
    pub fn words(&self) -> String {
        let choice = match self.method {
            MethodChoice::Auto => "auto".to_owned(),
            MethodChoice::Only(skip) => Choice {
                skip,
                block: self.block,
                cuts: self.cuts,
            }
            .words(),
        };
        format!("{choice}, step {}", self.step_voxels)
    }

    /// Whether the CPU backend can draw this in this mode.
    pub fn is_on_cpu(&self, mode: &Mode) -> bool {
        let has_method = match self.method {
            MethodChoice::Auto => true,
            MethodChoice::Only(skip) => {
                let cuts_best = skip == Skip::HalfSplit && self.cuts.half == HalfCut::Best;
                skip.check_backend("cpu").is_ok() && !cuts_best
            }
        };
        has_method
            && mode.check_backend("cpu").is_ok()
            && matches!(self.sampler, None | Some(Sampler::Exact))
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
            skip: match self.method {
                MethodChoice::Auto => Skip::Box,
                MethodChoice::Only(skip) => skip,
            },
            cuts: self.cuts,
            sampler: self.sampler,
            mode: look.mode,
            block: self.block,
            step_voxels: self.step_voxels,
            ert: self.ert,
            size,
            clipping: Clipping::in_voxels(&look.clip_box, &look.clip_planes, voxel_size)?,
            ..Settings::new(view.camera(voxel_size))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mode::MODES;
    use crate::volume::phantom;

    #[test]
    fn what_the_cpu_cannot_draw_is_known_before() {
        let statistics = Statistics::of(&phantom::make("pot", [8; 3]).unwrap());
        let way = Way::default();
        for row in MODES {
            let mode = (row.suited_to)(&statistics);
            assert_eq!(way.is_on_cpu(&mode), row.backends.contains(&"cpu"));
        }
        let mode = Mode::EmissionAbsorption;
        for (method, on_cpu) in [(Skip::BeamMasks, true), (Skip::KCuts, false)] {
            let method = MethodChoice::Only(method);
            assert_eq!(Way { method, ..way }.is_on_cpu(&mode), on_cpu);
        }
        let sampler = Some(Sampler::Hardware);
        assert!(!Way { sampler, ..way }.is_on_cpu(&mode));
    }
}
