//! Group 1: where the camera stands.

use glam::DVec3;

use super::Hazard;
use super::scenery::{BLOCK, DIRECTIONS, Scenery, looking, parallel};
use super::volumes::{carved, case, radius};
use crate::camera::{Camera, Orbit, Projection};
use crate::error::Result;
use crate::octree::Occupancy;
use crate::volume::{Volume, phantom};

pub(super) const HAZARDS: &[Hazard] = &[
    Hazard {
        name: "eye-in-cavity",
        group: 1,
        about: "the camera stands in the emptiness inside the object",
        make: || Ok(at(|n| DVec3::splat(n * 0.5 + 0.3))),
    },
    Hazard {
        name: "eye-in-wall",
        group: 1,
        about: "the camera stands in matter: rays begin inside an active block",
        make: || Ok(at(|n| DVec3::new(3.4, n * 0.5 + 0.2, n * 0.5 - 0.7))),
    },
    Hazard {
        name: "eye-on-cut",
        group: 1,
        about: "the camera stands on the plane that half-split cuts at",
        make: || Ok(at(cut)),
    },
    Hazard {
        name: "eye-on-block-face",
        group: 1,
        about: "the camera stands on the face between two leaf blocks",
        make: || Ok(at(|n| DVec3::new(8.0, n * 0.5 + 0.4, 12.0))),
    },
    Hazard {
        name: "eye-on-block-corner",
        group: 1,
        about: "the camera stands where eight leaf blocks meet, half of them active",
        make: || Ok(at(|_| DVec3::splat(4.0))),
    },
    Hazard {
        name: "eye-at-voxel-centre",
        group: 1,
        about: "the camera stands at a voxel's centre: samples lie exactly on the near plane",
        make: || Ok(at(|n| DVec3::new(8.5, n * 0.5 + 0.5, n * 0.5 + 0.5))),
    },
    Hazard {
        name: "eye-at-box-corner",
        group: 1,
        about: "the camera stands at a corner of the box",
        make: || Ok(at(|n| DVec3::new(0.0, n, 0.0))),
    },
    Hazard {
        name: "eye-on-box-face",
        group: 1,
        about: "the camera stands on a face of the box",
        make: || Ok(at(|n| DVec3::new(n * 0.5, 0.0, n * 0.5 + 0.25))),
    },
    Hazard {
        name: "eye-near-wall",
        group: 1,
        about: "the camera stands 10^-3 voxel before the first voxel of a wall",
        make: || Ok(at(|n| DVec3::new(1.5 - 1e-3, n * 0.5 + 0.1, n * 0.5))),
    },
    Hazard {
        name: "eye-far",
        group: 1,
        about: "the camera stands 10^4 box lengths away, the box fills the picture",
        make: || far(|_| shells(33), 0.008),
    },
    Hazard {
        name: "eye-far-wide",
        group: 1,
        about: "the camera stands 10^4 box lengths away, the box is smaller than a pixel",
        make: || far(|_| shells(33), 45.0),
    },
    Hazard {
        name: "eye-far-thin-wall",
        group: 1,
        about: "a wall of one voxel from 10^4 box lengths away: lengths from the eye are coarser than the step",
        make: || far(|n| Ok(case(n, 1, 200)), 0.008),
    },
    Hazard {
        name: "field-of-view",
        group: 1,
        about: "fields of view of 1, 100, 160 and 179 degrees",
        make: fields_of_view,
    },
    Hazard {
        name: "orthographic",
        group: 1,
        about: "parallel rays from outside, from inside and past the box",
        make: orthographic,
    },
    Hazard {
        name: "looking-away",
        group: 1,
        about: "the box lies behind the camera, or beside the picture",
        make: looking_away,
    },
    Hazard {
        name: "magnified-smooth-data",
        group: 1,
        about: "a few smooth voxels fill the picture: the steps of a filter's fractions show",
        make: magnified,
    },
];

/// Where half-split cuts a cube of `n` voxels, on every axis, in the blocks that hazards are drawn with.
fn cut(n: f64) -> DVec3 {
    let occupancy = Occupancy::new([n as usize; 3], BLOCK);
    DVec3::from_array([0, 1, 2].map(|axis| (occupancy.half_cut(axis) * BLOCK) as f64))
}

fn shells(n: usize) -> Result<Volume> {
    phantom::make("shells", [n; 3])
}

/// A case with a ball in it, looked at from one place into all directions. No block size divides its edge.
fn at(eye: fn(f64) -> DVec3) -> Scenery {
    let n = 30;
    let volume = carved("case with a ball", n, |at| {
        let depth = at.iter().map(|&i| i.min(n - 1 - i)).min().unwrap_or(0);
        (2..5).contains(&depth) || (radius(at, n) - 6.0).abs() < 1.0
    });
    let eye = eye(n as f64);
    let cameras = DIRECTIONS.map(|direction| looking(eye, direction, 75.0));
    let cameras = cameras
        .into_iter()
        .chain(DIRECTIONS.map(|d| parallel(eye, d, 20.0)));
    Scenery::new(volume, cameras.collect::<Vec<_>>())
}

fn far(volume: fn(usize) -> Result<Volume>, fov_y_degrees: f64) -> Result<Scenery> {
    let volume = volume(33)?;
    let cameras = [(35.0, 25.0), (0.0, 0.0), (45.0, 35.264), (90.0, 90.0)].map(|(az, el)| {
        Orbit {
            azimuth_degrees: az,
            elevation_degrees: el,
            distance_edges: 1e4,
            fov_y_degrees: Some(fov_y_degrees),
            ..Orbit::default()
        }
        .camera(volume.extent())
    });
    Ok(Scenery::new(volume, cameras))
}

fn fields_of_view() -> Result<Scenery> {
    let volume = shells(33)?;
    let extent = volume.extent();
    let orbit = |fov, distance_edges| {
        Orbit {
            distance_edges,
            fov_y_degrees: Some(fov),
            ..Orbit::default()
        }
        .camera(extent)
    };
    let cameras = [
        orbit(1.0, 2.0),
        orbit(1.0, 60.0),
        orbit(100.0, 0.8),
        orbit(160.0, 0.6),
        orbit(160.0, 0.1),
        orbit(179.0, 0.6),
    ];
    Ok(Scenery::new(volume, cameras))
}

fn orthographic() -> Result<Scenery> {
    let volume = shells(33)?;
    let n = 33.0;
    let middle = DVec3::splat(n * 0.5);
    let from = |direction: DVec3, distance: f64, height: f64| {
        parallel(middle - direction.normalize() * distance, direction, height)
    };
    let mut cameras: Vec<Camera> = DIRECTIONS.iter().map(|&d| from(d, 60.0, 40.0)).collect();
    cameras.extend(DIRECTIONS.iter().map(|&d| from(d, 4.0, 12.0)));
    cameras.push(from(DVec3::X, 60.0, 2000.0));
    cameras.push(from(DVec3::new(1.0, 2.0, 3.0), 1e5, 40.0));
    cameras.push(from(DVec3::new(1.0, 2.0, 3.0), 60.0, 0.01));
    Ok(Scenery::new(volume, cameras))
}

fn looking_away() -> Result<Scenery> {
    let volume = shells(33)?;
    let middle = DVec3::splat(16.5);
    let outside = middle - DVec3::X * 40.0;
    let cameras = [
        looking(outside, DVec3::NEG_X, 60.0),
        looking(outside, DVec3::Y, 60.0),
        looking(outside, DVec3::new(0.3, 1.0, 0.0), 60.0),
        parallel(outside, DVec3::NEG_X, 40.0),
        parallel(middle + DVec3::Y * 60.0, DVec3::X, 40.0),
    ];
    Ok(Scenery::new(volume, cameras))
}

fn magnified() -> Result<Scenery> {
    // Six smooth voxels across the picture, through a table that rises steeply.
    let volume = phantom::make("sphere", [24; 3])?;
    let camera = Camera {
        projection: Projection::Orthographic { height: 3.0 },
        ..looking(DVec3::new(12.3, 12.1, -20.0), DVec3::Z, 45.0)
    };
    let scenery = Scenery::new(
        volume,
        [Camera {
            up: DVec3::Y,
            ..camera
        }],
    );
    Ok(scenery
        .through(&super::scenery::through(&[
            (100.0, 0.0),
            (104.0, 0.9),
            (108.0, 0.0),
        ]))
        .with(|s| s.step_voxels = 0.1))
}
