//! How much of a volume's emptiness is shut in: what skipping only the outside cannot reach.

use rayon::prelude::*;

use super::Volume;
use crate::with_voxels;

/// The share of all voxels, 0 to 1, that are empty and cannot be reached from the box's faces through empty voxels,
/// stepping across voxel faces. `is_empty` is asked for data values.
///
/// Takes a quarter of a byte per voxel.
pub fn enclosed_share(volume: &Volume, is_empty: impl Fn(f64) -> bool + Sync) -> f64 {
    let rows = Rows::new(volume, is_empty);
    let reached = rows.flood();
    let count =
        |words: &[u64]| -> u64 { words.par_iter().map(|w| u64::from(w.count_ones())).sum() };
    (count(&rows.empty) - count(&reached)) as f64 / volume.len() as f64
}

/// One bit per voxel, set where it is empty; each row along x starts at a word.
struct Rows {
    dims: [usize; 3],
    words: usize,
    empty: Vec<u64>,
}

impl Rows {
    fn new(volume: &Volume, is_empty: impl Fn(f64) -> bool + Sync) -> Self {
        let nx = volume.dims[0];
        let words = nx.div_ceil(64);
        let mut empty = vec![0_u64; words * volume.dims[1] * volume.dims[2]];
        let value = |stored: f64| volume.rescale.value_from_stored(stored);
        with_voxels!(&volume.voxels, v => {
            empty.par_chunks_mut(words).zip(v.par_chunks(nx)).for_each(|(bits, row)| {
                for (word, voxels) in bits.iter_mut().zip(row.chunks(64)) {
                    for (i, &stored) in voxels.iter().enumerate() {
                        *word |= u64::from(is_empty(value(f64::from(stored)))) << i;
                    }
                }
            });
        });
        Self {
            dims: volume.dims,
            words,
            empty,
        }
    }

    fn row(&self, row: usize) -> std::ops::Range<usize> {
        row * self.words..(row + 1) * self.words
    }

    /// The empty voxels that are reached from outside.
    fn flood(&self) -> Vec<u64> {
        let [nx, ny, nz] = self.dims;
        let mut reached = vec![0_u64; self.empty.len()];
        let mut queued = vec![true; ny * nz];
        let mut stack: Vec<usize> = (0..ny * nz).collect();
        for row in 0..ny * nz {
            let (y, z) = (row % ny, row / ny);
            let span = self.row(row);
            if y == 0 || y == ny - 1 || z == 0 || z == nz - 1 {
                reached[span.clone()].copy_from_slice(&self.empty[span]);
            } else {
                let last = span.start + (nx - 1) / 64;
                reached[span.start] |= self.empty[span.start] & 1;
                reached[last] |= self.empty[last] & 1 << ((nx - 1) % 64);
            }
        }
        while let Some(row) = stack.pop() {
            queued[row] = false;
            let span = self.row(row);
            spread(&mut reached[span.clone()], &self.empty[span.clone()]);
            let (y, z) = (row % ny, row / ny);
            let neighbours = [
                (y > 0).then(|| row - 1),
                (y + 1 < ny).then(|| row + 1),
                (z > 0).then(|| row - ny),
                (z + 1 < nz).then(|| row + ny),
            ];
            for next in neighbours.into_iter().flatten() {
                let mut grew = false;
                for (from, to) in span.clone().zip(self.row(next)) {
                    let added = reached[from] & self.empty[to] & !reached[to];
                    reached[to] |= added;
                    grew |= added != 0;
                }
                if grew && !queued[next] {
                    queued[next] = true;
                    stack.push(next);
                }
            }
        }
        reached
    }
}

/// Spreads what is reached along a row, through empty voxels, both ways.
fn spread(reached: &mut [u64], empty: &[u64]) {
    let mut carry = 0;
    for (r, &e) in reached.iter_mut().zip(empty) {
        *r = fill(*r | carry & e, e, |bits, by| bits << by);
        carry = *r >> 63;
    }
    carry = 0;
    for (r, &e) in reached.iter_mut().zip(empty).rev() {
        *r = fill(*r | carry & e, e, |bits, by| bits >> by);
        carry = *r << 63;
    }
}

/// Doubling steps within a word: after step i, `open` says from which bits 2^i neighbours before are open too.
fn fill(mut reached: u64, mut open: u64, shift: impl Fn(u64, u32) -> u64) -> u64 {
    for by in [1, 2, 4, 8, 16, 32] {
        reached |= open & shift(reached, by);
        open &= shift(open, by);
    }
    reached
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::{Voxels, phantom};
    use proptest::prelude::*;

    /// The same by a stack of single voxels.
    fn by_voxels(dims: [usize; 3], solid: &[u8]) -> usize {
        let [nx, ny, nz] = dims;
        let mut open: Vec<bool> = solid.iter().map(|&s| s == 0).collect();
        let mut stack = Vec::new();
        for z in 0..nz {
            for y in 0..ny {
                for x in 0..nx {
                    if x == 0 || y == 0 || z == 0 || x == nx - 1 || y == ny - 1 || z == nz - 1 {
                        stack.push([x, y, z]);
                    }
                }
            }
        }
        while let Some([x, y, z]) = stack.pop() {
            if x >= nx || y >= ny || z >= nz || !open[(z * ny + y) * nx + x] {
                continue;
            }
            open[(z * ny + y) * nx + x] = false;
            for axis in 0..3 {
                for step in [1, usize::MAX] {
                    let mut next = [x, y, z];
                    next[axis] = next[axis].wrapping_add(step);
                    stack.push(next);
                }
            }
        }
        open.iter().filter(|&&o| o).count()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn floods_by_rows_reach_what_floods_by_voxels_reach(
            nx in 1_usize..140, ny in 1_usize..9, nz in 1_usize..9, seed in any::<u64>(), density in 1_u64..10,
        ) {
            let mut state = seed | 1;
            let solid: Vec<u8> = (0..nx * ny * nz).map(|_| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                u8::from((state >> 33) % 10 < density)
            }).collect();
            let expected = by_voxels([nx, ny, nz], &solid) as f64 / solid.len() as f64;
            let volume = Volume {
                dims: [nx, ny, nz],
                voxels: Voxels::U8(solid.into()),
                ..phantom::make("empty", [1; 3]).unwrap()
            };
            prop_assert_eq!(enclosed_share(&volume, |v| v == 0.0), expected);
        }
    }
}
