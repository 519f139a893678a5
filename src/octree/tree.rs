//! The octree of Yu et al. 2016 (section 2, fig. 4) over a region of leaf blocks.

use std::ops::Range;

use rayon::prelude::*;

use super::{LeafGrid, Occupancy, bits};

/// A min/max octree over a region of a [`LeafGrid`].
///
/// The paper's node is (depth, position in leaf blocks, min, max, eight children). Here depth and position follow from
/// the way down, children that lie in the region stand side by side, so that one index finds them, and the lowest level,
/// the leaves, is the grid itself, which all trees share: an inner node costs 12 bytes and a leaf nothing. Where all
/// leaves below a node are alike, they are merged into it.
#[derive(Debug)]
pub struct Octree {
    grid: LeafGrid,
    region: [Range<usize>; 3],
    /// The root covers 2^levels leaves per axis; at least 1.
    levels: u32,
    /// Level by level from the root; siblings side by side, x fastest. Empty where the region is.
    nodes: Vec<Node>,
}

#[derive(Debug, Clone, Copy)]
struct Node {
    /// Smallest and largest stored number of the leaves below.
    range: [f32; 2],
    /// Index of the first child; [`MERGED`] where all leaves below have this node's range; unused on level 1, whose
    /// children are leaves.
    first_child: u32,
}

/// Marks a node whose leaves are alike.
const MERGED: u32 = u32::MAX;

impl Octree {
    /// Builds the tree bottom-up, in parallel, from the ranges of the leaves in `region` alone.
    ///
    /// # Panics
    /// Where `region` reaches beyond the grid, or has so many leaves (over 2^34) that an index overflows.
    pub fn build(grid: &LeafGrid, region: [Range<usize>; 3]) -> Self {
        for (axis, range) in region.iter().enumerate() {
            assert!(
                range.end <= grid.dims[axis],
                "the region lies within the grid"
            );
        }
        let size = region.clone().map(|r| r.len());
        let longest = size.into_iter().max().unwrap_or(0);
        let levels = longest.next_power_of_two().ilog2().max(1);
        let mut tree = Self {
            grid: grid.clone(),
            region,
            levels,
            nodes: Vec::new(),
        };
        if size.contains(&0) {
            return tree;
        }
        let mut pyramid = vec![Level::above_leaves(grid, &tree.region)];
        for below in 0..levels as usize - 1 {
            pyramid.push(pyramid[below].above());
        }
        tree.link(&pyramid);
        tree
    }

    /// Lists the nodes of the full pyramid that merging leaves, from the root down.
    fn link(&mut self, pyramid: &[Level]) {
        let mut here = vec![[0; 3]];
        for (index, level) in pyramid.iter().enumerate().rev() {
            let below = index.checked_sub(1).map(|i| &pyramid[i]);
            let mut next_child = self.nodes.len() + here.len();
            let mut next = Vec::new();
            for at in here {
                let cell = level.cell(at);
                let first_child = if cell.alike {
                    MERGED
                } else {
                    next_child as u32
                };
                if let (false, Some(below)) = (cell.alike, below) {
                    let before = next.len();
                    for_children(at, below.dims, |child| next.push(child));
                    next_child += next.len() - before;
                    assert!(next_child < MERGED as usize, "node indices fit 32 bits");
                }
                self.nodes.push(Node {
                    range: cell.range,
                    first_child,
                });
            }
            here = next;
        }
        self.nodes.shrink_to_fit();
    }

    /// The leaves that the tree stands on.
    pub fn region(&self) -> &[Range<usize>; 3] {
        &self.region
    }

    /// Number of nodes above the leaves.
    pub fn node_count(&self) -> usize {
        self.nodes.len()
    }

    /// Bytes that this tree holds beyond the shared grid of leaves.
    pub fn bytes(&self) -> usize {
        size_of::<Self>() + self.nodes.capacity() * size_of::<Node>()
    }

    /// Marks the leaves of the region whose range (smallest and largest stored number) `is_active` accepts.
    ///
    /// Leaves that are marked already stay so. `is_active` must accept every range that contains one it accepts: what an
    /// invisible node holds is not looked at.
    ///
    /// # Panics
    /// Where `out` is over another grid.
    pub fn cull(&self, is_active: &(impl Fn([f32; 2]) -> bool + Sync), out: &mut Occupancy) {
        assert_eq!(self.grid.dims, out.dims, "occupancy of the same grid");
        if self.nodes.is_empty() {
            return;
        }
        // Layers of leaves are apart in memory: slabs of them, aligned to nodes, are culled in parallel.
        let slab_level = self.levels.saturating_sub(4).max(1);
        let words_per_row = out.words_per_row();
        let words_per_layer = words_per_row * out.dims[1];
        out.layers_mut(self.region[2].clone())
            .par_chunks_mut(words_per_layer << slab_level)
            .enumerate()
            .for_each(|(slab, words)| {
                let layers =
                    slab << slab_level..(slab << slab_level) + words.len() / words_per_layer;
                let mut walk = Walk {
                    tree: self,
                    is_active,
                    size: self.region.clone().map(|r| r.len()),
                    layers,
                    words,
                    words_per_row,
                };
                walk.visit(0, self.levels, [0; 3]);
            });
    }
}

/// One way down a tree, for one slab of layers.
struct Walk<'a, F> {
    tree: &'a Octree,
    is_active: &'a F,
    /// Leaves of the region per axis. Positions are counted from the region's corner.
    size: [usize; 3],
    /// The layers of leaves whose bits `words` are.
    layers: Range<usize>,
    words: &'a mut [u64],
    words_per_row: usize,
}

impl<F: Fn([f32; 2]) -> bool> Walk<'_, F> {
    /// Visits a node that covers 2^level leaves per axis from `at` on.
    fn visit(&mut self, node: usize, level: u32, at: [usize; 3]) {
        let node = self.tree.nodes[node];
        if !(self.is_active)(node.range) {
            return;
        }
        let reach: [Range<usize>; 3] =
            std::array::from_fn(|a| at[a]..(at[a] + (1 << level)).min(self.size[a]));
        if node.first_child == MERGED {
            let z = reach[2].start.max(self.layers.start)..reach[2].end.min(self.layers.end);
            let x = self.tree.region[0].start + reach[0].start
                ..self.tree.region[0].start + reach[0].end;
            for z in z {
                for y in reach[1].clone() {
                    bits::fill(self.row(y, z), &x);
                }
            }
        } else if level == 1 {
            for z in reach[2].clone() {
                for y in reach[1].clone() {
                    self.classify_leaves(reach[0].clone(), y, z);
                }
            }
        } else {
            let half = 1 << (level - 1);
            let mut child = node.first_child as usize;
            for_children(
                [0; 3],
                reach.map(|r| r.len().div_ceil(half)),
                |[x, y, z]| {
                    let corner = [at[0] + x * half, at[1] + y * half, at[2] + z * half];
                    if corner[2] < self.layers.end && self.layers.start < corner[2] + half {
                        self.visit(child, level - 1, corner);
                    }
                    child += 1;
                },
            );
        }
    }

    fn classify_leaves(&mut self, x: Range<usize>, y: usize, z: usize) {
        let Octree { grid, region, .. } = self.tree;
        let row = (region[2].start + z) * grid.dims[1] + region[1].start + y;
        let x = region[0].start + x.start..region[0].start + x.end;
        let ranges = &grid.ranges()[row * grid.dims[0]..][x.clone()];
        let is_active = self.is_active;
        let out = self.row(y, z);
        for (x, &range) in x.zip(ranges) {
            out[x / 64] |= u64::from(is_active(range)) << (x % 64);
        }
    }

    fn row(&mut self, y: usize, z: usize) -> &mut [u64] {
        let dims_y = self.tree.grid.dims[1];
        let row = (z - self.layers.start) * dims_y + self.tree.region[1].start + y;
        &mut self.words[row * self.words_per_row..][..self.words_per_row]
    }
}

/// Calls `f` with the position of every child that a parent has in a level of `dims` cells, x fastest.
fn for_children(parent: [usize; 3], dims: [usize; 3], mut f: impl FnMut([usize; 3])) {
    let reach = |a: usize| 2 * parent[a]..(2 * parent[a] + 2).min(dims[a]);
    for z in reach(2) {
        for y in reach(1) {
            for x in reach(0) {
                f([x, y, z]);
            }
        }
    }
}

/// One level of the full pyramid over a region, while a tree is built.
struct Level {
    dims: [usize; 3],
    cells: Vec<Cell>,
}

#[derive(Clone, Copy)]
struct Cell {
    range: [f32; 2],
    /// Whether all leaves below have this range.
    alike: bool,
}

impl Level {
    fn above_leaves(grid: &LeafGrid, region: &[Range<usize>; 3]) -> Self {
        let corner = region.clone().map(|r| r.start);
        let leaf = |[x, y, z]: [usize; 3]| Cell {
            range: grid.range([corner[0] + x, corner[1] + y, corner[2] + z]),
            alike: true,
        };
        Self::reduce(region.clone().map(|r| r.len()), leaf)
    }

    fn above(&self) -> Self {
        Self::reduce(self.dims, |at| self.cell(at))
    }

    fn reduce(below: [usize; 3], cell: impl Fn([usize; 3]) -> Cell + Sync) -> Self {
        let dims = below.map(|n| n.div_ceil(2));
        let nothing = Cell {
            range: [0.0; 2],
            alike: true,
        };
        let mut cells = vec![nothing; dims.iter().product()];
        cells
            .par_chunks_mut(dims[0])
            .enumerate()
            .with_min_len(64)
            .for_each(|(row, cells)| {
                let (y, z) = (row % dims[1], row / dims[1]);
                for (x, all) in cells.iter_mut().enumerate() {
                    let parent = [x, y, z];
                    let first = cell(parent.map(|i| 2 * i));
                    *all = first;
                    for_children(parent, below, |child| {
                        let c = cell(child);
                        all.alike &= c.alike && c.range == first.range;
                        all.range[0] = all.range[0].min(c.range[0]);
                        all.range[1] = all.range[1].max(c.range[1]);
                    });
                }
            });
        Self { dims, cells }
    }

    fn cell(&self, [x, y, z]: [usize; 3]) -> Cell {
        self.cells[(z * self.dims[1] + y) * self.dims[0] + x]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::octree::testing::{AnyVolume, volume_of};
    use crate::volume::Voxels;
    use proptest::prelude::*;

    /// The leaves of `region` that `is_active` accepts, one by one.
    fn brute_force(
        grid: &LeafGrid,
        region: &[Range<usize>; 3],
        is_active: impl Fn([f32; 2]) -> bool,
    ) -> Occupancy {
        let mut occupancy = Occupancy::new(grid.volume_dims, grid.block);
        for z in region[2].clone() {
            for y in region[1].clone() {
                for x in region[0].clone() {
                    if is_active(grid.range([x, y, z])) {
                        occupancy.set([x, y, z]);
                    }
                }
            }
        }
        occupancy
    }

    proptest! {
        /// Merging and skipping nodes whole changes no leaf's class, in any region.
        #[test]
        fn culling_classifies_as_the_plain_grid_of_leaves(
            any in AnyVolume::strategy(),
            log_block in 1u32..=6,
            ends in prop::array::uniform3(prop::array::uniform2(0.0f64..=1.0)),
            band in prop::array::uniform2(-300.0f32..300.0),
        ) {
            let volume = any.volume();
            let grid = LeafGrid::build(&volume, 1 << log_block, 1);
            let is_active = |[low, high]: [f32; 2]| low < band[0].max(band[1]) && band[0].min(band[1]) < high;
            let part: [Range<usize>; 3] = std::array::from_fn(|a| {
                let [start, end] = ends[a].map(|part| (part * grid.dims[a] as f64) as usize);
                start.min(end)..end
            });
            for region in [grid.dims.map(|n| 0..n), part] {
                let mut culled = Occupancy::new(grid.volume_dims, grid.block);
                Octree::build(&grid, region.clone()).cull(&is_active, &mut culled);
                prop_assert_eq!(culled, brute_force(&grid, &region, is_active));
            }
        }
    }

    /// Sizes over several slabs, words and blocks that the random volumes do not reach.
    #[test]
    fn culling_is_exact_on_large_odd_volumes() {
        let dims = [257, 255, 63];
        let voxels: Vec<u8> = (0..dims.iter().product::<usize>())
            .map(|i| {
                if i / 4096 % 3 == 0 {
                    (i % 251) as u8
                } else {
                    7
                }
            })
            .collect();
        let volume = volume_of(dims, Voxels::U8(voxels.into()));
        for block in [2, 4, 8, 64] {
            let grid = LeafGrid::build(&volume, block, 1);
            let region = grid.dims.map(|n| 0..n);
            let is_active = |[low, high]: [f32; 2]| low < 7.0 || high > 240.0;
            let mut culled = Occupancy::new(dims, block);
            Octree::build(&grid, region.clone()).cull(&is_active, &mut culled);
            let expected = brute_force(&grid, &region, is_active);
            assert!(culled == expected, "block {block}");
            assert!(expected.count() > 0, "block {block}");
        }
    }

    #[test]
    fn a_uniform_volume_is_one_node() {
        let volume = volume_of([65, 33, 17], Voxels::U8(vec![9; 65 * 33 * 17].into()));
        let grid = LeafGrid::build(&volume, 2, 1);
        let tree = Octree::build(&grid, grid.dims.map(|n| 0..n));
        assert_eq!(tree.node_count(), 1);
        let mut culled = Occupancy::new(grid.volume_dims, 2);
        tree.cull(&|range| range == [9.0, 9.0], &mut culled);
        assert_eq!(culled.count(), grid.dims.iter().product::<usize>());
    }

    #[test]
    fn trees_share_the_ranges_of_their_grid() {
        let volume = volume_of(
            [40, 40, 40],
            Voxels::U8((0..64_000).map(|i| i as u8).collect::<Vec<_>>().into()),
        );
        let grid = LeafGrid::build(&volume, 2, 1);
        let tree = Octree::build(&grid, [3..20, 0..20, 0..11]);
        assert!(std::ptr::eq(tree.grid.ranges(), grid.ranges()));
        let leaves = 17 * 20 * 11;
        assert!(
            tree.bytes() < leaves * 12 / 4,
            "nodes stand above the leaves only"
        );
    }
}
