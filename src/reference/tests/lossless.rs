//! Skipping changes nothing: the same bits as the bounding box, at most as many samples.

use std::ops::RangeInclusive;

use proptest::prelude::*;

use super::*;
use crate::camera::Orbit;
use crate::error::Error;
use crate::octree::Occupancy;
use crate::reference::{render, render_f64};
use crate::scene::{CountedPicture, Progress};
use crate::skip::k_cuts::{BestCuts, MAX_SLABS, Planes};
use crate::skip::{HalfSplit, METHODS, Method, Plan, Skip};

/// Brute force: each block by the least and greatest voxel of its closed support, its own voxels and one more around.
fn occupancy(volume: &Volume, table: &Table, block: usize) -> Occupancy {
    let mut occupancy = Occupancy::new(volume.dims, block);
    let [bx, by, bz] = occupancy.dims;
    for z in 0..bz {
        for y in 0..by {
            for x in 0..bx {
                let range = support(volume, [x, y, z], block);
                let [start, end] =
                    [*range.start(), *range.end()].map(|v| table.domain().x_from_stored(v));
                if Mode::EmissionAbsorption.is_active(table, start..=end) {
                    occupancy.set([x, y, z]);
                }
            }
        }
    }
    occupancy
}

fn support(volume: &Volume, at: [usize; 3], block: usize) -> RangeInclusive<f64> {
    let Voxels::U8(voxels) = &volume.voxels else {
        panic!("these tests use u8");
    };
    let [nx, ny, _] = volume.dims;
    let [xs, ys, zs] = [0, 1, 2]
        .map(|a| (at[a] * block).saturating_sub(1)..((at[a] + 1) * block + 1).min(volume.dims[a]));
    let mut range = [f64::INFINITY, f64::NEG_INFINITY];
    for z in zs {
        for y in ys.clone() {
            for x in xs.clone() {
                let value = f64::from(voxels[(z * ny + y) * nx + x]);
                range = [range[0].min(value), range[1].max(value)];
            }
        }
    }
    range[0]..=range[1]
}

/// Walls a voxel or two thick, and specks, in a background that touches the threshold of visibility.
fn volumes() -> impl Strategy<Value = Volume> {
    let dims = prop::array::uniform3(1usize..=41);
    let spacing = prop_oneof![Just([1.0; 3]), Just([0.5, 0.7, 1.3])];
    let wall = (0usize..3, 0usize..41, 1usize..3);
    (
        dims,
        spacing,
        prop::collection::vec(wall, 0..4),
        prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..12),
    )
        .prop_map(|(dims, spacing, walls, specks)| {
            let mut voxels = vec![40u8; dims.iter().product()];
            for (axis, at, thickness) in walls {
                for (i, voxel) in voxels.iter_mut().enumerate() {
                    let c = [i % dims[0], i / dims[0] % dims[1], i / dims[0] / dims[1]];
                    let inside =
                        |a: usize| a == axis || (c[a] * 4 >= dims[a] && c[a] * 4 < dims[a] * 3);
                    let near = c[axis] + thickness > at && c[axis] < at + thickness;
                    if near && (0..3).all(inside) {
                        *voxel = 41 + (i * 7 % 200) as u8;
                    }
                }
            }
            for (index, value) in specks {
                let i = index.index(voxels.len());
                voxels[i] = value;
            }
            volume(dims, spacing, Voxels::U8(voxels.into()))
        })
}

fn cameras() -> impl Strategy<Value = Orbit> {
    let angle = prop_oneof![
        -180.0..180.0f64,
        prop::sample::select(vec![0.0, 45.0, 90.0, 180.0])
    ];
    let elevation = prop_oneof![-90.0..90.0f64, prop::sample::select(vec![-90.0, 0.0, 90.0])];
    // From inside a wall or cavity to far away.
    let distance = prop_oneof![0.01..0.6f64, 1.0..5.0f64];
    (angle, elevation, distance, 0usize..3, any::<bool>()).prop_map(
        |(azimuth_degrees, elevation_degrees, distance_edges, up_axis, perspective)| Orbit {
            azimuth_degrees,
            elevation_degrees,
            distance_edges,
            up_axis,
            up_negative: false,
            fov_y_degrees: perspective.then_some(40.0),
        },
    )
}

fn ramp_from_40() -> TransferFunction {
    function(
        vec![
            point(40.0, 0.0, [0.9, 0.6, 0.4]),
            point(255.0, 0.3, [1.0, 0.9, 0.8]),
        ],
        1.0,
    )
}

fn counted(scene: &Scene, plan: &Plan) -> CountedPicture {
    render(scene, plan, &Progress::default()).expect("not cancelled")
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(192))]

    #[test]
    fn skipping_changes_no_bit(
        volume in volumes(),
        orbit in cameras(),
        block in prop::sample::select(vec![4usize, 8, 16, 32]),
        step in prop_oneof![0.2..1.0f64, 1.0..4.0f64, Just(0.5), Just(1.0)],
        ert in prop::sample::select(vec![0.5f32, 0.98, 1.0]),
        classification in prop::sample::select(Classification::ALL),
    ) {
        let camera = orbit.camera(volume.extent());
        let frame = RayFrame {
            reach: classification.reach(),
            ..camera.ray_frame(&volume, [11, 9], step).expect("a valid view")
        };
        let table = ramp_from_40().bake(&domain(&volume, 256), step);
        let occupancy = match classification {
            Classification::Pre => Occupancy::of_visible_voxels(&volume, &table, block, 1),
            _ => occupancy(&volume, &table, block),
        };
        let scene = Scene { classification, ..scene(&volume, &table, &frame, ert) };
        let whole = counted(&scene, &Plan::Box);
        let exact = render_f64(&scene, &Plan::Box, &Progress::default()).expect("not cancelled");

        let of = |m: &Method| Plan::new(m.skip, &occupancy, &frame).unwrap();
        let methods = METHODS.iter().filter(|m| m.lossless && m.backends.contains(&"reference"));
        let mut plans: Vec<Plan> = methods.map(of).collect();
        // Any cut will do, not only the one that pays.
        plans.extend((0..3).map(|axis| {
            Plan::HalfSplit(HalfSplit { occupancy: &occupancy, axis, cut: occupancy.dims[axis] / 3 })
        }));
        plans.extend((0..3).map(|axis| {
            let planes = BestCuts::new(&occupancy, axis).at_most(MAX_SLABS);
            Plan::with_planes(Skip::KCuts, &occupancy, &frame, axis, planes).unwrap()
        }));
        for plan in plans {
            let skipped = counted(&scene, &plan);
            prop_assert_eq!(&skipped.picture, &whole.picture);
            prop_assert_eq!(&skipped.first_hit, &whole.first_hit);
            prop_assert_eq!(skipped.counters.contributing, whole.counters.contributing);
            prop_assert_eq!(
                skipped.counters.samples,
                skipped.samples.iter().copied().map(u64::from).sum::<u64>()
            );
            for (few, many) in skipped.samples.iter().zip(&whole.samples) {
                prop_assert!(few <= many);
            }
            let pixels = render_f64(&scene, &plan, &Progress::default()).expect("not cancelled");
            prop_assert_eq!(&pixels, &exact);
        }
    }
}

/// A hollow box of walls two voxels thick.
fn hollow() -> Volume {
    let n = 40;
    let shell = |c: usize| !(10..=29).contains(&c);
    let voxels: Vec<u8> = (0..n * n * n)
        .map(|i| {
            let c = [i % n, i / n % n, i / n / n];
            let inside = c.iter().all(|&c| (8..=31).contains(&c));
            if inside && c.into_iter().any(shell) {
                200
            } else {
                0
            }
        })
        .collect();
    volume([n; 3], [1.0; 3], Voxels::U8(voxels.into()))
}

#[test]
fn threads_change_nothing() {
    let volume = hollow();
    let camera = Orbit::default().camera(volume.extent());
    let frame = camera
        .ray_frame(&volume, [24, 24], 0.7)
        .expect("a valid view");
    let table = ramp_from_40().bake(&domain(&volume, 256), 0.7);
    let scene = scene(&volume, &table, &frame, 0.98);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads")
            .install(|| counted(&scene, &Plan::Box))
    };
    let (one, three) = (on(1), on(3));
    assert!(one.counters.contributing > 0);
    assert_eq!(one.picture, three.picture);
    assert_eq!((one.counters, one.samples), (three.counters, three.samples));
}

#[test]
fn each_method_takes_fewer_samples_of_a_hollow_box() {
    let volume = hollow();
    let camera = Orbit::default().camera(volume.extent());
    let frame = camera
        .ray_frame(&volume, [32, 32], 0.5)
        .expect("a valid view");
    let table = ramp_from_40().bake(&domain(&volume, 256), 0.5);
    let occupancy = occupancy(&volume, &table, 4);
    let scene = scene(&volume, &table, &frame, 1.0);
    let samples = [Skip::Box, Skip::Hull, Skip::HalfSplit].map(|skip| {
        counted(&scene, &Plan::new(skip, &occupancy, &frame).unwrap())
            .counters
            .samples
    });
    assert!(
        samples[2] < samples[1] && samples[1] < samples[0],
        "{samples:?}"
    );
}

#[test]
fn a_picture_can_be_stopped_and_tells_how_far_it_is() {
    let volume = hollow();
    let camera = Orbit::default().camera(volume.extent());
    let frame = camera
        .ray_frame(&volume, [8, 6], 1.0)
        .expect("a valid view");
    let table = ramp_from_40().bake(&domain(&volume, 256), 1.0);
    let scene = scene(&volume, &table, &frame, 1.0);
    let progress = Progress::default();
    render(&scene, &Plan::Box, &progress).expect("not cancelled");
    assert_eq!(progress.rows_done(), 6);
    progress.cancel();
    assert!(matches!(
        render(&scene, &Plan::Box, &progress),
        Err(Error::Cancelled)
    ));
}

/// Two cavities in z, neither of them at the middle, which lies in the matter between them.
fn off_centre() -> Volume {
    let n = 64;
    let voxels: Vec<u8> = (0..n * n * n)
        .map(|i| {
            let [x, y, z] = [i % n, i / n % n, i / n / n];
            let is_inside = [x, y].iter().all(|c| (4..60).contains(c)) && (4..60).contains(&z);
            let is_cavity = (8..24).contains(&z) || (44..56).contains(&z);
            if is_inside && !is_cavity { 200 } else { 0 }
        })
        .collect();
    volume([n; 3], [1.0; 3], Voxels::U8(voxels.into()))
}

#[test]
fn the_best_cut_takes_fewer_samples_of_a_cavity_off_centre_than_the_middle_one() {
    let volume = off_centre();
    let camera = Orbit {
        elevation_degrees: 80.0,
        ..Orbit::default()
    }
    .camera(volume.extent());
    let frame = camera
        .ray_frame(&volume, [32, 32], 0.5)
        .expect("a valid view");
    let table = ramp_from_40().bake(&domain(&volume, 256), 0.5);
    let occupancy = occupancy(&volume, &table, 4);
    let scene = scene(&volume, &table, &frame, 1.0);
    let best = BestCuts::new(&occupancy, 2);
    let samples = |skip, planes| {
        let plan = Plan::with_planes(skip, &occupancy, &frame, 2, planes).unwrap();
        counted(&scene, &plan).counters.samples
    };
    let middle = samples(Skip::HalfSplit, Planes::new(&[occupancy.half_cut(2)]));
    let single = samples(Skip::HalfSplit, best.at_most(2));
    let several = samples(Skip::KCuts, best.at_most(MAX_SLABS));
    assert_eq!(best.at_most(MAX_SLABS).as_slice().len(), 2);
    assert!(
        several < single && single < middle,
        "{several}, {single}, {middle}"
    );
}
