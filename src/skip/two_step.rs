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
pub(super) struct CoarseSteps<'a> {
    /// Samples of the ray.
    pub(super) range: Range<u32>,
    pub(super) shows: Shows<'a>,
    /// Whether the last probe showed something; `None` before the first.
    pub(super) hit: Option<bool>,
    pub(super) probes: u32,
}

impl CoarseSteps<'_> {
    fn probe(&mut self, k: u32) -> bool {
        self.probes += 1;
        (self.shows)(k.min(self.range.end - 1))
    }
}

impl Segments for CoarseSteps<'_> {
    fn next(&mut self, k: u32, _highest: f64) -> Option<Range<u32>> {
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

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// Between two probes all is taken, or nothing and neither of them shows anything.
        #[test]
        fn samples_between_probes_are_taken_where_one_of_them_shows(
            near in 0u32..60,
            len in 1u32..120,
            shown in prop::collection::vec(any::<bool>(), 200),
        ) {
            let range = near..near + len;
            let shows = |k: u32| shown[k as usize];
            let mut probes = CoarseSteps { range: range.clone(), shows: &shows, hit: None, probes: 0 };
            let mut taken = [false; 200];
            let mut k = 0;
            while let Some(segment) = probes.next(k, f64::NAN) {
                prop_assert!(k.max(near) <= segment.start && segment.start < segment.end && segment.end <= range.end);
                k = segment.end;
                taken[segment.start as usize..segment.end as usize].fill(true);
            }
            for k in range.clone() {
                let before = k / COARSE * COARSE;
                let after = (before + COARSE).min(range.end - 1);
                prop_assert_eq!(taken[k as usize], shows(before) || shows(after));
            }
        }
    }
}
