//! The octree-encoded volume of Kang et al. 2012, as Yu et al. 2016 describe it: empty voxels are taken out of the texture,
//! which saves what they would cost to accumulate, but no ray passes them any faster. Every position of the box is visited;
//! one in an empty block is neither loaded nor accumulated.

use std::ops::Range;

use super::distance_map::block_at;
use super::{Bound, Segments};
use crate::lattice::Ray;
use crate::octree::Occupancy;

/// The positions of one ray.
pub(super) struct Positions<'a> {
    pub(super) occupancy: &'a Occupancy,
    pub(super) bound: Bound<'a>,
    pub(super) ray: Ray<f64>,
    /// Positions visited.
    pub(super) steps: u32,
}

impl Segments for Positions<'_> {
    fn next(&mut self, k: u32, highest: f64) -> Option<Range<u32>> {
        let start = (self.ray.k_near as u32).max(k);
        (start..self.ray.k_end as u32)
            .find(|&k| {
                self.steps += 1;
                let block = |reach: f64| {
                    let at = self.ray.at(f64::from(k) + reach);
                    std::array::from_fn(|a| {
                        block_at(self.occupancy.block, self.occupancy.dims[a], at[a]) as usize
                    })
                };
                let (front, back): ([usize; 3], [usize; 3]) =
                    (block(-self.ray.reach), block(self.ray.reach));
                // What lies between the values of two blocks that touch is theirs too: their supports overlap.
                let touch = (0..3).all(|a| front[a].abs_diff(back[a]) <= 1);
                let may_add =
                    |block| self.occupancy.get(block) && self.bound.may_add(block, highest);
                !touch || may_add(front) || may_add(back)
            })
            .map(|k| k..k + 1)
    }

    fn steps(&self) -> u32 {
        self.steps
    }
}
