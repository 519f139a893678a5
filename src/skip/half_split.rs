//! Half-splitting (Yu et al. 2016): the volume is cut across the view's dominant axis, and each half has a hull of its
//! own, so that a cavity at the cut is not marched.

use super::k_cuts::{KCuts, Planes};
use super::plan::Listed;
use super::traversal::Line;
use crate::octree::Occupancy;

/// The hulls of the two halves of these blocks.
#[derive(Debug, Clone, Copy)]
pub struct HalfSplit<'a> {
    /// Which blocks are active.
    pub occupancy: &'a Occupancy,
    /// The axis that the cut is perpendicular to: [`super::half_axis`].
    pub axis: usize,
    /// The first block of the upper half, 0 to `occupancy.dims[axis]`.
    pub cut: usize,
}

impl HalfSplit<'_> {
    /// The half that the ray enters first comes first.
    pub(super) fn segments(&self, line: &Line) -> Listed {
        let slabs = KCuts {
            occupancy: self.occupancy,
            axis: self.axis,
            planes: Planes::new(&[self.cut]),
        };
        slabs.segments(line)
    }
}
