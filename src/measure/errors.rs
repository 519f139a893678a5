//! How far pictures of one scene are from the truth, over views that are sought where it is worst.
//!
//! A pixel's error does not depend on how many pixels a picture has, so small pictures tell of it; the largest error of a
//! picture grows slowly with its pixels, and is told with its size.

use glam::DVec3;
use serde::Serialize;

use super::metrics::{Metrics, metrics};
use super::truth::{Truth, Truths};
use crate::camera::Camera;
use crate::error::Result;
use crate::render::{Renderer, Settings};
use crate::sample::{Classification, Sampler};

/// What decides a picture's error: lossless methods do not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Accuracy {
    /// HOW samples are taken.
    pub sampler: Sampler,
    /// When samples get their colour.
    pub classification: Classification,
    /// Distance of two samples in voxels of the smallest spacing.
    pub step_voxels: f64,
    /// Accumulated opacity at which a ray stops; 1 or more: never.
    pub ert: f32,
}

impl Accuracy {
    /// `settings` with this accuracy.
    pub fn in_settings(&self, settings: &Settings) -> Settings {
        Settings {
            sampler: Some(self.sampler),
            classification: self.classification,
            step_voxels: self.step_voxels,
            ert: self.ert,
            ..*settings
        }
    }

    /// In words: `sampler exact, classification post, step 0.5, ert 0.98`.
    pub fn words(&self) -> String {
        let ert = if self.ert >= 1.0 {
            "off".to_owned()
        } else {
            self.ert.to_string()
        };
        format!(
            "sampler {}, classification {}, step {:.4}, ert {ert}",
            self.sampler.name(),
            self.classification.name(),
            self.step_voxels
        )
    }
}

/// Which error is meant; a number that is 0 where nothing is off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Measure {
    /// The channel that is off most.
    MaxAbs,
    /// The root of the mean square, of which PSNR is another name.
    Rms,
}

impl Measure {
    fn of(self, metrics: &Metrics) -> f64 {
        match self {
            Self::MaxAbs => metrics.max_abs,
            Self::Rms => metrics.rms,
        }
    }
}

/// Views that are climbed from.
const STARTS: usize = 3;
/// Turns of the camera while climbing.
const TURNS_DEGREES: [f64; 3] = [10.0, 5.0, 2.5];

/// Views with their truths.
pub struct Views<'a> {
    truths: &'a mut Truths,
    settings: Settings,
    measure: Measure,
    seen: Vec<(Camera, Truth)>,
}

/// How far a picture is off over some views.
#[derive(Debug, Clone, PartialEq)]
pub struct Errors {
    /// One for each view.
    pub of_views: Vec<f64>,
}

impl Errors {
    /// The largest.
    pub fn largest(&self) -> f64 {
        self.of_views.iter().copied().fold(0.0, f64::max)
    }

    /// So many views with the largest, the worst first.
    fn worst(&self, count: usize) -> Vec<usize> {
        let mut views: Vec<usize> = (0..self.of_views.len()).collect();
        views.sort_by(|&a, &b| self.of_views[b].total_cmp(&self.of_views[a]));
        views.truncate(count);
        views
    }

    /// What other views are expected to stay below: the largest and, for what was not seen, the standard deviation over the
    /// views.
    pub fn expected(&self) -> f64 {
        let n = self.of_views.len() as f64;
        let mean = self.of_views.iter().sum::<f64>() / n;
        let squares = self
            .of_views
            .iter()
            .map(|e| (e - mean).powi(2))
            .sum::<f64>();
        let deviation = if n > 1.0 {
            (squares / (n - 1.0)).sqrt()
        } else {
            0.0
        };
        self.largest() + deviation
    }
}

impl<'a> Views<'a> {
    /// Truths of these cameras; all else is as `settings` have it.
    ///
    /// # Errors
    /// As [`Truths::of`].
    pub fn new(
        truths: &'a mut Truths,
        settings: &Settings,
        measure: Measure,
        cameras: &[Camera],
        progress: &mut dyn FnMut(f64),
    ) -> Result<Self> {
        let mut views = Self {
            truths,
            settings: *settings,
            measure,
            seen: Vec::new(),
        };
        for (i, &camera) in cameras.iter().enumerate() {
            views.see(camera, &mut |done| {
                progress((i as f64 + done) / cameras.len() as f64);
            })?;
        }
        Ok(views)
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.seen.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.seen.is_empty()
    }

    fn see(&mut self, camera: Camera, progress: &mut dyn FnMut(f64)) -> Result<()> {
        let settings = Settings {
            camera,
            ..self.settings
        };
        let truth = self.truths.of(&settings, progress)?;
        self.seen.push((camera, truth));
        Ok(())
    }

    /// The errors of pictures of this accuracy. Stops at the first view whose error is above `limit`.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn errors(
        &self,
        renderer: &mut Renderer,
        accuracy: &Accuracy,
        limit: f64,
    ) -> Result<Errors> {
        let mut of_views = Vec::with_capacity(self.seen.len());
        // What was found last is most likely what is worst.
        for view in (0..self.seen.len()).rev() {
            let error = self.error(renderer, accuracy, view)?;
            of_views.push(error);
            if error > limit {
                break;
            }
        }
        of_views.resize(self.seen.len().max(of_views.len()), 0.0);
        of_views.reverse();
        Ok(Errors { of_views })
    }

    /// Goes from each of the worst views to where it is worse still, around the camera's target, in smaller and smaller turns;
    /// adds what it finds to the views, and gives their errors.
    ///
    /// # Errors
    /// As [`Self::errors`] and [`Truths::of`].
    pub fn climb(&mut self, renderer: &mut Renderer, accuracy: &Accuracy) -> Result<Errors> {
        let mut errors = self.errors(renderer, accuracy, f64::INFINITY)?;
        for start in errors.worst(STARTS) {
            let (mut top, _) = self.seen[start];
            let mut worst = errors.of_views[start];
            for turn in TURNS_DEGREES {
                let from = top;
                for direction in around(&from, turn) {
                    let camera = seen_from(&from, direction);
                    self.see(camera, &mut |_| ())?;
                    let error = self.error(renderer, accuracy, self.seen.len() - 1)?;
                    if error > worst {
                        (top, worst) = (camera, error);
                        errors.of_views.push(error);
                    } else {
                        self.seen.pop();
                    }
                }
            }
        }
        Ok(errors)
    }

    /// The error of one view.
    fn error(&self, renderer: &mut Renderer, accuracy: &Accuracy, view: usize) -> Result<f64> {
        let (camera, truth) = &self.seen[view];
        let settings = Settings {
            camera: *camera,
            ..accuracy.in_settings(&self.settings)
        };
        let picture = renderer.render(&settings)?.picture;
        Ok(self.measure.of(&metrics([(&picture, truth)])))
    }
}

/// So many cameras all around what `camera` looks at, as far from it; they lie evenly, on a spiral (the golden angle apart).
pub fn all_around(camera: &Camera, count: usize) -> Vec<Camera> {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    (0..count)
        .map(|i| {
            let z = 1.0 - (2.0 * i as f64 + 1.0) / count as f64;
            let radius = (1.0 - z * z).sqrt();
            let (sin, cos) = (golden * i as f64).sin_cos();
            seen_from(camera, DVec3::new(radius * cos, radius * sin, z))
        })
        .collect()
}

/// The camera moved to this side (a unit vector) of its target, as far from it.
pub fn seen_from(camera: &Camera, direction: DVec3) -> Camera {
    let distance = (camera.eye - camera.target).length();
    let up = camera.up.normalize();
    // Straight from above, up must be another direction.
    let up = if up.cross(direction).length() < 0.1 {
        direction.any_orthonormal_vector()
    } else {
        up
    };
    Camera {
        eye: camera.target + distance * direction,
        up,
        ..*camera
    }
}

/// Six directions around the camera's, turned by so much.
fn around(camera: &Camera, degrees: f64) -> [DVec3; 6] {
    let direction = (camera.eye - camera.target).normalize();
    let (a, b) = direction.any_orthonormal_pair();
    let (sin_turn, cos_turn) = degrees.to_radians().sin_cos();
    std::array::from_fn(|i| {
        let (sin, cos) = (std::f64::consts::TAU * i as f64 / 6.0).sin_cos();
        cos_turn * direction + sin_turn * (cos * a + sin * b)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Orbit;

    #[test]
    fn cameras_around_a_place_look_at_it_from_afar_and_lie_evenly() {
        let camera = Orbit::default().camera(DVec3::new(10.0, 20.0, 30.0));
        let distance = (camera.eye - camera.target).length();
        let all = all_around(&camera, 20);
        let mut middle = DVec3::ZERO;
        for other in &all {
            other.check().unwrap();
            assert!(((other.eye - other.target).length() - distance).abs() < 1e-9);
            assert_eq!(other.target, camera.target);
            middle += (other.eye - other.target) / distance / 20.0;
        }
        assert!(middle.length() < 0.1, "{middle}");
        for direction in around(&camera, 10.0) {
            let cos = direction.dot((camera.eye - camera.target).normalize());
            assert!((cos - 10.0_f64.to_radians().cos()).abs() < 1e-12);
            seen_from(&camera, direction).check().unwrap();
        }
    }

    #[test]
    fn what_is_expected_is_no_less_than_what_was_seen() {
        let errors = Errors {
            of_views: vec![1.0, 3.0, 2.0],
        };
        assert_eq!((errors.largest(), errors.worst(2)), (3.0, vec![1, 2]));
        assert_eq!(errors.expected(), 4.0);
        assert_eq!(
            Errors {
                of_views: vec![2.0]
            }
            .expected(),
            2.0
        );
    }
}
