//! Group 5: thin walls and hostile tables.

use super::Hazard;
use super::scenery::{Scenery, ramp, through};
use super::volumes::{carved, case, numbers, radius, volume};
use crate::error::Result;
use crate::transfer::{TABLE_SIZES, TransferFunction};
use crate::volume::{Volume, Voxels, phantom};

pub(super) const HAZARDS: &[Hazard] = &[
    Hazard {
        name: "wall-below-a-voxel",
        group: 5,
        about: "a wall that fills a third of its voxels, barely above the threshold",
        make: || Ok(Scenery::from_outside(case(30, 1, 60))),
    },
    Hazard {
        name: "wall-of-a-voxel",
        group: 5,
        about: "a wall one voxel thick, in steps of half a voxel and of two",
        make: || {
            let scenery = Scenery::from_outside(case(30, 1, 200));
            Ok(scenery.for_each([0.5, 2.0], |frame, &step| {
                frame.settings.step_voxels = step;
            }))
        },
    },
    Hazard {
        name: "wall-of-a-block",
        group: 5,
        about: "a wall as thick as a leaf block, and off its faces",
        make: || {
            let scenery = Scenery::from_outside(case(30, 4, 200));
            Ok(scenery.for_each([2, 4, 8], |frame, &block| frame.settings.block = block))
        },
    },
    Hazard {
        name: "peak-between-two-voxels",
        group: 5,
        about: "opacity only where interpolation passes between emptiness and matter: no voxel has the value",
        make: || {
            let n = 33;
            let voxels_of_two_numbers =
                carved("hollow ball", n, |at| (7.0..11.0).contains(&radius(at, n)));
            let between = through(&[(90.0, 0.0), (100.0, 0.9), (110.0, 0.0)]);
            Ok(Scenery::from_outside(voxels_of_two_numbers).through(&between))
        },
    },
    Hazard {
        name: "spike-of-one-entry",
        group: 5,
        about: "one entry of the table is opaque, its neighbours are not",
        make: || Ok(solid()?.through(&through(&[(99.0, 0.0), (100.0, 1.0), (101.0, 0.0)]))),
    },
    Hazard {
        name: "faint-spike",
        group: 5,
        about: "a spike of opacity that is faint beside another material's, in data that pass it within a voxel",
        make: || {
            let rising = Scenery::from_outside(phantom::make("ramp", [33; 3])?);
            let spike_and_wall = through(&[
                (97.0, 0.0),
                (100.0, 0.15),
                (103.0, 0.0),
                (200.0, 0.0),
                (210.0, 1.0),
            ]);
            Ok(rising
                .through(&spike_and_wall)
                .with(|s| s.step_voxels = 0.25))
        },
    },
    Hazard {
        name: "spike-at-the-ends",
        group: 5,
        about: "only the first and the last entry of the table are visible",
        make: || {
            let scenery = Scenery::from_outside(extremes());
            Ok(scenery.through(&through(&[
                (0.0, 0.4),
                (1.0, 0.0),
                (254.0, 0.0),
                (255.0, 0.8),
            ])))
        },
    },
    Hazard {
        name: "jumping-table",
        group: 5,
        about: "opacity jumps from nothing to everything within an entry",
        make: || {
            Ok(solid()?.through(&through(&[
                (99.0, 0.0),
                (99.0, 1.0),
                (150.0, 1.0),
                (150.0, 0.0),
            ])))
        },
    },
    Hazard {
        name: "inverted-table",
        group: 5,
        about: "emptiness is opaque and matter is not",
        make: || Ok(solid()?.through(&through(&[(0.0, 0.3), (60.0, 0.0)]))),
    },
    Hazard {
        name: "all-transparent",
        group: 5,
        about: "nothing is visible anywhere",
        make: || Ok(solid()?.through(&through(&[(0.0, 0.0), (255.0, 0.0)]))),
    },
    Hazard {
        name: "all-opaque",
        group: 5,
        about: "everything is opaque: rays end at their first sample",
        make: || {
            let scenery = solid()?.through(&through(&[(0.0, 1.0), (255.0, 1.0)]));
            Ok(scenery.for_each([1.0, 0.98], |frame, &ert| frame.settings.ert = ert))
        },
    },
    Hazard {
        name: "faint",
        group: 5,
        about: "opacities of 1/65535: corrected for the step they are smaller still",
        make: || {
            let scenery = solid()?.through(&ramp(40.0, 255.0, 1.0 / 65535.0));
            Ok(scenery.for_each([0.5, 0.01], |frame, &step| {
                frame.settings.step_voxels = step;
                frame.settings.size = [23, 23];
            }))
        },
    },
    Hazard {
        name: "threshold-at-the-background",
        group: 5,
        about: "opacity begins exactly at the background's value, in 16 bits far up",
        make: || {
            let n = 30;
            let wide = numbers([n; 3], |at| 60_033 + u16::from(wall(at, n)) * 20);
            let wide = volume("16 bits far up", [n; 3], Voxels::U16(wide.into()));
            Ok(at_background(wide, &ramp(60_033.0, 65_535.0, 0.9)))
        },
    },
    Hazard {
        name: "threshold-at-the-background-of-bytes",
        group: 5,
        about: "opacity begins exactly at the background's value, in 8 bits",
        make: || {
            let n = 30;
            let bytes = super::volumes::bytes("bytes", [n; 3], |at| 33 + wall(at, n));
            Ok(at_background(bytes, &ramp(33.0, 255.0, 0.9)))
        },
    },
    Hazard {
        name: "thin-layer-between-two-materials",
        group: 5,
        about: "a translucent layer a few values wide, between two transparent materials",
        make: || {
            let n = 30;
            let nested = carved("ball", n, |at| radius(at, n) < 11.0);
            Ok(Scenery::from_outside(nested)
                .through(&through(&[(60.0, 0.0), (64.0, 0.5), (68.0, 0.0)]))
                .for_each([0.5, 0.1], |frame, &step| {
                    frame.settings.step_voxels = step;
                }))
        },
    },
];

/// Through tables of every size.
fn at_background(volume: Volume, transfer: &TransferFunction) -> Scenery {
    Scenery::from_outside(volume)
        .through(transfer)
        .for_each(TABLE_SIZES, |frame, &n| frame.settings.table_entries = n)
}

/// A hollow ball with smooth walls.
fn solid() -> Result<Scenery> {
    Ok(Scenery::from_outside(phantom::make("sphere", [33; 3])?))
}

fn wall(at: [usize; 3], n: usize) -> u8 {
    let depth = at.iter().map(|&i| i.min(n - 1 - i)).min().unwrap_or(0);
    if (3..6).contains(&depth) { 200 } else { 0 }
}

/// Voxels of 0 and of 255, and between them what interpolation makes.
fn extremes() -> Volume {
    let n = 30;
    super::volumes::bytes("extremes", [n; 3], |at| {
        if radius(at, n) < 10.0 { 255 } else { 0 }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_voxel_has_a_value_of_the_peak_between_two() {
        let hazard = HAZARDS.iter().find(|h| h.name == "peak-between-two-voxels");
        let scenery = (hazard.unwrap().make)().unwrap();
        let Voxels::U8(voxels) = &scenery.volume.voxels else {
            panic!("bytes")
        };
        let transfer = &scenery.frames[0].transfer;
        let mut stored = voxels.iter();
        assert!(stored.all(|&v| transfer.at(f64::from(v)).1 == 0.0));
        assert!(transfer.at(100.0).1 > 0.0);
    }
}
