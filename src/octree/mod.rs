//! The min/max octree over a grid of leaf blocks, its classification by a transfer function, and culling.
//!
//! The voxels are read once, into a [`LeafGrid`]. Every [`Octree`] (of the whole volume, of each half of an axis) stands
//! on that one grid and holds only its inner nodes. A table and a mode turn a tree into an [`Occupancy`], one bit per
//! leaf, and that into a [`Hull`], the faces that are rasterised. An [`Accelerator`] owns what one volume needs.

pub mod accelerator;
mod bits;
pub mod bricks;
pub mod cells;
mod colored;
pub mod hull;
pub mod leaf_grid;
pub mod occupancy;
#[cfg(test)]
mod testing;
pub mod tree;

/// The edges of leaf blocks that there are, in voxels.
pub const BLOCKS: [usize; 6] = [2, 4, 8, 16, 32, 64];

pub use accelerator::Accelerator;
pub use bricks::Bricks;
pub use cells::{CellRule, Cells};
pub use hull::{Face, Hull};
pub use leaf_grid::LeafGrid;
pub use occupancy::Occupancy;
pub use tree::Octree;
