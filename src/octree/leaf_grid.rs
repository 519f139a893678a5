//! The grid of leaf blocks: each block's smallest and largest stored number over its closed support.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use crate::volume::Volume;
use crate::with_voxels;

/// Minimum and maximum of every leaf block: all that the trees know of a volume.
///
/// A clone shares the ranges.
#[derive(Debug, Clone)]
pub struct LeafGrid {
    /// Edge of a block in voxels.
    pub block: usize,
    /// Blocks along x, y, z; the last one of an axis ends with the volume.
    pub dims: [usize; 3],
    /// Voxels along x, y, z.
    pub volume_dims: [usize; 3],
    /// Stored numbers (min, max), x fastest. Of small blocks these are the largest structure there is, so they are
    /// shared, and not even moved once built (as they would be into an `Arc` of a slice).
    ranges: Arc<Vec<[f32; 2]>>,
}

impl LeafGrid {
    /// Reads every voxel of `volume` once, in parallel over layers of blocks along z.
    ///
    /// A block's range covers its own voxels and `apron` voxels on each side, as far as there are any: all that
    /// interpolation touches from any point of the closed block ([`crate::sample::Sampler::apron`]). So the range of
    /// eight neighbouring blocks together is exactly that of the block twice as large.
    ///
    /// # Panics
    /// Where `block` is 0.
    pub fn build(volume: &Volume, block: usize, apron: usize) -> Self {
        let dims = volume.dims.map(|n| n.div_ceil(block));
        let support = Support {
            block,
            apron,
            dims: volume.dims,
        };
        let mut ranges = vec![[0.0; 2]; dims.iter().product()];
        with_voxels!(&volume.voxels, voxels => {
            ranges
                .par_chunks_mut(dims[0] * dims[1])
                .enumerate()
                .for_each_init(
                    || LayerScratch::new(voxels[0], &support),
                    |scratch, (layer, ranges)| scratch.reduce(voxels, &support, layer, ranges),
                );
        });
        Self {
            block,
            dims,
            volume_dims: volume.dims,
            ranges: Arc::new(ranges),
        }
    }

    /// Smallest and largest stored number of block (x, y, z)'s closed support.
    pub fn range(&self, [x, y, z]: [usize; 3]) -> [f32; 2] {
        self.ranges[(z * self.dims[1] + y) * self.dims[0] + x]
    }

    /// All ranges, x fastest.
    pub fn ranges(&self) -> &[[f32; 2]] {
        &self.ranges
    }

    /// Bytes of the ranges.
    pub fn bytes(&self) -> usize {
        size_of_val(self.ranges())
    }
}

/// Which voxels a block's range covers.
struct Support {
    block: usize,
    apron: usize,
    dims: [usize; 3],
}

impl Support {
    fn along(&self, axis: usize, block: usize) -> Range<usize> {
        let start = (block * self.block).saturating_sub(self.apron);
        let end = ((block + 1) * self.block + self.apron).min(self.dims[axis]);
        start..end
    }
}

/// Rows of running minima and maxima for one layer of blocks.
///
/// The reduction goes over z, then y, then x: the first two are whole rows at a time, which vectorise, and only the last
/// one, over rows already reduced, goes within a row.
struct LayerScratch<T> {
    /// Rows reduced over z, minima and maxima; row y is kept in slot `y % slots` until no block along y needs it.
    rows: [Vec<T>; 2],
    slots: usize,
    /// One row reduced over z and y.
    row: [Vec<T>; 2],
}

impl<T: Copy + PartialOrd + Into<f32>> LayerScratch<T> {
    fn new(any: T, support: &Support) -> Self {
        let slots = (support.block + 2 * support.apron).min(support.dims[1]);
        let nx = support.dims[0];
        Self {
            rows: [vec![any; slots * nx], vec![any; slots * nx]],
            slots,
            row: [vec![any; nx], vec![any; nx]],
        }
    }

    fn reduce(&mut self, voxels: &[T], support: &Support, layer: usize, ranges: &mut [[f32; 2]]) {
        let [nx, ny, _] = support.dims;
        let z_support = support.along(2, layer);
        let mut y_ready = 0;
        for (by, ranges) in ranges.chunks_mut(nx.div_ceil(support.block)).enumerate() {
            let y_support = support.along(1, by);
            for y in y_ready..y_support.end {
                let slot = y % self.slots * nx..(y % self.slots + 1) * nx;
                let [low, high] = &mut self.rows;
                let (low, high) = (&mut low[slot.clone()], &mut high[slot]);
                let row_at = |z: usize| &voxels[(z * ny + y) * nx..][..nx];
                low.copy_from_slice(row_at(z_support.start));
                high.copy_from_slice(row_at(z_support.start));
                for z in z_support.start + 1..z_support.end {
                    min_into(low, row_at(z));
                    max_into(high, row_at(z));
                }
            }
            y_ready = y_support.end;

            let [low, high] = &mut self.row;
            for (i, y) in y_support.enumerate() {
                let slot = y % self.slots * nx..(y % self.slots + 1) * nx;
                if i == 0 {
                    low.copy_from_slice(&self.rows[0][slot.clone()]);
                    high.copy_from_slice(&self.rows[1][slot]);
                } else {
                    min_into(low, &self.rows[0][slot.clone()]);
                    max_into(high, &self.rows[1][slot]);
                }
            }
            for (bx, range) in ranges.iter_mut().enumerate() {
                let x_support = support.along(0, bx);
                let smallest = low[x_support.clone()]
                    .iter()
                    .copied()
                    .reduce(|a, b| if b < a { b } else { a });
                let largest = high[x_support]
                    .iter()
                    .copied()
                    .reduce(|a, b| if a < b { b } else { a });
                let (Some(smallest), Some(largest)) = (smallest, largest) else {
                    unreachable!("a block holds at least one voxel")
                };
                *range = [smallest.into(), largest.into()];
            }
        }
    }
}

pub(super) fn min_into<T: Copy + PartialOrd>(into: &mut [T], row: &[T]) {
    for (a, &b) in into.iter_mut().zip(row) {
        *a = if b < *a { b } else { *a };
    }
}

pub(super) fn max_into<T: Copy + PartialOrd>(into: &mut [T], row: &[T]) {
    for (a, &b) in into.iter_mut().zip(row) {
        *a = if *a < b { b } else { *a };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::octree::testing::{self, AnyVolume};
    use crate::sample::{cell, trilinear};
    use proptest::prelude::*;

    /// The trilinear value at a grid position, voxels clamped to the volume.
    fn sample(volume: &Volume, grid: [f64; 3]) -> f64 {
        let cells = grid.map(cell);
        let voxel = |axis: usize, upper: usize| {
            (cells[axis].0 + upper as f64).clamp(0.0, (volume.dims[axis] - 1) as f64) as usize
        };
        let corners = std::array::from_fn(|z| {
            std::array::from_fn(|y| {
                std::array::from_fn(|x| {
                    f64::from(testing::stored(
                        volume,
                        [voxel(0, x), voxel(1, y), voxel(2, z)],
                    ))
                })
            })
        });
        trilinear(corners, cells.map(|c| c.1))
    }

    proptest! {
        /// Contract 3: no sample in a closed block lies outside the block's range.
        #[test]
        fn every_sample_of_a_closed_block_lies_in_its_range(
            any in AnyVolume::strategy(),
            log_block in 1u32..=6,
            at in prop::array::uniform3(0.0f64..1.0),
            // Faces, edges and corners of the block belong to it too.
            snap in prop::array::uniform3(0u8..4),
        ) {
            let volume = any.volume();
            let block = 1 << log_block;
            let grid = LeafGrid::build(&volume, block, 1);
            for z in 0..grid.dims[2] {
                for y in 0..grid.dims[1] {
                    for x in 0..grid.dims[0] {
                        let leaf = [x, y, z];
                        let position = std::array::from_fn(|a| {
                            let f = match snap[a] { 0 => 0.0, 1 => 1.0, _ => at[a] };
                            ((leaf[a] as f64 + f) * block as f64).min(volume.dims[a] as f64)
                        });
                        let value = sample(&volume, position);
                        let [low, high] = grid.range(leaf).map(f64::from);
                        // f64 interpolation of f32 numbers rounds too.
                        let slack = low.abs().max(high.abs()) * 1e-14;
                        prop_assert!(low - slack <= value && value <= high + slack, "{leaf:?} {position:?}");
                    }
                }
            }
        }

        /// The range is tight: it is that of exactly the voxels within the apron.
        #[test]
        fn a_range_is_that_of_the_voxels_within_the_apron(
            any in AnyVolume::strategy(),
            log_block in 1u32..=6,
            apron in 0usize..=2,
        ) {
            let volume = any.volume();
            let block = 1usize << log_block;
            let grid = LeafGrid::build(&volume, block, apron);
            for z in 0..grid.dims[2] {
                for y in 0..grid.dims[1] {
                    for x in 0..grid.dims[0] {
                        let leaf = [x, y, z];
                        let reach: [Range<usize>; 3] = std::array::from_fn(|a| {
                            (leaf[a] * block).saturating_sub(apron)
                                ..((leaf[a] + 1) * block + apron).min(volume.dims[a])
                        });
                        let mut expected = [f32::INFINITY, f32::NEG_INFINITY];
                        for vz in reach[2].clone() {
                            for vy in reach[1].clone() {
                                for vx in reach[0].clone() {
                                    let v = testing::stored(&volume, [vx, vy, vz]);
                                    expected = [expected[0].min(v), expected[1].max(v)];
                                }
                            }
                        }
                        prop_assert_eq!(grid.range(leaf), expected);
                    }
                }
            }
        }
    }
}
