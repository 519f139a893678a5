//! Volumes for this module's tests: random, of every voxel type and of awkward sizes.

use std::ops::Range;

use glam::{DMat3, DVec3};
use proptest::prelude::*;

use crate::octree::Occupancy;
use crate::transfer::{ControlPoint, Domain, Table, TransferFunction};
use crate::volume::{Rescale, Volume, VoxelType, Voxels};
use crate::with_voxels;

/// A volume of these voxels, unit spacing.
pub(super) fn volume_of(dims: [usize; 3], voxels: Voxels) -> Volume {
    Volume {
        name: "test".into(),
        dims,
        spacing: DVec3::ONE,
        origin: DVec3::ZERO,
        direction: DMat3::IDENTITY,
        rescale: Rescale::IDENTITY,
        voxels,
        warnings: Vec::new(),
    }
}

/// The stored number of voxel (x, y, z).
#[allow(clippy::useless_conversion)] // of f32, one of the types that the macro expands to
pub(super) fn stored(volume: &Volume, [x, y, z]: [usize; 3]) -> f32 {
    let at = (z * volume.dims[1] + y) * volume.dims[0] + x;
    with_voxels!(&volume.voxels, v => f32::from(v[at]))
}

/// What a random volume is made from.
#[derive(Debug, Clone)]
pub(super) struct AnyVolume {
    dims: [usize; 3],
    voxel_type: VoxelType,
    /// Share of voxels, in 256ths, that are not background.
    filled: u8,
    /// Edge of the cubes of voxels that are alike: large ones make nodes that merge.
    grain: usize,
    seed: u64,
}

impl AnyVolume {
    /// Sizes include single voxels, slabs and primes; types and fillings vary.
    pub(super) fn strategy() -> impl Strategy<Value = Self> {
        let dims = prop_oneof![
            prop::array::uniform3(1usize..24),
            Just([2, 3, 5]),
            Just([1, 31, 29]),
            Just([67, 9, 33]),
            Just([130, 3, 17]),
            Just([1, 1, 1]),
        ];
        let types = prop::sample::select(vec![
            VoxelType::U8,
            VoxelType::I8,
            VoxelType::U16,
            VoxelType::I16,
            VoxelType::F32,
        ]);
        (dims, types, any::<u8>(), 1usize..12, any::<u64>()).prop_map(
            |(dims, voxel_type, filled, grain, seed)| Self {
                dims,
                voxel_type,
                filled,
                grain,
                seed,
            },
        )
    }

    /// The volume: background 0 and hashed values.
    pub(super) fn volume(&self) -> Volume {
        let [nx, ny, nz] = self.dims;
        let mut hashes = Vec::with_capacity(nx * ny * nz);
        for z in 0..nz {
            for y in 0..ny {
                for x in 0..nx {
                    let grain = [x, y, z].map(|i| (i / self.grain) as u64);
                    let hash = grain.iter().fold(self.seed, |h, &i| mix(h ^ i));
                    hashes.push(if hash as u8 <= self.filled {
                        (hash >> 32) as u32
                    } else {
                        0
                    });
                }
            }
        }
        let hashes = hashes.into_iter();
        let voxels = match self.voxel_type {
            VoxelType::U8 => Voxels::U8(hashes.map(|h| h as u8).collect::<Vec<_>>().into()),
            VoxelType::I8 => Voxels::I8(hashes.map(|h| h as i8).collect::<Vec<_>>().into()),
            VoxelType::U16 => Voxels::U16(hashes.map(|h| h as u16).collect::<Vec<_>>().into()),
            VoxelType::I16 => Voxels::I16(hashes.map(|h| h as i16).collect::<Vec<_>>().into()),
            VoxelType::F32 => Voxels::F32(
                hashes
                    .map(|h| h as i32 as f32 / 65536.0)
                    .collect::<Vec<_>>()
                    .into(),
            ),
        };
        volume_of(self.dims, voxels)
    }
}

/// The finaliser of `SplitMix64` (Steele, Lea, Flood 2014).
fn mix(h: u64) -> u64 {
    let h = h.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let h = (h ^ (h >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let h = (h ^ (h >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    h ^ (h >> 31)
}

/// Random activity and a region to look at.
#[derive(Debug, Clone)]
pub(super) struct AnyOccupancy {
    dims: [usize; 3],
    /// Parts of each axis where the region starts and ends.
    ends: [[f64; 2]; 3],
    /// Share of active leaves in 256ths: sparse, mixed and dense activity merge differently.
    filled: u8,
    /// Edge of the cubes of leaves that are alike.
    grain: usize,
    seed: u64,
}

impl AnyOccupancy {
    /// Grids of up to three words per row, and regions that may be empty.
    pub(super) fn strategy() -> impl Strategy<Value = Self> {
        let dims = prop_oneof![
            prop::array::uniform3(1usize..12),
            [60usize..140, 1usize..5, 1usize..5],
            [1usize..5, 60usize..140, 1usize..5],
        ];
        let ends = prop_oneof![
            Just([[0.0, 1.0]; 3]),
            prop::array::uniform3(prop::array::uniform2(0.0f64..=1.0)),
        ];
        (dims, ends, any::<u8>(), 1usize..5, any::<u64>()).prop_map(
            |(dims, ends, filled, grain, seed)| Self {
                dims,
                ends,
                filled,
                grain,
                seed,
            },
        )
    }

    /// The activity, one voxel short of whole blocks along every axis.
    pub(super) fn occupancy(&self) -> Occupancy {
        let mut occupancy = Occupancy::new(self.dims.map(|n| n * 4 - 1), 4);
        for z in 0..self.dims[2] {
            for y in 0..self.dims[1] {
                for x in 0..self.dims[0] {
                    let grain = [x, y, z].map(|i| (i / self.grain) as u64);
                    let hash = grain.iter().fold(self.seed, |h, &i| mix(h ^ i));
                    if hash as u8 <= self.filled {
                        occupancy.set([x, y, z]);
                    }
                }
            }
        }
        occupancy
    }

    /// The region.
    pub(super) fn region(&self) -> [Range<usize>; 3] {
        std::array::from_fn(|a| {
            let [start, end] = self.ends[a].map(|part| (part * self.dims[a] as f64) as usize);
            start.min(end)..end
        })
    }
}

/// The smallest and largest stored number.
pub(super) fn stored_range(volume: &Volume) -> [f64; 2] {
    with_voxels!(&volume.voxels, v => v
    .iter()
    .map(|&s| f64::from(s))
    .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], s| {
        [low.min(s), high.max(s)]
    }))
}

/// A table that shows only values between the `low` and `high` parts of the volume's range.
pub(super) fn band(volume: &Volume, low: f64, high: f64) -> Table {
    let range = stored_range(volume);
    let at = |part: f64| range[0] + part * (range[1] - range[0]);
    let point = |value, opacity| ControlPoint {
        value,
        opacity,
        color: [1.0; 3],
    };
    let points = vec![
        point(at(low), 0.0),
        point(at(0.5 * (low + high)), 0.5),
        point(at(high), 0.0),
    ];
    let function = TransferFunction::new(points, 1.0).expect("points ascend");
    let domain = Domain::new(volume, range, 256).expect("256 is a table size");
    function.bake(&domain, 1.0)
}
