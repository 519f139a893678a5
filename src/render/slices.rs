//! Slices: polygons across the view through the volume, nearest first, for a rasteriser to blend. The way to draw before
//! programmable hardware cast rays, kept to compare with.

use std::fmt;
use std::str::FromStr;

use glam::DVec3;

use super::Settings;
use crate::camera::Camera;
use crate::error::{Error, Result};
use crate::lattice::Clipping;
use crate::mode::Mode;
use crate::skip::Skip;

/// How many slices a picture is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SliceCount {
    /// One per voxel of the smallest spacing on the way.
    PerVoxel,
    /// So many between the nearest and the farthest corner of the box, or the eye.
    Exactly(u32),
}

impl SliceCount {
    /// Whether slices draw pictures in a mode: where the rasteriser can blend what single samples make.
    pub fn draw(mode: &Mode) -> bool {
        matches!(
            mode,
            Mode::EmissionAbsorption | Mode::Grey(_) | Mode::Mip(_) | Mode::Minip(_)
        )
    }
}

/// The most slices that can be asked for.
const MOST: u32 = 65_536;

impl FromStr for SliceCount {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        if text == "voxel" {
            return Ok(Self::PerVoxel);
        }
        let count = text.parse().ok().filter(|n| (1..=MOST).contains(n));
        count.map(Self::Exactly).ok_or_else(|| {
            let reason = format!("expected voxel (one per voxel) or a number of 1 to {MOST}");
            Error::setting("slices", reason)
        })
    }
}

impl fmt::Display for SliceCount {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::PerVoxel => f.write_str("one per voxel"),
            Self::Exactly(count) => count.fmt(f),
        }
    }
}

/// A corner of a slice, as `shaders/slices` reads it.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct Corner {
    /// Local coordinates.
    pub(super) local: [f32; 3],
    /// From the eye along the view.
    pub(super) depth: f32,
}

/// The slices of one picture.
#[derive(Debug, Clone)]
pub(super) struct Slices {
    /// From one slice to the next, local units (voxels of the smallest spacing): the step of what is drawn.
    pub(super) distance: f64,
    /// Of triangles, nearest slice first.
    pub(super) corners: Vec<Corner>,
}

impl Slices {
    /// The slices of a box [0, extent] that a camera sees, less what is clipped: each in the middle of its share of the way.
    pub(super) fn new(
        count: SliceCount,
        camera: &Camera,
        extent: DVec3,
        clipping: &Clipping,
    ) -> Self {
        let forward = camera.forward();
        let middle = (extent * 0.5 - camera.eye).dot(forward);
        let half = (extent * 0.5).dot(forward.abs());
        let (near, far) = ((middle - half).max(0.0), middle + half);
        let depth = (far - near).max(0.0);
        let distance = match count {
            SliceCount::Exactly(count) if depth > 0.0 => depth / f64::from(count),
            SliceCount::PerVoxel | SliceCount::Exactly(_) => 1.0,
        };
        let planes = half_spaces(extent, clipping);
        let mut corners = Vec::new();
        for i in 0..(depth / distance).round() as u32 {
            let depth = near + (f64::from(i) + 0.5) * distance;
            let slice = slice(camera, extent, depth, &planes);
            let corner = |p: DVec3| Corner {
                local: p.as_vec3().to_array(),
                depth: depth as f32,
            };
            for pair in slice.windows(2).skip(1) {
                corners.extend([slice[0], pair[0], pair[1]].map(corner));
            }
        }
        Self { distance, corners }
    }
}

/// Inward normals and distances of the box's faces and the clip planes.
fn half_spaces(extent: DVec3, clipping: &Clipping) -> Vec<(DVec3, f64)> {
    let faces = [DVec3::X, DVec3::Y, DVec3::Z]
        .into_iter()
        .flat_map(|n| [(n, 0.0), (-n, n.dot(extent))]);
    let planes = clipping.planes().iter();
    let planes = planes.map(|&[x, y, z, distance]| (DVec3::new(x, y, z), distance));
    faces.chain(planes).collect()
}

/// The convex polygon that the half-spaces leave of the plane at this depth: empty, or of three corners and more.
fn slice(camera: &Camera, extent: DVec3, depth: f64, half_spaces: &[(DVec3, f64)]) -> Vec<DVec3> {
    let forward = camera.forward();
    let right = forward.any_orthonormal_vector() * extent.length();
    let up = forward.cross(right);
    let middle = extent * 0.5;
    let middle = middle + (depth - (middle - camera.eye).dot(forward)) * forward;
    let mut polygon = vec![
        middle - right - up,
        middle + right - up,
        middle + right + up,
        middle - right + up,
    ];
    for &(normal, distance) in half_spaces {
        polygon = cut(&polygon, |p| normal.dot(p) + distance);
        if polygon.len() < 3 {
            return Vec::new();
        }
    }
    polygon
}

/// What of a convex polygon has no negative height (Sutherland & Hodgman 1974).
fn cut(polygon: &[DVec3], height: impl Fn(DVec3) -> f64) -> Vec<DVec3> {
    let next = polygon.iter().cycle().skip(1);
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (&a, &b) in polygon.iter().zip(next) {
        let (above, below) = (height(a), height(b));
        if above >= 0.0 {
            kept.push(a);
        }
        if (above >= 0.0) != (below >= 0.0) {
            kept.push(a + (b - a) * (above / (above - below)));
        }
    }
    kept
}

/// Checks that slices can draw what is asked for.
pub(super) fn check(settings: &Settings, backend: &str) -> Result<()> {
    let refused = |field: &str, reason: String| Err(Error::setting(field, reason));
    if backend != "gpu" {
        return refused(
            "renderer",
            format!("slices are drawn by the gpu backend, not by {backend}"),
        );
    }
    if settings.skip != Skip::Box {
        let name = settings.skip.method().name;
        return refused("method", format!("slices skip nothing: {name} is for rays"));
    }
    if !SliceCount::draw(&settings.mode) {
        let name = settings.mode.name();
        return refused(
            "mode",
            format!("slices draw emission-absorption, grey, mip and minip, not {name}"),
        );
    }
    if settings.depth_cue > 0.0 {
        return refused("depth cue", "slices have none".to_owned());
    }
    Ok(())
}

/// Whether near fragments cover far ones in a mode; otherwise the highest counts.
pub(super) fn are_ordered(mode: &Mode) -> bool {
    !mode.keeps_highest()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Orbit, Projection};

    fn area(corners: &[Corner]) -> f64 {
        let at = |c: &Corner| glam::Vec3::from_array(c.local).as_dvec3();
        let triangles = corners.chunks_exact(3);
        triangles
            .map(|t| {
                let [a, b, c] = [at(&t[0]), at(&t[1]), at(&t[2])];
                (b - a).cross(c - a).length() * 0.5
            })
            .sum()
    }

    /// Areas times distances add up to the volume of what is drawn.
    #[test]
    fn slices_fill_what_is_left_of_the_box() {
        let extent = DVec3::new(40.0, 30.0, 20.0);
        let mut half = Clipping::NONE;
        half.keep(DVec3::X, 20.0).unwrap();
        for (azimuth_degrees, elevation_degrees) in [(30.0, 20.0), (0.0, 0.0), (200.0, 85.0)] {
            let camera = Orbit {
                azimuth_degrees,
                elevation_degrees,
                ..Orbit::default()
            }
            .camera(extent);
            for (clipping, expected) in [(Clipping::NONE, 24_000.0), (half, 12_000.0)] {
                let slices = Slices::new(SliceCount::Exactly(200), &camera, extent, &clipping);
                let volume = area(&slices.corners) * slices.distance;
                assert!((volume / expected - 1.0).abs() < 2e-3, "{volume}");
                let is_sorted = slices.corners.is_sorted_by(|a, b| a.depth <= b.depth);
                assert!(is_sorted, "nearest first");
            }
        }
    }

    #[test]
    fn slices_behind_the_eye_are_not_drawn() {
        let extent = DVec3::splat(32.0);
        let inside = Camera {
            eye: extent * 0.5,
            target: extent * 0.5 + DVec3::X,
            up: DVec3::Z,
            projection: Projection::Perspective {
                fov_y_degrees: 60.0,
            },
        };
        let slices = Slices::new(SliceCount::PerVoxel, &inside, extent, &Clipping::NONE);
        assert!((area(&slices.corners) - 16.0 * 32.0 * 32.0).abs() < 1e-3);
        assert!(slices.corners.iter().all(|c| c.local[0] > 16.0));
        let behind = Camera {
            target: extent * 0.5 - DVec3::X,
            eye: DVec3::splat(-5.0),
            ..inside
        };
        let behind = Camera {
            target: behind.eye - DVec3::X,
            ..behind
        };
        let none = Slices::new(SliceCount::Exactly(9), &behind, extent, &Clipping::NONE);
        assert!(none.corners.is_empty());
    }
}
