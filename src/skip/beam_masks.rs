//! Beam masks: for a tile of pixels, which layers of blocks across the view's dominant axis are active inside the beam
//! of its rays.
//!
//! Per axis and per layer a summed-area table of activity (Crow 1984) answers in O(1) whether a rectangle of blocks
//! holds an active one. The beam's rectangle in a layer is bounded by the tile's four corner rays: all rays of a tile
//! meet a plane inside the convex hull of where its corners meet it, as long as all go through it the same way.
//! Rays then take the runs of active layers, found with one multiplication per plane.
//!
//! A block answers for half a voxel more than itself on every side: interpolation at a position `p` touches the voxels
//! `floor(p - 1/2)` and the next, and a block's classification counts one voxel of apron (design contract 3). Rectangles
//! and runs are therefore *shrunk* by half a voxel, less a slack for the rounding of single-precision rays.

use std::ops::Range;
use std::sync::OnceLock;

use rayon::prelude::*;

use crate::lattice::{Ray, RayFrame, Real};
use crate::octree::Occupancy;

/// Half a voxel: how far beyond its faces a block's classification holds.
const REACH: f64 = 0.5;

/// How the active layers of a tile's beam become runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Collapse {
    /// Every run of active layers.
    Runs,
    /// From the first active layer to the last.
    Hull,
    /// From the first to the last active layer of each half, the cut lying on a block boundary.
    Halves,
}

/// Summed-area tables of an occupancy, one set per axis, made at first use and kept.
#[derive(Debug)]
pub struct BeamMasks {
    occupancy: Occupancy,
    axes: [OnceLock<AxisSums>; 3],
}

/// Layers of one block and of [`THICK`] blocks: most tiles see nothing in most of the latter.
#[derive(Debug)]
struct AxisSums {
    thin: LayerSums,
    thick: LayerSums,
}

/// Blocks of a thick layer.
const THICK: usize = 8;

/// For every layer across an axis: how many active blocks lie below and left of each block corner.
#[derive(Debug)]
struct LayerSums {
    /// Blocks along the two other axes, in cyclic order.
    lateral: [usize; 2],
    /// `[layer][v][u]`, one more than there are blocks along u and v.
    sums: Vec<u32>,
}

impl LayerSums {
    /// Tables of layers that are `thickness` blocks thick.
    fn new(occupancy: &Occupancy, axis: usize, thickness: usize) -> Self {
        let lateral = [1, 2].map(|i| occupancy.dims[(axis + i) % 3]);
        let [width, height] = lateral.map(|n| n + 1);
        let mut sums = vec![0u32; occupancy.dims[axis].div_ceil(thickness) * width * height];
        sums.par_chunks_mut(width * height)
            .enumerate()
            .for_each(|(layer, sums)| {
                for v in 0..lateral[1] {
                    let mut row = 0;
                    for u in 0..lateral[0] {
                        let mut block = [0; 3];
                        block[(axis + 1) % 3] = u;
                        block[(axis + 2) % 3] = v;
                        let end = ((layer + 1) * thickness).min(occupancy.dims[axis]);
                        row += u32::from((layer * thickness..end).any(|layer| {
                            block[axis] = layer;
                            occupancy.get(block)
                        }));
                        sums[(v + 1) * width + u + 1] = sums[v * width + u + 1] + row;
                    }
                }
            });
        Self { lateral, sums }
    }

    /// Whether any block of `layer` is active in `u` x `v` (block indices, ends included, inside the grid).
    #[inline(always)]
    fn any(&self, layer: usize, u: [usize; 2], v: [usize; 2]) -> bool {
        let width = self.lateral[0] + 1;
        let sums = &self.sums[layer * width * (self.lateral[1] + 1)..];
        let at = |u: usize, v: usize| sums[v * width + u];
        at(u[1] + 1, v[1] + 1).wrapping_add(at(u[0], v[0]))
            != at(u[0], v[1] + 1).wrapping_add(at(u[1] + 1, v[0]))
    }
}

/// Runs of active layers of one tile: kept from tile to tile so that no tile allocates.
#[derive(Debug, Default)]
pub struct TileRuns {
    /// The axis that layers lie across; `None`: rays disagree about every axis and take the whole box.
    axis: Option<usize>,
    /// Where each run begins and ends along the axis, in grid coordinates and in the order of the rays.
    spans: Vec<[f64; 2]>,
    /// Voxels along the axis.
    voxels: f64,
}

impl BeamMasks {
    /// Tables over this occupancy; none is computed yet.
    pub fn new(occupancy: Occupancy) -> Self {
        Self {
            occupancy,
            axes: Default::default(),
        }
    }

    /// Bytes held so far.
    pub fn bytes(&self) -> usize {
        let sums = self.axes.iter().filter_map(OnceLock::get);
        size_of_val(self.occupancy.words())
            + sums
                .flat_map(|s| [&s.thin, &s.thick])
                .map(|s| size_of_val(s.sums.as_slice()))
                .sum::<usize>()
    }

    /// Finds the runs of the tile of pixels `x` x `y` (not empty).
    #[inline(always)]
    pub fn find(
        &self,
        frame: &RayFrame,
        x: Range<u32>,
        y: Range<u32>,
        collapse: Collapse,
        runs: &mut TileRuns,
    ) {
        runs.spans.clear();
        let beam = Beam::new(frame, x, y);
        runs.axis = beam.axis();
        let Some(axis) = runs.axis else { return };
        runs.voxels = self.occupancy.volume_dims[axis] as f64;
        let sums = self.axes[axis].get_or_init(|| AxisSums {
            thin: LayerSums::new(&self.occupancy, axis, 1),
            thick: LayerSums::new(&self.occupancy, axis, THICK),
        });
        let layers = self.occupancy.dims[axis];
        let ascending = beam.direction[0][axis] > 0.0;
        let slack = slack(frame);
        let walls = |thickness| {
            [1, 2].map(|i| {
                Wall::new(
                    &beam,
                    &self.occupancy,
                    [axis, (axis + i) % 3],
                    thickness,
                    slack,
                )
            })
        };
        let (thin, thick) = (walls(1), walls(THICK));

        // Runs as [first layer, end layer) in the order of the rays.
        let block = self.occupancy.block as f64;
        let mut open: Option<[usize; 2]> = None;
        let mut close = |run: [usize; 2]| {
            let [first, end] = if ascending {
                run
            } else {
                [layers - run[1], layers - run[0]]
            };
            // The inactive layer on the other side answers for half a voxel of this run; the box's faces have none.
            let trim = REACH - slack;
            let low = if first > 0 {
                first as f64 * block + trim
            } else {
                f64::NEG_INFINITY
            };
            let high = if end < layers {
                end as f64 * block - trim
            } else {
                f64::INFINITY
            };
            runs.spans
                .push(if ascending { [low, high] } else { [high, low] });
        };
        let is_active = |sums: &LayerSums, walls: &[Wall; 2], layer: usize, first_block: usize| {
            let low = first_block as f64 * block - REACH;
            match (walls[0].blocks(low), walls[1].blocks(low)) {
                (Some(u), Some(v)) => sums.any(layer, u, v),
                _ => false,
            }
        };
        let groups = layers.div_ceil(THICK);
        for i in 0..groups {
            let group = if ascending { i } else { groups - 1 - i };
            let first = group * THICK;
            if !is_active(&sums.thick, &thick, group, first) {
                continue;
            }
            let end = (first + THICK).min(layers);
            for j in 0..end - first {
                let layer = if ascending { first + j } else { end - 1 - j };
                if !is_active(&sums.thin, &thin, layer, layer) {
                    continue;
                }
                // Counted along the rays.
                let i = if ascending { layer } else { layers - 1 - layer };
                open = Some(match open {
                    Some([first, end]) if end == i || collapse.joins(end - 1, i, layers) => {
                        [first, i + 1]
                    }
                    Some(run) => {
                        close(run);
                        [i, i + 1]
                    }
                    None => [i, i + 1],
                });
            }
        }
        if let Some(run) = open {
            close(run);
        }
    }
}

impl Collapse {
    /// Whether the gap between two active layers (in the order of the rays) is marched all the same.
    fn joins(self, a: usize, b: usize, layers: usize) -> bool {
        match self {
            Self::Runs => false,
            Self::Hull => true,
            Self::Halves => (a < layers / 2) == (b < layers / 2),
        }
    }
}

/// How far single-precision rays may lie from the exact ones, in voxels, with a margin.
///
/// Positions are sums of a handful of products of numbers up to the reach of the start plane and the box: some eight
/// roundings of 2^-24 each, doubled and doubled again.
fn slack(frame: &RayFrame) -> f64 {
    let plane = frame.start.abs()
        + frame.start_dx.abs() * (f64::from(frame.size[0]) * 0.5)
        + frame.start_dy.abs() * (f64::from(frame.size[1]) * 0.5);
    let reach = ((plane + frame.extent) * frame.grid_from_local).max_element();
    1.0 / 64.0 + reach * f64::from(2.0f32.powi(-19))
}

/// The four corner rays of a tile, in grid coordinates; directions are not normalised.
struct Beam {
    start: [[f64; 3]; 4],
    direction: [[f64; 3]; 4],
}

impl Beam {
    fn new(frame: &RayFrame, x: Range<u32>, y: Range<u32>) -> Self {
        let corner = |i: usize| {
            let px =
                f64::from([x.start, x.end - 1][i & 1]) - (f64::from(frame.size[0]) - 1.0) * 0.5;
            let py =
                f64::from([y.start, y.end - 1][i >> 1]) - (f64::from(frame.size[1]) - 1.0) * 0.5;
            let start = frame.start + frame.start_dx * px + frame.start_dy * py;
            let direction = frame.dir + frame.dir_dx * px + frame.dir_dy * py;
            (
                (start * frame.grid_from_local).to_array(),
                (direction * frame.grid_from_local).to_array(),
            )
        };
        let corners: [_; 4] = std::array::from_fn(corner);
        Self {
            start: corners.map(|c| c.0),
            direction: corners.map(|c| c.1),
        }
    }

    /// The axis of the steepest component that all corner rays, and so all rays of the tile, follow the same way.
    fn axis(&self) -> Option<usize> {
        let steepness = |axis: usize| {
            let d = self.direction.map(|d| d[axis]);
            let same_way = d.iter().all(|&d| d > 0.0) || d.iter().all(|&d| d < 0.0);
            let least = d.iter().fold(f64::INFINITY, |m, d| m.min(d.abs()));
            // Flatter rays count as parallel to the layers (lattice::PARALLEL) and cross none.
            if same_way && least > 1e-6 { least } else { 0.0 }
        };
        (0..3)
            .max_by(|&a, &b| steepness(a).total_cmp(&steepness(b)))
            .filter(|&axis| steepness(axis) > 0.0)
    }
}

/// The extent of a beam along one lateral axis, over a layer that starts at `c`: between the smallest
/// `low[i] + slope[i] * c` and the largest `high[i] + slope[i] * c` of its corner rays.
struct Wall {
    low: [f64; 4],
    high: [f64; 4],
    slope: [f64; 4],
    per_block: f64,
    voxels: f64,
    last: f64,
}

impl Wall {
    /// The walls of layers of so many blocks.
    fn new(
        beam: &Beam,
        occupancy: &Occupancy,
        [axis, lateral]: [usize; 2],
        thickness: usize,
        slack: f64,
    ) -> Self {
        // A layer with the half voxel that it answers for on both sides.
        let thickness = (thickness * occupancy.block) as f64 + 2.0 * REACH;
        let slope: [f64; 4] =
            std::array::from_fn(|i| beam.direction[i][lateral] / beam.direction[i][axis]);
        let base: [f64; 4] =
            std::array::from_fn(|i| beam.start[i][lateral] - beam.start[i][axis] * slope[i]);
        Self {
            low: std::array::from_fn(|i| base[i] + (slope[i] * thickness).min(0.0) - slack),
            high: std::array::from_fn(|i| base[i] + (slope[i] * thickness).max(0.0) + slack),
            slope,
            per_block: 1.0 / occupancy.block as f64,
            voxels: occupancy.volume_dims[lateral] as f64,
            last: (occupancy.dims[lateral] - 1) as f64,
        }
    }

    /// First and last block between the walls, over the layer whose extended span starts at `c`; `None` outside the grid.
    #[inline(always)]
    fn blocks(&self, c: f64) -> Option<[usize; 2]> {
        let low: [f64; 4] = std::array::from_fn(|i| self.low[i] + self.slope[i] * c);
        let high: [f64; 4] = std::array::from_fn(|i| self.high[i] + self.slope[i] * c);
        let least = |v: [f64; 4]| {
            let pair = |a: f64, b: f64| if a < b { a } else { b };
            pair(pair(v[0], v[1]), pair(v[2], v[3]))
        };
        let low = least(low);
        let high = -least(high.map(|h| -h));
        if high < 0.0 || low > self.voxels {
            return None;
        }
        let first = ((low + REACH) * self.per_block).clamp(0.0, self.last) as usize;
        let last = ((high - REACH) * self.per_block).clamp(0.0, self.last) as usize;
        Some([first, last.max(first)])
    }
}

impl TileRuns {
    /// The axis that layers lie across; `None`: rays disagree about every axis and take the whole box.
    pub fn axis(&self) -> Option<usize> {
        self.axis
    }

    /// Where each run begins and ends along the axis, in grid coordinates and in the order of the rays; infinite at the
    /// faces of the box.
    pub fn spans(&self) -> &[[f64; 2]] {
        &self.spans
    }

    /// Whether no ray of the tile meets an active block.
    pub fn is_empty(&self) -> bool {
        self.axis.is_some() && self.spans.is_empty()
    }

    /// Number of runs.
    pub fn len(&self) -> usize {
        if self.axis.is_some() {
            self.spans.len()
        } else {
            1
        }
    }

    /// The range of sample indices [k0, k1) of run `i` on a ray of the tile, inside the box and the near plane; empty
    /// where `k1 <= k0`. Ranges of one ray ascend and are disjoint.
    #[inline(always)]
    pub fn range<R: Real>(&self, ray: &Ray<R>, i: usize) -> [R; 2] {
        let Some(axis) = self.axis else {
            return [ray.k_near, ray.k_end];
        };
        let half = R::splat(0.5);
        let per_step = R::splat(1.0) / ray.delta[axis];
        // Roundings of the crossing and of the sample's own position, in samples: six of 2^-24 over the whole axis.
        let margin = R::splat(1.0 / 1024.0)
            + (R::splat(self.voxels) * per_step).abs() * R::splat(f64::from(2.0f32.powi(-21)));
        let crossing = |c: f64| (R::splat(c) - ray.entry[axis]) * per_step - half;
        let [enter, leave] = self.spans[i];
        let first = if enter.is_finite() {
            (crossing(enter) - margin).ceil().max(ray.k_near)
        } else {
            ray.k_near
        };
        let end = if leave.is_finite() {
            ((crossing(leave) + margin).floor() + R::splat(1.0)).min(ray.k_end)
        } else {
            ray.k_end
        };
        [first, end]
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::skip::support::{check_ray, scenes};

    proptest! {
        /// Segments ascend, do not meet, lie in the box, and leave out only what an inactive block answers for.
        #[test]
        fn runs_cover_what_is_active(
            scene in scenes(),
            collapse in prop::sample::select(vec![Collapse::Runs, Collapse::Hull, Collapse::Halves]),
        ) {
            let masks = BeamMasks::new(scene.occupancy.clone());
            let mut runs = TileRuns::default();
            let [width, height] = scene.frame.size;
            masks.find(&scene.frame, 0..width, 0..height, collapse, &mut runs);
            match collapse {
                Collapse::Runs => {}
                Collapse::Hull => prop_assert!(runs.len() <= 1),
                Collapse::Halves => prop_assert!(runs.len() <= 2),
            }
            for (_, ray) in scene.rays() {
                let mut found = Vec::new();
                let mut k = ray.k_near;
                for i in 0..runs.len() {
                    let [first, end] = runs.range(&ray, i);
                    if first.max(k) < end {
                        found.push(first.max(k) as u32..end as u32);
                    }
                    k = end.max(k);
                }
                check_ray(&scene.occupancy, &ray, &found)?;
            }
        }
    }

    #[test]
    fn more_than_64_layers_are_told_apart() {
        let mut occupancy = Occupancy::new([4, 4, 600], 4);
        for layer in [3, 70, 149] {
            occupancy.set([0, 0, layer]);
        }
        let frame = RayFrame {
            start: glam::DVec3::new(2.0, 2.0, -1.0),
            start_dx: glam::DVec3::X * 0.1,
            start_dy: glam::DVec3::Y * 0.1,
            dir: glam::DVec3::Z,
            dir_dx: glam::DVec3::ZERO,
            dir_dy: glam::DVec3::ZERO,
            extent: glam::DVec3::new(4.0, 4.0, 600.0),
            grid_from_local: glam::DVec3::ONE,
            step: 1.0,
            size: [8, 8],
            clipping: crate::lattice::Clipping::NONE,
            reach: 0.0,
        };
        let mut runs = TileRuns::default();
        BeamMasks::new(occupancy).find(&frame, 0..8, 0..8, Collapse::Runs, &mut runs);
        assert_eq!(runs.len(), 3);
        let ray = frame.basis::<f64>().ray(3.0, 3.0);
        // Layer 70 is [280, 284]; half a voxel at both ends is answered for by its neighbours, give or take the slack.
        let [first, end] = runs.range(&ray, 1);
        assert!((280.0..=281.0).contains(&first) && (283.0..=284.0).contains(&end));
    }
}
