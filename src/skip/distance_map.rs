//! Distance map: for every block the Chebyshev distance, in blocks, to the nearest active one (Sramek & Kaufman 2000,
//! Deakin & Knoll 2019). A ray leaps as far as the distance allows.
//!
//! The map is made by three separable passes: `min over j of max(|i - j|, d(j))` along each axis in turn.

use std::ops::Range;

use rayon::prelude::*;

use super::{Bound, Segments};
use crate::lattice::{Ray, Real};
use crate::octree::Occupancy;

/// Leaps stop this much short of the half voxel beyond its faces that an empty block answers for (design contract 3:
/// one voxel of apron), for the rounding of single-precision positions: one part in 2^-22 of 2^16 voxels and a margin.
pub(super) const REACH: f64 = 0.5 - 1.0 / 16.0;

/// Distances to the nearest active block.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DistanceMap {
    /// Edge of a block in voxels.
    pub block: usize,
    /// Blocks along x, y, z.
    pub dims: [usize; 3],
    /// Distance per block, x fastest; 0: active. At most 255, also where it is more or where no block is active.
    distances: Vec<u8>,
}

impl DistanceMap {
    /// The map of an occupancy, computed in parallel.
    pub fn new(occupancy: &Occupancy) -> Self {
        let dims @ [nx, ny, nz] = occupancy.dims;
        let mut along_x = vec![255u8; nx * ny * nz];
        along_x
            .par_chunks_mut(nx)
            .enumerate()
            .for_each(|(i, row)| row_distances(occupancy.row(i % ny, i / ny), row));
        let mut along_xy = vec![0u8; nx * ny * nz];
        along_xy
            .par_chunks_mut(nx)
            .enumerate()
            .for_each(|(i, out)| {
                let slice = &along_x[i / ny * ny * nx..][..ny * nx];
                nearest_rows(out, i % ny, ny, |y| &slice[y * nx..][..nx]);
            });
        let mut distances = along_x;
        distances
            .par_chunks_mut(nx)
            .enumerate()
            .for_each(|(i, out)| {
                nearest_rows(out, i / ny, nz, |z| {
                    &along_xy[(z * ny + i % ny) * nx..][..nx]
                });
            });
        Self {
            block: occupancy.block,
            dims,
            distances,
        }
    }

    /// Distance of block (x, y, z), inside the grid.
    pub fn get(&self, [x, y, z]: [usize; 3]) -> u8 {
        self.distances[(z * self.dims[1] + y) * self.dims[0] + x]
    }

    /// Four distances to a word, x fastest, the first in the lowest byte: what shaders read.
    pub fn words(&self) -> Vec<u32> {
        super::words_of_bytes(&self.distances)
    }

    /// Distances, x fastest: what packets read.
    pub fn distances(&self) -> &[u8] {
        &self.distances
    }

    /// The block that a grid coordinate of `axis` lies in, clamped to the grid.
    #[inline(always)]
    pub fn block_at<R: Real>(&self, axis: usize, grid: R) -> R {
        block_at(self.block, self.dims[axis], grid)
    }

    /// How many samples on from the one at `at` are certain to see nothing, that one included; at least 1.
    ///
    /// `block` is where the sample lies and `distance` (at least 1) what the map says there.
    #[inline(always)]
    pub fn leap<R: Real>(&self, ray: &Ray<R>, at: [R; 3], block: [R; 3], distance: R) -> R {
        leap(self.block, ray, at, block, distance)
    }

    /// The segments of one ray: of single samples where these are bounded by what the ray has seen, which every one can
    /// change.
    pub fn segments<'a>(&'a self, ray: Ray<f64>, bound: Bound<'a>) -> impl Segments + 'a {
        RaySegments {
            map: self,
            bound,
            ray,
            given: u32::MAX,
            steps: 0,
        }
    }
}

/// The block of `edge` voxels that a grid coordinate lies in, clamped to the `dims` blocks of its axis.
#[inline(always)]
pub(super) fn block_at<R: Real>(edge: usize, dims: usize, grid: R) -> R {
    (grid * R::splat(1.0 / edge as f64))
        .floor()
        .max(R::splat(0.0))
        .min(R::splat((dims - 1) as f64))
}

/// [`DistanceMap::leap`] for blocks of `edge` voxels.
#[inline(always)]
pub(super) fn leap<R: Real>(
    edge: usize,
    ray: &Ray<R>,
    at: [R; 3],
    block: [R; 3],
    distance: R,
) -> R {
    let zero = R::splat(0.0);
    let one = R::splat(1.0);
    let edge = R::splat(edge as f64);
    let mut least = R::splat(1e30);
    for a in 0..3 {
        let delta = ray.delta[a];
        let forward = zero.lt(delta);
        let face = R::select(
            forward,
            (block[a] + distance) * edge + R::splat(REACH),
            (block[a] + one - distance) * edge - R::splat(REACH),
        );
        let parallel = delta.abs().lt(R::splat(1e-30));
        let samples = (face - at[a]) / R::select(parallel, one, delta);
        least = least.min(R::select(parallel, R::splat(1e30), samples));
    }
    least.ceil().max(one)
}

/// Distance along a row to the nearest set bit.
fn row_distances(bits: &[u64], row: &mut [u8]) {
    let mut distance = 255u8;
    for (x, out) in row.iter_mut().enumerate() {
        distance = if bits[x / 64] >> (x % 64) & 1 == 1 {
            0
        } else {
            distance.saturating_add(1)
        };
        *out = distance;
    }
    distance = 255;
    for out in row.iter_mut().rev() {
        distance = if *out == 0 {
            0
        } else {
            distance.saturating_add(1)
        };
        *out = distance.min(*out);
    }
}

/// `out[x] = min over j of max(|i - j|, row(j)[x])`, for rows 0..n: outwards from `i`, whole rows at a time, until no
/// farther row can be nearer.
fn nearest_rows<'a>(out: &mut [u8], i: usize, n: usize, row: impl Fn(usize) -> &'a [u8]) {
    out.copy_from_slice(row(i));
    for distance in 1..n.min(255) {
        if out.iter().all(|&d| usize::from(d) <= distance) {
            break;
        }
        let before = i.checked_sub(distance);
        let after = (i + distance < n).then_some(i + distance);
        for j in before.into_iter().chain(after) {
            for (out, &d) in out.iter_mut().zip(row(j)) {
                *out = (*out).min(d.max(distance as u8));
            }
        }
    }
}

struct RaySegments<'a> {
    map: &'a DistanceMap,
    bound: Bound<'a>,
    ray: Ray<f64>,
    /// One past the last sample given.
    given: u32,
    /// Leaps, and runs of samples given.
    steps: u32,
}

impl Segments for RaySegments<'_> {
    fn next(&mut self, k: u32, highest: f64) -> Option<Range<u32>> {
        let mut k = f64::from(k).max(self.ray.k_near);
        let mut first = None;
        while k < self.ray.k_end {
            let at = self.ray.at(k - self.ray.reach);
            let block: [f64; 3] = std::array::from_fn(|a| self.map.block_at(a, at[a]));
            let place = block.map(|b| b as usize);
            let distance = self.map.get(place);
            // An interval ends where the next begins: the last one that begins in emptiness may end beyond it.
            let free = if distance == 0 && self.bound.may_add(place, highest) {
                0.0
            } else {
                let distance = f64::from(distance.max(1));
                self.map.leap(&self.ray, at, block, distance) - 2.0 * self.ray.reach
            };
            if free == 0.0 {
                first.get_or_insert(k as u32);
                k += 1.0;
                if self.bound.is_some() {
                    let end = k as u32;
                    self.steps += u32::from(end - 1 != self.given);
                    self.given = end;
                    return Some(end - 1..end);
                }
            } else if let Some(first) = first {
                self.steps += 1;
                return Some(first..k as u32);
            } else {
                self.steps += 1;
                k += free;
            }
        }
        self.steps += u32::from(first.is_some());
        first.map(|first| first..self.ray.k_end as u32)
    }

    fn steps(&self) -> u32 {
        self.steps
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::skip::support::{check_ray, scenes};

    fn chebyshev(a: [usize; 3], b: [usize; 3]) -> usize {
        (0..3).map(|i| a[i].abs_diff(b[i])).max().unwrap_or(0)
    }

    proptest! {
        /// The passes give the distance by definition.
        #[test]
        fn distances_are_chebyshev_s(scene in scenes()) {
            let map = DistanceMap::new(&scene.occupancy);
            let blocks = |occupancy: &Occupancy| -> Vec<[usize; 3]> {
                let [nx, ny, nz] = occupancy.dims;
                (0..nx * ny * nz).map(|i| [i % nx, i / nx % ny, i / nx / ny]).collect()
            };
            let all = blocks(&scene.occupancy);
            let active: Vec<_> = all.iter().filter(|&&b| scene.occupancy.get(b)).collect();
            for &block in &all {
                let nearest = active.iter().map(|&&a| chebyshev(a, block)).min().unwrap_or(255);
                prop_assert_eq!(usize::from(map.get(block)), nearest.min(255));
            }
        }

        /// Segments ascend, do not meet, lie in the box, and leave out only what an inactive block answers for.
        #[test]
        fn segments_cover_what_is_active(scene in scenes()) {
            let map = DistanceMap::new(&scene.occupancy);
            for (_, ray) in scene.rays() {
                let mut segments = map.segments(ray, Bound::NONE);
                let mut found = Vec::new();
                let mut k = 0;
                while let Some(segment) = segments.next(k, f64::NAN) {
                    k = segment.end;
                    found.push(segment);
                }
                check_ray(&scene.occupancy, &ray, &found)?;
            }
        }
    }

    #[test]
    fn distances_saturate() {
        let mut occupancy = Occupancy::new([600, 2, 1], 2);
        occupancy.set([299, 0, 0]);
        let map = DistanceMap::new(&occupancy);
        assert_eq!(map.get([0, 0, 0]), 255);
        assert_eq!(map.get([44, 0, 0]), 255);
        assert_eq!(map.get([45, 0, 0]), 254);
    }
}
