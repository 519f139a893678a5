//! Beam cells: the rays of a tile of pixels leap together, as one beam, as far as the distance map allows; what is left of each
//! ray is then cut down, from both ends, to the first and the last cell of eight voxels that contributes.
//!
//! A hybrid: gaps cost a leap for 64 rays, not for each (as the beams of Laine & Karras 2010 do), and where something is near,
//! rays look at the smallest part of a volume that can be known to be empty ([`Cells`]). What lies between the first and
//! the last such cell of a run is sampled.

use std::ops::Range;
use std::sync::Arc;

use glam::DVec3;

use super::distance_map::{DistanceMap, REACH};
use super::{MOST_SEGMENTS, Segments};
use crate::lattice::{Ray, RayFrame};
use crate::octree::{CellRule, Cells, Occupancy};

/// Edge of a tile in pixels.
pub const TILE: u32 = 8;

/// How far before a cell that may contribute leaps end, in voxels: more than single precision, or a filter, rounds a
/// position by.
pub const MARGIN: f64 = 1.0 / 64.0;

/// A distance beyond all others.
const FAR: f64 = 1e30;

/// What rays know of the cells on their way.
#[derive(Debug, Clone)]
pub enum Near<'a> {
    /// Nothing: runs are not cut down.
    Unknown,
    /// How near each is to one that contributes.
    Distances(Arc<Cells>),
    /// Whether each contributes, asked of the voxels.
    Rule(CellRule<'a>),
}

/// Where beams may meet something, tile by tile.
#[derive(Debug)]
pub struct BeamCells<'a> {
    map: Arc<DistanceMap>,
    frame: RayFrame,
    /// Voxels along x, y, z.
    dims: [usize; 3],
    near: Near<'a>,
}

/// The runs of one tile.
#[derive(Debug, Clone, Default)]
pub struct BeamRuns {
    /// Where each begins and ends, in depth along the unnormalised direction, ascending; [`MOST_SEGMENTS`] at most, of
    /// which the last then reaches to the end of all.
    pub runs: Vec<[f64; 2]>,
    /// Leaps, and blocks gone through.
    pub steps: u32,
}

impl<'a> BeamCells<'a> {
    /// For pictures of `frame` over these blocks.
    pub fn new(occupancy: &Occupancy, frame: &RayFrame, near: Near<'a>) -> Self {
        let map = Arc::new(DistanceMap::new(occupancy));
        Self::with_map(map, occupancy.volume_dims, frame, near)
    }

    /// The same by the distance map of the blocks, for a volume of these dimensions.
    pub fn with_map(
        map: Arc<DistanceMap>,
        dims: [usize; 3],
        frame: &RayFrame,
        near: Near<'a>,
    ) -> Self {
        Self {
            map,
            frame: *frame,
            dims,
            near,
        }
    }

    /// The same, where rays know this of cells.
    #[must_use]
    pub fn with_cells(self, near: Near<'a>) -> Self {
        Self { near, ..self }
    }

    /// The runs of the tile that a pixel lies in.
    pub fn runs(&self, pixel: [u32; 2]) -> BeamRuns {
        let frame = &self.frame;
        let half = f64::from(TILE - 1) * 0.5;
        let [x, y] = std::array::from_fn(|a| {
            f64::from(pixel[a] / TILE * TILE) + half - (f64::from(frame.size[a]) * 0.5 - 0.5)
        });
        let grid = frame.grid_from_local;
        // The beam's middle and half of what it spans, where rays start and for each unit of depth.
        let start = (frame.start + x * frame.start_dx + y * frame.start_dy) * grid;
        let dir = (frame.dir + x * frame.dir_dx + y * frame.dir_dy) * grid;
        let start_half = half * (frame.start_dx.abs() + frame.start_dy.abs()) * grid;
        let dir_half = half * (frame.dir_dx.abs() + frame.dir_dy.abs()) * grid;
        // Its upper and its lower side, each where it starts and how fast it goes up.
        let upper = [start + start_half, dir + dir_half];
        let lower = [start - start_half, dir - dir_half];
        let dims = DVec3::from_array(self.dims.map(|n| n as f64));
        let at_plane = |plane: f64, side: [DVec3; 2], a: usize| (plane - side[0][a]) / side[1][a];

        // No ray goes farther than from its start to the farthest corner, and directions are of unit length at least: a beam that
        // widens in all directions never leaves the box.
        let start_spread = half * (frame.start_dx.abs() + frame.start_dy.abs());
        let from = start / grid;
        let farthest = (from.abs().max((frame.extent - from).abs()) + start_spread).length();
        let (mut s, mut s_out) = (0.0f64, farthest);
        for a in 0..3 {
            if upper[1][a] > 0.0 {
                s = s.max(at_plane(0.0, upper, a));
            } else if upper[1][a] < 0.0 {
                s_out = s_out.min(at_plane(0.0, upper, a));
            }
            if lower[1][a] < 0.0 {
                s = s.max(at_plane(dims[a], lower, a));
            } else if lower[1][a] > 0.0 {
                s_out = s_out.min(at_plane(dims[a], lower, a));
            }
        }
        let mut found = BeamRuns::default();
        let block = self.map.block as f64;
        // On by a quarter of a block at least, whatever rounds.
        let least = 0.25 * block / dir.abs().max_element();
        while s < s_out {
            found.steps += 1;
            let at = start + s * dir;
            let around = start_half + s * dir_half;
            let middle: [f64; 3] = std::array::from_fn(|a| self.map.block_at(a, at[a]));
            let distance = f64::from(self.map.get(middle.map(|b| b as usize)));
            let mut fits = distance > 0.0;
            let (mut free, mut leaves) = (FAR, FAR);
            for a in 0..3 {
                // What is known to be empty, in grid coordinates; the outermost blocks reach outwards without end.
                let (first, end) = (middle[a] - (distance - 1.0), middle[a] + distance);
                let low = if first <= 0.0 {
                    -FAR
                } else {
                    first * block - REACH
                };
                let last = self.map.dims[a] as f64;
                let high = if end >= last {
                    FAR
                } else {
                    end * block + REACH
                };
                fits &= low <= at[a] - around[a] && at[a] + around[a] <= high;
                if upper[1][a] > 0.0 {
                    free = free.min(at_plane(high, upper, a));
                }
                if lower[1][a] < 0.0 {
                    free = free.min(at_plane(low, lower, a));
                }
                if dir[a] != 0.0 {
                    let face = (middle[a] + f64::from(u8::from(dir[a] > 0.0))) * block;
                    leaves = leaves.min((face - start[a]) / dir[a]);
                }
            }
            fits &= s + least <= free;
            let next = if fits { free } else { leaves.max(s + least) };
            if !fits {
                let is_full = found.runs.len() == MOST_SEGMENTS;
                match found.runs.last_mut() {
                    Some(last) if s <= last[1] || is_full => last[1] = next,
                    _ => found.runs.push([s, next]),
                }
            }
            s = next;
        }
        found
    }

    /// The segments of a pixel's ray in the runs of its tile.
    pub fn segments(&self, ray: Ray<f64>, pixel: [u32; 2], runs: BeamRuns) -> BeamSegments<'_> {
        let frame = &self.frame;
        let [x, y] =
            std::array::from_fn(|a| f64::from(pixel[a]) - (f64::from(frame.size[a]) * 0.5 - 0.5));
        let length = (frame.dir + x * frame.dir_dx + y * frame.dir_dy).length();
        BeamSegments {
            of: self,
            runs,
            scale: length / frame.step,
            offset: ray.t_box / frame.step + 0.5,
            ray,
            next: 0,
            steps: 0,
        }
    }

    /// Cells to the nearest one that may contribute, around a position; the position among the centres of voxels, and the
    /// cell.
    fn look(&self, at: [f64; 3]) -> (f64, [f64; 3], [f64; 3]) {
        let shifted = at.map(|c| c - 0.5);
        let cell: [f64; 3] =
            std::array::from_fn(|a| shifted[a].floor().clamp(0.0, (self.dims[a] - 1) as f64));
        let place = cell.map(|c| c as usize);
        let distance = match &self.near {
            Near::Unknown => 0,
            Near::Distances(cells) => cells.distance(place),
            Near::Rule(rule) => u32::from(!rule.contributes(place)),
        };
        (f64::from(distance), shifted, cell)
    }
}

/// The segments of one ray, one for each run of its tile that meets a cell that contributes.
#[derive(Debug)]
pub struct BeamSegments<'a> {
    of: &'a BeamCells<'a>,
    runs: BeamRuns,
    ray: Ray<f64>,
    /// A depth `s` lies at sample `s * scale - offset`.
    scale: f64,
    offset: f64,
    next: usize,
    steps: u32,
}

impl BeamSegments<'_> {
    /// How many samples from `k` on, forwards (`direction` 1) or backwards (-1), are certain to show nothing.
    fn free(&self, k: f64, direction: f64) -> f64 {
        let ray = &self.ray;
        let (distance, at, cell) = self.of.look(ray.at(k - direction * ray.reach));
        if distance == 0.0 {
            return 0.0;
        }
        let mut least = FAR;
        for a in 0..3 {
            let delta = ray.delta[a] * direction;
            if delta != 0.0 {
                let face = if delta > 0.0 {
                    cell[a] + distance - MARGIN
                } else {
                    cell[a] + 1.0 - distance + MARGIN
                };
                least = least.min((face - at[a]) / delta);
            }
        }
        // An interval ends where the next begins: the last one that begins in emptiness may end beyond it.
        least.ceil().max(1.0) - 2.0 * ray.reach
    }
}

impl Segments for BeamSegments<'_> {
    fn next(&mut self, k: u32, _highest: f64) -> Option<Range<u32>> {
        while let Some(&[start, end]) = self.runs.runs.get(self.next) {
            self.next += 1;
            self.steps += 1;
            let ray = &self.ray;
            let sample = |s: f64| (s * self.scale - self.offset).clamp(-1.0, ray.k_end);
            // Positions are rounded; blocks reach farther than that.
            let mut first = (sample(start) - 0.0625 - ray.reach).ceil();
            let mut end = (sample(end) + 0.0625 + ray.reach).ceil().min(ray.k_end);
            first = first.max(ray.k_near).max(f64::from(k));
            while first < end {
                let free = self.free(first, 1.0);
                self.steps += 1;
                if free == 0.0 {
                    break;
                }
                first += free;
            }
            while first < end {
                let free = self.free(end - 1.0, -1.0);
                self.steps += 1;
                if free == 0.0 {
                    break;
                }
                end -= free;
            }
            if first < end {
                return Some(first as u32..end as u32);
            }
        }
        None
    }

    fn steps(&self) -> u32 {
        self.steps
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::mode::Mode;
    use crate::octree::Accelerator;
    use crate::skip::support::{check_ray, scenes};
    use crate::transfer::{ControlPoint, Domain, TransferFunction};
    use crate::volume::{Rescale, Volume, Voxels};

    fn all_segments(beams: &BeamCells, ray: Ray<f64>, pixel: [u32; 2]) -> Vec<Range<u32>> {
        let mut segments = beams.segments(ray, pixel, beams.runs(pixel));
        let mut found = Vec::new();
        let mut k = 0;
        while let Some(segment) = segments.next(k, f64::NAN) {
            k = segment.end;
            found.push(segment);
        }
        found
    }

    proptest! {
        /// Runs ascend, do not meet, and leave out only what an inactive block answers for.
        #[test]
        fn runs_cover_what_is_active(scene in scenes()) {
            let beams = BeamCells::new(&scene.occupancy, &scene.frame, Near::Unknown);
            for (pixel, ray) in scene.rays() {
                let runs = beams.runs(pixel).runs;
                prop_assert!(runs.len() <= MOST_SEGMENTS);
                prop_assert!(runs.iter().all(|[start, end]| start < end));
                prop_assert!(runs.windows(2).all(|two| two[0][1] < two[1][0]));
                check_ray(&scene.occupancy, &ray, &all_segments(&beams, ray, pixel))?;
            }
        }

        /// Cut down to cells, segments still hold every sample that touches a visible voxel, also of intervals: by the cells'
        /// distances, and by looking at the voxels.
        #[test]
        fn no_sample_that_contributes_is_cut_off(
            scene in scenes(),
            seeds in prop::collection::vec(any::<prop::sample::Index>(), 0..9),
            reach in prop::sample::select(vec![0.0, 0.5]),
        ) {
            let dims @ [nx, ny, nz] = scene.occupancy.volume_dims;
            let mut voxels = vec![0u8; nx * ny * nz];
            for seed in seeds {
                voxels[seed.index(nx * ny * nz)] = 200;
            }
            let volume = Volume {
                name: "seeds".into(),
                dims,
                spacing: DVec3::ONE,
                origin: DVec3::ZERO,
                direction: glam::DMat3::IDENTITY,
                rescale: Rescale::IDENTITY,
                voxels: Voxels::U8(voxels.into()),
                warnings: Vec::new(),
            };
            let domain = Domain::new(&volume, [0.0, 255.0], 256).unwrap();
            let point = |value, opacity| ControlPoint { value, opacity, color: [1.0; 3] };
            let table = TransferFunction::new(vec![point(0.0, 0.0), point(255.0, 1.0)], 1.0).unwrap().bake(&domain, 1.0);
            let mode = Mode::EmissionAbsorption;
            let occupancy = Accelerator::build(&volume, 4, 1).unwrap().cull(&table, mode);
            let rule = CellRule { volume: &volume, table: &table, mode, apron: 1, is_by_voxel: false };
            let cells = Cells::new(&rule, &occupancy);
            let frame = RayFrame { reach, ..scene.frame };
            let by_distance = BeamCells::new(&occupancy, &frame, Near::Distances(Arc::new(cells)));
            let by_rule = BeamCells::new(&occupancy, &frame, Near::Rule(rule));
            let basis = frame.basis::<f64>();
            for (pixel, _) in scene.rays() {
                let ray = basis.ray(f64::from(pixel[0]), f64::from(pixel[1]));
                let both = [&by_distance, &by_rule].map(|beams| all_segments(beams, ray, pixel));
                for k in ray.k_near as u32..ray.k_end as u32 {
                    let ends = [f64::from(k) - reach, f64::from(k) + reach];
                    let touches = ends.into_iter().any(|k| {
                        let at = ray.at(k);
                        let cell = std::array::from_fn(|a| {
                            (at[a] - 0.5).floor().clamp(0.0, (dims[a] - 1) as f64) as usize
                        });
                        rule.contributes(cell)
                    });
                    for segments in &both {
                        let is_held = segments.iter().any(|s| s.contains(&k));
                        prop_assert!(!touches || is_held, "sample {} of {:?}", k, segments);
                    }
                }
            }
        }
    }
}
