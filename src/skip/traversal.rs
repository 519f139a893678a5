//! The blocks that a ray meets, in order: a walk by block index (after Amanatides & Woo 1987) whose crossings follow
//! from the index of the plane, so that nothing accumulates and nothing is nudged.
//!
//! Everything here is a function of `s = k + 1/2`, in which positions are `entry + s * delta`. Which block holds `s` is
//! defined by the crossings alone: along each axis, the block behind the last plane crossed at or before `s`. Hence all
//! walks along a line agree, wherever they start, and so do those along its reverse, but for ties.
//!
//! A sample on a face, or one that rounding pushed over it, belongs to the blocks on both sides. Finding either is
//! enough: a block is inactive only if everything within half a voxel of it contributes nothing, because of the apron
//! of its closed support (design contract 3). Along the ray one sample of padding is added on top (contract 5).

use std::ops::Range;

use crate::lattice::{Ray, Real};
use crate::octree::Occupancy;

/// A ray in f64, with at least one sample.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line {
    entry: [f64; 3],
    delta: [f64; 3],
    /// 1 / delta; unused where the line is parallel.
    inverse: [f64; 3],
    k_near: f64,
    k_end: f64,
    /// How far a sample reaches to both sides.
    reach: f64,
}

impl Line {
    /// `None` where the ray has no sample.
    pub(super) fn new<R: Real + Into<f64>>(ray: &Ray<R>) -> Option<Self> {
        let delta = ray.delta.map(Into::into);
        let (k_near, k_end) = (ray.k_near.into(), ray.k_end.into());
        (k_near < k_end).then(|| Self {
            entry: ray.entry.map(Into::into),
            delta,
            inverse: delta.map(|d| 1.0 / d),
            k_near,
            k_end,
            reach: ray.reach.into(),
        })
    }

    /// From the first to the last sample and as far as these reach, in `s`.
    pub(super) fn span(&self) -> [f64; 2] {
        [
            self.k_near + 0.5 - self.reach,
            self.k_end - 0.5 + self.reach,
        ]
    }

    /// How far a sample reaches to both sides, in `s`.
    pub(super) fn reach(&self) -> f64 {
        self.reach
    }

    /// All samples.
    pub(super) fn range(&self) -> Range<u32> {
        self.k_near as u32..self.k_end as u32
    }

    /// The samples that reach into a closed interval of `s`, and one more at each end.
    pub(super) fn padded(&self, [start, end]: [f64; 2]) -> Range<u32> {
        let first = (start - 0.5 - self.reach).ceil() - 1.0;
        let last = (end - 0.5 + self.reach).floor() + 1.0;
        first.max(self.k_near) as u32..(last + 1.0).min(self.k_end) as u32
    }

    /// Whether the line does not descend along `axis`.
    pub(super) fn ascends(&self, axis: usize) -> bool {
        self.delta[axis] >= 0.0
    }

    /// Where the line crosses the plane at grid coordinate `plane` of `axis`, in `s`; infinite where it is parallel.
    pub(super) fn crossing(&self, axis: usize, plane: f64) -> f64 {
        if self.delta[axis] == 0.0 {
            f64::INFINITY
        } else {
            (plane - self.entry[axis]) * self.inverse[axis]
        }
    }

    /// The interval from where the line enters its first active block within `span` to where it leaves its last one.
    pub(super) fn hull(&self, occupancy: &Occupancy, span: [f64; 2]) -> Option<[f64; 2]> {
        let first = Blocks::new(occupancy, *self, span).find(|(b, _)| occupancy.get(*b))?;
        let backwards = Blocks::new(occupancy, self.reversed(), [-span[1], -span[0]])
            .find(|(b, _)| occupancy.get(*b));
        // Where ties let only one of the walks see a block, that block is the hull.
        let last = backwards.map_or(first.1[1], |(_, interval)| -interval[0]);
        Some([first.1[0], last.max(first.1[1])])
    }

    /// The same points in the other order, at `-s`.
    fn reversed(self) -> Self {
        Self {
            delta: self.delta.map(|d| -d),
            inverse: self.inverse.map(|i| -i),
            ..self
        }
    }
}

/// The blocks along a line in order, each with the interval of `s` (not empty, unless the span is) in which it holds
/// the line. Outermost blocks reach outwards without end, as clamped voxels do.
#[derive(Debug)]
pub(super) struct Blocks {
    line: Line,
    block: f64,
    last: [usize; 3],
    at: [usize; 3],
    /// Where the line leaves block `at` along each axis.
    leave: [f64; 3],
    /// What is left of the span; `None` at its end.
    rest: Option<[f64; 2]>,
}

impl Blocks {
    /// The blocks from `span[0]` to `span[1] >= span[0]`.
    pub(super) fn new(occupancy: &Occupancy, line: Line, span: [f64; 2]) -> Self {
        let block = occupancy.block as f64;
        let mut blocks = Self {
            line,
            block,
            last: occupancy.dims.map(|n| n - 1),
            at: std::array::from_fn(|a| {
                let position = line.entry[a] + span[0] * line.delta[a];
                // Saturates below 0.
                ((position / block) as usize).min(occupancy.dims[a] - 1)
            }),
            leave: [f64::INFINITY; 3],
            rest: Some(span),
        };
        for a in 0..3 {
            blocks.settle(a, span[0]);
        }
        blocks
    }

    /// Makes `at` and `leave` of one axis true to the crossings at `s`, starting from a block near by.
    fn settle(&mut self, a: usize, s: f64) {
        if self.line.delta[a] == 0.0 {
            return;
        }
        let ascending = self.line.delta[a] > 0.0;
        let plane = |i: usize| self.line.crossing(a, i as f64 * self.block);
        let mut at = self.at[a];
        // Forwards over every plane crossed, then backwards over what the division rounded up.
        let mut leave = loop {
            let leave = match (ascending, at) {
                (true, at) if at < self.last[a] => plane(at + 1),
                (false, at) if at > 0 => plane(at),
                _ => f64::INFINITY,
            };
            if leave > s {
                break leave;
            }
            at = if ascending { at + 1 } else { at - 1 };
        };
        loop {
            let enter = match (ascending, at) {
                (true, at) if at > 0 => plane(at),
                (false, at) if at < self.last[a] => plane(at + 1),
                _ => break,
            };
            if enter <= s {
                break;
            }
            leave = enter;
            at = if ascending { at - 1 } else { at + 1 };
        }
        self.at[a] = at;
        self.leave[a] = leave;
    }
}

impl Iterator for Blocks {
    type Item = ([usize; 3], [f64; 2]);

    #[inline]
    fn next(&mut self) -> Option<Self::Item> {
        let [start, end] = self.rest?;
        let at = self.at;
        let leave = self.leave[0].min(self.leave[1]).min(self.leave[2]);
        if leave < end {
            self.rest = Some([leave, end]);
            for a in 0..3 {
                if self.leave[a] <= leave {
                    self.settle(a, leave);
                }
            }
        } else {
            self.rest = None;
        }
        Some((at, [start, leave.min(end)]))
    }
}
