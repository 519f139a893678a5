//! NIfTI-1 and -2: one file (.nii, .nii.gz) or a pair (.hdr and .img, either gzipped).
//!
//! Written here because the crate `nifti` (0.18) reserves what the header declares before it has seen any data, and
//! does not read NIfTI-2. Layouts: nifti1.h and nifti2.h (nifti.nimh.nih.gov).

use std::io::Read;
use std::path::{Path, PathBuf};

use glam::{DMat3, DQuat, DVec3};

use super::header::{Geometry, Header};
use super::payload::{Encoding, Payload, Skip, open_file, read_head};
use super::scalar::{Endian, Scalar};
use super::{GZIP_MAGIC, Rescale};
use crate::error::{Error, Result};

const NIFTI1_BYTES: usize = 348;
const NIFTI2_BYTES: usize = 540;

/// The header's bytes, unpacked, and how to read them.
struct Fields<'a> {
    path: &'a Path,
    bytes: Vec<u8>,
    endian: Endian,
    version: u8,
    /// Whether voxels follow in the same file.
    single: bool,
}

/// The first bytes of a file, unpacked where it is gzip. What cannot be unpacked is no header of ours.
fn unpacked_head(path: &Path) -> Result<Vec<u8>> {
    let head = read_head(path, 1 << 12)?;
    if !head.starts_with(&GZIP_MAGIC) {
        return Ok(head);
    }
    let (file, _) = open_file(path)?;
    let mut bytes = Vec::new();
    let unpacked = flate2::read::GzDecoder::new(file)
        .take(NIFTI2_BYTES as u64)
        .read_to_end(&mut bytes);
    match unpacked {
        Ok(_) => Ok(bytes),
        Err(e) => Err(Error::file(
            path,
            "header",
            format!("the gzip data are damaged or cut short ({e})"),
        )),
    }
}

impl<'a> Fields<'a> {
    /// `None` where the file has no `NIfTI` header.
    fn read(path: &'a Path) -> Result<Option<Self>> {
        let bytes = unpacked_head(path)?;
        let Some(&size) = bytes.first_chunk::<4>() else {
            return Ok(None);
        };
        for endian in [Endian::Little, Endian::Big] {
            let size = match endian {
                Endian::Little => u32::from_le_bytes(size),
                Endian::Big => u32::from_be_bytes(size),
            };
            let (version, magic) = match size {
                348 if bytes.len() >= NIFTI1_BYTES => (1, &bytes[344..348]),
                540 if bytes.len() >= NIFTI2_BYTES => (2, &bytes[4..8]),
                _ => continue,
            };
            let single = match magic {
                b"n+1\0" | b"n+2\0" => true,
                b"ni1\0" | b"ni2\0" => false,
                _ => continue,
            };
            return Ok(Some(Self {
                path,
                bytes,
                endian,
                version,
                single,
            }));
        }
        Ok(None)
    }

    fn array<const N: usize>(&self, offset: usize) -> [u8; N] {
        let mut bytes = [0; N];
        bytes.copy_from_slice(&self.bytes[offset..offset + N]);
        if self.endian == Endian::Big {
            bytes.reverse();
        }
        bytes
    }

    fn i16(&self, offset: usize) -> i16 {
        i16::from_le_bytes(self.array(offset))
    }

    /// A number that is an f32 in version 1 and an f64 in version 2, by its offset in each.
    fn float(&self, [v1, v2]: [usize; 2]) -> f64 {
        if self.version == 1 {
            f64::from(f32::from_le_bytes(self.array(v1)))
        } else {
            f64::from_le_bytes(self.array(v2))
        }
    }

    /// The i-th of an array of such numbers.
    fn float_at(&self, [v1, v2]: [usize; 2], i: usize) -> f64 {
        self.float([v1 + 4 * i, v2 + 8 * i])
    }

    fn dim(&self, i: usize) -> i64 {
        if self.version == 1 {
            i64::from(self.i16(40 + 2 * i))
        } else {
            i64::from_le_bytes(self.array(16 + 8 * i))
        }
    }

    fn code(&self, [v1, v2]: [usize; 2]) -> i32 {
        if self.version == 1 {
            i32::from(self.i16(v1))
        } else {
            i32::from_le_bytes(self.array(v2))
        }
    }

    fn error(&self, field: &str, reason: impl Into<String>) -> Error {
        Error::file(self.path, field, reason)
    }
}

/// Whether the file has a `NIfTI` header that can be read.
pub(super) fn is_nifti(path: &Path) -> bool {
    Fields::read(path).is_ok_and(|fields| fields.is_some())
}

/// The other file of a pair: `name.hdr` for `name.img` and the other way round, gzipped or not.
fn partner(path: &Path, extension: &str) -> Option<PathBuf> {
    let name = path.file_name()?.to_str()?;
    let stem = name.strip_suffix(".gz").unwrap_or(name);
    let (stem, _) = stem.rsplit_once('.')?;
    ["", ".gz"]
        .iter()
        .map(|gz| path.with_file_name(format!("{stem}.{extension}{gz}")))
        .find(|candidate| candidate.is_file())
}

/// Reads a header, given any file of the volume.
pub(super) fn header(path: &Path) -> Result<Header> {
    if let Some(fields) = Fields::read(path)? {
        return from_fields(&fields);
    }
    if let Some(header_path) = partner(path, "hdr").filter(|p| p != path)
        && let Some(fields) = Fields::read(&header_path)?
        && !fields.single
    {
        return from_fields(&fields);
    }
    Err(Error::file(
        path,
        "sizeof_hdr, magic",
        "neither this file nor a .hdr beside it has a NIfTI-1 or NIfTI-2 header",
    ))
}

fn from_fields(fields: &Fields) -> Result<Header> {
    let mut warnings = Vec::new();
    let axes = fields.dim(0);
    if !(1..=7).contains(&axes) {
        return Err(fields.error("dim[0]", format!("{axes} dimensions; 1 to 7 are possible")));
    }
    let sizes = (1..=axes as usize)
        .map(|i| {
            u64::try_from(fields.dim(i))
                .map_err(|_| fields.error(&format!("dim[{i}]"), "is negative"))
        })
        .collect::<Result<Vec<_>>>()?;
    let code = if fields.version == 1 {
        fields.i16(70)
    } else {
        fields.i16(12)
    };
    let scalar = match code {
        2 => Scalar::U8,
        4 => Scalar::I16,
        8 => Scalar::I32,
        16 => Scalar::F32,
        64 => Scalar::F64,
        256 => Scalar::I8,
        512 => Scalar::U16,
        768 => Scalar::U32,
        1024 => Scalar::I64,
        1280 => Scalar::U64,
        _ => {
            let what = match code {
                32 | 1792 | 2048 => " (complex)",
                128 | 2304 => " (colour)",
                1536 => " (float128)",
                _ => "",
            };
            return Err(fields.error(
                "datatype",
                format!("{code}{what} is no scalar type that is supported"),
            ));
        }
    };
    let rescale = rescale(fields, &mut warnings);
    Ok(Header {
        path: fields.path.to_owned(),
        sizes_field: "dim",
        geometry: geometry(fields, &sizes, &mut warnings),
        sizes,
        scalar,
        endian: fields.endian,
        payload: payload(fields)?,
        rescale,
        warnings,
    })
}

fn rescale(fields: &Fields, warnings: &mut Vec<String>) -> Rescale {
    let (slope, intercept) = (fields.float([112, 176]), fields.float([116, 184]));
    if slope == 0.0 {
        // By definition: no scaling.
        return Rescale::IDENTITY;
    }
    if slope.is_finite() && intercept.is_finite() {
        return Rescale { slope, intercept };
    }
    // NaN is what some writers put where there is none.
    if !slope.is_nan() || !(intercept.is_nan() || intercept == 0.0) {
        warnings.push(
            "scl_slope or scl_inter is not finite: stored numbers are taken as values".into(),
        );
    }
    Rescale::IDENTITY
}

fn payload(fields: &Fields) -> Result<Payload> {
    let offset = if fields.version == 1 {
        fields.float([108, 0])
    } else {
        i64::from_le_bytes(fields.array(168)) as f64
    };
    let header_bytes = if fields.version == 1 {
        NIFTI1_BYTES
    } else {
        NIFTI2_BYTES
    };
    let least = if fields.single { header_bytes } else { 0 };
    if !(offset >= least as f64 && offset < 2_f64.powi(62)) {
        return Err(fields.error(
            "vox_offset",
            format!("{offset} does not lie behind the header's {least} bytes"),
        ));
    }
    let path = if fields.single {
        fields.path.to_owned()
    } else {
        partner(fields.path, "img").ok_or_else(|| {
            fields.error(
                "magic",
                "says that the voxels are in a .img file, and none is beside it",
            )
        })?
    };
    let encoding = if read_head(&path, 2)?.starts_with(&GZIP_MAGIC) {
        Encoding::Gzip
    } else {
        Encoding::Raw
    };
    Ok(Payload {
        path,
        start: 0,
        line_skip: 0,
        skip: Skip::Bytes(offset as u64),
        encoding,
    })
}

/// Grid to world (x to the right, y to the front, z up): the sform where there is one, else the qform, else, as
/// nibabel has it, the pixel sizes about the grid's centre with x running from right to left.
fn geometry(fields: &Fields, sizes: &[u64], warnings: &mut Vec<String>) -> Geometry {
    let pixdim = |i: usize| fields.float_at([76, 104], i);
    let (qform_code, sform_code) = (fields.code([252, 344]), fields.code([254, 348]));
    let place = |steps: [DVec3; 3], origin: DVec3, warnings: &mut Vec<String>| {
        Geometry::from_steps(steps.map(Some), origin, warnings)
    };
    if sform_code > 0 {
        let row = |r: usize, c: usize| fields.float_at([280 + 16 * r, 400 + 32 * r], c);
        let column = |c: usize| DVec3::new(row(0, c), row(1, c), row(2, c));
        return place([column(0), column(1), column(2)], column(3), warnings);
    }
    let spacing = [1, 2, 3].map(|i| pixdim(i).abs());
    if qform_code > 0 {
        let [b, c, d] = [0, 1, 2].map(|i| fields.float_at([256, 352], i));
        let offset = [0, 1, 2].map(|i| fields.float_at([268, 376], i));
        // The quaternion has unit length; rounding may have left its vector part a little long.
        let a = (1.0 - (b * b + c * c + d * d)).max(0.0).sqrt();
        let rotation = DMat3::from_quat(DQuat::from_xyzw(b, c, d, a).normalize());
        let handedness = if pixdim(0) < 0.0 { -1.0 } else { 1.0 };
        return place(
            [
                rotation.col(0) * spacing[0],
                rotation.col(1) * spacing[1],
                rotation.col(2) * spacing[2] * handedness,
            ],
            DVec3::from_array(offset),
            warnings,
        );
    }
    let flipped = DVec3::new(-1.0, 1.0, 1.0);
    let steps = [0, 1, 2].map(|i| DVec3::AXES[i] * flipped * spacing[i]);
    let centre = (0..3)
        .map(|i| steps[i] * (sizes.get(i).copied().unwrap_or(1).max(1) - 1) as f64 * 0.5)
        .sum::<DVec3>();
    place(steps, -centre, warnings)
}
