//! Group 8: steps, thresholds and sizes at their limits.

use super::Hazard;
use super::scenery::{Scenery, ramp};
use crate::error::Result;
use crate::volume::phantom;

pub(super) const HAZARDS: &[Hazard] = &[
    Hazard {
        name: "step-of-a-thousandth",
        group: 8,
        about: "a thousandth of a voxel a step: tens of thousands of samples on a ray, in many dispatches",
        make: || stepped(&[1e-3], 16, 24),
    },
    Hazard {
        name: "steps-from-a-tenth-to-ten",
        group: 8,
        about: "steps of 0.1, 0.7, 1, 2.5 and 10 voxels",
        make: || stepped(&[0.1, 0.7, 1.0, 2.5, 10.0], 45, 31),
    },
    Hazard {
        name: "step-beyond-the-box",
        group: 8,
        about: "steps longer than the box: one sample on a ray, or none",
        make: || stepped(&[40.0, 60.0, 1000.0], 45, 24),
    },
    Hazard {
        name: "thresholds",
        group: 8,
        about: "rays stop at opacities of 0, 0.01, 0.5, 0.98, 0.9999 and never",
        make: || {
            let scenery = shells(31)?;
            Ok(
                scenery.for_each([0.0, 0.01, 0.5, 0.98, 0.9999, 1.0], |frame, &ert| {
                    frame.settings.ert = ert;
                }),
            )
        },
    },
    Hazard {
        name: "odd-sizes",
        group: 8,
        about: "pictures of 1x1, 1x37, 37x1, 7x5, 8x8, 9x17 and 100x3 pixels",
        make: || {
            let sizes = [[1, 1], [1, 37], [37, 1], [7, 5], [8, 8], [9, 17], [100, 3]];
            Ok(shells(31)?.for_each(sizes, |frame, &size| frame.settings.size = size))
        },
    },
    Hazard {
        name: "wide-picture",
        group: 8,
        about: "pictures beyond the largest target: drawn in pieces",
        make: || {
            let sizes = [[2049, 3], [5, 2050]];
            Ok(shells(31)?.for_each(sizes, |frame, &size| frame.settings.size = size))
        },
    },
    Hazard {
        name: "picture-of-4096",
        group: 8,
        about: "4096x4096 pixels, in pieces, few samples each",
        make: || {
            let mut scenery = shells(24)?;
            scenery.frames.truncate(1);
            Ok(scenery.with(|s| {
                s.size = [4096; 2];
                s.step_voxels = 10.0;
            }))
        },
    },
    Hazard {
        name: "block-sizes",
        group: 8,
        about: "leaf blocks from 2 to 64 voxels, the largest larger than the volume",
        make: || {
            Ok(
                shells(31)?.for_each([2, 4, 8, 16, 32, 64], |frame, &block| {
                    frame.settings.block = block;
                }),
            )
        },
    },
];

fn shells(n: usize) -> Result<Scenery> {
    Ok(Scenery::from_outside(phantom::make("shells", [n; 3])?))
}

fn stepped(steps: &[f64], size: u32, n: usize) -> Result<Scenery> {
    let scenery = shells(n)?.through(&ramp(40.0, 255.0, 0.1));
    let scenery = scenery.with(|s| s.size = [size; 2]);
    Ok(scenery.for_each(steps.iter().copied(), |frame, &step| {
        frame.settings.step_voxels = step;
    }))
}
