//! Group 6: data that leave nothing to skip, or nothing easy.

use glam::DVec3;

use super::Hazard;
use super::scenery::{Scenery, ramp};
use super::volumes::{MATTER, bytes, carved, case, cavity, one_per_block, shells, spiral};
use crate::error::Result;
use crate::skip::segment_list::MOST_SEGMENTS;
use crate::volume::{Volume, phantom};

pub(super) const HAZARDS: &[Hazard] = &[
    Hazard {
        name: "checkerboard",
        group: 6,
        about: "every other voxel",
        make: || named("checkerboard"),
    },
    Hazard {
        name: "noise",
        group: 6,
        about: "a hash of every voxel",
        make: || named("noise"),
    },
    Hazard {
        name: "full",
        group: 6,
        about: "one material everywhere",
        make: || named("full"),
    },
    Hazard {
        name: "empty",
        group: 6,
        about: "nothing anywhere",
        make: || named("empty"),
    },
    Hazard {
        name: "one-voxel",
        group: 6,
        about: "a single voxel, at a block's corner",
        make: || {
            Ok(Scenery::from_outside(carved("one voxel", 33, |at| {
                at == [8, 15, 16]
            })))
        },
    },
    Hazard {
        name: "one-voxel-per-block",
        group: 6,
        about: "a single voxel in every block, at its corners: every block is active, hardly a sample shows anything",
        make: || Ok(Scenery::from_outside(one_per_block(32, 8)).with(|s| s.block = 8)),
    },
    Hazard {
        name: "shells-16-walls",
        group: 6,
        about: "nested shells that a ray crosses 16 walls of",
        make: || Ok(nested(16)),
    },
    Hazard {
        name: "shells-8-walls",
        group: 6,
        about: "nested shells that a ray crosses 8 walls of",
        make: || Ok(nested(8)),
    },
    Hazard {
        name: "shells-4-walls",
        group: 6,
        about: "nested shells that a ray crosses 4 walls of",
        make: || Ok(nested(4)),
    },
    Hazard {
        name: "shells-2-walls",
        group: 6,
        about: "a shell that a ray crosses 2 walls of",
        make: || Ok(nested(2)),
    },
    Hazard {
        name: "spiral",
        group: 6,
        about: "a rolled sheet: many layers on every ray",
        make: || Ok(Scenery::from_outside(spiral(48))),
    },
    Hazard {
        name: "cavity-off-the-cut",
        group: 6,
        about: "the cavity lies within one half",
        make: || Ok(Scenery::from_outside(cavity(32, 0.58, 0.9))),
    },
    Hazard {
        name: "cavity-just-missed-by-the-cut",
        group: 6,
        about: "the cavity begins a voxel behind the cut",
        make: || Ok(Scenery::from_outside(cavity(32, 17.0 / 32.0, 0.95))),
    },
    Hazard {
        name: "time-cavity-off-the-cut",
        group: 6,
        about: "time: half-split marches a cavity that its cut does not go through",
        make: || Ok(Scenery::timed(cavity(TIMED, 0.1, 0.48)).through(&ramp(40.0, 255.0, 0.01))),
    },
    Hazard {
        name: "time-cavity-in-one-half",
        group: 6,
        about: "time: two thin walls in one half with a cavity between them, and nothing in the other half",
        make: || {
            let walls = carved("walls in one half", TIMED, |[_, _, z]| {
                [2, TIMED / 2 - 6]
                    .iter()
                    .any(|wall| (*wall..wall + 2).contains(&z))
            });
            Ok(Scenery::timed(walls).through(&ramp(40.0, 255.0, 0.01)))
        },
    },
    Hazard {
        name: "time-many-sheets",
        group: 6,
        about: "time: more than twice as many sheets on a ray as lists of segments have slots",
        make: || {
            const APART: usize = 10;
            let sheet = |z| if z % APART == 0 { MATTER } else { 0 };
            let dims = [36, 36, APART * (2 * MOST_SEGMENTS + 8)];
            let sheets = Volume {
                // As wide as deep, so that rays cross all of them.
                spacing: DVec3::new(11.0, 11.0, 1.0),
                ..bytes("sheets", dims, |[_, _, z]| sheet(z))
            };
            Ok(Scenery::timed(sheets)
                .through(&ramp(40.0, 255.0, 0.02))
                .with(|s| s.block = 2))
        },
    },
    Hazard {
        name: "time-fragmented",
        group: 6,
        about: "time: one voxel in every block, so that leaps are short and every block is active",
        make: || Ok(Scenery::timed(one_per_block(TIMED, 4))),
    },
    Hazard {
        name: "time-scattered",
        group: 6,
        about: "time: every third block of four voxels is active in each direction, so that leaps are one block long",
        make: || {
            let lone = |at: [usize; 3]| at.iter().all(|i| i % 12 == 5);
            Ok(Scenery::timed(carved("scattered voxels", TIMED, lone)))
        },
    },
    Hazard {
        name: "time-many-walls",
        group: 6,
        about: "time: sixteen translucent walls on a ray",
        make: || Ok(Scenery::timed(shells(TIMED, 16)).through(&ramp(40.0, 255.0, 0.02))),
    },
    Hazard {
        name: "time-full",
        group: 6,
        about: "time: nothing to skip",
        make: || {
            let full = phantom::make("full", [TIMED; 3])?;
            Ok(Scenery::timed(full).through(&ramp(40.0, 255.0, 0.01)))
        },
    },
    Hazard {
        name: "time-large-cavity",
        group: 6,
        about: "time: an empty case, which methods that pass every position do not skip",
        make: || Ok(Scenery::timed(case(TIMED, 2, 200)).through(&ramp(40.0, 255.0, 0.02))),
    },
];

/// Edge of volumes that are timed, in voxels.
const TIMED: usize = 72;

fn named(name: &str) -> Result<Scenery> {
    // No block size divides the edge; translucent, so that rays go all the way.
    let scenery = Scenery::from_outside(phantom::make(name, [31; 3])?);
    Ok(scenery
        .through(&ramp(40.0, 255.0, 0.05))
        .for_each([4, 8], |frame, &block| frame.settings.block = block))
}

fn nested(walls: usize) -> Scenery {
    let scenery = Scenery::from_outside(shells(48, walls));
    scenery
        .through(&ramp(40.0, 255.0, 0.05))
        .for_each([2, 4], |frame, &block| frame.settings.block = block)
}
