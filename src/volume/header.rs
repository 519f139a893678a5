//! What a file's header says, whatever its format, and the volume that follows from it.

use std::path::PathBuf;

use glam::{DMat3, DVec3};

use super::convert;
use super::payload::Payload;
use super::scalar::{Element, Endian, Scalar};
use super::store::Store;
use super::{MAX_DIM, Rescale, Volume, Voxels};
use crate::error::{Error, Result};

/// A header, understood.
#[derive(Debug)]
pub(super) struct Header {
    /// The file that errors name.
    pub path: PathBuf,
    /// What the format calls the number of voxels per axis.
    pub sizes_field: &'static str,
    /// Voxels per axis, the fastest first: space, then time and the like.
    pub sizes: Vec<u64>,
    /// The type in the file.
    pub scalar: Scalar,
    /// Its byte order.
    pub endian: Endian,
    /// Where the voxels lie.
    pub payload: Payload,
    /// Place in the world.
    pub geometry: Geometry,
    /// What stored numbers mean.
    pub rescale: Rescale,
    /// What was noticed so far.
    pub warnings: Vec<String>,
}

/// A grid's place in the world.
#[derive(Debug, Clone, Copy)]
pub(super) struct Geometry {
    /// Distance of voxel centres per axis.
    pub spacing: DVec3,
    /// Centre of the first voxel.
    pub origin: DVec3,
    /// Unit vectors of the grid axes.
    pub direction: DMat3,
}

impl Geometry {
    /// A grid along the world's axes.
    pub(super) const UNIT: Self = Self {
        spacing: DVec3::ONE,
        origin: DVec3::ZERO,
        direction: DMat3::IDENTITY,
    };

    /// From the step of each grid axis in the world; `None` for axes that the file does not place.
    ///
    /// What cannot be used (zero, not finite, two axes alike) is replaced and stated in `warnings`.
    pub(super) fn from_steps(
        steps: [Option<DVec3>; 3],
        origin: DVec3,
        warnings: &mut Vec<String>,
    ) -> Self {
        let usable = steps.map(|s| s.filter(|v| v.is_finite() && v.length() > 0.0));
        if steps
            .iter()
            .zip(&usable)
            .any(|(s, u)| s.is_some() && u.is_none())
        {
            warnings
                .push("an axis has a zero or infinite spacing: taken as its neighbours'".into());
        }
        let known = || usable.iter().flatten().map(|v| v.length());
        let fallback = known().fold(f64::INFINITY, f64::min);
        let fallback = if fallback.is_finite() { fallback } else { 1.0 };
        let spacing = DVec3::from_array(usable.map(|s| s.map_or(fallback, DVec3::length)));
        let units = usable.map(|s| s.map(DVec3::normalize));
        let direction = match units {
            [Some(x), Some(y), Some(z)] => DMat3::from_cols(x, y, z),
            [Some(x), Some(y), None] => DMat3::from_cols(x, y, x.cross(y).normalize_or_zero()),
            [Some(x), None, None] => {
                let y = x.any_orthonormal_vector();
                DMat3::from_cols(x, y, x.cross(y))
            }
            _ => DMat3::IDENTITY,
        };
        let direction = if direction.determinant().abs() > 1e-6 {
            direction
        } else {
            warnings
                .push("the axes' directions do not span space: taken as the world's axes".into());
            DMat3::IDENTITY
        };
        let origin = if origin.is_finite() {
            origin
        } else {
            warnings.push("the origin is not finite: taken as 0".into());
            DVec3::ZERO
        };
        Self {
            spacing,
            origin,
            direction,
        }
    }

    /// From spacings alone, in the file's order; missing ones follow the others.
    pub(super) fn from_spacings(spacings: &[f64], warnings: &mut Vec<String>) -> Self {
        let axis = |i: usize| {
            let spacing = spacings.get(i)?;
            // NaN is how NRRD says that an axis has no spacing.
            (!spacing.is_nan()).then(|| DMat3::IDENTITY.col(i) * spacing.abs())
        };
        Self {
            direction: DMat3::IDENTITY,
            ..Self::from_steps([axis(0), axis(1), axis(2)], DVec3::ZERO, warnings)
        }
    }
}

/// All numbers of a file in its own type, before any conversion.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stored {
    /// Numbers per axis, the fastest first; time and the like after space.
    pub shape: Vec<usize>,
    /// Their type.
    pub scalar: Scalar,
    /// Their bytes, little-endian.
    pub bytes: Vec<u8>,
}

impl Header {
    /// Voxels of the first volume, voxels of all, and the first volume's dims.
    fn counts(&self) -> Result<(usize, usize, [usize; 3])> {
        let bad = |reason: String| Err(Error::file(&self.path, self.sizes_field, reason));
        if self.sizes.is_empty() {
            return bad("names no axis".into());
        }
        if self.sizes.contains(&0) {
            return bad("an axis has no voxels; each needs at least one".into());
        }
        let mut dims = [1; 3];
        for (dim, &size) in dims.iter_mut().zip(&self.sizes) {
            if size > MAX_DIM as u64 {
                return bad(format!(
                    "{size} voxels along one axis; at most {MAX_DIM} are supported"
                ));
            }
            *dim = size as usize;
        }
        let all = self
            .sizes
            .iter()
            .try_fold(1_u64, |n, &s| n.checked_mul(s))
            .filter(|n| n.checked_mul(8).is_some_and(|b| isize::try_from(b).is_ok()));
        let Some(all) = all else {
            return bad("the product of the sizes exceeds what a machine can address".into());
        };
        Ok((dims.iter().product(), all as usize, dims))
    }

    /// The first volume of the file.
    pub(super) fn into_volume(mut self) -> Result<Volume> {
        let (first, all, dims) = self.counts()?;
        let bytes = all as u64 * self.scalar.bytes() as u64;
        let surplus = self.payload.raw_surplus(bytes)?;
        if surplus > 0 {
            self.warnings.push(format!(
                "{}: {surplus} bytes follow the declared voxels and were left out",
                self.payload.path.display()
            ));
        }
        if all > first {
            self.warnings.push(format!(
                "the file holds {} volumes: the first is taken",
                all / first
            ));
        }
        let voxels = self.voxels(first, all == first)?;
        let volume = Volume {
            name: self.path.display().to_string(),
            dims,
            spacing: self.geometry.spacing,
            origin: self.geometry.origin,
            direction: self.geometry.direction,
            rescale: self.rescale,
            voxels,
            warnings: self.warnings,
        };
        Ok(volume.in_range_of_f32())
    }

    fn store<T: Element>(&self, count: usize, whole: bool) -> Result<Store<T>> {
        Ok(match self.payload.map(count, self.endian)? {
            Some(mapped) => mapped,
            None => Store::Owned(self.payload.read(count, self.endian, whole)?),
        })
    }

    fn voxels(&mut self, n: usize, whole: bool) -> Result<Voxels> {
        let (endian, name) = (self.endian, self.scalar.name());
        let converted = match self.scalar {
            Scalar::U8 => return Ok(Voxels::U8(self.store(n, whole)?)),
            Scalar::I8 => return Ok(Voxels::I8(self.store(n, whole)?)),
            Scalar::U16 => return Ok(Voxels::U16(self.store(n, whole)?)),
            Scalar::I16 => return Ok(Voxels::I16(self.store(n, whole)?)),
            Scalar::F32 => convert::finite(self.store(n, whole)?),
            Scalar::F16 => convert::from_f16(&self.payload.read(n, endian, whole)?),
            Scalar::U32 => {
                convert::from_integers(&self.payload.read::<u32>(n, endian, whole)?, name)
            }
            Scalar::I32 => {
                convert::from_integers(&self.payload.read::<i32>(n, endian, whole)?, name)
            }
            Scalar::U64 => {
                convert::from_integers(&self.payload.read::<u64>(n, endian, whole)?, name)
            }
            Scalar::I64 => {
                convert::from_integers(&self.payload.read::<i64>(n, endian, whole)?, name)
            }
            Scalar::F64 => convert::from_f64(&self.payload.read(n, endian, whole)?),
        };
        let (voxels, warnings) = converted.ok_or_else(|| {
            Error::file(&self.payload.path, "data", "no voxel is a finite number")
        })?;
        self.warnings.extend(warnings);
        Ok(voxels)
    }

    fn little_endian<T: Element>(&self, n: usize) -> Result<Vec<u8>> {
        let mut numbers = self.payload.read::<T>(n, self.endian, true)?;
        if Endian::NATIVE == Endian::Big {
            for number in &mut numbers {
                *number = number.swapped();
            }
        }
        Ok(bytemuck::cast_slice(&numbers).to_vec())
    }

    /// All numbers of the file as they are stored.
    pub(super) fn into_stored(self) -> Result<Stored> {
        let (_, all, _) = self.counts()?;
        let shape = self.sizes.iter().map(|&s| s as usize).collect();
        let bytes = match self.scalar {
            Scalar::U8 => self.payload.read(all, self.endian, true)?,
            Scalar::I8 => self.little_endian::<i8>(all)?,
            Scalar::U16 | Scalar::F16 => self.little_endian::<u16>(all)?,
            Scalar::I16 => self.little_endian::<i16>(all)?,
            Scalar::U32 => self.little_endian::<u32>(all)?,
            Scalar::I32 => self.little_endian::<i32>(all)?,
            Scalar::U64 => self.little_endian::<u64>(all)?,
            Scalar::I64 => self.little_endian::<i64>(all)?,
            Scalar::F32 => self.little_endian::<f32>(all)?,
            Scalar::F64 => self.little_endian::<f64>(all)?,
        };
        Ok(Stored {
            shape,
            scalar: self.scalar,
            bytes,
        })
    }
}
