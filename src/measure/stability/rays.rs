//! Group 2: rays along axes, planes, edges and corners.

use glam::DVec3;

use super::Hazard;
use super::scenery::{Scenery, looking, parallel};
use super::volumes::{carved, radius};
use crate::camera::Camera;
use crate::lattice::PARALLEL;
use crate::volume::Volume;

pub(super) const HAZARDS: &[Hazard] = &[
    Hazard {
        name: "axis-parallel",
        group: 2,
        about: "every ray is parallel to an axis, both ways, through voxel centres",
        make: || Ok(Scenery::new(object(), along_axes(0.5))),
    },
    Hazard {
        name: "along-block-faces",
        group: 2,
        about: "rays parallel to an axis lie in the faces between voxels, blocks and halves",
        make: || Ok(Scenery::new(object(), along_axes(0.0))),
    },
    Hazard {
        name: "negative-zero",
        group: 2,
        about: "direction components are exactly 0 and -0, in perspective too",
        make: || Ok(Scenery::new(object(), negative_zero())),
    },
    Hazard {
        name: "almost-parallel",
        group: 2,
        about: "rays tilted by 10^-6 to 10^-13, around the limit from which on they count as parallel",
        make: || Ok(almost_parallel()),
    },
    Hazard {
        name: "along-the-cut",
        group: 2,
        about: "rays lie in the plane that half-split cuts at, or cross it at a thousandth of a degree",
        make: || Ok(along_the_cut()),
    },
    Hazard {
        name: "through-edges",
        group: 2,
        about: "diagonal rays go through the edges of voxels and blocks",
        make: || Ok(Scenery::new(object(), diagonals(DVec3::new(1.0, 1.0, 0.0)))),
    },
    Hazard {
        name: "through-corners",
        group: 2,
        about: "diagonal rays go through the corners of voxels, blocks and the box",
        make: || Ok(Scenery::new(object(), diagonals(DVec3::ONE))),
    },
    Hazard {
        name: "grazing",
        group: 2,
        about: "rays graze the faces of the box",
        make: || Ok(grazing()),
    },
];

/// Edge of the object: a power of two, so that cuts and block faces lie on whole coordinates.
const N: usize = 32;

/// A ball in a case, with emptiness between them.
fn object() -> Volume {
    carved("ball in a case", N, |at| {
        let depth = at.iter().map(|&i| i.min(N - 1 - i)).min().unwrap_or(0);
        (1..3).contains(&depth) || (5.0..8.0).contains(&radius(at, N))
    })
}

/// Parallel rays, a voxel apart, along each axis both ways; their coordinates are whole numbers plus `offset`.
fn along_axes(offset: f64) -> Vec<Camera> {
    // 45 pixels over 45 voxels: the middle ray goes through the picture's centre.
    let middle = DVec3::splat(N as f64 * 0.5 + offset);
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let cameras = axes.iter().flat_map(|&axis| {
        [axis, -axis].map(|forward| Camera {
            up: if axis == DVec3::Z { DVec3::Y } else { DVec3::Z },
            ..parallel(middle - forward * 40.0, forward, 45.0)
        })
    });
    cameras.collect()
}

fn negative_zero() -> Vec<Camera> {
    let mut cameras = Vec::new();
    for [a, b] in [[-0.0, 0.0], [0.0, -0.0], [-0.0, -0.0]] {
        for (eye, target, up) in [
            (
                DVec3::new(-40.0, 0.0, 0.0),
                DVec3::new(-39.0, a, b),
                DVec3::Z,
            ),
            (
                DVec3::new(0.0, 0.0, -40.0),
                DVec3::new(a, b, -39.0),
                DVec3::Y,
            ),
        ] {
            // Only -0 less 0 is -0: the eye is on the planes of zeros, and the target is not the eye and a direction.
            let at = |camera| Camera {
                target,
                up,
                ..camera
            };
            cameras.push(at(looking(eye, target - eye, 60.0)));
            cameras.push(at(parallel(eye, target - eye, 45.0)));
        }
    }
    cameras
}

fn almost_parallel() -> Scenery {
    let middle = DVec3::splat(N as f64 * 0.5);
    let tilts = [1e-6, 1e-9, 2.0 * PARALLEL, PARALLEL, 0.5 * PARALLEL, 1e-13];
    let cameras = tilts.iter().flat_map(|&tilt| {
        [DVec3::new(1.0, tilt, -tilt), DVec3::new(-tilt, tilt, -1.0)]
            .map(|forward| parallel(middle - forward * 40.0, forward, 45.0))
    });
    Scenery::new(object(), cameras.collect::<Vec<_>>())
}

fn along_the_cut() -> Scenery {
    let n = N as f64;
    let middle = DVec3::splat(n * 0.5);
    let slight = 1e-3_f64.to_radians();
    let mut cameras = Vec::new();
    for tilt in [0.0, slight, -slight] {
        // The dominant axis is x by a hair: the cut across it is seen at 45 degrees; that across z from the side.
        for forward in [
            DVec3::new(1.0, 0.0, tilt),
            DVec3::new(1.0 + 1e-9, 1.0, tilt),
            DVec3::new(1.0, 1.0 + 1e-9, tilt),
        ] {
            cameras.push(looking(middle - forward.normalize() * 50.0, forward, 50.0));
            cameras.push(looking(middle, forward, 90.0));
        }
    }
    Scenery::new(object(), cameras)
}

/// Parallel and perspective rays along a diagonal, through whole coordinates.
fn diagonals(direction: DVec3) -> Vec<Camera> {
    let middle = DVec3::splat(N as f64 * 0.5);
    let signs = [
        DVec3::ONE,
        DVec3::new(1.0, -1.0, 1.0),
        DVec3::new(-1.0, 1.0, -1.0),
        DVec3::NEG_ONE,
    ];
    let height = 45.0 * std::f64::consts::SQRT_2;
    let cameras = signs.iter().flat_map(|&sign| {
        let forward = direction * sign;
        let corner = middle - forward * N as f64 * 0.5;
        [
            parallel(middle - forward * 40.0, forward, height),
            parallel(middle - forward * 40.0, forward, 45.0),
            looking(corner - forward * 8.0, forward, 50.0),
            // From the corner of the box itself, and over a right angle: outer rays lie in its faces.
            looking(corner, forward, 90.0),
        ]
    });
    cameras.collect()
}

fn grazing() -> Scenery {
    let n = N as f64;
    let mut cameras = Vec::new();
    for height in [0.0, n, 1e-4, n - 1e-4] {
        let eye = DVec3::new(-30.0, n * 0.5, height);
        // Of an odd number of rows, the middle one's rays lie in the face, or a hair beside it.
        cameras.push(looking(eye, DVec3::X, 40.0));
        cameras.push(parallel(eye, DVec3::X, 45.0));
    }
    Scenery::new(object(), cameras)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_camera_of_negative_zero_has_such_a_direction_and_no_two_are_one() {
        let views: Vec<_> = negative_zero()
            .iter()
            .map(|c| (c.forward().to_array().map(f64::to_bits), c.projection))
            .collect();
        for (i, view) in views.iter().enumerate() {
            assert!(view.0.contains(&(-0.0_f64).to_bits()), "camera {i}");
            assert!(!views[..i].contains(view), "camera {i}");
        }
    }
}
