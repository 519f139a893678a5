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
