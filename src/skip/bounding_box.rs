//! The bounding box: every sample of the ray, the baseline of all methods.

use super::plan::Listed;
use super::traversal::Line;

/// The whole range of the ray.
pub(super) fn segments(line: &Line) -> Listed {
    let mut listed = Listed::default();
    listed.push(line.range());
    listed
}
