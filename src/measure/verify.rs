//! Bit-identity, tried: every lossless method against box casting over scenes, views and settings.

use std::sync::Arc;

use glam::DVec3;

use crate::camera::{Camera, Orbit, Projection};
use crate::error::Result;
use crate::lattice::Clipping;
use crate::mode::Mode;
use crate::render::{Renderer, Settings};
use crate::sample::{Classification, Gradients, Sampler};
use crate::scene::Picture;
use crate::skip::{Cuts, METHODS, Skip};
use crate::transfer::TransferFunction;
use crate::volume::Volume;

/// Where a scene is looked at from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum View {
    /// Outside, all of the box in the picture.
    Outside,
    /// In the emptiness nearest the volume's middle.
    Cavity,
    /// In the visible matter nearest the volume's middle.
    Wall,
}

impl View {
    /// All views.
    pub const ALL: [Self; 3] = [Self::Outside, Self::Cavity, Self::Wall];

    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Outside => "outside",
            Self::Cavity => "cavity",
            Self::Wall => "wall",
        }
    }

    /// The camera of this view of a volume, of which `transfer` shows some.
    pub fn camera(self, volume: &Volume, transfer: &TransferFunction, is_parallel: bool) -> Camera {
        let extent = volume.extent();
        let eye = match self {
            Self::Outside => {
                let fov_y_degrees = (!is_parallel).then_some(crate::camera::DEFAULT_FOV_Y_DEGREES);
                let orbit = Orbit {
                    azimuth_degrees: 35.0,
                    elevation_degrees: 25.0,
                    fov_y_degrees,
                    ..Orbit::default()
                };
                return orbit.camera(extent);
            }
            Self::Cavity => nearest(volume, |opacity| opacity == 0.0, transfer),
            Self::Wall => nearest(volume, |opacity| opacity > 0.0, transfer),
        };
        let projection = if is_parallel {
            Projection::Orthographic {
                height: extent.max_element() * 0.7,
            }
        } else {
            Projection::Perspective {
                fov_y_degrees: 75.0,
            }
        };
        Camera {
            eye,
            target: eye + DVec3::new(0.8, 0.5, -0.33),
            up: DVec3::Z,
            projection,
        }
    }
}

/// Centre (local coordinates) of the voxel nearest the middle whose opacity is as wanted; the middle if there is none.
fn nearest(volume: &Volume, is_wanted: impl Fn(f64) -> bool, transfer: &TransferFunction) -> DVec3 {
    let middle = volume.dims.map(|n| n as f64 * 0.5);
    let mut best = (f64::INFINITY, DVec3::from_array(middle));
    crate::with_voxels!(&volume.voxels, voxels => {
        let mut index = 0;
        for z in 0..volume.dims[2] {
            for y in 0..volume.dims[1] {
                for x in 0..volume.dims[0] {
                    let centre = DVec3::new(x as f64, y as f64, z as f64) + 0.5;
                    let distance = (centre - DVec3::from_array(middle)).length_squared();
                    if distance < best.0 {
                        let value = volume.rescale.value_from_stored(f64::from(voxels[index]));
                        if is_wanted(transfer.at(value).1) {
                            best = (distance, centre);
                        }
                    }
                    index += 1;
                }
            }
        }
    });
    best.1 * volume.voxel_size()
}

/// One comparison: a scene's settings, under which every method is compared with box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Case {
    /// Where from.
    pub view: View,
    /// Whether rays are parallel.
    pub is_parallel: bool,
    /// Leaf block edge in voxels.
    pub block: usize,
    /// Step in parts of the longest box edge.
    pub step_edges: f64,
    /// Accumulated opacity at which rays stop; 1: never.
    pub ert: f32,
    /// HOW.
    pub sampler: Sampler,
}

/// Block sizes of the matrix.
pub const BLOCKS: [usize; 4] = [4, 8, 16, 32];
/// Steps of the matrix: the paper's.
pub const STEPS: [f64; 3] = [0.002, 0.005, 0.01];
/// Early termination thresholds of the matrix.
pub const THRESHOLDS: [f32; 2] = [0.98, 1.0];
/// Samplers of the pairwise cases. The B-spline costs eight times as much and more: [`matrix`] tries it where it is named.
pub const SAMPLERS: [Sampler; 3] = [Sampler::Hardware, Sampler::Exact, Sampler::Nearest];

/// Every combination of the settings, with these samplers. Cases that differ in the block alone follow one another.
pub fn matrix(samplers: &[Sampler]) -> Vec<Case> {
    let mut cases = Vec::new();
    for view in View::ALL {
        for is_parallel in [false, true] {
            for step_edges in STEPS {
                for ert in THRESHOLDS {
                    for &sampler in samplers {
                        cases.extend(BLOCKS.map(|block| Case {
                            view,
                            is_parallel,
                            block,
                            step_edges,
                            ert,
                            sampler,
                        }));
                    }
                }
            }
        }
    }
    cases
}

/// Cases in which every pair of two settings' values occurs together, chosen greedily from [`matrix`].
///
/// # Panics
/// Never: cases are made of the values that are looked up.
pub fn pairwise() -> Vec<Case> {
    let all = matrix(&SAMPLERS);
    let key = |c: &Case| {
        let position = |found: Option<usize>| found.expect("cases are made of these values");
        [
            position(View::ALL.iter().position(|v| *v == c.view)),
            usize::from(c.is_parallel),
            position(STEPS.iter().position(|s| *s == c.step_edges)),
            position(THRESHOLDS.iter().position(|t| *t == c.ert)),
            position(SAMPLERS.iter().position(|s| *s == c.sampler)),
            position(BLOCKS.iter().position(|b| *b == c.block)),
        ]
    };
    let pairs = |c: &Case| {
        let k = key(c);
        let mut pairs = Vec::new();
        for i in 0..k.len() {
            for j in i + 1..k.len() {
                pairs.push((i, k[i], j, k[j]));
            }
        }
        pairs
    };
    let mut open: std::collections::BTreeSet<_> = all.iter().flat_map(pairs).collect();
    let mut chosen = Vec::new();
    while !open.is_empty() {
        let gain = |c: &&Case| pairs(c).iter().filter(|p| open.contains(p)).count();
        // The first of the best, so that the list is the same every time.
        let best = all
            .iter()
            .rev()
            .max_by_key(gain)
            .expect("the matrix is not empty");
        for pair in pairs(best) {
            open.remove(&pair);
        }
        chosen.push(*best);
    }
    chosen
}

/// How one method did in one case.
#[derive(Debug, Clone, Copy)]
pub struct Outcome {
    /// The method.
    pub skip: Skip,
    /// Pixels with any bit different from box.
    pub differing_pixels: u64,
    /// Largest difference of any channel.
    pub max_abs: f64,
}

/// Draws cases of one volume and compares.
pub struct Verifier<'a> {
    renderer: &'a mut Renderer,
    volume: &'a Arc<Volume>,
    transfer: &'a TransferFunction,
    /// What is compared with box.
    methods: Vec<Skip>,
    mode: Mode,
    classification: Classification,
    gradients: Gradients,
    depth_cue: f64,
    clipping: Clipping,
    cuts: Cuts,
    size: [u32; 2],
    /// The last case's picture by box, which does not depend on the block.
    by_box: Option<(Case, Picture)>,
}

impl<'a> Verifier<'a> {
    /// For pictures of `size` pixels, cut as `cuts` says, by a renderer whose volume and transfer function are these.
    pub fn new(
        renderer: &'a mut Renderer,
        volume: &'a Arc<Volume>,
        transfer: &'a TransferFunction,
        cuts: Cuts,
        size: [u32; 2],
    ) -> Self {
        let methods = METHODS
            .iter()
            .filter(|m| m.lossless && m.skip != Skip::Box)
            .map(|m| m.skip);
        let methods = methods.filter(|&m| renderer.has(m)).collect();
        Self {
            renderer,
            volume,
            transfer,
            methods,
            mode: Mode::EmissionAbsorption,
            classification: Classification::Post,
            gradients: Gradients::Fly,
            depth_cue: 0.0,
            clipping: Clipping::NONE,
            cuts,
            size,
            by_box: None,
        }
    }

    /// Compares these methods alone. One that the backend does not have is refused when it is drawn.
    #[must_use]
    pub fn with_methods(self, methods: Vec<Skip>) -> Self {
        Self { methods, ..self }
    }

    /// Draws in this mode instead of emission and absorption.
    #[must_use]
    pub fn with_mode(self, mode: Mode) -> Self {
        Self { mode, ..self }
    }

    /// Draws with gradients from here, and with a depth cue of this strength.
    #[must_use]
    pub fn with_shading(self, gradients: Gradients, depth_cue: f64) -> Self {
        Self {
            gradients,
            depth_cue,
            ..self
        }
    }

    /// Classifies samples this way instead of after interpolation.
    #[must_use]
    pub fn with_classification(self, classification: Classification) -> Self {
        Self {
            classification,
            ..self
        }
    }

    /// Draws what these planes leave.
    #[must_use]
    pub fn with_clipping(self, clipping: Clipping) -> Self {
        Self { clipping, ..self }
    }

    /// Draws a case with every method, and compares with box.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn run(&mut self, case: &Case) -> Result<Vec<Outcome>> {
        let mut settings = Settings {
            sampler: Some(case.sampler),
            mode: self.mode,
            classification: self.classification,
            gradients: self.gradients,
            depth_cue: self.depth_cue,
            block: case.block,
            step_voxels: case.step_edges * self.volume.extent().max_element(),
            ert: case.ert,
            size: self.size,
            clipping: self.clipping,
            table_entries: 256,
            cuts: self.cuts,
            ..Settings::new(
                case.view
                    .camera(self.volume, self.transfer, case.is_parallel),
            )
        };
        let by_box = match self.by_box.take() {
            Some((last, picture))
                if (Case {
                    block: case.block,
                    ..last
                }) == *case =>
            {
                picture
            }
            _ => self.renderer.render(&settings)?.picture,
        };
        let mut outcomes = Vec::new();
        for &skip in &self.methods {
            settings.skip = skip;
            let difference = self.renderer.render(&settings)?.picture.difference(&by_box);
            outcomes.push(Outcome {
                skip,
                differing_pixels: difference.pixels,
                max_abs: difference.max_abs,
            });
        }
        self.by_box = Some((*case, by_box));
        Ok(outcomes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairwise_cases_hold_every_pair_in_few_cases() {
        let cases = pairwise();
        assert!(
            cases.len() < matrix(&SAMPLERS).len() / 8,
            "{} cases",
            cases.len()
        );
        for view in View::ALL {
            for block in BLOCKS {
                assert!(cases.iter().any(|c| c.view == view && c.block == block));
            }
        }
        for step in STEPS {
            for ert in THRESHOLDS {
                assert!(cases.iter().any(|c| c.step_edges == step && c.ert == ert));
            }
        }
    }
}
