//! Group 7: odd grids, spacings and numbers.

use glam::DVec3;

use super::Hazard;
use super::scenery::{Scenery, ramp};
use super::volumes::{numbers, radius, volume};
use crate::error::Result;
use crate::transfer::{TABLE_SIZES, TransferFunction};
use crate::volume::{Rescale, Volume, Voxels, phantom};

pub(super) const HAZARDS: &[Hazard] = &[
    Hazard {
        name: "one-slice",
        group: 7,
        about: "a volume one voxel thick, across x",
        make: || shaped([1, 29, 31]),
    },
    Hazard {
        name: "one-slice-across-y",
        group: 7,
        about: "a volume one voxel thick, across y",
        make: || shaped([31, 1, 29]),
    },
    Hazard {
        name: "one-slice-across-z",
        group: 7,
        about: "a volume of a single slice",
        make: || shaped([31, 29, 1]),
    },
    Hazard {
        name: "one-row",
        group: 7,
        about: "a single row of voxels",
        make: || shaped([37, 1, 1]),
    },
    Hazard {
        name: "single-voxel-volume",
        group: 7,
        about: "a volume of one voxel",
        make: || shaped([1, 1, 1]),
    },
    Hazard {
        name: "two-by-three-by-five",
        group: 7,
        about: "a volume smaller than a leaf block",
        make: || shaped([2, 3, 5]),
    },
    Hazard {
        name: "primes",
        group: 7,
        about: "edges of 31, 37 and 29 voxels: no block size divides them",
        make: || shaped([31, 37, 29]),
    },
    Hazard {
        name: "just-over-a-block",
        group: 7,
        about: "edges of a block's multiple and one voxel",
        make: || shaped([33, 17, 9]),
    },
    Hazard {
        name: "spacing-1-1-10",
        group: 7,
        about: "slices ten times as far apart as voxels",
        make: || spaced(DVec3::new(1.0, 1.0, 10.0), [31, 29, 9]),
    },
    Hazard {
        name: "spacing-1-1000",
        group: 7,
        about: "voxels a thousand times as long as wide",
        make: || spaced(DVec3::new(1.0, 1.0, 1000.0), [24, 24, 3]),
    },
    Hazard {
        name: "spacing-1000-1",
        group: 7,
        about: "voxels a thousand times as wide as long, along x and y",
        make: || spaced(DVec3::new(1000.0, 1000.0, 1.0), [4, 3, 24]),
    },
    Hazard {
        name: "spacing-in-micrometres",
        group: 7,
        about: "spacings of 10^-9: everything is measured in the smallest",
        make: || spaced(DVec3::new(2e-9, 1e-9, 1e-9), [23, 31, 29]),
    },
    Hazard {
        name: "sixteen-bit-extremes",
        group: 7,
        about: "voxels of 0 and 65535",
        make: || {
            let voxels = ball(|f| (f * 65535.0).round() as u16);
            Ok(stored(
                Voxels::U16(voxels.into()),
                &ramp(9000.0, 65535.0, 0.3),
            ))
        },
    },
    Hazard {
        name: "signed-extremes",
        group: 7,
        about: "voxels of -32768 and 32767",
        make: || {
            let voxels = ball(|f| (f * 65535.0 - 32768.0).round() as i16);
            Ok(stored(
                Voxels::I16(voxels.into()),
                &ramp(-20000.0, 32767.0, 0.3),
            ))
        },
    },
    Hazard {
        name: "falling-rescale",
        group: 7,
        about: "data values fall as stored numbers rise",
        make: || {
            let voxels = ball(|f| (f * 2000.0).round() as i16);
            let mut volume = volume("falling", [EDGE; 3], Voxels::I16(voxels.into()));
            volume.rescale = Rescale {
                slope: -0.5,
                intercept: 100.0,
            };
            Ok(Scenery::from_outside(volume)
                .through(&super::scenery::through(&[(-900.0, 0.3), (-100.0, 0.0)])))
        },
    },
    Hazard {
        name: "float-not-finite",
        group: 7,
        about: "NaN, infinities and denormals among the voxels, replaced as at load",
        make: not_finite,
    },
    Hazard {
        name: "float-huge",
        group: 7,
        about: "floats from -3 10^38 to 3 10^38: their difference is beyond what a float holds",
        make: || {
            let voxels = ball(|f| ((f - 0.5) * 6.6e38) as f32);
            loaded(voxels, &ramp(-2e38, 3e38, 0.3))
        },
    },
    Hazard {
        name: "float-denormal",
        group: 7,
        about: "floats up to 10^-39 only: adapters take such numbers for zero",
        make: || {
            let voxels = ball(|f| (f * 1e-39) as f32);
            loaded(voxels, &ramp(2e-40, 1e-39, 0.3))
        },
    },
    Hazard {
        name: "float-far-from-zero",
        group: 7,
        about: "floats from 10^6 on, in quarters",
        make: || {
            let voxels = ball(|f| 1e6 + (f as f32 * 400.0).round() * 0.25);
            loaded(voxels, &ramp(1e6 + 20.0, 1e6 + 100.0, 0.3))
        },
    },
    Hazard {
        name: "float-outlier",
        group: 7,
        about: "one voxel of 10^6 among floats from 0 to 1: the table has one entry for all of them",
        make: || {
            let mut voxels = ball(|f| f as f32);
            voxels[0] = 1e6;
            loaded(voxels, &ramp(0.2, 1.0, 0.3))
        },
    },
];

/// Edge of the balls below.
const EDGE: usize = 29;

/// A smooth hollow ball, from emptiness at 0 to matter at 1.
fn ball<T>(number: impl Fn(f64) -> T) -> Vec<T> {
    numbers([EDGE; 3], |at| {
        number((1.0 - ((radius(at, EDGE) - 9.0).abs() - 1.0) * 0.5).clamp(0.0, 1.0))
    })
}

fn shaped(dims: [usize; 3]) -> Result<Scenery> {
    // Noise has matter in any shape of box, and emptiness.
    let scenery = Scenery::from_outside(phantom::make("noise", dims)?);
    Ok(scenery
        .through(&ramp(180.0, 255.0, 0.5))
        .for_each([2, 4, 16], |frame, &block| frame.settings.block = block))
}

fn spaced(spacing: DVec3, dims: [usize; 3]) -> Result<Scenery> {
    let volume = Volume {
        spacing,
        ..phantom::make("noise", dims)?
    };
    // A long box has few samples across and many along: as many as its diagonal in steps of its own.
    let step = volume.extent().max_element() / 200.0;
    Ok(Scenery::from_outside(volume)
        .through(&ramp(180.0, 255.0, 0.2))
        .with(|s| s.step_voxels = step.max(0.5)))
}

/// Through tables of every size.
fn stored(voxels: Voxels, transfer: &TransferFunction) -> Scenery {
    sized(volume("numbers", [EDGE; 3], voxels), transfer)
}

fn sized(volume: Volume, transfer: &TransferFunction) -> Scenery {
    Scenery::from_outside(volume)
        .through(transfer)
        .for_each(TABLE_SIZES, |frame, &n| frame.settings.table_entries = n)
}

/// Floats as a file would bring them.
fn loaded(voxels: Vec<f32>, transfer: &TransferFunction) -> Result<Scenery> {
    let nothing = volume("floats", [EDGE; 3], Voxels::F32(Vec::new().into()));
    Ok(sized(nothing.with_floats(voxels)?, transfer))
}

fn not_finite() -> Result<Scenery> {
    let mut voxels = ball(|f| f as f32);
    let odd = [
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::MIN_POSITIVE / 8.0,
        -f32::MIN_POSITIVE / 1024.0,
    ];
    for (i, &number) in (0..voxels.len()).step_by(97).zip(odd.iter().cycle()) {
        voxels[i] = number;
    }
    loaded(voxels, &ramp(0.2, 1.0, 0.3))
}
