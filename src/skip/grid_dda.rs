//! Grid DDA: a walk through the blocks that a ray meets, one by one, by block index (Amanatides & Woo 1987; the macrocells
//! of OpenVKL and OSPRay). Samples are taken in the active ones.

use std::ops::Range;

use super::traversal::{Blocks, Line};
use super::{Bound, Segments};
use crate::octree::Occupancy;

/// The walk through these blocks.
#[derive(Debug, Clone, Copy)]
pub struct GridDda<'a> {
    /// Which blocks are active.
    pub occupancy: &'a Occupancy,
    /// Which of them are left out all the same.
    pub bound: Bound<'a>,
}

impl<'a> GridDda<'a> {
    /// The samples of a line in active blocks, a segment for each block.
    pub(super) fn segments(self, line: Line) -> Walk<'a> {
        Walk {
            occupancy: self.occupancy,
            bound: self.bound,
            line,
            blocks: Blocks::new(self.occupancy, line, line.span()),
            given: line.range().start,
            steps: 0,
        }
    }
}

/// A walk on its way.
pub(super) struct Walk<'a> {
    occupancy: &'a Occupancy,
    bound: Bound<'a>,
    line: Line,
    blocks: Blocks,
    /// Samples before this one have been given or left out.
    given: u32,
    /// Blocks met.
    steps: u32,
}

impl Segments for Walk<'_> {
    fn next(&mut self, k: u32, highest: f64) -> Option<Range<u32>> {
        for (block, [_, leave]) in self.blocks.by_ref() {
            self.steps += 1;
            let is_active = self.occupancy.get(block) && self.bound.may_add(block, highest);
            // Samples that reach from one block into the next are the active one's.
            let reach = self.line.reach();
            let reach = if is_active { reach } else { -reach };
            let all = self.line.range();
            // A sample where the line leaves lies in the next block; the last one of all has no next.
            let end = if leave < self.line.span()[1] {
                ((leave - 0.5 + reach).ceil().max(0.0) as u32).clamp(self.given, all.end)
            } else {
                all.end
            };
            let start = self.given.max(k);
            self.given = end;
            if start < end && is_active {
                return Some(start..end);
            }
        }
        None
    }

    fn steps(&self) -> u32 {
        self.steps
    }
}
