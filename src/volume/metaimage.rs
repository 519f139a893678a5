//! `MetaImage` (.mha, .mhd), the format of ITK's `MetaIO`.

use std::collections::HashMap;
use std::path::Path;

use glam::DVec3;

use super::Rescale;
use super::header::{Geometry, Header};
use super::payload::{Encoding, Payload, Skip, read_head};
use super::scalar::{Endian, Scalar};
use crate::error::{Error, Result};

/// Longest header that is looked at.
const MAX_HEADER_BYTES: u64 = 1 << 20;

/// Keys that a header may start with.
const FIRST_KEYS: &[&str] = &[
    "ObjectType",
    "ObjectSubType",
    "NDims",
    "Comment",
    "Name",
    "ID",
];

/// Whether a file that starts so is a `MetaImage`: there is no magic number, only a first key of this format.
pub(super) fn is_metaimage(head: &[u8]) -> bool {
    let line = head.split(|&b| b == b'\n').next().unwrap_or_default();
    std::str::from_utf8(line)
        .ok()
        .and_then(|line| line.split_once('='))
        .is_some_and(|(key, _)| FIRST_KEYS.contains(&key.trim()))
}

struct Fields<'a> {
    path: &'a Path,
    values: HashMap<String, String>,
    end: u64,
}

impl Fields<'_> {
    fn read(path: &Path) -> Result<Fields<'_>> {
        let head = read_head(path, MAX_HEADER_BYTES)?;
        let mut values = HashMap::new();
        let mut end = 0;
        for (i, line) in head.split_inclusive(|&b| b == b'\n').enumerate() {
            end += line.len() as u64;
            let line = String::from_utf8_lossy(line);
            if line.trim().is_empty() {
                continue;
            }
            let (key, value) = line.split_once('=').ok_or_else(|| {
                Error::file(
                    path,
                    format!("line {}", i + 1),
                    "is not of the form key = value",
                )
            })?;
            values.insert(key.trim().to_owned(), value.trim().to_owned());
            // By definition the last line of the header.
            if key.trim() == "ElementDataFile" {
                break;
            }
        }
        Ok(Fields { path, values, end })
    }

    fn error(&self, field: &str, reason: impl Into<String>) -> Error {
        Error::file(self.path, field, reason)
    }

    /// The first of these keys that is there, and its value.
    fn any<'k>(&self, keys: &[&'k str]) -> Option<(&'k str, &str)> {
        keys.iter()
            .find_map(|key| self.values.get(*key).map(|v| (*key, v.as_str())))
    }

    fn required(&self, field: &str) -> Result<&str> {
        self.any(&[field])
            .map(|(_, value)| value)
            .ok_or_else(|| self.error(field, "is missing; every MetaImage needs it"))
    }

    fn numbers<T: std::str::FromStr>(&self, field: &str, value: &str) -> Result<Vec<T>> {
        value
            .split_whitespace()
            .map(|word| {
                word.parse().map_err(|_| {
                    self.error(
                        field,
                        format!("\"{}\" is not a number it can be", word.escape_debug()),
                    )
                })
            })
            .collect()
    }

    /// Finite numbers under any of these names, `count` of them.
    fn vector(&self, keys: &[&str], count: usize) -> Result<Option<Vec<f64>>> {
        let Some((key, value)) = self.any(keys) else {
            return Ok(None);
        };
        let numbers = self.numbers::<f64>(key, value)?;
        if numbers.len() == count {
            Ok(Some(numbers))
        } else {
            Err(self.error(
                key,
                format!("{} numbers where {count} are needed", numbers.len()),
            ))
        }
    }

    fn flag(&self, keys: &[&str]) -> bool {
        self.any(keys)
            .is_some_and(|(_, value)| value.eq_ignore_ascii_case("true") || value == "1")
    }
}

/// The sizes are those that `MetaIO` writes: `MET_LONG` has four bytes there.
fn scalar(name: &str) -> Option<Scalar> {
    Some(match name {
        "MET_UCHAR" => Scalar::U8,
        "MET_CHAR" | "MET_ASCII_CHAR" => Scalar::I8,
        "MET_USHORT" => Scalar::U16,
        "MET_SHORT" => Scalar::I16,
        "MET_UINT" | "MET_ULONG" => Scalar::U32,
        "MET_INT" | "MET_LONG" => Scalar::I32,
        "MET_ULONG_LONG" => Scalar::U64,
        "MET_LONG_LONG" => Scalar::I64,
        "MET_FLOAT" => Scalar::F32,
        "MET_DOUBLE" => Scalar::F64,
        _ => return None,
    })
}

/// Reads a header and where its voxels are.
pub(super) fn header(path: &Path) -> Result<Header> {
    let fields = Fields::read(path)?;
    let mut warnings = Vec::new();
    let dimension: usize = fields
        .required("NDims")?
        .parse()
        .ok()
        .filter(|n| (1..=16).contains(n))
        .ok_or_else(|| fields.error("NDims", "must be a number of axes from 1 to 16"))?;
    let sizes: Vec<u64> = fields.numbers("DimSize", fields.required("DimSize")?)?;
    if sizes.len() != dimension {
        return Err(fields.error(
            "DimSize",
            format!("{} numbers for {dimension} dimensions", sizes.len()),
        ));
    }
    let type_name = fields.required("ElementType")?;
    let scalar = scalar(type_name).ok_or_else(|| {
        fields.error(
            "ElementType",
            format!(
                "\"{}\" is no scalar type that is supported",
                type_name.escape_debug()
            ),
        )
    })?;
    if let Some((key, channels)) = fields.any(&["ElementNumberOfChannels"])
        && channels != "1"
    {
        return Err(fields.error(
            key,
            format!(
                "{} parts per voxel; only scalar volumes are supported",
                channels.escape_debug()
            ),
        ));
    }
    let endian = if fields.flag(&["BinaryDataByteOrderMSB", "ElementByteOrderMSB"]) {
        Endian::Big
    } else {
        Endian::Little
    };

    let spacings = fields
        .vector(&["ElementSpacing", "ElementSize"], dimension)?
        .unwrap_or_else(|| vec![1.0; dimension]);
    let axes = fields.vector(
        &["TransformMatrix", "Rotation", "Orientation"],
        dimension * dimension,
    )?;
    let origin = fields.vector(&["Offset", "Position", "Origin"], dimension)?;
    let space = dimension.min(3);
    let in_space = |numbers: &[f64]| {
        DVec3::from_array(std::array::from_fn(|i| {
            if i < space { numbers[i] } else { 0.0 }
        }))
    };
    // The file's rows are the grid axes in the world.
    let step = |i: usize| {
        (i < space).then(|| match &axes {
            Some(axes) => in_space(&axes[i * dimension..]).normalize_or_zero() * spacings[i].abs(),
            None => DVec3::AXES[i] * spacings[i].abs(),
        })
    };
    let geometry = Geometry::from_steps(
        [step(0), step(1), step(2)],
        origin.map_or(DVec3::ZERO, |o| in_space(&o)),
        &mut warnings,
    );
    Ok(Header {
        path: path.to_owned(),
        sizes_field: "DimSize",
        sizes,
        scalar,
        endian,
        payload: payload(&fields)?,
        geometry,
        rescale: Rescale::IDENTITY,
        warnings,
    })
}

fn payload(fields: &Fields) -> Result<Payload> {
    let name = fields.required("ElementDataFile")?;
    let local = name.eq_ignore_ascii_case("LOCAL");
    let (path, start) = if local {
        (fields.path.to_owned(), fields.end)
    } else if name.starts_with("LIST") || name.contains('%') {
        return Err(fields.error(
            "ElementDataFile",
            "voxels in several files are not supported; join them first",
        ));
    } else {
        let beside = fields.path.parent().unwrap_or(Path::new(""));
        (beside.join(name), 0)
    };
    let skip = match fields.any(&["HeaderSize"]) {
        Some((key, value)) => match value.parse::<i64>() {
            Ok(-1) => Skip::ToEnd,
            // Attached voxels follow the header; MetaIO counts its size only for a file apart.
            Ok(skip) if skip >= 0 => Skip::Bytes(if local { 0 } else { skip as u64 }),
            _ => return Err(fields.error(key, "must be -1 (voxels at the file's end) or more")),
        },
        None => Skip::Bytes(0),
    };
    let binary = fields.any(&["BinaryData"]).is_none() || fields.flag(&["BinaryData"]);
    let encoding = if fields.flag(&["CompressedData"]) {
        // zlib by definition; gzip is met too, and tells itself by its first two bytes.
        let (mut file, _) = super::payload::open_file(&path)?;
        let mut magic = [0; 2];
        let read = std::io::Seek::seek(&mut file, std::io::SeekFrom::Start(start))
            .and_then(|_| std::io::Read::read(&mut file, &mut magic));
        read.map_err(|e| Error::io(&path, e))?;
        if magic == super::GZIP_MAGIC {
            Encoding::Gzip
        } else {
            Encoding::Zlib
        }
    } else if binary {
        Encoding::Raw
    } else {
        Encoding::Text
    };
    Ok(Payload {
        path,
        start,
        line_skip: 0,
        skip,
        encoding,
    })
}
