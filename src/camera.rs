//! Cameras: where the picture is taken from, and the rays that follow from it.
//!
//! Local coordinates: the box is [0, extent], one unit is the smallest voxel spacing. x points right, y down in the
//! picture; the camera looks from `eye` to `target` with `up` upwards.

use glam::{DMat4, DVec3, DVec4};

use crate::error::{Error, Result};
use crate::lattice::{Clipping, MAX_SAMPLES_PER_RAY, RayFrame};
use crate::volume::Volume;

/// How rays spread.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Projection {
    /// All rays through the eye.
    Perspective {
        /// Full vertical field of view in degrees, 0 to 180 exclusive.
        fov_y_degrees: f64,
    },
    /// Parallel rays, from a plane through the eye.
    Orthographic {
        /// Height of the picture in local units.
        height: f64,
    },
}

/// A camera in local coordinates. What lies behind the eye (its plane, where rays are parallel) is not drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Where the camera stands.
    pub eye: DVec3,
    /// The point in the middle of the picture.
    pub target: DVec3,
    /// Upwards in the picture; need not be perpendicular to the view.
    pub up: DVec3,
    /// How rays spread.
    pub projection: Projection,
}

/// A camera on a sphere around the box's centre, looking at it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Orbit {
    /// Turn about the up axis in degrees; 0 looks along the first axis after it.
    pub azimuth_degrees: f64,
    /// Height over the plane through the centre in degrees, -90 to 90.
    pub elevation_degrees: f64,
    /// Distance from the centre in longest box edges. The paper's view has 2.
    pub distance_edges: f64,
    /// The axis that points up in the picture: 0, 1, 2 for x, y, z.
    pub up_axis: usize,
    /// Whether up is the axis' negative direction.
    pub up_negative: bool,
    /// Full vertical field of view in degrees; `None` for parallel rays that show the same extent at the centre.
    pub fov_y_degrees: Option<f64>,
}

/// The field of view that pictures have unless told otherwise, in degrees.
pub const DEFAULT_FOV_Y_DEGREES: f64 = 45.0;

/// Where rasterised geometry is clipped in front of the eye's plane, in local units: far below the half voxel within
/// which a segment starts at the eye anyway (design contract 6).
pub const RASTER_NEAR: f64 = 1.0 / 64.0;

impl Default for Orbit {
    fn default() -> Self {
        Self {
            azimuth_degrees: 30.0,
            elevation_degrees: 20.0,
            distance_edges: 2.0,
            up_axis: 2,
            up_negative: false,
            fov_y_degrees: Some(DEFAULT_FOV_Y_DEGREES),
        }
    }
}

impl Orbit {
    /// The camera for a box of these edges (local units).
    pub fn camera(&self, extent: DVec3) -> Camera {
        let (sin_az, cos_az) = self.azimuth_degrees.to_radians().sin_cos();
        let (sin_el, cos_el) = self.elevation_degrees.to_radians().sin_cos();
        let sign = if self.up_negative { -1.0 } else { 1.0 };
        let axis =
            |i: usize| DVec3::from_array(std::array::from_fn(|a| f64::from(u8::from(a == i % 3))));
        let (up, forward, side) = (
            axis(self.up_axis) * sign,
            axis(self.up_axis + 1),
            axis(self.up_axis + 2) * sign,
        );
        let outward = cos_el * (cos_az * forward + sin_az * side) + sin_el * up;
        // Straight from above the up axis is no longer "up in the picture": the limit of lower elevations is.
        let picture_up = cos_el * up - sin_el * (cos_az * forward + sin_az * side);
        let centre = extent * 0.5;
        let distance = self.distance_edges * extent.max_element();
        let projection = match self.fov_y_degrees {
            Some(fov_y_degrees) => Projection::Perspective { fov_y_degrees },
            None => Projection::Orthographic {
                height: 2.0 * distance * (DEFAULT_FOV_Y_DEGREES.to_radians() * 0.5).tan(),
            },
        };
        Camera {
            eye: centre + outward * distance,
            target: centre,
            up: picture_up,
            projection,
        }
    }
}

/// Right, down and forward of a camera; orthonormal.
struct Axes {
    right: DVec3,
    down: DVec3,
    forward: DVec3,
}

impl Camera {
    /// Checks that the camera points somewhere.
    ///
    /// # Errors
    /// [`Error::Setting`] that names the part of the camera that is wrong.
    pub fn check(&self) -> Result<()> {
        let bad =
            |field: &str, reason: &str| Err(Error::setting(format!("camera {field}"), reason));
        if !(self.eye.is_finite() && self.target.is_finite() && self.up.is_finite()) {
            return bad("eye, target, up", "must be finite numbers");
        }
        if (self.target - self.eye).length() <= 0.0 {
            return bad("target", "equals the eye: the view has no direction");
        }
        match self.projection {
            Projection::Perspective { fov_y_degrees }
                if !(fov_y_degrees > 0.0 && fov_y_degrees < 180.0) =>
            {
                bad("fov", "must lie between 0 and 180 degrees")
            }
            Projection::Orthographic { height } if !(height > 0.0 && height.is_finite()) => {
                bad("height", "must be a positive number")
            }
            _ => Ok(()),
        }
    }

    fn axes(&self) -> Axes {
        let forward = (self.target - self.eye).normalize();
        let right = forward.cross(self.up);
        // Up along the view says nothing about the picture's roll: any perpendicular does.
        let right = if right.length() > 1e-9 * self.up.length() {
            right
        } else {
            forward.any_orthogonal_vector()
        };
        let right = right.normalize();
        Axes {
            right,
            down: forward.cross(right),
            forward,
        }
    }

    /// Unit vector from the eye to the target.
    pub fn forward(&self) -> DVec3 {
        self.axes().forward
    }

    /// The rays of a picture of `size` pixels through `volume`, sampled every `step` local units.
    ///
    /// # Errors
    /// [`Error::Setting`] where the camera, size or step is out of range.
    pub fn ray_frame(&self, volume: &Volume, size: [u32; 2], step: f64) -> Result<RayFrame> {
        self.check()?;
        if size[0] == 0 || size[1] == 0 {
            return Err(Error::setting("size", "must be at least 1x1"));
        }
        if !(step > 0.0 && step.is_finite()) {
            return Err(Error::setting(
                "step",
                "must be a positive number of voxels",
            ));
        }
        let extent = volume.extent();
        let axes = self.axes();
        let depth = self.start_depth(extent);
        let (scale, spread) = match self.projection {
            Projection::Perspective { fov_y_degrees } => (
                (fov_y_degrees.to_radians() * 0.5).tan() * 2.0 / f64::from(size[1]),
                true,
            ),
            Projection::Orthographic { height } => (height / f64::from(size[1]), false),
        };
        let (right, down) = (axes.right * scale, axes.down * scale);
        let (start_dx, start_dy, dir_dx, dir_dy) = if spread {
            (right * depth, down * depth, right, down)
        } else {
            (right, down, DVec3::ZERO, DVec3::ZERO)
        };
        let frame = RayFrame {
            start: self.eye + axes.forward * depth,
            start_dx,
            start_dy,
            dir: axes.forward,
            dir_dx,
            dir_dy,
            extent,
            grid_from_local: 1.0 / volume.voxel_size(),
            step,
            size,
            clipping: Clipping::NONE,
            reach: 0.0,
        };
        if frame.max_samples() > MAX_SAMPLES_PER_RAY {
            return Err(Error::setting(
                "step",
                format!(
                    "{step} voxels make over {MAX_SAMPLES_PER_RAY} samples on a ray; take a larger step"
                ),
            ));
        }
        Ok(frame)
    }

    /// Depth along the view of the plane that rays start on: just outside the box, or 0 where the eye's plane cuts it.
    fn start_depth(&self, extent: DVec3) -> f64 {
        let forward = self.axes().forward;
        let nearest = (0..8)
            .map(|i| {
                let corner =
                    DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)) * extent;
                (corner - self.eye).dot(forward)
            })
            .fold(f64::INFINITY, f64::min);
        (nearest - 1e-3 * extent.max_element()).max(0.0)
    }

    /// Clip coordinates of a local position, for rasterising what the rays of [`Self::ray_frame`] will meet.
    ///
    /// `w` is the distance along the view from the eye (perspective) or 1 (orthographic); `z` is not a depth: it only
    /// clips what lies less than [`RASTER_NEAR`] in front of the eye's plane.
    pub fn clip_from_local(&self, size: [u32; 2]) -> DMat4 {
        let axes = self.axes();
        let aspect = f64::from(size[0]) / f64::from(size[1]);
        let row = |v: DVec3, scale: f64| (v * scale).extend(-v.dot(self.eye) * scale);
        let (x, y, z, w) = match self.projection {
            Projection::Perspective { fov_y_degrees } => {
                let f = 1.0 / (fov_y_degrees.to_radians() * 0.5).tan();
                let w = row(axes.forward, 1.0);
                (
                    row(axes.right, f / aspect),
                    row(axes.down, -f),
                    w - DVec4::W * RASTER_NEAR,
                    w,
                )
            }
            Projection::Orthographic { height } => {
                let f = 2.0 / height;
                // Depth over a length that nothing in front of the camera exceeds; small, so that it keeps its sign.
                let z = (row(axes.forward, 1.0) - DVec4::W * RASTER_NEAR) * 1e-9;
                (row(axes.right, f / aspect), row(axes.down, -f), z, DVec4::W)
            }
        };
        DMat4::from_cols(x, y, z, w).transpose()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_orbit_looks_at_the_centre_with_up_upwards() {
        let extent = DVec3::new(10.0, 20.0, 30.0);
        for up_axis in 0..3 {
            for elevation_degrees in [-90.0, -20.0, 0.0, 45.0, 90.0] {
                let orbit = Orbit {
                    elevation_degrees,
                    up_axis,
                    ..Orbit::default()
                };
                let camera = orbit.camera(extent);
                assert!(((camera.eye - camera.target).length() - 60.0).abs() < 1e-9);
                assert!(camera.axes().right.dot(camera.up).abs() < 1e-9);
                assert!(camera.axes().down.dot(camera.up) < 0.0);
            }
        }
    }

    #[test]
    fn the_picture_is_not_mirrored() {
        // Seen from +x with z up, +y is to the right... of an observer at +x looking to -x: right = -x cross z = +y.
        let camera = Camera {
            eye: DVec3::new(10.0, 0.0, 0.0),
            target: DVec3::ZERO,
            up: DVec3::Z,
            projection: Projection::Perspective {
                fov_y_degrees: 45.0,
            },
        };
        assert!((camera.axes().right - DVec3::Y).length() < 1e-12);
        assert!((camera.axes().down + DVec3::Z).length() < 1e-12);
    }

    #[test]
    fn a_point_projects_to_the_pixel_whose_ray_meets_it() {
        let extent = DVec3::new(8.0, 6.0, 4.0);
        for fov_y_degrees in [Some(40.0), None] {
            let camera = Orbit {
                fov_y_degrees,
                ..Orbit::default()
            }
            .camera(extent);
            let size = [64, 48];
            let clip = camera.clip_from_local(size) * DVec3::new(2.0, 5.0, 1.0).extend(1.0);
            let x = (clip.x / clip.w * 0.5 + 0.5) * 64.0 - 32.0;
            let y = (0.5 - clip.y / clip.w * 0.5) * 48.0 - 24.0;
            let axes = camera.axes();
            let along = DVec3::new(2.0, 5.0, 1.0) - camera.eye;
            let (right, down, depth) = (
                along.dot(axes.right),
                along.dot(axes.down),
                along.dot(axes.forward),
            );
            let scale = match camera.projection {
                Projection::Perspective { fov_y_degrees } => {
                    depth * (fov_y_degrees.to_radians() * 0.5).tan() * 2.0 / 48.0
                }
                Projection::Orthographic { height } => height / 48.0,
            };
            assert!((x * scale - right).abs() < 1e-9 && (y * scale - down).abs() < 1e-9);
        }
    }
}
