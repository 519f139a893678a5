//! Which leaf blocks are active: one bit each.

use std::ops::Range;

/// Activity of every leaf block of a volume for one table and mode.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Occupancy {
    /// Edge of a block in voxels. Block i covers grid coordinates [i * block, (i + 1) * block], closed; the last one of
    /// an axis ends with the volume.
    pub block: usize,
    /// Blocks along x, y, z.
    pub dims: [usize; 3],
    /// Voxels along x, y, z.
    pub volume_dims: [usize; 3],
    /// Bit `(z * dims.y + y) * words_per_row * 64 + x`: rows start on a word.
    words: Vec<u64>,
    words_per_row: usize,
}

impl Occupancy {
    /// All blocks inactive.
    pub fn new(volume_dims: [usize; 3], block: usize) -> Self {
        let dims = volume_dims.map(|n| n.div_ceil(block));
        let words_per_row = dims[0].div_ceil(64);
        Self {
            block,
            dims,
            volume_dims,
            words: vec![0; words_per_row * dims[1] * dims[2]],
            words_per_row,
        }
    }

    /// Whether block (x, y, z) is active.
    pub fn get(&self, [x, y, z]: [usize; 3]) -> bool {
        self.row(y, z)[x / 64] >> (x % 64) & 1 == 1
    }

    /// Marks block (x, y, z) active.
    pub fn set(&mut self, [x, y, z]: [usize; 3]) {
        self.row_mut(y, z)[x / 64] |= 1 << (x % 64);
    }

    /// The bits of the row of blocks at (y, z), x from bit 0 of the first word on.
    pub fn row(&self, y: usize, z: usize) -> &[u64] {
        let at = (z * self.dims[1] + y) * self.words_per_row;
        &self.words[at..at + self.words_per_row]
    }

    /// The same, to write. Bits past `dims[0]` must stay 0.
    pub fn row_mut(&mut self, y: usize, z: usize) -> &mut [u64] {
        let at = (z * self.dims[1] + y) * self.words_per_row;
        &mut self.words[at..at + self.words_per_row]
    }

    /// The bits of layers of blocks along z, all rows of them, to write. Bits past `dims[0]` must stay 0.
    pub(super) fn layers_mut(&mut self, layers: Range<usize>) -> &mut [u64] {
        let layer = self.words_per_row * self.dims[1];
        &mut self.words[layers.start * layer..layers.end * layer]
    }

    /// The same in blocks twice as large, each active where one of its eight is.
    ///
    /// Classified on its own, a larger block can be active where none of the eight is: where their ranges lie on both
    /// sides of what the table shows. So this is an estimate, and nothing may be left out by it.
    pub fn coarser(&self) -> Self {
        let mut coarser = Self::new(self.volume_dims, self.block * 2);
        for z in 0..self.dims[2] {
            for y in 0..self.dims[1] {
                for (w, &word) in self.row(y, z).iter().enumerate() {
                    let mut bits = word;
                    while bits != 0 {
                        let x = w * 64 + bits.trailing_zeros() as usize;
                        coarser.set([x / 2, y / 2, z / 2]);
                        // The other bit of the pair says no more.
                        bits &= !(0b11 << (x % 64 / 2 * 2));
                    }
                }
            }
        }
        coarser
    }

    /// Number of faces between an active block and an inactive one, or the outside.
    pub fn exposed_faces(&self) -> usize {
        let ones = |words: &[u64]| words.iter().map(|w| w.count_ones() as usize).sum::<usize>();
        // Each pair of active neighbours hides two of the six faces that every block has.
        let mut hidden = 0;
        for z in 0..self.dims[2] {
            for y in 0..self.dims[1] {
                let row = self.row(y, z);
                let mut carry = 0;
                for &word in row {
                    hidden += (word & (word << 1 | carry)).count_ones() as usize;
                    carry = word >> 63;
                }
                let both = |other: &[u64]| -> usize {
                    let pairs = row.iter().zip(other);
                    pairs.map(|(a, b)| (a & b).count_ones() as usize).sum()
                };
                if y > 0 {
                    hidden += both(self.row(y - 1, z));
                }
                if z > 0 {
                    hidden += both(self.row(y, z - 1));
                }
            }
        }
        6 * ones(&self.words) - 2 * hidden
    }

    /// Number of active blocks.
    pub fn count(&self) -> usize {
        self.words.iter().map(|w| w.count_ones() as usize).sum()
    }

    /// The block on `axis` that the volume is cut at: of the block boundaries, the one nearest the middle of the volume
    /// (the upper of two). A volume of one block has an empty half.
    pub fn half_cut(&self, axis: usize) -> usize {
        half_cut(self.volume_dims[axis], self.block)
    }

    /// The whole grid as a region of blocks.
    pub fn whole(&self) -> [Range<usize>; 3] {
        self.dims.map(|n| 0..n)
    }

    /// Rows as 64-bit words, [`Self::words_per_row`] each, y before z: what shaders read.
    pub fn words(&self) -> &[u64] {
        &self.words
    }

    /// Words per row of blocks.
    pub fn words_per_row(&self) -> usize {
        self.words_per_row
    }
}

/// See [`Occupancy::half_cut`].
pub(super) fn half_cut(voxels: usize, block: usize) -> usize {
    (voxels + block) / (2 * block)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn faces_and_coarser_blocks_are_those_counted_one_by_one(
            dims in prop::array::uniform3(1usize..150),
            active in prop::collection::vec(any::<[prop::sample::Index; 3]>(), 0..60),
        ) {
            let dims = [dims[0], dims[1] % 7 + 1, dims[2] % 5 + 1];
            let mut occupancy = Occupancy::new(dims.map(|n| n * 4), 4);
            for block in active {
                // Crowded, so that neighbours meet.
                let at = std::array::from_fn(|a| block[a].index(dims[a].min(80)));
                occupancy.set(at);
            }
            let all = || {
                let [nx, ny, nz] = dims;
                (0..nx * ny * nz).map(move |i| [i % nx, i / nx % ny, i / nx / ny])
            };
            let is_active = |at: [i64; 3]| {
                (0..3).all(|a| (0..dims[a] as i64).contains(&at[a])) && occupancy.get(at.map(|i| i as usize))
            };
            let mut faces = 0;
            for at in all().filter(|&at| occupancy.get(at)) {
                for axis in 0..3 {
                    for side in [-1, 1] {
                        let mut beside = at.map(|i| i as i64);
                        beside[axis] += side;
                        faces += usize::from(!is_active(beside));
                    }
                }
            }
            prop_assert_eq!(occupancy.exposed_faces(), faces);
            let mut expected = Occupancy::new(dims.map(|n| n * 4), 8);
            for at in all().filter(|&at| occupancy.get(at)) {
                expected.set(at.map(|i| i / 2));
            }
            prop_assert_eq!(occupancy.coarser(), expected);
        }
    }
}
