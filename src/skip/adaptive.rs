//! Adaptive strides, after Bergner et al. 2006 and Suwelack et al. 2010: a block is sampled as densely as its colours vary.
//!
//! The frequency of a composition `h(f(x))` is at most that of the transfer function `h` times the steepest gradient of the
//! data `f` (Bergner et al., section 4). Both are taken per block, and in its place of `h`'s spectrum its steepest slope
//! over the block's values: a wave of amplitude 1/2 and frequency v rises by at most `pi v` per unit of length, so that
//! colours which change by `r` of their full scale per unit of length want samples `pi / (2 r)` apart ([`OVERSAMPLING`]
//! times as many are taken). Strides are the powers of two up to [`MAX_STRIDE`] samples that this allows; opacity is
//! corrected for them. Empty blocks are leapt over.

use std::f64::consts::PI;
use std::ops::Range;

use rayon::prelude::*;

use super::Segments;
use super::distance_map::{block_at, leap};
use crate::lattice::Ray;
use crate::octree::{LeafGrid, Occupancy};
use crate::transfer::Table;
use crate::volume::Volume;
use crate::with_voxels;

/// The longest stride, in samples.
pub const MAX_STRIDE: u32 = 8;

/// Samples taken where the rule asks for one.
pub const OVERSAMPLING: f64 = 2.0;

/// The steepest change of a volume's stored numbers in every block's closed support, per local unit of length; x fastest.
#[derive(Debug)]
pub struct Gradients(Vec<f32>);

impl Gradients {
    /// Reads all voxels of the blocks of `grid`.
    pub fn new(volume: &Volume, grid: &LeafGrid) -> Self {
        let [nx, ny, _] = grid.dims;
        let mut steepest = vec![0.0; grid.dims.iter().product()];
        with_voxels!(&volume.voxels, voxels => {
            steepest.par_iter_mut().enumerate().for_each(|(i, steepest)| {
                *steepest = steepest_in(volume, voxels, grid.block, [i % nx, i / nx % ny, i / nx / ny]);
            });
        });
        Self(steepest)
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.0[..])
    }
}

/// The length of the gradient whose components are the largest differences of neighbouring voxels, along each axis.
fn steepest_in<V: Copy + Into<f64>>(
    volume: &Volume,
    voxels: &[V],
    edge: usize,
    block: [usize; 3],
) -> f32 {
    let dims = volume.dims;
    let range =
        |a: usize| (block[a] * edge).saturating_sub(1)..((block[a] + 1) * edge + 1).min(dims[a]);
    let strides = [1, dims[0], dims[0] * dims[1]];
    let mut largest = [0.0f64; 3];
    for z in range(2) {
        for y in range(1) {
            for x in range(0) {
                let at = (z * dims[1] + y) * dims[0] + x;
                let value: f64 = voxels[at].into();
                for (a, c) in [x, y, z].into_iter().enumerate() {
                    if c + 1 < range(a).end {
                        let next: f64 = voxels[at + strides[a]].into();
                        largest[a] = largest[a].max((next - value).abs());
                    }
                }
            }
        }
    }
    let size = volume.voxel_size().to_array();
    let squares: f64 = (0..3).map(|a| (largest[a] / size[a]).powi(2)).sum();
    squares.sqrt() as f32
}

/// The stride of every block.
#[derive(Debug)]
pub struct Strides {
    /// Edge of a block in voxels.
    block: usize,
    /// Blocks along x, y, z.
    dims: [usize; 3],
    /// x fastest; 0: empty, otherwise 1 + log2 of the stride.
    codes: Vec<u8>,
}

impl Strides {
    /// Strides for samples `step` local units apart.
    pub fn new(
        occupancy: &Occupancy,
        gradients: &Gradients,
        grid: &LeafGrid,
        table: &Table,
        step: f64,
    ) -> Self {
        let dims @ [nx, ny, _] = occupancy.dims;
        let slopes = Slopes::new(table);
        let domain = table.domain();
        let codes = (0..dims.iter().product::<usize>())
            .into_par_iter()
            .map(|i| {
                let block = [i % nx, i / nx % ny, i / nx / ny];
                if !occupancy.get(block) {
                    return 0;
                }
                let [low, high] = grid
                    .range(block)
                    .map(|stored| domain.x_from_stored(f64::from(stored)));
                let per_length =
                    slopes.steepest(low, high) * domain.scale * f64::from(gradients.0[i]);
                let samples = PI / (2.0 * OVERSAMPLING * step * per_length);
                1 + samples.clamp(1.0, f64::from(MAX_STRIDE)).log2() as u8
            })
            .collect();
        Self {
            block: occupancy.block,
            dims,
            codes,
        }
    }

    /// Codes, four to a word: what shaders read.
    pub fn words(&self) -> Vec<u32> {
        super::words_of_bytes(&self.codes)
    }

    /// The segments of one ray.
    pub(super) fn segments(&self, ray: Ray<f64>) -> impl Segments + '_ {
        Strided {
            strides: self,
            ray,
            stride: 1,
            steps: 0,
        }
    }
}

/// How much a table's entries change from one to the next, in parts of the largest.
struct Slopes {
    /// `[j][i]`: the most from entry i to entry i + 2^j (a sparse table).
    most: Vec<Vec<f32>>,
}

impl Slopes {
    fn new(table: &Table) -> Self {
        let rgba = table.rgba();
        let full_scale = rgba
            .iter()
            .flatten()
            .fold(f32::MIN_POSITIVE, |m, &c| m.max(c));
        let change = |pair: &[[f32; 4]]| {
            let channels = pair[0].iter().zip(pair[1]);
            channels.fold(0.0f32, |m, (a, b)| m.max((a - b).abs())) / full_scale
        };
        let mut most = vec![rgba.windows(2).map(change).collect::<Vec<_>>()];
        let mut half = 1;
        while most[most.len() - 1].len() > half {
            let last = &most[most.len() - 1];
            let doubled = last.iter().zip(&last[half..]).map(|(a, b)| a.max(*b));
            let doubled = doubled.collect();
            most.push(doubled);
            half *= 2;
        }
        Self { most }
    }

    /// The steepest slope over table coordinates from `low` to `high`.
    fn steepest(&self, low: f64, high: f64) -> f64 {
        let last = self.most[0].len() as f64;
        let first = low.clamp(0.0, last - 1.0) as usize;
        let end = (high.clamp(0.0, last).ceil() as usize).max(first + 1);
        let level = (end - first).ilog2() as usize;
        let row = &self.most[level];
        f64::from(row[first].max(row[end - (1 << level)]))
    }
}

struct Strided<'a> {
    strides: &'a Strides,
    ray: Ray<f64>,
    stride: u32,
    steps: u32,
}

impl Segments for Strided<'_> {
    fn next(&mut self, k: u32, _highest: f64) -> Option<Range<u32>> {
        let Strides { block, dims, codes } = self.strides;
        let mut k = (self.ray.k_near as u32).max(k);
        let k_end = self.ray.k_end as u32;
        while k < k_end {
            self.steps += 1;
            let at = self.ray.at(f64::from(k));
            let cell: [f64; 3] = std::array::from_fn(|a| block_at(*block, dims[a], at[a]));
            let [x, y, z] = cell.map(|c| c as usize);
            let inside = leap(*block, &self.ray, at, cell, 1.0) as u32;
            let inside = inside.min(k_end - k);
            let code = codes[(z * dims[1] + y) * dims[0] + x];
            if code == 0 {
                k += inside;
                continue;
            }
            self.stride = 1 << u32::from(code - 1).min(inside.ilog2());
            return Some(k..k + inside / self.stride * self.stride);
        }
        None
    }

    fn stride(&self) -> u32 {
        self.stride
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
    use crate::transfer::{ControlPoint, Domain, TransferFunction};
    use crate::volume::{Voxels, phantom};

    proptest! {
        /// Whatever the strides, segments hold whole ones and leave out only what an inactive block answers for.
        #[test]
        fn segments_hold_whole_strides_and_cover_what_is_active(scene in scenes()) {
            let [nx, ny, nz] = scene.occupancy.dims;
            let code = |i: usize| {
                let active = scene.occupancy.get([i % nx, i / nx % ny, i / nx / ny]);
                if active { 1 + (i % 4) as u8 } else { 0 }
            };
            let strides = Strides {
                block: scene.occupancy.block,
                dims: scene.occupancy.dims,
                codes: (0..nx * ny * nz).map(code).collect(),
            };
            for (_, ray) in scene.rays() {
                let mut segments = strides.segments(ray);
                let mut found = Vec::new();
                let mut k = 0;
                while let Some(segment) = segments.next(k, f64::NAN) {
                    prop_assert_eq!((segment.end - segment.start) % segments.stride(), 0);
                    k = segment.end;
                    found.push(segment);
                }
                check_ray(&scene.occupancy, &ray, &found)?;
            }
        }
    }

    #[test]
    fn flat_data_take_the_longest_stride_and_steep_data_the_shortest() {
        let n = 16;
        // Flat in x up to the middle, then from wall to wall; all of it visible.
        let voxels: Vec<u8> = (0..n * n * n)
            .map(|i| if i % n < 8 || i % 2 == 0 { 200 } else { 50 })
            .collect();
        let volume = Volume {
            voxels: Voxels::U8(voxels.into()),
            ..phantom::make("empty", [n; 3]).unwrap()
        };
        let points = [(0.0, 0.1), (255.0, 0.9)].map(|(value, opacity)| ControlPoint {
            value,
            opacity,
            color: [1.0; 3],
        });
        let function = TransferFunction::new(points.into(), 1.0).unwrap();
        let domain = Domain::new(&volume, [0.0, 255.0], 256).unwrap();
        let table = function.bake(&domain, 1.0);
        let grid = LeafGrid::build(&volume, 4, 1);
        let mut occupancy = Occupancy::new([n; 3], 4);
        (0..64).for_each(|i| occupancy.set([i % 4, i / 4 % 4, i / 16]));
        let gradients = Gradients::new(&volume, &grid);
        let strides = Strides::new(&occupancy, &gradients, &grid, &table, 1.0);
        assert_eq!(strides.codes[0], 4);
        assert_eq!(strides.codes[3], 1);
    }
}
