//! Raw voxels without a header: described by flags, by a sidecar file or by the file's name; and `VolPack`'s .den, raw
//! voxels behind a few shorts.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::Rescale;
use super::header::{Geometry, Header};
use super::payload::{Encoding, Payload, Skip, open_file, read_head};
use super::scalar::{Endian, Scalar};
use crate::error::{Error, Result};

/// How to read a file that does not say it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawLayout {
    /// Voxels along x (fastest), y, z.
    pub dims: [usize; 3],
    /// The type of one voxel.
    #[serde(rename = "type")]
    pub scalar: Scalar,
    /// The order of its bytes.
    pub endian: Endian,
    /// Bytes before the first voxel.
    pub skip_bytes: u64,
    /// Distance of neighbouring voxel centres per axis.
    #[serde(with = "numbers")]
    pub spacing: DVec3,
}

/// A vector as three numbers.
mod numbers {
    use super::{DVec3, Deserialize, Serialize};

    pub(super) fn serialize<S: serde::Serializer>(v: &DVec3, to: S) -> Result<S::Ok, S::Error> {
        v.to_array().serialize(to)
    }

    pub(super) fn deserialize<'d, D: serde::Deserializer<'d>>(from: D) -> Result<DVec3, D::Error> {
        <[f64; 3]>::deserialize(from).map(DVec3::from_array)
    }
}

impl RawLayout {
    /// Little-endian voxels from the first byte on, with unit spacing.
    pub fn new(dims: [usize; 3], scalar: Scalar) -> Self {
        Self {
            dims,
            scalar,
            endian: Endian::Little,
            skip_bytes: 0,
            spacing: DVec3::ONE,
        }
    }
}

/// Dims from text such as `256x256x178`; also used by flags and phantom names.
///
/// # Errors
/// [`Error::Setting`] where it is not three positive numbers.
pub fn parse_dims(text: &str) -> Result<[usize; 3]> {
    dims_in(text).ok_or_else(|| {
        Error::setting(
            "dims",
            format!("\"{}\" is not of the form 256x256x178", text.escape_debug()),
        )
    })
}

fn dims_in(text: &str) -> Option<[usize; 3]> {
    let numbers: Option<Vec<usize>> = text
        .split(['x', 'X'])
        .map(|n| n.parse().ok().filter(|&n| n > 0))
        .collect();
    numbers?.try_into().ok()
}

/// A sidecar's content.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Sidecar {
    dims: [usize; 3],
    #[serde(rename = "type")]
    scalar: String,
    endian: Option<String>,
    #[serde(default)]
    skip_bytes: u64,
    spacing: Option<[f64; 3]>,
}

const MAX_SIDECAR_BYTES: u64 = 1 << 16;

impl Sidecar {
    /// `name.raw.json`, `name.json`, `name.raw.toml`, `name.toml`: the first that is there.
    fn path_of(path: &Path) -> Option<PathBuf> {
        ["json", "toml"].iter().find_map(|extension| {
            let mut appended = OsString::from(path);
            appended.push(format!(".{extension}"));
            [PathBuf::from(appended), path.with_extension(extension)]
                .into_iter()
                .find(|p| p != path && p.is_file())
        })
    }

    fn read(path: &Path) -> Result<RawLayout> {
        let bad = |field: &str, reason: &str| Error::file(path, field, reason.trim());
        let bytes = read_head(path, MAX_SIDECAR_BYTES)?;
        let text = std::str::from_utf8(&bytes).map_err(|_| bad("sidecar", "is not UTF-8 text"))?;
        let sidecar: Self = if path.extension().is_some_and(|e| e == "json") {
            serde_json::from_str(text).map_err(|e| bad("sidecar", &e.to_string()))?
        } else {
            toml::from_str(text).map_err(|e| bad("sidecar", e.message()))?
        };
        let scalar = Scalar::from_name(&sidecar.scalar)
            .ok_or_else(|| bad("type", "is no scalar type that is supported"))?;
        let endian = match &sidecar.endian {
            Some(name) => {
                Endian::from_name(name).ok_or_else(|| bad("endian", "is neither little nor big"))?
            }
            None => Endian::Little,
        };
        Ok(RawLayout {
            dims: sidecar.dims,
            scalar,
            endian,
            skip_bytes: sidecar.skip_bytes,
            spacing: sidecar.spacing.map_or(DVec3::ONE, DVec3::from_array),
        })
    }
}

/// The layout that a file's name tells, as in `foot_256x256x178_uint8.raw` or `head_64x64x93_i16le.raw`.
fn layout_from_name(path: &Path) -> Option<RawLayout> {
    let stem = path.file_stem()?.to_str()?.to_ascii_lowercase();
    let words = || stem.split(['_', '-', '.', ' ']);
    let dims = words().find_map(dims_in)?;
    let (scalar, endian) = words().find_map(|word| {
        let (name, endian) = if let Some(name) = word.strip_suffix("be") {
            (name, Endian::Big)
        } else {
            (word.strip_suffix("le").unwrap_or(word), Endian::Little)
        };
        // "double" ends like a byte order.
        Scalar::from_name(word)
            .map(|scalar| (scalar, Endian::Little))
            .or_else(|| Scalar::from_name(name).map(|scalar| (scalar, endian)))
    })?;
    Some(RawLayout {
        endian,
        ..RawLayout::new(dims, scalar)
    })
}

/// What a file without any known header is read as.
pub(super) fn header(path: &Path, layout: Option<&RawLayout>) -> Result<Header> {
    let layout = match (layout, Sidecar::path_of(path)) {
        (Some(layout), _) => layout.clone(),
        (None, Some(sidecar)) => Sidecar::read(&sidecar)?,
        (None, None) => layout_from_name(path).ok_or_else(|| {
            Error::file(
                path,
                "format",
                "is none of NRRD, MetaImage, NIfTI; raw voxels need their dims and type from flags, from a sidecar \
                 (.json, .toml) or from the name, as in name_256x256x178_uint8.raw",
            )
        })?,
    };
    if !layout.spacing.cmpgt(DVec3::ZERO).all() || !layout.spacing.is_finite() {
        return Err(Error::file(
            path,
            "spacing",
            "must be three positive numbers",
        ));
    }
    let (_, len) = open_file(path)?;
    let voxels = layout
        .dims
        .iter()
        .try_fold(layout.scalar.bytes() as u64, |n, &d| {
            n.checked_mul(d as u64)
        })
        .and_then(|n| n.checked_add(layout.skip_bytes));
    // With no header to trust, dims that do not fit the file to the byte are wrong, and so would the picture be.
    if voxels != Some(len) {
        let [x, y, z] = layout.dims;
        return Err(Error::file(
            path,
            "dims",
            format!(
                "{x}x{y}x{z} voxels of {} after {} bytes do not make up the file's {len} bytes",
                layout.scalar.name(),
                layout.skip_bytes
            ),
        ));
    }
    Ok(described(path, &layout))
}

fn described(path: &Path, layout: &RawLayout) -> Header {
    Header {
        path: path.to_owned(),
        sizes_field: "dims",
        sizes: layout.dims.map(|d| d as u64).to_vec(),
        scalar: layout.scalar,
        endian: layout.endian,
        payload: Payload {
            path: path.to_owned(),
            start: 0,
            line_skip: 0,
            skip: Skip::Bytes(layout.skip_bytes),
            encoding: Encoding::Raw,
        },
        geometry: Geometry {
            spacing: layout.spacing,
            ..Geometry::UNIT
        },
        rescale: Rescale::IDENTITY,
        warnings: Vec::new(),
    }
}

/// Bytes of a .den header: 29 shorts and the number of voxels.
const DEN_HEADER_BYTES: usize = 62;

/// The header of a `VolPack` .den file of unsigned bytes (version 1), in either byte order.
///
/// There is no magic number: a file is one if its version is 1 and its own size, its map's dims and its map's length
/// all agree.
pub(super) fn den_header(path: &Path, head: &[u8], len: u64) -> Option<Header> {
    let head = head.first_chunk::<DEN_HEADER_BYTES>()?;
    for endian in [Endian::Little, Endian::Big] {
        let short = |i: usize| {
            let bytes = [head[2 * i], head[2 * i + 1]];
            match endian {
                Endian::Little => u16::from_le_bytes(bytes),
                Endian::Big => u16::from_be_bytes(bytes),
            }
        };
        // Version; then min, max and size of the original, the extracted part and the map; then the warps.
        let dims = [25, 26, 27].map(|i| usize::from(short(i)));
        let length = [head[58], head[59], head[60], head[61]];
        let length = match endian {
            Endian::Little => u32::from_le_bytes(length),
            Endian::Big => u32::from_be_bytes(length),
        };
        let voxels: u64 = dims.iter().map(|&d| d as u64).product();
        if short(0) == 1
            && voxels > 0
            && voxels == u64::from(length)
            && voxels + DEN_HEADER_BYTES as u64 == len
        {
            let layout = RawLayout {
                skip_bytes: DEN_HEADER_BYTES as u64,
                ..RawLayout::new(dims, Scalar::U8)
            };
            return Some(described(path, &layout));
        }
    }
    None
}
