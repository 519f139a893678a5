//! What the properties are tried on: volumes, tables and views, drawn at random.

use glam::{DMat3, DVec3};
use proptest::prelude::*;

use super::TYPES;
use crate::camera::{Camera, Orbit, Projection};
use crate::cpu::CpuPlan;
use crate::lattice::RayFrame;
use crate::octree::Occupancy;
use crate::scene::Scene;
use crate::skip::Skip;
use crate::transfer::{ControlPoint, Domain, Table, TransferFunction};
use crate::volume::{Rescale, Volume, VoxelType, Voxels};
use crate::with_voxels;

/// A picture's ingredients, drawn at random.
#[derive(Debug, Clone)]
pub(super) struct Case {
    pub(super) dims: [usize; 3],
    pub(super) spacing: DVec3,
    pub(super) voxel_type: VoxelType,
    /// Share of voxels that are above the background.
    pub(super) density: f64,
    pub(super) seed: u64,
    pub(super) block: usize,
    /// Visible from this share of the value range on, and up to this one.
    pub(super) visible: [f64; 2],
    pub(super) camera: CameraCase,
    pub(super) step: f64,
    pub(super) ert: f32,
    pub(super) size: [u32; 2],
}

#[derive(Debug, Clone)]
pub(super) enum CameraCase {
    Around(Orbit),
    /// The eye at this share of the box, looking along a direction, over a field of view in degrees.
    Inside([f64; 3], [f64; 3], f64),
}

pub(super) fn cases() -> impl Strategy<Value = Case> {
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
pub(super) struct Made {
    pub(super) volume: Volume,
    pub(super) table: Table,
    pub(super) frame: RayFrame,
    pub(super) occupancy: Occupancy,
}

impl Case {
    pub(super) fn make(&self) -> Made {
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

pub(super) fn stored(volume: &Volume, [x, y, z]: [usize; 3]) -> f64 {
    let at = (z * volume.dims[1] + y) * volume.dims[0] + x;
    with_voxels!(&volume.voxels, v => f64::from(v[at]))
}

/// Activity in emission and absorption by definition: each block's range over its voxels and one of apron.
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
    pub(super) fn scene(&self, ert: f32) -> Scene<'_> {
        Scene {
            ert,
            ..Scene::new(&self.volume, &self.table, &self.frame)
        }
    }

    pub(super) fn plan(&self, skip: Skip) -> CpuPlan {
        CpuPlan::new(skip, &self.volume, &self.table, &self.occupancy).expect("the method is there")
    }
}
