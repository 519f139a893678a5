//! Segment lists, after SparseLeap (Hadwiger et al. 2018): all entries into active space and exits from it are listed for
//! each pixel, in order, before its ray is marched. Where two blocks touch there is neither.
//!
//! SparseLeap rasterises occupied space and sorts what falls on a pixel; here the events come from a walk through the
//! blocks (as grid-dda takes), which meets them in order. A list has [`MOST_SEGMENTS`] slots: in one that overflows, the
//! last segment reaches to the last exit.

use std::ops::Range;

use super::grid_dda::GridDda;
use super::plan::Listed;
use super::traversal::Line;
use super::{Bound, Segments};
use crate::octree::Occupancy;

/// The most segments of a ray: what a pixel's memory is bounded by, 8 bytes each.
pub const MOST_SEGMENTS: usize = 16;

/// The segments of a line, listed.
pub(super) fn segments(occupancy: &Occupancy, line: Line) -> Listed {
    let bound = Bound::NONE;
    let mut walk = GridDda { occupancy, bound }.segments(line);
    let mut listed: Vec<Range<u32>> = Vec::new();
    let mut k = 0;
    while let Some(next) = walk.next(k, f64::NAN) {
        k = next.end;
        let is_full = listed.len() == MOST_SEGMENTS;
        match listed.last_mut() {
            Some(last) if is_full || last.end == next.start => last.end = next.end,
            _ => listed.push(next),
        }
    }
    listed.into_iter().collect()
}
