//! Properties of the CPU backend: what must be equal is equal in every bit, and near the same sum in double precision.

use std::sync::atomic::AtomicBool;

use glam::{DMat3, DVec3};
use proptest::prelude::*;

use super::*;
use crate::camera::{Camera, Orbit, Projection};
use crate::lattice::RayFrame;
use crate::mode::Mode;
use crate::sample::{Classification, cell, trilinear};
use crate::transfer::{ControlPoint, Domain, TransferFunction, lookup};
use crate::volume::{Rescale, VoxelType, Voxels};

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

/// A picture's ingredients, drawn at random.
#[derive(Debug, Clone)]
struct Case {
    dims: [usize; 3],
    spacing: DVec3,
    voxel_type: VoxelType,
    /// Share of voxels that are above the background.
    density: f64,
    seed: u64,
    block: usize,
    /// Visible from this share of the value range on, and up to this one.
    visible: [f64; 2],
    camera: CameraCase,
    step: f64,
    ert: f32,
    size: [u32; 2],
}

#[derive(Debug, Clone)]
enum CameraCase {
    Around(Orbit),
    /// The eye at this share of the box, looking along a direction, over a field of view in degrees.
    Inside([f64; 3], [f64; 3], f64),
}

fn cases() -> impl Strategy<Value = Case> {
    let orbit = (
        prop_oneof![Just(0.0), Just(90.0), -180.0..180.0],
        prop_oneof![Just(0.0), Just(90.0), -90.0..90.0],
        0.3..3.0f64,
        0..3usize,
        prop_oneof![Just(None), (20.0..120.0).prop_map(Some)],
    )
        .prop_map(|(azimuth, elevation, distance, up_axis, fov)| {
            CameraCase::Around(Orbit {
                azimuth_degrees: azimuth,
                elevation_degrees: elevation,
                distance_edges: distance,
                up_axis,
                up_negative: false,
                fov_y_degrees: fov,
            })
        });
    let inside = (
        prop::array::uniform3(0.0..1.0f64),
        prop::array::uniform3(-1.0..1.0f64),
        30.0..150.0f64,
    )
        .prop_map(|(eye, to, fov)| CameraCase::Inside(eye, to, fov));
    let shape = prop_oneof![
        prop::array::uniform3(1..24usize),
        prop::array::uniform3(20..40usize)
    ];
    (
        (
            shape,
            prop::array::uniform3(prop_oneof![Just(1.0), 0.5..4.0f64]),
        ),
        prop::sample::select(TYPES.to_vec()),
        (
            prop_oneof![Just(0.0), 0.0..0.05f64, Just(1.0)],
            any::<u64>(),
        ),
        prop::sample::select(vec![2usize, 3, 4, 8]),
        (0.0..0.9f64, 0.05..1.0f64),
        prop_oneof![orbit, inside],
        (
            prop_oneof![Just(0.5), 0.2..2.0f64],
            prop::sample::select(vec![0.98f32, 1.0]),
        ),
        (1..30u32, 1..30u32),
    )
        .prop_map(
            |(
                (dims, spacing),
                voxel_type,
                (density, seed),
                block,
                (low, width),
                camera,
                (step, ert),
                (w, h),
            )| {
                Case {
                    dims,
                    spacing: DVec3::from_array(spacing),
                    voxel_type,
                    density,
                    seed,
                    block,
                    visible: [low, low + width],
                    camera,
                    step,
                    ert,
                    size: [w, h],
                }
            },
        )
}

/// What a case stands for, made.
struct Made {
    volume: Volume,
    table: Table,
    frame: RayFrame,
    occupancy: Occupancy,
}

impl Case {
    fn make(&self) -> Made {
        let mut state = self.seed | 1;
        let mut random = || {
            // xorshift64*: any sequence without a pattern does.
            state ^= state >> 12;
            state ^= state << 25;
            state ^= state >> 27;
            (state.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 40) as f64 / f64::from(1 << 24)
        };
        let range = self.voxel_type.integer_range().unwrap_or([-3.5, 1000.25]);
        let count = self.dims.iter().product::<usize>();
        let stored: Vec<f64> = (0..count)
            .map(|_| {
                let value = if random() < self.density {
                    random()
                } else {
                    0.0
                };
                let value = range[0] + value * (range[1] - range[0]);
                if self.voxel_type == VoxelType::F32 {
                    value
                } else {
                    value.floor()
                }
            })
            .collect();
        let voxels = match self.voxel_type {
            VoxelType::U8 => Voxels::U8(stored.iter().map(|&v| v as u8).collect::<Vec<_>>().into()),
            VoxelType::I8 => Voxels::I8(stored.iter().map(|&v| v as i8).collect::<Vec<_>>().into()),
            VoxelType::U16 => {
                Voxels::U16(stored.iter().map(|&v| v as u16).collect::<Vec<_>>().into())
            }
            VoxelType::I16 => {
                Voxels::I16(stored.iter().map(|&v| v as i16).collect::<Vec<_>>().into())
            }
            VoxelType::F32 => {
                Voxels::F32(stored.iter().map(|&v| v as f32).collect::<Vec<_>>().into())
            }
        };
        let volume = Volume {
            name: "random".to_owned(),
            dims: self.dims,
            spacing: self.spacing,
            origin: DVec3::ZERO,
            direction: DMat3::IDENTITY,
            rescale: Rescale::IDENTITY,
            voxels,
            warnings: Vec::new(),
        };
        let point = |share: f64, opacity, color| ControlPoint {
            value: range[0] + share * (range[1] - range[0]),
            opacity,
            color,
        };
        let function = TransferFunction::new(
            vec![
                point(self.visible[0], 0.0, [1.0, 0.5, 0.1]),
                point(
                    0.5 * (self.visible[0] + self.visible[1]),
                    0.6,
                    [0.2, 0.9, 0.3],
                ),
                point(self.visible[1], 0.0, [0.1, 0.2, 1.0]),
            ],
            1.0,
        )
        .expect("points ascend");
        let domain = Domain::new(&volume, range, 256).expect("256 is a size");
        let camera = match self.camera {
            CameraCase::Around(orbit) => orbit.camera(volume.extent()),
            CameraCase::Inside(eye, to, fov_y_degrees) => {
                let eye = DVec3::from_array(eye) * volume.extent();
                let to = DVec3::from_array(to);
                let to = if to.length() > 1e-3 { to } else { DVec3::X };
                Camera {
                    eye,
                    target: eye + to,
                    up: DVec3::Z,
                    projection: Projection::Perspective { fov_y_degrees },
                }
            }
        };
        let frame = camera
            .ray_frame(&volume, self.size, self.step)
            .expect("in range");
        let table = function.bake(&domain, self.step);
        let occupancy = occupancy(&volume, &table, self.block);
        Made {
            volume,
            table,
            frame,
            occupancy,
        }
    }
}

fn stored(volume: &Volume, [x, y, z]: [usize; 3]) -> f64 {
    let at = (z * volume.dims[1] + y) * volume.dims[0] + x;
    with_voxels!(&volume.voxels, v => f64::from(v[at]))
}

/// Activity by definition: each block's range over its voxels and one of apron.
fn occupancy(volume: &Volume, table: &Table, block: usize) -> Occupancy {
    let mut occupancy = Occupancy::new(volume.dims, block);
    let span = |i: usize, n: usize| (i * block).saturating_sub(1)..((i + 1) * block + 1).min(n);
    for z in occupancy.whole()[2].clone() {
        for y in occupancy.whole()[1].clone() {
            for x in occupancy.whole()[0].clone() {
                let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
                for vz in span(z, volume.dims[2]) {
                    for vy in span(y, volume.dims[1]) {
                        for vx in span(x, volume.dims[0]) {
                            let v = stored(volume, [vx, vy, vz]);
                            (low, high) = (low.min(v), high.max(v));
                        }
                    }
                }
                let ulp = if volume.voxels.voxel_type() == VoxelType::F32 {
                    4.0 * f64::from(f32::EPSILON) * low.abs().max(high.abs())
                } else {
                    0.0
                };
                let x_of = |v| table.domain().x_from_stored(v);
                if table.is_visible(x_of(low - ulp)..=x_of(high + ulp)) {
                    occupancy.set([x, y, z]);
                }
            }
        }
    }
    occupancy
}

impl Made {
    fn scene(&self, ert: f32) -> Scene<'_> {
        Scene {
            volume: &self.volume,
            table: &self.table,
            frame: &self.frame,
            sampler: Sampler::Exact,
            classification: Classification::Post,
            mode: Mode::EmissionAbsorption,
            gradients: crate::sample::Gradients::Fly,
            depth_cue: 0.0,
            ert,
        }
    }

    fn plan(&self, skip: Skip) -> CpuPlan {
        CpuPlan::new(skip, &self.volume, &self.table, &self.occupancy).expect("the method is there")
    }
}

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
