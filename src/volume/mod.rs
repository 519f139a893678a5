//! Voxels: the [`Volume`], one reader per file format, and phantoms (closed-form test scenes).
//!
//! A volume keeps its voxels as they are stored (u8, i8, u16, i16 or f32; other types are converted at load, with the
//! loss stated in [`Volume::warnings`]) and memory-maps them where the file allows. x varies fastest.

mod convert;
mod edit;
mod enclosed;
mod floats;
mod header;
mod metaimage;
mod nifti;
mod nrrd;
mod nrrd_write;
mod open;
mod payload;
pub mod phantom;
mod raw;
mod reading;
mod scalar;
mod source;
pub mod statistics;
mod store;

pub use enclosed::enclosed_share;
pub use header::Stored;
pub use nrrd_write::{Packing, write_nrrd};
pub use open::{load, open, read_stored};
pub use raw::{RawLayout, parse_dims};
pub use reading::Reading;
pub use scalar::{Endian, Scalar};
pub use source::{Crop, Source};
pub use statistics::{Statistics, empty_share};
pub use store::Store;

use glam::{DMat3, DVec3};

/// The largest number of voxels along one axis.
///
/// Grid coordinates are f32 on the GPU and in the SIMD backend: 2^16 voxels leave them 2^-8 of a voxel.
pub const MAX_DIM: usize = 1 << 16;

const GZIP_MAGIC: [u8; 2] = [0x1f, 0x8b];

/// A regular grid of scalar voxels with its place in the world.
#[derive(Debug)]
pub struct Volume {
    /// Where the volume came from: a path or a phantom's name. For messages and cache keys only.
    pub name: String,
    /// Voxels along x, y, z; each at least 1 and at most [`MAX_DIM`].
    pub dims: [usize; 3],
    /// Distance of neighbouring voxel centres along each grid axis, in the file's unit of length; positive and finite.
    pub spacing: DVec3,
    /// World position of the centre of voxel (0, 0, 0).
    pub origin: DVec3,
    /// Columns are the unit vectors of the grid axes in the world. Kept and reported; pictures are taken in the grid's
    /// own frame.
    pub direction: DMat3,
    /// What a stored number means: `value = slope * stored + intercept`.
    pub rescale: Rescale,
    /// The voxels, x fastest, `dims` in number.
    pub voxels: Voxels,
    /// What was changed or lost while loading, one line each.
    pub warnings: Vec<String>,
}

/// The linear map from stored numbers to data values (`NIfTI`'s `scl_slope` and `scl_inter`).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rescale {
    /// Data value per stored unit; finite and not zero.
    pub slope: f64,
    /// Data value of stored zero; finite.
    pub intercept: f64,
}

impl Rescale {
    /// Stored numbers are data values.
    pub const IDENTITY: Self = Self {
        slope: 1.0,
        intercept: 0.0,
    };

    /// The data value of a stored number.
    pub fn value_from_stored(self, stored: f64) -> f64 {
        self.slope * stored + self.intercept
    }

    /// The stored number of a data value.
    pub fn stored_from_value(self, value: f64) -> f64 {
        (value - self.intercept) / self.slope
    }
}

/// The type a voxel is stored as.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum VoxelType {
    /// 8 bits unsigned.
    U8,
    /// 8 bits signed.
    I8,
    /// 16 bits unsigned.
    U16,
    /// 16 bits signed.
    I16,
    /// 32-bit float; all finite.
    F32,
}

impl VoxelType {
    /// Bytes per voxel.
    pub fn bytes(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::F32 => 4,
        }
    }

    /// The name used by files, flags and reports: `uint8`, `int8`, `uint16`, `int16`, `float32`.
    pub fn name(self) -> &'static str {
        match self {
            Self::U8 => "uint8",
            Self::I8 => "int8",
            Self::U16 => "uint16",
            Self::I16 => "int16",
            Self::F32 => "float32",
        }
    }

    /// The smallest and largest stored number of an integer type.
    pub fn integer_range(self) -> Option<[f64; 2]> {
        match self {
            Self::U8 => Some([0.0, 255.0]),
            Self::I8 => Some([-128.0, 127.0]),
            Self::U16 => Some([0.0, 65535.0]),
            Self::I16 => Some([-32768.0, 32767.0]),
            Self::F32 => None,
        }
    }
}

/// The voxels of a volume, by type.
#[derive(Debug)]
pub enum Voxels {
    /// 8 bits unsigned.
    U8(Store<u8>),
    /// 8 bits signed.
    I8(Store<i8>),
    /// 16 bits unsigned.
    U16(Store<u16>),
    /// 16 bits signed.
    I16(Store<i16>),
    /// 32-bit float.
    F32(Store<f32>),
}

/// Runs `$body` with `$slice` bound to the voxels as a typed slice.
///
/// ```
/// # use hollowcast::{volume::{Volume, Voxels}, with_voxels};
/// # fn largest(volume: &Volume) -> f64 {
/// with_voxels!(&volume.voxels, v => v.iter().map(|&s| f64::from(s)).fold(f64::MIN, f64::max))
/// # }
/// ```
#[macro_export]
macro_rules! with_voxels {
    ($voxels:expr, $slice:ident => $body:expr) => {
        match $voxels {
            $crate::volume::Voxels::U8(store) => {
                let $slice: &[u8] = store;
                $body
            }
            $crate::volume::Voxels::I8(store) => {
                let $slice: &[i8] = store;
                $body
            }
            $crate::volume::Voxels::U16(store) => {
                let $slice: &[u16] = store;
                $body
            }
            $crate::volume::Voxels::I16(store) => {
                let $slice: &[i16] = store;
                $body
            }
            $crate::volume::Voxels::F32(store) => {
                let $slice: &[f32] = store;
                $body
            }
        }
    };
}

impl Voxels {
    /// The type of one voxel.
    pub fn voxel_type(&self) -> VoxelType {
        match self {
            Self::U8(_) => VoxelType::U8,
            Self::I8(_) => VoxelType::I8,
            Self::U16(_) => VoxelType::U16,
            Self::I16(_) => VoxelType::I16,
            Self::F32(_) => VoxelType::F32,
        }
    }

    /// The voxels' bytes in this machine's order.
    pub fn as_bytes(&self) -> &[u8] {
        with_voxels!(self, v => bytemuck::cast_slice(v))
    }
}

impl Volume {
    /// Number of voxels.
    pub fn len(&self) -> usize {
        self.dims.iter().product()
    }

    /// Always false: every axis has a voxel. Here because `len` is.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Bytes of voxel data.
    pub fn bytes(&self) -> usize {
        self.len() * self.voxels.voxel_type().bytes()
    }

    /// The smallest spacing, in the file's unit: the length that rendering calls one voxel.
    pub fn unit_length(&self) -> f64 {
        self.spacing.min_element()
    }

    /// Edges of one voxel in units of the smallest spacing; each at least 1.
    ///
    /// Local coordinates, in which cameras are placed and rays are traced, are `grid * voxel_size`.
    pub fn voxel_size(&self) -> DVec3 {
        self.spacing / self.unit_length()
    }

    /// Edges of the box in local coordinates (units of the smallest spacing): the box is [0, extent].
    pub fn extent(&self) -> DVec3 {
        DVec3::new(
            self.dims[0] as f64,
            self.dims[1] as f64,
            self.dims[2] as f64,
        ) * self.voxel_size()
    }
}
