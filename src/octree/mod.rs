//! The min/max octree over a grid of leaf blocks, its classification by a transfer function, and culling.

pub mod occupancy;

pub use occupancy::Occupancy;
