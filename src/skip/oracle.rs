//! The oracle: the samples that contribute and no other. No method: the limit that methods are measured against. Which they
//! are, a march before the one that is timed has noted (on the GPU), or is looked up as the ray goes (in the reference).

use std::ops::Range;

use super::Segments;
use super::plan::Shows;

/// What one ray shows.
pub(super) struct Contributing<'a> {
    /// Samples of the ray.
    pub(super) range: Range<u32>,
    pub(super) shows: Shows<'a>,
    pub(super) given: u32,
}

impl Segments for Contributing<'_> {
    fn next(&mut self, k: u32, _highest: f64) -> Option<Range<u32>> {
        let start = (k.max(self.range.start)..self.range.end).find(|&k| (self.shows)(k))?;
        self.given += 1;
        Some(start..start + 1)
    }

    fn steps(&self) -> u32 {
        self.given
    }
}
