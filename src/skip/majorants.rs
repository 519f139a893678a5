//! Majorants: for every block the highest place in a mode's window that a sample of it can have. A ray that has seen as
//! much already gains nothing there: this is how mip and minip skip by their running extremum.

use super::words_of_bytes;
use crate::mode::{Mode, Parameters};
use crate::octree::LeafGrid;
use crate::octree::accelerator::stored_range_to_x;
use crate::transfer::Domain;
use crate::volume::VoxelType;

/// The byte of a block that reaches the window's end; one more is above all that a ray can have seen.
pub const FULL: f64 = 254.0;

/// More than the places of samples err in single precision.
const SLACK: f64 = 1.0 / (1 << 20) as f64;

/// A byte for every block: nothing in the block lies above `byte / 254` of the window.
#[derive(Debug, Clone, PartialEq)]
pub struct Majorants {
    /// What they hold for.
    mode: Mode,
    domain: Domain,
    /// Blocks along x, y, z.
    dims: [usize; 3],
    /// x fastest.
    bytes: Vec<u8>,
}

impl Majorants {
    /// The majorants of all blocks of `grid` in the window of `mode`, over values in `domain`.
    pub fn new(grid: &LeafGrid, voxel_type: VoxelType, domain: &Domain, mode: &Mode) -> Self {
        // Windows know no step.
        let parameters = Parameters::new(mode, domain, 1.0);
        let [nx, ny, nz] = grid.dims;
        let bytes = (0..nx * ny * nz).map(|i| {
            let range = grid.range([i % nx, i / nx % ny, i / nx / ny]);
            let ends = stored_range_to_x(range, voxel_type, domain);
            let highest = parameters
                .in_window(*ends.start())
                .max(parameters.in_window(*ends.end()));
            // What rounds to the window's dead end lies within two snaps of it; so does what rounds above a maximum.
            let bound = highest + 2.0 * parameters.window_dead + SLACK;
            (bound * FULL).ceil().min(FULL + 1.0) as u8
        });
        Self {
            mode: *mode,
            domain: *domain,
            dims: grid.dims,
            bytes: bytes.collect(),
        }
    }

    /// Whether they hold in this mode over values in this domain.
    pub fn hold_for(&self, mode: &Mode, domain: &Domain) -> bool {
        self.mode == *mode && self.domain == *domain
    }

    /// Blocks along x, y, z.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// Those of blocks twice as large, which hold the voxels of eight of these and are bounded by the highest of them.
    #[must_use]
    pub fn coarser(&self) -> Self {
        let dims = self.dims.map(|n| n.div_ceil(2));
        let mut bytes = vec![0; dims.iter().product()];
        let [nx, ny, _] = self.dims;
        for (i, &byte) in self.bytes.iter().enumerate() {
            let [x, y, z] = [i % nx, i / nx % ny, i / nx / ny].map(|c| c / 2);
            let coarse: &mut u8 = &mut bytes[(z * dims[1] + y) * dims[0] + x];
            *coarse = byte.max(*coarse);
        }
        Self {
            dims,
            bytes,
            ..*self
        }
    }

    /// Whether a block can add anything to a ray that has seen `highest`, a place in the window. Where that is no number, it
    /// can.
    pub fn may_add(&self, [x, y, z]: [usize; 3], highest: f64) -> bool {
        let byte = self.bytes[(z * self.dims[1] + y) * self.dims[0] + x];
        highest.is_nan() || highest * FULL < f64::from(byte)
    }

    /// A byte for every block, x fastest: what packets read.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Four bytes to a word: what shaders read.
    pub fn words(&self) -> Vec<u32> {
        words_of_bytes(&self.bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mode::{Mode, Window};
    use crate::octree::Accelerator;
    use crate::volume::{Volume, Voxels, phantom};

    fn majorants(mode: &Mode, volume: &Volume, block: usize) -> Majorants {
        let domain = Domain::new(volume, [0.0, 255.0], 256).unwrap();
        let grid = Accelerator::build(volume, block, 1).unwrap().grid;
        Majorants::new(&grid, volume.voxels.voxel_type(), &domain, mode)
    }

    fn bytes(mode: &Mode, volume: &Volume) -> Vec<u8> {
        majorants(mode, volume, 4).bytes
    }

    #[test]
    fn no_voxel_of_a_block_lies_above_its_majorant_nor_far_below() {
        let volume = phantom::make("noise", [16, 12, 8]).unwrap();
        let Voxels::U8(voxels) = &volume.voxels else {
            panic!("phantoms are bytes")
        };
        let window = Window {
            low: 40.0,
            high: 300.0,
        };
        let place = |value: f64| ((value - window.low) / (window.high - window.low)).max(0.0);
        let up = bytes(&Mode::Mip(window), &volume);
        let down = bytes(&Mode::Minip(window), &volume);
        for (i, (&up, &down)) in up.iter().zip(&down).enumerate() {
            let block = [i % 4, i / 4 % 3, i / 12];
            // A voxel more on every side: the closed support.
            let near =
                |a: usize, n: usize| (block[a] * 4).saturating_sub(1)..(block[a] * 4 + 5).min(n);
            let reached: Vec<f64> = near(2, 8)
                .flat_map(|z| near(1, 12).map(move |y| (y, z)))
                .flat_map(|(y, z)| near(0, 16).map(move |x| (z * 12 + y) * 16 + x))
                .map(|voxel| f64::from(voxels[voxel]))
                .collect();
            let highest = reached.iter().copied().fold(0.0, f64::max);
            let lowest = reached.iter().copied().fold(255.0, f64::min);
            for (byte, expected) in [(up, place(highest)), (down, 1.0 - place(lowest))] {
                let bound = f64::from(byte) / FULL;
                assert!(
                    bound > expected && bound < expected + 0.01,
                    "{i}: {bound} {expected}"
                );
            }
        }
    }

    #[test]
    fn a_block_at_the_windows_end_is_above_all_that_a_ray_can_have_seen() {
        let volume = phantom::make("full", [4; 3]).unwrap();
        let window = Window {
            low: 0.0,
            high: 100.0,
        };
        assert_eq!(bytes(&Mode::Mip(window), &volume), [255]);
    }

    #[test]
    fn a_coarser_block_is_bounded_by_what_it_holds_and_a_ray_that_has_seen_nothing_is_not() {
        let volume = phantom::make("noise", [19, 9, 14]).unwrap();
        let mode = Mode::Mip(Window {
            low: 40.0,
            high: 300.0,
        });
        let (fine, coarse) = (majorants(&mode, &volume, 4), majorants(&mode, &volume, 8));
        assert!(fine.hold_for(&mode, &fine.domain));
        let derived = fine.coarser();
        assert_eq!(derived.dims, coarse.dims);
        // The aprons of small blocks reach no farther than those of the large ones that hold them.
        assert!(derived.bytes.iter().zip(&coarse.bytes).all(|(d, c)| d == c));
        assert!(coarse.may_add([0; 3], 0.0) && coarse.may_add([0; 3], f64::NAN));
        assert!(!coarse.may_add([0; 3], 1.0));
    }
}
