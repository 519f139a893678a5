//! Half-splitting (Yu et al. 2016): the volume is cut across the view's dominant axis, and each half has a hull of its
//! own, so that a cavity at the cut is not marched.

use super::Listed;
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
    /// The half that the ray enters first comes first: k only grows.
    pub(super) fn segments(&self, line: &Line) -> Listed {
        let [start, end] = line.span();
        let cut = line.crossing(self.axis, (self.cut * self.occupancy.block) as f64);
        // A ray that stays in one half, or touches the other in a point, has one hull. So has one parallel to the cut,
        // whose crossing is infinite.
        let cut = cut.clamp(start, end);
        let mut listed = Listed::default();
        for half in [[start, cut], [cut, end]] {
            // Halves of no length have no samples, unless the whole ray is one sample; the list drops its second copy.
            let has_samples = half[0] < half[1] || start == end;
            if has_samples && let Some(hull) = line.hull(self.occupancy, half) {
                listed.push(line.padded(hull));
            }
        }
        listed
    }
}
