//! Groups 3, 4 and 9: what may change from one frame to the next, and what may not.

use glam::DVec3;

use super::Hazard;
use super::scenery::{Scenery, looking, ramp, through};
use super::volumes::{carved, radius, shells};
use crate::camera::{Camera, Orbit};
use crate::error::Result;
use crate::volume::phantom;

pub(super) const ORBITS: &[Hazard] = &[
    Hazard {
        name: "orbit-across-45",
        group: 3,
        about: "azimuth from 44.5 to 45.5 degrees by 0.1: the axis that methods cut across changes",
        make: || orbit(|t| (44.5 + t, 20.0)),
    },
    Hazard {
        name: "orbit-over-the-edge",
        group: 3,
        about: "elevation from 44.5 to 45.5 degrees by 0.1",
        make: || orbit(|t| (10.0, 44.5 + t)),
    },
    Hazard {
        name: "orbit-around-the-corner",
        group: 3,
        about: "around the diagonal of the box by at most 0.1 degree: all three axes compete",
        make: || {
            orbit(|t| {
                // Ten steps around a circle of this radius are chords of 2 r sin(18 degrees) < 0.1 degrees.
                const RADIUS_DEGREES: f64 = 0.16;
                let turn = t * std::f64::consts::TAU;
                let (east, north) = (RADIUS_DEGREES * turn.cos(), RADIUS_DEGREES * turn.sin());
                (45.0 + east, 35.264_39 + north)
            })
        },
    },
    Hazard {
        name: "orbit-parallel-rays",
        group: 3,
        about: "the same change of axis with parallel rays, whose tiles all change at once",
        make: || circled(|t| (44.5 + t, 20.0), None),
    },
];

/// With perspective: see [`circled`].
fn orbit(place: impl Fn(f64) -> (f64, f64)) -> Result<Scenery> {
    circled(place, Orbit::default().fov_y_degrees)
}

/// Eleven frames around a hollow ball, at the azimuth and elevation of `t` = 0, 0.1 ... 1; parallel rays without a field
/// of view.
fn circled(place: impl Fn(f64) -> (f64, f64), fov_y_degrees: Option<f64>) -> Result<Scenery> {
    let volume = phantom::make("shells", [32; 3])?;
    let extent = volume.extent();
    let cameras: Vec<Camera> = (0..=10)
        .map(|i| {
            let (azimuth_degrees, elevation_degrees) = place(f64::from(i) * 0.1);
            Orbit {
                azimuth_degrees,
                elevation_degrees,
                distance_edges: 1.6,
                fov_y_degrees,
                ..Orbit::default()
            }
            .camera(extent)
        })
        .collect();
    Ok(Scenery::new(volume, cameras).in_sequence())
}

pub(super) const MOVEMENTS: &[Hazard] = &[
    Hazard {
        name: "tiny-movements-outside",
        group: 4,
        about: "the camera moves by 10^-6 to 10^-2 of the box, outside",
        make: || Ok(moving(DVec3::new(-20.0, -30.0, 40.0), 45.0)),
    },
    Hazard {
        name: "tiny-movements-inside",
        group: 4,
        about: "the same inside the cavity",
        make: || Ok(moving(DVec3::new(14.1, 17.3, 15.2), 75.0)),
    },
    Hazard {
        name: "tiny-movements-through-a-wall",
        group: 4,
        about: "the same across the outside of a wall",
        make: || Ok(moving(DVec3::new(1.999_99, 16.3, 15.2), 75.0)),
    },
    Hazard {
        name: "tiny-movements-across-the-cut",
        group: 4,
        about: "the same across the plane of the cut, a block's face and a voxel's centre",
        make: || Ok(moving(DVec3::splat(16.0 - 1e-6), 75.0)),
    },
];

fn moving(eye: DVec3, fov: f64) -> Scenery {
    let n = 32;
    let volume = carved("case with a ball", n, |at| {
        let depth = at.iter().map(|&i| i.min(n - 1 - i)).min().unwrap_or(0);
        (2..4).contains(&depth) || (5.0..7.0).contains(&radius(at, n))
    });
    let middle = DVec3::splat(n as f64 * 0.5);
    let toward = DVec3::new(0.8, 0.5, -0.33);
    let forward = if (middle - eye).length() > n as f64 {
        middle - eye
    } else {
        toward
    };
    let movements = [0.0, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2];
    let cameras = movements.map(|part| {
        let moved = eye + DVec3::new(1.0, 1.0, 0.7) * (part * n as f64);
        looking(moved, forward, fov)
    });
    Scenery::new(volume, cameras).in_sequence()
}

pub(super) const CHANGES: &[Hazard] = &[
    Hazard {
        name: "table-between-frames",
        group: 9,
        about: "the transfer function changes between frames: culled differently, coloured differently, and back",
        make: tables_between_frames,
    },
    Hazard {
        name: "view-between-frames",
        group: 9,
        about: "view, size, block, step and threshold change between frames, and back",
        make: || Ok(views_between_frames()),
    },
];

fn tables_between_frames() -> Result<Scenery> {
    let tables = [
        ramp(40.0, 255.0, 0.3),
        // The same entries are visible: what was culled holds, colours do not.
        ramp(40.0, 255.0, 0.05),
        through(&[(40.0, 0.0), (60.0, 0.6), (80.0, 0.0)]),
        ramp(254.0, 255.0, 1.0),
        through(&[(0.0, 0.1), (20.0, 0.0)]),
        ramp(40.0, 255.0, 0.3),
    ];
    let scenery = Scenery::from_outside(phantom::make("shells", [32; 3])?);
    Ok(scenery.for_each(tables, |frame, table| frame.transfer = table.clone()))
}

fn views_between_frames() -> Scenery {
    let volume = shells(32, 6);
    let extent = volume.extent();
    let cameras = (0..8).map(|i| {
        Orbit {
            azimuth_degrees: 97.0 * f64::from(i),
            elevation_degrees: 61.0 * (f64::from(i) * 1.3).sin(),
            distance_edges: [1.6, 0.3, 4.0][i as usize % 3],
            ..Orbit::default()
        }
        .camera(extent)
    });
    let mut scenery = Scenery::new(volume, cameras.collect::<Vec<_>>());
    for (i, frame) in scenery.frames.iter_mut().enumerate() {
        let s = &mut frame.settings;
        s.size = [[45, 45], [90, 17], [8, 8], [33, 70]][i % 4];
        s.block = [4, 8, 4, 16, 32][i % 5];
        s.step_voxels = [0.5, 0.3, 0.5][i % 3];
        s.ert = [1.0, 0.9][i % 2];
    }
    let first = scenery.frames[0].clone();
    scenery.frames.push(first);
    scenery
}
