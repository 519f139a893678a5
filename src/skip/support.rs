//! What the tests of skipping methods share: random occupancies and views, and the property that makes them lossless.

use std::ops::Range;

use glam::DVec3;
use proptest::prelude::*;

use crate::lattice::{Clipping, Ray, RayFrame};
use crate::octree::Occupancy;

/// Random blocks seen from somewhere.
#[derive(Debug, Clone)]
pub(crate) struct SkipScene {
    pub(crate) occupancy: Occupancy,
    pub(crate) frame: RayFrame,
}

impl SkipScene {
    /// Every pixel and its ray.
    pub(crate) fn rays(&self) -> impl Iterator<Item = ([u32; 2], Ray<f64>)> {
        let basis = self.frame.basis::<f64>();
        let [width, height] = self.frame.size;
        (0..width * height).map(move |i| {
            let pixel = [i % width, i / width];
            (pixel, basis.ray(f64::from(pixel[0]), f64::from(pixel[1])))
        })
    }
}

pub(crate) fn scenes() -> impl Strategy<Value = SkipScene> {
    let vector = || prop::array::uniform3(-1.0..1.0f64).prop_map(DVec3::from_array);
    (
        prop::array::uniform3(1..50usize),
        prop::array::uniform3(prop_oneof![Just(1.0), 1.0..4.0f64]),
        prop::sample::select(vec![1usize, 2, 3, 4, 8]),
        prop::collection::vec(any::<prop::sample::Index>(), 0..12),
        (
            vector(),
            vector(),
            vector(),
            0.0..0.3f64,
            0.0..0.3f64,
            any::<bool>(),
        ),
        0.1..2.0f64,
    )
        .prop_map(
            |(
                dims,
                spacing,
                block,
                active,
                (eye, to, side, spread, shift, axis_parallel),
                step,
            )| {
                let mut occupancy = Occupancy::new(dims, block);
                let [nx, ny, nz] = occupancy.dims;
                for i in active {
                    let i = i.index(nx * ny * nz);
                    occupancy.set([i % nx, i / nx % ny, i / nx / ny]);
                }
                let size = DVec3::from_array(spacing);
                let extent = size * DVec3::new(dims[0] as f64, dims[1] as f64, dims[2] as f64);
                let dir = if axis_parallel || to.length() < 1e-3 {
                    DVec3::Y
                } else {
                    to.normalize()
                };
                let right = dir
                    .cross(side + DVec3::splat(0.01))
                    .normalize_or(dir.any_orthonormal_vector());
                let down = dir.cross(right);
                let frame = RayFrame {
                    start: extent * (0.5 + eye),
                    start_dx: right * shift,
                    start_dy: down * shift,
                    dir,
                    dir_dx: right * spread,
                    dir_dy: down * spread,
                    extent,
                    grid_from_local: 1.0 / size,
                    step,
                    size: [7, 5],
                    clipping: Clipping::NONE,
                    reach: 0.0,
                };
                SkipScene { occupancy, frame }
            },
        )
}

/// Checks the segments of one ray: ascending, disjoint, not empty, inside the box; and for each sample left out there is
/// an inactive block that answers for it: whose voxels, with one of apron, are all that the sample touches.
pub(crate) fn check_ray(
    occupancy: &Occupancy,
    ray: &Ray<f64>,
    segments: &[Range<u32>],
) -> Result<(), TestCaseError> {
    let mut last = ray.k_near;
    for segment in segments {
        prop_assert!(segment.start < segment.end);
        prop_assert!(last <= f64::from(segment.start) && f64::from(segment.end) <= ray.k_end);
        last = f64::from(segment.end);
    }
    let mut k = ray.k_near;
    while k < ray.k_end {
        if !segments.iter().any(|s| s.contains(&(k as u32))) {
            let at = ray.at(k);
            prop_assert!(
                is_answered_for(occupancy, at),
                "sample {k} at {at:?} is left out"
            );
        }
        k += 1.0;
    }
    Ok(())
}

/// Whether an inactive block's voxels and apron hold all that trilinear interpolation touches at `at`.
pub(crate) fn is_answered_for(occupancy: &Occupancy, at: [f64; 3]) -> bool {
    let block = occupancy.block as f64;
    let candidates = [0, 1, 2].map(|a| {
        let last = occupancy.dims[a] as i64 - 1;
        // The block that the position lies in and its neighbours.
        let middle = (at[a] / block).floor() as i64;
        (middle - 1..=middle + 1)
            .filter(move |&i| (0..=last).contains(&i))
            .filter(move |&i| {
                let low = if i == 0 {
                    f64::NEG_INFINITY
                } else {
                    i as f64 * block - 0.5
                };
                let high = if i == last {
                    f64::INFINITY
                } else {
                    (i + 1) as f64 * block + 0.5
                };
                low <= at[a] && at[a] <= high
            })
            .collect::<Vec<_>>()
    });
    candidates[0].iter().any(|&x| {
        candidates[1].iter().any(|&y| {
            candidates[2]
                .iter()
                .any(|&z| !occupancy.get([x, y, z].map(|i| i as usize)))
        })
    })
}
