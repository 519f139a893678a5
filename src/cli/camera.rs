//! `--camera`: around the box, or at a place in it.

use std::str::FromStr;

use glam::DVec3;
use hollowcast::camera::{Camera, DEFAULT_FOV_Y_DEGREES, Orbit, Projection};
use hollowcast::volume::Volume;

use super::values::vector;

pub(super) const HELP: &str = "\
Where the picture is taken from. Around the box, all parts optional:
  az=30,el=20,dist=2,up=z,fov=45
azimuth and elevation in degrees, distance from the box's centre in longest box edges, the axis that points up (x, y, z, \
-x, -y, -z), vertical field of view in degrees; or ortho instead of fov for parallel rays.
At a place, parts parted by semicolons, in voxels (voxel i's centre is at i + 1/2; the box is 0 to the number of voxels):
  eye=-200,90,90;target=128,128,89;up=0,0,1;fov=45
target defaults to the box's centre, up to 0,0,1; ortho or ortho=HEIGHT (in voxels of the smallest spacing) for parallel \
rays.";

/// A camera before the volume is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum CameraSpec {
    /// Looking at the box from around it.
    Around(Orbit),
    /// From a place, in grid coordinates.
    At {
        eye: DVec3,
        target: Option<DVec3>,
        up: DVec3,
        rays: Rays,
    },
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Rays {
    Perspective { fov_y_degrees: f64 },
    Parallel { height: Option<f64> },
}

impl Default for CameraSpec {
    fn default() -> Self {
        Self::Around(Orbit::default())
    }
}

impl CameraSpec {
    /// The camera for this volume, turned by `turn_degrees` more where it goes around the box.
    pub(super) fn camera(&self, volume: &Volume, turn_degrees: f64) -> Camera {
        match *self {
            Self::Around(orbit) => Orbit {
                azimuth_degrees: orbit.azimuth_degrees + turn_degrees,
                ..orbit
            }
            .camera(volume.extent()),
            Self::At {
                eye,
                target,
                up,
                rays,
            } => {
                let local_from_grid = volume.voxel_size();
                let eye = eye * local_from_grid;
                let target = target.map_or(volume.extent() * 0.5, |t| t * local_from_grid);
                let projection = match rays {
                    Rays::Perspective { fov_y_degrees } => {
                        Projection::Perspective { fov_y_degrees }
                    }
                    // As much as the usual field of view shows at the target.
                    Rays::Parallel { height } => Projection::Orthographic {
                        height: height.unwrap_or_else(|| {
                            let half = (DEFAULT_FOV_Y_DEGREES * 0.5).to_radians().tan();
                            2.0 * half * (target - eye).length()
                        }),
                    },
                };
                Camera {
                    eye,
                    target,
                    up: up * local_from_grid,
                    projection,
                }
            }
        }
    }
}

impl CameraSpec {
    /// Whether it goes around the box.
    pub(super) fn is_around(&self) -> bool {
        matches!(self, Self::Around(_))
    }

    /// So many views evenly around the box; a camera at a place is one.
    pub(super) fn views(&self, volume: &Volume, count: u32) -> Vec<Camera> {
        let count = match self {
            Self::Around(_) => count,
            Self::At { .. } => 1,
        };
        let turn = |i: u32| 360.0 * f64::from(i) / f64::from(count);
        (0..count).map(|i| self.camera(volume, turn(i))).collect()
    }
}

impl FromStr for CameraSpec {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let at_a_place = text.contains(';') || text.trim_start().starts_with("eye=");
        let parts = text
            .split(if at_a_place { ';' } else { ',' })
            .map(|part| part.trim().split_once('=').unwrap_or((part.trim(), "")));
        if at_a_place { at(parts) } else { around(parts) }
    }
}

fn number(key: &str, value: &str) -> Result<f64, String> {
    value
        .parse()
        .ok()
        .filter(|n| f64::is_finite(*n))
        .ok_or_else(|| format!("{key}: expected a number, found {value:?}"))
}

fn around<'a>(parts: impl Iterator<Item = (&'a str, &'a str)>) -> Result<CameraSpec, String> {
    let mut orbit = Orbit::default();
    for (key, value) in parts {
        match key {
            "az" => orbit.azimuth_degrees = number(key, value)?,
            "el" => {
                orbit.elevation_degrees = number(key, value)?;
                if orbit.elevation_degrees.abs() > 90.0 {
                    return Err("el: expected -90 to 90 degrees".to_owned());
                }
            }
            "dist" => {
                orbit.distance_edges = number(key, value)?;
                if orbit.distance_edges <= 0.0 {
                    return Err("dist: expected a number above 0".to_owned());
                }
            }
            "fov" => orbit.fov_y_degrees = Some(number(key, value)?),
            "ortho" if value.is_empty() => orbit.fov_y_degrees = None,
            "ortho" => return Err("ortho: takes no number beside az, el and dist".to_owned()),
            "up" => {
                orbit.up_negative = value.starts_with('-');
                orbit.up_axis = ["x", "y", "z"]
                    .iter()
                    .position(|&axis| axis == value.trim_start_matches(['-', '+']))
                    .ok_or("up: expected x, y, z, -x, -y or -z")?;
            }
            _ => {
                return Err(format!(
                    "{key:?} is none of az, el, dist, up, fov, ortho (nor eye, target, up, parted by semicolons)"
                ));
            }
        }
    }
    Ok(CameraSpec::Around(orbit))
}

fn at<'a>(parts: impl Iterator<Item = (&'a str, &'a str)>) -> Result<CameraSpec, String> {
    let (mut eye, mut target, mut up) = (None, None, DVec3::Z);
    let mut rays = Rays::Perspective {
        fov_y_degrees: DEFAULT_FOV_Y_DEGREES,
    };
    for (key, value) in parts {
        let place = || {
            vector(value)
                .map(DVec3::from_array)
                .map_err(|e| format!("{key}: {e}"))
        };
        match key {
            "eye" => eye = Some(place()?),
            "target" => target = Some(place()?),
            "up" => up = place()?,
            "fov" => {
                rays = Rays::Perspective {
                    fov_y_degrees: number(key, value)?,
                };
            }
            "ortho" if value.is_empty() => rays = Rays::Parallel { height: None },
            "ortho" => {
                rays = Rays::Parallel {
                    height: Some(number(key, value)?),
                };
            }
            _ => return Err(format!("{key:?} is none of eye, target, up, fov, ortho")),
        }
    }
    Ok(CameraSpec::At {
        eye: eye.ok_or("eye is missing")?,
        target,
        up,
        rays,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_orbit_keeps_the_defaults_of_what_is_not_said() {
        let spec: CameraSpec = "el=-10,up=-y".parse().unwrap();
        let expected = Orbit {
            elevation_degrees: -10.0,
            up_axis: 1,
            up_negative: true,
            ..Orbit::default()
        };
        assert_eq!(spec, CameraSpec::Around(expected));
        let CameraSpec::Around(parallel) = "ortho".parse().unwrap() else {
            panic!("an orbit")
        };
        assert_eq!(parallel.fov_y_degrees, None);
    }

    #[test]
    fn a_place_is_given_with_semicolons() {
        let spec: CameraSpec = "eye=1,2,3;ortho=10".parse().unwrap();
        let expected = CameraSpec::At {
            eye: DVec3::new(1.0, 2.0, 3.0),
            target: None,
            up: DVec3::Z,
            rays: Rays::Parallel { height: Some(10.0) },
        };
        assert_eq!(spec, expected);
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (text, named) in [
            ("azimuth=3", "azimuth"),
            ("az=north", "az"),
            ("el=91", "el"),
            ("dist=0", "dist"),
            ("up=w", "up"),
            ("eye=1,2", "eye"),
            ("target=1,2,3;up=0,0,1", "eye"),
            ("eye=1,2,3;roll=4", "roll"),
        ] {
            let error = text.parse::<CameraSpec>().unwrap_err();
            assert!(error.contains(named), "{text}: {error}");
        }
    }
}
