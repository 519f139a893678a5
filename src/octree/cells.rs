//! Cells: what lies between eight voxels, the smallest part of a volume that can be known to show nothing. Two bits for each
//! tell how near the next one is that may show something; a look at them costs a fraction of the loads that it saves.

use std::ops::RangeInclusive;

use rayon::prelude::*;

use super::Occupancy;
use super::accelerator::stored_range_to_x;
use super::bits::next_run;
use super::leaf_grid::{max_into, min_into};
use crate::mode::Mode;
use crate::transfer::Table;
use crate::volume::Volume;
use crate::with_voxels;

/// The farthest that is told of a cell: this far or farther.
pub const FARTHEST: u32 = 3;

/// Cells to a word.
pub(super) const PER_WORD: usize = 16;

/// What makes a cell contribute to pictures.
///
/// Cell (x, y, z) lies between the centres of voxel (x, y, z) and of the next ones; those before the first and behind the
/// last voxels count as the outermost's.
#[derive(Debug, Clone, Copy)]
pub struct CellRule<'a> {
    /// The voxels.
    pub volume: &'a Volume,
    /// What they are shown by.
    pub table: &'a Table,
    /// What is done with their samples.
    pub mode: Mode,
    /// Voxels on each side of a cell that its samples touch ([`crate::sample::Sampler::apron`]).
    pub apron: usize,
    /// Whether voxels get their colours before these are interpolated: values between them do not count.
    pub is_by_voxel: bool,
}

impl CellRule<'_> {
    /// Whether a sample in the cell can contribute: asked of eight voxels (where the apron is 1), for who wants to know of few
    /// cells.
    pub fn contributes(&self, cell: [usize; 3]) -> bool {
        with_voxels!(&self.volume.voxels, voxels => self.contributes_among(voxels, cell))
    }

    fn contributes_among<T: Copy + Into<f32>>(&self, voxels: &[T], cell: [usize; 3]) -> bool {
        let [nx, ny, _] = self.volume.dims;
        let [xs, ys, zs] = [0, 1, 2].map(|a| self.touched(a, cell[a]));
        let mut range = [f32::INFINITY, f32::NEG_INFINITY];
        for z in zs {
            for y in ys.clone() {
                for x in xs.clone() {
                    let stored: f32 = voxels[(z * ny + y) * nx + x].into();
                    if self.is_by_voxel && self.shows([stored; 2]) {
                        return true;
                    }
                    range = [range[0].min(stored), range[1].max(stored)];
                }
            }
        }
        !self.is_by_voxel && self.shows(range)
    }

    /// The voxels along an axis that samples in a cell touch.
    fn touched(&self, axis: usize, cell: usize) -> RangeInclusive<usize> {
        let last = self.volume.dims[axis] - 1;
        cell.saturating_sub(self.apron - 1)..=(cell + self.apron).min(last)
    }

    /// Whether samples between two stored numbers can contribute.
    fn shows(&self, range: [f32; 2]) -> bool {
        let domain = self.table.domain();
        let voxel_type = self.volume.voxels.voxel_type();
        let x = stored_range_to_x(range, voxel_type, domain);
        self.mode.activity(domain).is_active(self.table, x)
    }

    /// A bit for every cell that contributes, in rows of whole words. Looked for in the active blocks alone: a block's
    /// closed support holds the voxels of the cells that begin in it.
    fn bits<T>(&self, voxels: &[T], occupancy: &Occupancy) -> Vec<u64>
    where
        T: Copy + PartialOrd + Into<f32> + Send + Sync,
    {
        let [nx, ny, nz] = self.volume.dims;
        let per_row = nx.div_ceil(64);
        let mut bits = vec![0u64; per_row * ny * nz];
        bits.par_chunks_mut(per_row)
            .enumerate()
            .with_min_len(16)
            .for_each_init(
                || [voxels[..nx].to_vec(), voxels[..nx].to_vec()],
                |scratch, (row, out)| {
                    self.bits_of_row(voxels, occupancy, [row % ny, row / ny], scratch, out);
                },
            );
        bits
    }

    /// The bits of the row at (y, z); `scratch` holds as many voxels, twice.
    fn bits_of_row<T: Copy + PartialOrd + Into<f32>>(
        &self,
        voxels: &[T],
        occupancy: &Occupancy,
        [y, z]: [usize; 2],
        [low, high]: &mut [Vec<T>; 2],
        out: &mut [u64],
    ) {
        let [nx, ny, _] = self.volume.dims;
        let block = occupancy.block;
        let active = occupancy.row(y / block, z / block);
        let mut searched = 0;
        while let Some(run) = next_run(active, searched) {
            searched = run.end;
            let cells = run.start * block..(run.end * block).min(nx);
            // The voxels that they touch, least and most over y and z.
            let first = *self.touched(0, cells.start).start();
            let end = self.touched(0, cells.end - 1).end() + 1;
            let row_at = |y: usize, z: usize| &voxels[(z * ny + y) * nx..][first..end];
            let (low, high) = (&mut low[first..end], &mut high[first..end]);
            low.copy_from_slice(row_at(y, z));
            high.copy_from_slice(row_at(y, z));
            for z in self.touched(2, z) {
                for y in self.touched(1, y) {
                    min_into(low, row_at(y, z));
                    max_into(high, row_at(y, z));
                }
            }
            // Neighbours are often of one range, inside a solid above all.
            let mut last = ([f32::NAN; 2], false);
            for x in cells {
                let touched = self.touched(0, x);
                let mut range = [f32::INFINITY, f32::NEG_INFINITY];
                for i in touched.start() - first..=touched.end() - first {
                    range = [range[0].min(low[i].into()), range[1].max(high[i].into())];
                }
                if range != last.0 {
                    last = (range, self.shows(range));
                }
                out[x / 64] |= u64::from(last.1) << (x % 64);
            }
        }
    }

    /// The same where voxels are shown, not what lies between them.
    fn bits_by_voxel(&self) -> Vec<u64> {
        let shown = Occupancy::of_visible_voxels(self.volume, self.table, 1, 0);
        let (before, after) = (self.apron, self.apron - 1);
        spread(shown.words(), self.volume.dims, before, after)
    }
}

/// How near every cell is to one that contributes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cells {
    dims: [usize; 3],
    /// Two bits for each cell, [`PER_WORD`] to a word, the first in the lowest; rows start on a word.
    words: Vec<u32>,
}

impl Cells {
    /// The cells that contribute by `rule`, which lie in the active blocks of `occupancy`, and the distances to them.
    pub fn new(rule: &CellRule, occupancy: &Occupancy) -> Self {
        let dims @ [nx, ny, nz] = rule.volume.dims;
        let at = if rule.is_by_voxel {
            rule.bits_by_voxel()
        } else {
            with_voxels!(&rule.volume.voxels, voxels => rule.bits(voxels, occupancy))
        };
        let within_1 = spread(&at, dims, 1, 1);
        let within_2 = spread(&within_1, dims, 1, 1);
        let per_row = nx.div_ceil(64);
        let words_per_row = nx.div_ceil(PER_WORD);
        let mut words = vec![0u32; words_per_row * ny * nz];
        words
            .par_chunks_mut(words_per_row)
            .enumerate()
            .with_min_len(16)
            .for_each(|(row, out)| {
                let bits = |of: &[u64], i: usize| {
                    let four = of[row * per_row + i / 4];
                    (four >> (i % 4 * PER_WORD)) as u32 & 0xffff
                };
                for (i, word) in out.iter_mut().enumerate() {
                    let [at, near, far] = [&at, &within_1, &within_2].map(|of| bits(of, i));
                    // 0: at; 1: near but not at; 2: far but not near; 3: not even far.
                    let (low, high) = ((near & !at) | !far, !near);
                    *word = apart(low) | apart(high) << 1;
                }
            });
        Self { dims, words }
    }

    /// Cells, 0 to 3 = [`FARTHEST`] or more, to the nearest one that contributes (0: this one), by the largest of the
    /// distances along the axes.
    pub fn distance(&self, [x, y, z]: [usize; 3]) -> u32 {
        let row = (z * self.dims[1] + y) * self.dims[0].div_ceil(PER_WORD);
        self.words[row + x / PER_WORD] >> (x % PER_WORD * 2) & 3
    }

    /// Cells along x, y, z: as many as voxels.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// The cells of a row that contribute: of two bits for each the lower, in words as those of [`Self::words`].
    pub(super) fn contributing(&self, y: usize, z: usize) -> impl Iterator<Item = u32> + '_ {
        let per_row = self.dims[0].div_ceil(PER_WORD);
        let words = &self.words[(z * self.dims[1] + y) * per_row..][..per_row];
        words.iter().map(|word| !(word | word >> 1) & 0x5555_5555)
    }

    /// What shaders read.
    pub fn words(&self) -> &[u32] {
        &self.words
    }

    /// Bytes of the words for a volume of these dimensions.
    pub fn bytes_of(dims: [usize; 3]) -> u64 {
        (dims[0].div_ceil(PER_WORD) * dims[1] * dims[2] * 4) as u64
    }
}

/// The lowest 16 bits, each in the lower of two.
fn apart(bits: u32) -> u32 {
    let bits = bits & 0xffff;
    let bits = (bits | bits << 8) & 0x00ff_00ff;
    let bits = (bits | bits << 4) & 0x0f0f_0f0f;
    let bits = (bits | bits << 2) & 0x3333_3333;
    (bits | bits << 1) & 0x5555_5555
}

/// Sets what lies up to `before` before a set bit and up to `after` after it, along each axis.
fn spread(bits: &[u64], [nx, ny, nz]: [usize; 3], before: usize, after: usize) -> Vec<u64> {
    let per_row = nx.div_ceil(64);
    let spread_in_row = |row: &[u64], out: &mut [u64]| {
        out.copy_from_slice(row);
        for by in 1..=before.max(after) {
            for (i, out) in out.iter_mut().enumerate() {
                if by <= before {
                    let next = row.get(i + 1).map_or(0, |next| next << (64 - by));
                    *out |= row[i] >> by | next;
                }
                if by <= after {
                    let last = i.checked_sub(1).map_or(0, |i| row[i] >> (64 - by));
                    *out |= row[i] << by | last;
                }
            }
        }
        // What was shifted beyond the last cell is none.
        if nx % 64 != 0 {
            out[per_row - 1] &= u64::MAX >> (64 - nx % 64);
        }
    };
    let mut along_x = vec![0; bits.len()];
    along_x
        .par_chunks_mut(per_row)
        .zip(bits.par_chunks(per_row))
        .with_min_len(64)
        .for_each(|(out, row)| spread_in_row(row, out));
    let joined = |from: &[u64], row_of: &(dyn Fn(usize, usize) -> Option<usize> + Sync)| {
        let mut joined = vec![0; from.len()];
        joined
            .par_chunks_mut(per_row)
            .enumerate()
            .with_min_len(64)
            .for_each(|(row, out)| {
                for i in 0..=before + after {
                    if let Some(other) = row_of(row, i) {
                        let other = &from[other * per_row..][..per_row];
                        out.iter_mut().zip(other).for_each(|(out, o)| *out |= o);
                    }
                }
            });
        joined
    };
    // A row is set by those from `after` before it to `before` after it.
    let along_y = joined(&along_x, &|row, i| {
        let y = (row % ny + i).checked_sub(after)?;
        (y < ny).then(|| row / ny * ny + y)
    });
    joined(&along_y, &|row, i| {
        let z = (row / ny + i).checked_sub(after)?;
        (z < nz).then(|| z * ny + row % ny)
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::octree::Accelerator;
    use crate::octree::testing::{self, AnyVolume};

    proptest! {
        /// Every cell's distance is the one that looking at all of them gives; so none that contributes lies outside the
        /// active blocks.
        #[test]
        fn distances_are_to_the_nearest_cell_that_contributes(
            any in AnyVolume::strategy(),
            log_block in 1u32..=3,
            apron in 1usize..=2,
            band in prop::array::uniform2(0.0f64..=1.0),
            is_by_voxel: bool,
        ) {
            let volume = any.volume();
            let block = 1 << log_block;
            let table = testing::band(&volume, band[0].min(band[1]), band[0].max(band[1]));
            let mode = Mode::EmissionAbsorption;
            let occupancy = if is_by_voxel {
                Occupancy::of_visible_voxels(&volume, &table, block, apron)
            } else {
                Accelerator::build(&volume, block, apron).unwrap().cull(&table, mode)
            };
            let rule = CellRule { volume: &volume, table: &table, mode, apron, is_by_voxel };
            let cells = Cells::new(&rule, &occupancy);
            prop_assert_eq!(size_of_val(cells.words()) as u64, Cells::bytes_of(volume.dims));
            let [nx, ny, nz] = volume.dims;
            let all: Vec<[usize; 3]> = (0..nx * ny * nz).map(|i| [i % nx, i / nx % ny, i / nx / ny]).collect();
            let contributing: Vec<_> = all.iter().filter(|&&c| rule.contributes(c)).collect();
            for &cell in &all {
                let distance = |other: &[usize; 3]| (0..3).map(|a| cell[a].abs_diff(other[a])).max().unwrap_or(0);
                let nearest = contributing.iter().map(|c| distance(c) as u32).min().unwrap_or(FARTHEST);
                prop_assert_eq!(cells.distance(cell), nearest.min(FARTHEST));
            }
        }
    }
}
