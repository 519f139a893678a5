//! The culled hull: from the first to the last active block that the ray meets (what rasterising the outer faces of the
//! active blocks yields on the GPU).

use super::plan::Listed;
use super::traversal::Line;
use crate::octree::Occupancy;

/// The hull of these blocks.
#[derive(Debug, Clone, Copy)]
pub struct Hull<'a> {
    /// Which blocks are active.
    pub occupancy: &'a Occupancy,
}

impl Hull<'_> {
    pub(super) fn segments(self, line: &Line) -> Listed {
        let mut listed = Listed::default();
        if let Some(hull) = line.hull(self.occupancy, line.span()) {
            listed.push(line.padded(hull));
        }
        listed
    }
}
