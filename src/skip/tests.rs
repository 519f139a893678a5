//! Properties that every method's segments have, on random blocks and views.

use proptest::prelude::*;

use std::ops::Range;

use super::k_cuts::Planes;
use super::traversal::Line;
use super::*;
use crate::camera::{Camera, Projection};
use crate::lattice::{Ray, RayFrame, Real};
use crate::volume::{Rescale, Volume, Voxels};

/// How near to a face a sample counts as on it, in voxels: far above what f32 rounds in boxes this small, far below the
/// half voxel that closed support forgives.
const ON_FACE: f64 = 1e-4;

fn volume(dims: [usize; 3], spacing: DVec3) -> Volume {
    Volume {
        name: "empty".into(),
        dims,
        spacing,
        origin: DVec3::ZERO,
        direction: glam::DMat3::IDENTITY,
        rescale: Rescale::IDENTITY,
        voxels: Voxels::U8(vec![0; dims.iter().product()].into()),
        warnings: Vec::new(),
    }
}

fn occupancies() -> impl Strategy<Value = Occupancy> {
    let dims = prop::array::uniform3(1usize..=41);
    let block = prop::sample::select(vec![4usize, 8, 16, 32]);
    (dims, block, 0.0..0.6f64, any::<u64>()).prop_map(|(dims, block, share, seed)| {
        let mut occupancy = Occupancy::new(dims, block);
        let mut state = seed | 1;
        let [nx, ny, nz] = occupancy.dims;
        for z in 0..nz {
            for y in 0..ny {
                for x in 0..nx {
                    state ^= state << 13;
                    state ^= state >> 7;
                    state ^= state << 17;
                    if (state >> 11) as f64 / (1u64 << 53) as f64 <= share {
                        occupancy.set([x, y, z]);
                    }
                }
            }
        }
        occupancy
    })
}

/// A camera by fractions of the box: inside and outside, oblique, along an axis, along a diagonal.
#[derive(Debug, Clone)]
struct View {
    target: DVec3,
    toward: DVec3,
    /// From the eye to the target in longest edges; short distances from inside.
    distance: f64,
    perspective: bool,
}

fn views() -> impl Strategy<Value = View> {
    let target = prop::array::uniform3(prop_oneof![0.0..1.0f64, Just(0.5), Just(0.25)]);
    let toward = prop_oneof![
        prop::array::uniform3(-1.0..1.0f64),
        prop::array::uniform3(prop::sample::select(vec![-1.0, 0.0, 1.0])),
        // Not parallel by a hair.
        (0usize..3, -1e-9..1e-9f64).prop_map(|(axis, tilt)| {
            let mut toward = [tilt, -tilt, tilt];
            toward[axis] = 1.0;
            toward
        }),
    ]
    .prop_filter("a direction", |toward| toward.iter().any(|c| c.abs() > 0.1));
    let distance = prop_oneof![0.01..0.5f64, 1.0..4.0f64];
    (target, toward, distance, any::<bool>()).prop_map(|(target, toward, distance, perspective)| {
        View {
            target: target.into(),
            toward: DVec3::from(toward).normalize(),
            distance,
            perspective,
        }
    })
}

fn camera(view: &View, extent: DVec3) -> Camera {
    let target = view.target * extent;
    let edge = extent.max_element();
    Camera {
        eye: target - view.toward * view.distance * edge,
        target,
        up: DVec3::Z,
        projection: if view.perspective {
            Projection::Perspective {
                fov_y_degrees: 30.0,
            }
        } else {
            // Six pixels, whole or half voxels apart: rays run along faces.
            Projection::Orthographic {
                height: (edge / 12.0).ceil() * 6.0,
            }
        },
    }
}

fn frames() -> impl Strategy<Value = (Occupancy, RayFrame)> {
    let spacing = prop_oneof![
        Just([1.0, 1.0, 1.0]),
        prop::array::uniform3(prop::sample::select(vec![0.5, 0.7, 1.0, 2.5]))
    ];
    let step = prop_oneof![0.05..0.5f64, 0.5..10.0f64, Just(0.5), Just(1.0)];
    (occupancies(), spacing, views(), step).prop_map(|(occupancy, spacing, view, step)| {
        let volume = volume(occupancy.volume_dims, spacing.into());
        let camera = camera(&view, volume.extent());
        let frame = camera
            .ray_frame(&volume, [6, 6], step)
            .expect("the views are valid");
        (occupancy, frame)
    })
}

fn segments_of<R: Real + Into<f64>>(plan: &Plan, ray: &Ray<R>) -> Vec<Range<u32>> {
    segments_where(plan, ray, [0, 0], &|_| true)
}

/// The segments of a pixel's ray on which these samples contribute.
fn segments_where<R: Real + Into<f64>>(
    plan: &Plan,
    ray: &Ray<R>,
    pixel: [u32; 2],
    shows: Shows,
) -> Vec<Range<u32>> {
    let mut segments = plan.segments(ray, pixel, shows);
    let mut k = 0;
    let mut all = Vec::new();
    while let Some(range) = segments.next(k, f64::NAN) {
        k = range.end;
        all.push(range);
    }
    assert!(segments.steps() as usize >= all.len());
    all
}

/// Whether every block within [`ON_FACE`] of a position is active.
fn surely_active(occupancy: &Occupancy, position: [f64; 3]) -> bool {
    let near = |a: usize| {
        let block =
            |p: f64| ((p / occupancy.block as f64).max(0.0) as usize).min(occupancy.dims[a] - 1);
        block(position[a] - ON_FACE)..=block(position[a] + ON_FACE)
    };
    near(2).all(|z| near(1).all(|y| near(0).all(|x| occupancy.get([x, y, z]))))
}

/// Whether a method's segments are padded hulls, each in that of the whole volume.
fn is_hull_of_slabs(skip: Skip) -> bool {
    matches!(skip, Skip::Box | Skip::Hull | Skip::HalfSplit | Skip::KCuts)
}

/// Whether a method makes use of the half voxel around an inactive block that this answers for.
fn takes_apron(skip: Skip) -> bool {
    matches!(skip, Skip::BeamMasks | Skip::DistanceMap | Skip::BeamCells)
}

fn check<R: Real + Into<f64>>(occupancy: &Occupancy, frame: &RayFrame) {
    let basis = frame.basis::<R>();
    let plans: Vec<_> = METHODS
        .iter()
        .filter(|m| m.lossless && m.backends.contains(&"reference"))
        .map(|m| (m, Plan::new(m.skip, occupancy, frame).unwrap()))
        .collect();
    for pixel in 0..frame.size[0] * frame.size[1] {
        let (x, y) = (pixel % frame.size[0], pixel / frame.size[0]);
        let ray = basis.ray(R::splat(f64::from(x)), R::splat(f64::from(y)));
        let [near, end] = [ray.k_near, ray.k_end].map(|k| k.into() as u32);
        let position = |k: u32| ray.at(R::splat(f64::from(k))).map(Into::into);
        // As if everything in an active block contributed.
        let shows = |k: u32| surely_active(occupancy, position(k));
        let mut covered_by = Vec::new();
        for (method, plan) in &plans {
            let segments = segments_where(plan, &ray, [x, y], &shows);
            assert!(segments.len() <= method.max_segments);
            let mut after = near;
            for s in &segments {
                assert!(s.start >= after && s.start < s.end && s.end <= end.max(near));
                after = s.end;
            }
            let covers = |k: &u32| segments.iter().any(|s| s.contains(k));
            for k in (near..end).filter(|k| !covers(k)) {
                let at = position(k);
                let may_be_left_out = if takes_apron(method.skip) {
                    support::is_answered_for(occupancy, at)
                } else {
                    !surely_active(occupancy, at)
                };
                assert!(
                    may_be_left_out,
                    "{} leaves out sample {k} at {at:?} of pixel ({x}, {y})",
                    method.name
                );
            }
            if is_hull_of_slabs(method.skip) {
                covered_by.push((near..end).filter(covers).collect::<Vec<_>>());
            }
        }
        let [every, hull, cut @ ..] = covered_by.as_slice() else {
            panic!("the table lists box and hull first");
        };
        assert_eq!(every.len() as u32, end.saturating_sub(near));
        for cut in cut {
            assert!(cut.iter().all(|k| hull.binary_search(k).is_ok()));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn segments_ascend_and_cover_all_that_may_contribute((occupancy, frame) in frames()) {
        check::<f64>(&occupancy, &frame);
        check::<f32>(&occupancy, &frame);
    }

    #[test]
    fn a_line_of_any_cut_is_covered_by_its_hull((occupancy, frame) in frames(), axis in 0usize..3) {
        let ray = frame.basis::<f64>().ray(2.0, 3.0);
        let hull = segments_of(&Plan::new(Skip::Hull, &occupancy, &frame).unwrap(), &ray);
        for cut in 0..=occupancy.dims[axis] {
            let half = HalfSplit { occupancy: &occupancy, axis, cut };
            let half = segments_of(&Plan::HalfSplit(half), &ray);
            prop_assert_eq!(half.first().map(|s| s.start), hull.first().map(|s| s.start));
            prop_assert_eq!(half.last().map(|s| s.end), hull.last().map(|s| s.end));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn slabs_between_any_planes_cover_all_that_may_contribute_within_the_hull(
        (occupancy, frame) in frames(),
        axis in 0usize..3,
        at in prop::collection::vec(any::<prop::sample::Index>(), 0..=7),
    ) {
        let mut at: Vec<_> = at.iter().map(|i| i.index(occupancy.dims[axis] + 1)).collect();
        at.sort_unstable();
        let planes = Planes::new(&at);
        let plan = Plan::with_planes(Skip::KCuts, &occupancy, &frame, axis, planes).unwrap();
        let hull = Plan::new(Skip::Hull, &occupancy, &frame).unwrap();
        let basis = frame.basis::<f64>();
        for pixel in 0..frame.size[0] * frame.size[1] {
            let ray = basis.ray(f64::from(pixel % frame.size[0]), f64::from(pixel / frame.size[0]));
            let (slabs, hull) = (segments_of(&plan, &ray), segments_of(&hull, &ray));
            support::check_ray(&occupancy, &ray, &slabs)?;
            prop_assert!(slabs.len() <= at.len() + 1);
            prop_assert_eq!(slabs.first().map(|s| s.start), hull.first().map(|s| s.start));
            prop_assert_eq!(slabs.last().map(|s| s.end), hull.last().map(|s| s.end));
        }
    }
}

fn ray(entry: [f64; 3], delta: [f64; 3], k_end: f64) -> Ray<f64> {
    Ray {
        entry,
        delta,
        k_near: 0.0,
        k_end,
        t_box: 0.0,
        drawn: [0.0, k_end],
        reach: 0.0,
    }
}

#[test]
fn a_cavity_at_the_cut_is_left_out_from_either_side() {
    let mut occupancy = Occupancy::new([32, 4, 4], 4);
    occupancy.set([1, 0, 0]);
    occupancy.set([6, 0, 0]);
    let plan = Plan::HalfSplit(HalfSplit {
        occupancy: &occupancy,
        axis: 0,
        cut: 4,
    });
    // Samples at 0.5, 1.5, ...: block 1 holds samples 4 to 7, block 6 holds 24 to 27; one more at each end.
    let forward = ray([0.0, 2.0, 2.0], [1.0, 0.0, 0.0], 32.0);
    assert_eq!(segments_of(&plan, &forward), [3..9, 23..29]);
    let backward = ray([32.0, 2.0, 2.0], [-1.0, 0.0, 0.0], 32.0);
    assert_eq!(segments_of(&plan, &backward), [3..9, 23..29]);
    let hull = Plan::Hull(Hull {
        occupancy: &occupancy,
    });
    assert_eq!(segments_of(&hull, &forward), [Range { start: 3, end: 29 }]);
}

#[test]
fn the_walk_meets_each_block_of_an_oblique_line_once() {
    let occupancy = Occupancy::new([16, 16, 16], 4);
    let line = Line::new(&ray([0.0, 16.0, 1.0], [0.3, -0.1, 0.0], 53.0)).expect("has samples");
    let blocks: Vec<_> = traversal::Blocks::new(&occupancy, line, line.span()).collect();
    // y leaves 12 at s = 40, x passes 4, 8, 12 at 13.3, 26.7 and 40: there both change at once.
    let at: Vec<_> = blocks.iter().map(|b| b.0).collect();
    assert_eq!(at, [[0, 3, 0], [1, 3, 0], [2, 3, 0], [3, 2, 0]]);
    assert!(blocks.windows(2).all(|w| w[0].1[1] == w[1].1[0]));
    assert_eq!([blocks[0].1[0], blocks[3].1[1]], line.span());
}

#[test]
fn the_largest_component_of_the_view_is_the_axis() {
    assert_eq!(half_axis(DVec3::new(0.1, -0.9, 0.3)), 1);
    assert_eq!(half_axis(DVec3::new(0.5, 0.5, -0.6)), 2);
    assert_eq!(half_axis(DVec3::ONE), 0);
}
