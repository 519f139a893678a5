//! One bit per cell of eight voxels: whether it may be visible. A test of it costs a fraction of the eight loads.

use rayon::prelude::*;

use super::grid::Cell;
use super::packet::{Packet, Voxel};

/// Which cells have a corner outside the background. Cell (x, y, z) lies between voxel (x, y, z) and the next ones.
#[derive(Debug)]
pub(super) struct Cells {
    words: Vec<u32>,
    words_per_row: usize,
}

impl Cells {
    /// The bits for a background of voxels between `low` and `high`, both included.
    pub(super) fn new<V: Voxel>(voxels: &[V], dims: [usize; 3], [low, high]: [V; 2]) -> Self {
        let [nx, ny, nz] = dims;
        let words_per_row = nx.div_ceil(32);
        let mut corners = vec![0u32; words_per_row * ny * nz];
        corners
            .par_chunks_mut(words_per_row)
            .zip(voxels.par_chunks(nx))
            .with_min_len(ny.min(64))
            .for_each(|(words, row)| {
                for (word, voxels) in words.iter_mut().zip(row.chunks(32)) {
                    *word = outside(voxels, low, high);
                }
                spread_along_row(words, nx);
            });
        let mut words = vec![0u32; corners.len()];
        words
            .par_chunks_mut(words_per_row)
            .enumerate()
            .with_min_len(ny.min(64))
            .for_each(|(i, out)| {
                let (y, z) = (i % ny, i / ny);
                let row = |y: usize, z: usize| {
                    &corners[(z.min(nz - 1) * ny + y.min(ny - 1)) * words_per_row..]
                        [..words_per_row]
                };
                let rows = [row(y, z), row(y + 1, z), row(y, z + 1), row(y + 1, z + 1)];
                for (j, word) in out.iter_mut().enumerate() {
                    *word = rows[0][j] | rows[1][j] | rows[2][j] | rows[3][j];
                }
            });
        Self {
            words,
            words_per_row,
        }
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.words.as_slice())
    }

    /// Whether the cells may be visible.
    #[inline(always)]
    pub(super) fn visible<P: Packet>(&self, cell: &Cell<P>) -> P::Mask {
        let bit = P::mul_add_index(cell.row, self.words_per_row * 32, cell.x);
        P::test_bits(&self.words, bit)
    }
}

/// Bit i: whether voxel i, of at most 32, lies outside [low, high].
#[inline(always)]
// Lazy operators would be branches.
#[allow(clippy::needless_bitwise_bool)]
fn outside<V: Voxel>(voxels: &[V], low: V, high: V) -> u32 {
    if let Ok(voxels) = <&[V; 32]>::try_from(voxels) {
        // Compared as bytes, which compilers vectorise, then eight bytes at a time gathered by one multiplication.
        let flags = voxels.map(|v| u8::from((v < low) | (v > high)));
        let mut bits = 0;
        for (i, eight) in flags.chunks_exact(8).enumerate() {
            let eight = eight.iter().rev().fold(0u64, |w, &f| w << 8 | u64::from(f));
            bits |= ((eight.wrapping_mul(0x0102_0408_1020_4080) >> 56) as u32) << (i * 8);
        }
        bits
    } else {
        voxels.iter().enumerate().fold(0, |bits, (i, &v)| {
            bits | u32::from((v < low) | (v > high)) << i
        })
    }
}

/// Adds to each bit of a row of `nx` the one after it.
fn spread_along_row(words: &mut [u32], nx: usize) {
    debug_assert!(nx <= words.len() * 32, "a row's bits fit its words");
    for i in 0..words.len() {
        let next = words.get(i + 1).copied().unwrap_or(0);
        words[i] |= words[i] >> 1 | next << 31;
    }
}
