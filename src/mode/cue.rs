//! Depth cueing: what is far away is darker.

use super::Mode;
use crate::error::{Error, Result};
use crate::lattice::RayFrame;

/// How colours fade with depth. Twin of `shaders/cue/on.inc.wgsl`.
///
/// A sample's colour loses a share of its light that grows linearly from 0 at the nearest point of the box (or the eye, where
/// that is inside) to the strength at the farthest, both along the view. It depends on where the sample lies and on nothing
/// else, and leaves opacities alone: what contributes, and what hides what, stays as it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthCue {
    /// Share of light lost at the farthest point; 0: none anywhere.
    pub strength: f64,
    /// Depth of the nearest point, from the plane that rays start on, local units.
    pub start: f64,
    /// One over the depth between the nearest and the farthest point.
    pub scale: f64,
}

impl DepthCue {
    /// The cue of this strength in a view.
    pub fn new(strength: f64, frame: &RayFrame) -> Self {
        // Depth is linear in the position, so that corners of the box have the extremes.
        let depth_of_origin = -frame.start.dot(frame.dir);
        let edges = frame.extent * frame.dir;
        let nearest = depth_of_origin + edges.min(glam::DVec3::ZERO).element_sum();
        let farthest = depth_of_origin + edges.max(glam::DVec3::ZERO).element_sum();
        let start = nearest.max(0.0);
        Self {
            strength,
            start,
            // Behind the eye there is nothing to fade.
            scale: 1.0 / (farthest - start).max(f64::MIN_POSITIVE.sqrt()),
        }
    }

    /// What is left of the light at a depth from the plane that rays start on, local units.
    pub fn light(&self, depth: f64) -> f64 {
        1.0 - self.strength * ((depth - self.start) * self.scale).clamp(0.0, 1.0)
    }

    /// Checks a strength, and that pictures in `mode` have colours that can fade.
    ///
    /// # Errors
    /// [`Error::Setting`] where it is not between 0 and 1, or neither 0 nor of use to the mode.
    pub fn check(strength: f64, mode: &Mode, backend: &str) -> Result<()> {
        if !(0.0..=1.0).contains(&strength) {
            return Err(Error::setting("depth cue", "must lie between 0 and 1"));
        }
        if strength == 0.0 {
            return Ok(());
        }
        let reason = match mode {
            Mode::Mip(_) | Mode::Minip(_) | Mode::Mean(_) => {
                format!("{} shows values, at no depth of their own", mode.name())
            }
            Mode::Normals { .. } => {
                "the colours of normals are directions, and must not fade".to_owned()
            }
            _ if backend == "cpu" => {
                "the cpu backend does not have it; gpu, reference have it".to_owned()
            }
            _ => return Ok(()),
        };
        Err(Error::setting("depth cue", reason))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Clipping;
    use glam::DVec3;

    #[test]
    fn light_falls_from_the_nearest_to_the_farthest_corner() {
        let frame = |start| RayFrame {
            start,
            start_dx: DVec3::ZERO,
            start_dy: DVec3::ZERO,
            dir: DVec3::new(0.6, -0.8, 0.0),
            dir_dx: DVec3::ZERO,
            dir_dy: DVec3::ZERO,
            extent: DVec3::new(10.0, 5.0, 3.0),
            grid_from_local: DVec3::ONE,
            step: 0.5,
            size: [1, 1],
            clipping: Clipping::NONE,
            reach: 0.0,
        };
        // The nearest corner is (0, 5), the farthest (10, 0): 10 local units deeper.
        let cue = DepthCue::new(0.5, &frame(DVec3::new(0.0, 5.0, 1.0)));
        assert_eq!(
            [cue.light(0.0), cue.light(5.0), cue.light(10.0)],
            [1.0, 0.75, 0.5]
        );
        assert_eq!([cue.light(-3.0), cue.light(30.0)], [1.0, 0.5]);
        // From the middle on, where the eye is there.
        let cue = DepthCue::new(0.5, &frame(DVec3::new(5.0, 2.5, 1.0)));
        assert_eq!([cue.light(0.0), cue.light(5.0)], [1.0, 0.5]);
    }
}
