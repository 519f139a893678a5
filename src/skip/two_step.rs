//! Two steps (Ye et al. 2010, as Yu et al. 2016 describe it): a coarse one through emptiness; on the first hit the ray goes
//! back by it and takes the fine one, until it has left what it met.
//!
//! Every [`COARSE`]-th sample is a probe, and the samples between two probes are taken where either of them shows
//! something. What lies between two probes that show nothing is lost: this method is lossy.

use std::ops::Range;

use super::Segments;
use super::plan::Shows;

/// Samples from one probe to the next. The papers give no number.
const COARSE: u32 = 8;

/// The probes of one ray.
pub(super) struct Probes<'a> {
    /// Samples of the ray.
    pub(super) range: Range<u32>,
    pub(super) shows: Shows<'a>,
    /// Whether the last probe showed something; `None` before the first.
    pub(super) hit: Option<bool>,
    pub(super) probes: u32,
}

impl Probes<'_> {
    fn probe(&mut self, k: u32) -> bool {
        self.probes += 1;
        (self.shows)(k.min(self.range.end - 1))
    }
}

impl Segments for Probes<'_> {
    fn next(&mut self, k: u32, _state: f64) -> Option<Range<u32>> {
        let mut k = k.max(self.range.start);
        while k < self.range.end {
            let before = match self.hit {
                Some(hit) => hit,
                None => self.probe(k / COARSE * COARSE),
            };
            let next = (k / COARSE + 1) * COARSE;
            let after = self.probe(next);
            self.hit = Some(after);
            let end = next.min(self.range.end);
            if before || after {
                return Some(k..end);
            }
            k = end;
        }
        None
    }

    fn steps(&self) -> u32 {
        self.probes
    }

    fn probes(&self) -> u32 {
        self.probes
    }
}
