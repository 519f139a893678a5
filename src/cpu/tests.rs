//! Properties of the CPU backend: what must be equal is equal in every bit, and near the same sum in double precision.

mod cases;
mod projections;

use std::sync::atomic::AtomicBool;

use glam::DVec3;
use proptest::prelude::*;

use self::cases::{CameraCase, Case, cases, stored};
use super::*;
use crate::camera::Orbit;
use crate::sample::{cell, trilinear};
use crate::transfer::lookup;
use crate::volume::VoxelType;

const METHODS: [Skip; 5] = [
    Skip::Box,
    Skip::Hull,
    Skip::HalfSplit,
    Skip::BeamMasks,
    Skip::DistanceMap,
];

const TYPES: [VoxelType; 5] = [
    VoxelType::U8,
    VoxelType::I8,
    VoxelType::U16,
    VoxelType::I16,
    VoxelType::F32,
];

fn bits(picture: &Picture) -> Vec<[u32; 4]> {
    picture.rgba.iter().map(|p| p.map(f32::to_bits)).collect()
}

fn draw_now(scene: &Scene, plan: &CpuPlan) -> Picture {
    render(scene, plan, &AtomicBool::new(false)).expect("nothing cancels it")
}

/// The picture by definition, in double precision: every sample in the box, one ray after another.
fn by_definition(scene: &Scene) -> Vec<[f64; 4]> {
    let basis = scene.frame.basis::<f64>();
    let domain = scene.table.domain();
    let entries = scene.table.rgba();
    let [width, height] = scene.frame.size;
    let pixel = |i: u32| {
        let ray = basis.ray(f64::from(i % width), f64::from(i / width));
        let mut rgba = [0.0; 4];
        let mut k = ray.k_near;
        while k < ray.k_end {
            let cells = ray.at(k).map(cell);
            let corner = |o: usize, a: usize| {
                (cells[a].0 + o as f64).clamp(0.0, (scene.volume.dims[a] - 1) as f64) as usize
            };
            let corners = [0, 1].map(|z| {
                [0, 1].map(|y| {
                    [0, 1].map(|x| stored(scene.volume, [corner(x, 0), corner(y, 1), corner(z, 2)]))
                })
            });
            let x = domain.x_from_stored(trilinear(corners, cells.map(|c| c.1)));
            let (lower, fraction) = lookup(x, entries.len() as f64, domain.snap());
            let (a, b) = (
                entries[lower as usize],
                entries[(lower as usize + 1).min(entries.len() - 1)],
            );
            let remaining = 1.0 - rgba[3];
            for c in 0..4 {
                let (a, b) = (f64::from(a[c]), f64::from(b[c]));
                rgba[c] += remaining * (a + fraction * (b - a));
            }
            k += 1.0;
        }
        rgba
    };
    (0..width * height).map(pixel).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    /// Every method, every path of instructions and the counting run give the bits of the box by the scalar twin.
    #[test]
    fn methods_and_paths_are_bit_identical(case in cases()) {
        let made = case.make();
        let scene = made.scene(case.ert);
        let scalar_box = made.plan(Skip::Box).with(Path::Scalar, TILE).expect("scalar runs everywhere");
        let expected = bits(&draw_now(&scene, &scalar_box));
        for skip in METHODS {
            for path in Path::ALL {
                if !path.is_available(case.dims) {
                    continue;
                }
                let plan = made.plan(skip).with(*path, TILE).expect("available");
                prop_assert!(bits(&draw_now(&scene, &plan)) == expected, "{skip:?} {path:?}");
            }
            let counted = render_counted(&scene, &made.plan(skip), &AtomicBool::new(false)).expect("not cancelled");
            prop_assert!(bits(&counted.picture) == expected, "{skip:?} counted");
        }
    }

    /// A skipping method takes no more samples than box, all that contribute, and reports the same first hits.
    #[test]
    fn what_is_left_out_is_empty(case in cases()) {
        let made = case.make();
        let scene = made.scene(case.ert);
        let count = |skip| render_counted(&scene, &made.plan(skip), &AtomicBool::new(false)).expect("not cancelled");
        let all = count(Skip::Box);
        prop_assert!(all.counters.samples >= all.counters.contributing);
        for skip in METHODS {
            let some = count(skip);
            prop_assert_eq!(some.counters.contributing, all.counters.contributing, "{:?}", skip);
            prop_assert!(some.counters.samples <= all.counters.samples, "{:?}", skip);
            prop_assert!(some.first_hit == all.first_hit, "{:?}", skip);
            prop_assert_eq!(some.samples.iter().map(|&s| u64::from(s)).sum::<u64>(), some.counters.samples);
        }
    }

    /// Neither the number of threads nor the size of tiles changes a bit.
    #[test]
    fn threads_and_tiles_change_nothing(case in cases(), tile in prop::sample::select(vec![4u32, 12, 16])) {
        let made = case.make();
        let scene = made.scene(case.ert);
        let plan = made.plan(Skip::BeamMasks);
        let path = plan.path();
        let expected = bits(&draw_now(&scene, &plan));
        let plan = plan.with(path, tile).expect("a multiple of 4");
        for threads in [1, 2, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
            prop_assert!(pool.install(|| bits(&draw_now(&scene, &plan))) == expected, "{threads} threads");
        }
    }
}

/// Without early termination no channel is off by more than 2/255 from double precision, and 60 dB are kept.
#[test]
fn pictures_are_those_of_double_precision() {
    for (i, voxel_type) in TYPES.into_iter().enumerate() {
        for fov_y_degrees in [Some(45.0), None] {
            let case = Case {
                dims: [23, 17, 29],
                spacing: DVec3::new(1.0, 1.5, 1.0),
                voxel_type,
                density: 0.1,
                seed: 77 + i as u64,
                block: 4,
                visible: [0.15, 1.2],
                camera: CameraCase::Around(Orbit {
                    fov_y_degrees,
                    ..Orbit::default()
                }),
                step: 0.5,
                ert: 1.0,
                size: [48, 40],
            };
            let made = case.make();
            let scene = made.scene(1.0);
            let expected = by_definition(&scene);
            let picture = draw_now(&scene, &made.plan(Skip::BeamMasks));
            let (mut worst, mut squares) = (0.0f64, 0.0);
            for (a, b) in picture.rgba.iter().zip(&expected) {
                for (&a, &b) in a.iter().zip(b) {
                    worst = worst.max((f64::from(a) - b).abs());
                    squares += (f64::from(a) - b).powi(2);
                }
            }
            let psnr = -10.0 * (squares / (4.0 * expected.len() as f64)).log10();
            assert!(
                expected.iter().any(|p| p[3] > 0.1),
                "something is to be seen"
            );
            assert!(worst <= 2.0 / 255.0, "{voxel_type:?}: off by {worst}");
            assert!(psnr >= 60.0, "{voxel_type:?}: {psnr} dB");
        }
    }
}

fn plain_case() -> Case {
    Case {
        dims: [12, 12, 12],
        spacing: DVec3::ONE,
        voxel_type: VoxelType::U8,
        density: 0.5,
        seed: 5,
        block: 4,
        visible: [0.2, 0.8],
        camera: CameraCase::Around(Orbit::default()),
        step: 1.0,
        ert: 0.98,
        size: [16, 16],
    }
}

#[test]
fn a_cancelled_picture_is_an_error() {
    let made = plain_case().make();
    let result = render(
        &made.scene(0.98),
        &made.plan(Skip::BeamMasks),
        &AtomicBool::new(true),
    );
    assert!(matches!(result, Err(Error::Cancelled)));
}

#[test]
fn what_does_not_belong_together_is_refused() {
    let made = plain_case().make();
    let plan = made.plan(Skip::BeamMasks);
    let refused = |scene: Scene| {
        let error = render(&scene, &plan, &AtomicBool::new(false)).expect_err("must be refused");
        assert!(error.is_bad_input() && error.to_string().lines().count() == 1);
    };
    refused(Scene {
        sampler: Sampler::Hardware,
        ..made.scene(0.98)
    });
    let other = Case {
        dims: [12, 12, 13],
        ..plain_case()
    }
    .make();
    refused(other.scene(0.98));
    // Where the plan's background has become visible.
    let brighter = Case {
        visible: [-0.1, 0.8],
        ..plain_case()
    }
    .make();
    refused(brighter.scene(0.98));
    assert!(CpuPlan::new(Skip::Box, &made.volume, &made.table, &other.occupancy).is_err());
    assert!(made.plan(Skip::Box).with(Path::Scalar, 6).is_err());
}
