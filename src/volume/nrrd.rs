//! NRRD, attached and detached (teem.sourceforge.net/nrrd/format.html).

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

/// Keys under which [`super::write_nrrd`] keeps what the format has no field for.
pub(super) const SLOPE_KEY: &str = "rescale slope";
pub(super) const INTERCEPT_KEY: &str = "rescale intercept";

/// Whether a file that starts so is an NRRD.
pub(super) fn is_nrrd(head: &[u8]) -> bool {
    head.starts_with(b"NRRD000")
}

/// A header's lines.
struct Fields<'a> {
    path: &'a Path,
    /// `field: value`, names in lower case.
    values: HashMap<String, String>,
    /// `key:=value`.
    keys: HashMap<String, String>,
    /// Offset of the first byte after the header.
    end: u64,
}

impl Fields<'_> {
    fn read(path: &Path) -> Result<Fields<'_>> {
        let head = read_head(path, MAX_HEADER_BYTES)?;
        let mut values = HashMap::new();
        let mut keys = HashMap::new();
        let mut end = 0;
        for (i, line) in head.split_inclusive(|&b| b == b'\n').enumerate() {
            end += line.len() as u64;
            let line = String::from_utf8_lossy(line);
            let line = line.trim_end_matches(['\n', '\r']);
            if line.is_empty() {
                break;
            }
            if i == 0 || line.starts_with('#') {
                continue;
            }
            // A key may hold ": " and a field's value ":=": whichever comes first tells which line it is.
            let separator = line.find(':').map(|at| (at, line[at..].starts_with(":=")));
            match separator {
                Some((at, true)) => keys.insert(line[..at].into(), line[at + 2..].trim().into()),
                Some((at, false)) => values.insert(
                    line[..at].trim().to_ascii_lowercase(),
                    line[at + 1..].trim().into(),
                ),
                None => {
                    return Err(Error::file(
                        path,
                        format!("line {}", i + 1),
                        "is neither a field (name: value) nor a key (name:=value)",
                    ));
                }
            };
        }
        Ok(Fields {
            path,
            values,
            keys,
            end,
        })
    }

    fn error(&self, field: &str, reason: impl Into<String>) -> Error {
        Error::file(self.path, field, reason)
    }

    /// A field's value, under its name with or without the space.
    fn get(&self, field: &str) -> Option<&str> {
        self.values
            .get(field)
            .or_else(|| self.values.get(&field.replace(' ', "")))
            .map(String::as_str)
    }

    fn required(&self, field: &str) -> Result<&str> {
        self.get(field)
            .ok_or_else(|| self.error(field, "is missing; every NRRD needs it"))
    }

    /// Numbers of a field, separated by blanks.
    fn numbers<T: std::str::FromStr>(&self, field: &str) -> Result<Option<Vec<T>>> {
        let Some(value) = self.get(field) else {
            return Ok(None);
        };
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
            .collect::<Result<_>>()
            .map(Some)
    }

    fn number<T: std::str::FromStr>(&self, field: &str, default: T) -> Result<T> {
        let mut numbers = self.numbers(field)?.unwrap_or_default();
        match numbers.len() {
            0 => Ok(default),
            1 => Ok(numbers.remove(0)),
            _ => Err(self.error(field, "must be one number")),
        }
    }

    /// Vectors of a field, `(x,y,z)` or `none` each.
    fn vectors(&self, field: &str) -> Result<Option<Vec<Option<DVec3>>>> {
        let Some(value) = self.get(field) else {
            return Ok(None);
        };
        let bad = || self.error(field, "must be vectors like (1,0,0), or none");
        let mut rest = value.trim_start();
        let mut vectors = Vec::new();
        while !rest.is_empty() {
            if let Some(after) = rest.strip_prefix("none") {
                vectors.push(None);
                rest = after.trim_start();
                continue;
            }
            let (inside, after) = rest
                .strip_prefix('(')
                .and_then(|r| r.split_once(')'))
                .ok_or_else(bad)?;
            let numbers: Vec<f64> = inside
                .split(',')
                .map(|n| n.trim().parse().map_err(|_| bad()))
                .collect::<Result<_>>()?;
            if numbers.is_empty() || numbers.len() > 3 {
                return Err(self.error(field, "vectors must have one to three numbers"));
            }
            let mut vector = [0.0; 3];
            vector[..numbers.len()].copy_from_slice(&numbers);
            let vector = DVec3::from_array(vector);
            // NaN is the other way to say that an axis does not lie in space.
            vectors.push(Some(vector).filter(|v| !v.is_nan()));
            rest = after.trim_start();
        }
        Ok(Some(vectors))
    }
}

/// Kinds of axes along which a volume extends; all others hold the parts of one value.
const EXTENDING_KINDS: &[&str] = &["domain", "space", "time", "list", "???", "none"];

/// Reads a header, attached or detached.
pub(super) fn header(path: &Path) -> Result<Header> {
    let fields = Fields::read(path)?;
    let mut warnings = Vec::new();
    let dimension: usize = fields
        .required("dimension")?
        .parse()
        .map_err(|_| fields.error("dimension", "is not a number of axes"))?;
    fields.required("sizes")?;
    let mut sizes: Vec<u64> = fields.numbers("sizes")?.unwrap_or_default();
    if sizes.len() != dimension {
        return Err(fields.error(
            "sizes",
            format!("{} numbers for {dimension} dimensions", sizes.len()),
        ));
    }
    let type_name = fields.required("type")?;
    let scalar = Scalar::from_name(type_name).ok_or_else(|| {
        fields.error(
            "type",
            format!(
                "\"{}\" is no scalar type that is supported",
                type_name.escape_debug()
            ),
        )
    })?;
    let encoding_name = fields.required("encoding")?;
    let encoding = match encoding_name.to_ascii_lowercase().as_str() {
        "raw" => Encoding::Raw,
        "gzip" | "gz" => Encoding::Gzip,
        "bzip2" | "bz2" => Encoding::Bzip2,
        "ascii" | "text" | "txt" => Encoding::Text,
        "hex" => Encoding::Hex,
        _ => {
            return Err(fields.error(
                "encoding",
                format!(
                    "\"{}\" is none of raw, gzip, bzip2, ascii, hex",
                    encoding_name.escape_debug()
                ),
            ));
        }
    };
    let endian = match fields.get("endian") {
        Some(name) => Endian::from_name(name)
            .ok_or_else(|| fields.error("endian", "is neither little nor big"))?,
        None if scalar.bytes() == 1 || encoding == Encoding::Text => Endian::NATIVE,
        None => return Err(fields.error("endian", "is missing; types of several bytes need it")),
    };

    let mut steps = fields.vectors("space directions")?;
    let mut spacings: Option<Vec<f64>> = fields.numbers("spacings")?;
    let mut kinds: Option<Vec<String>> = fields.numbers("kinds")?;
    for (field, count) in [
        ("space directions", steps.as_ref().map(Vec::len)),
        ("spacings", spacings.as_ref().map(Vec::len)),
        ("kinds", kinds.as_ref().map(Vec::len)),
    ] {
        if let Some(count) = count.filter(|&count| count != dimension) {
            return Err(fields.error(field, format!("{count} entries for {dimension} dimensions")));
        }
    }
    // A leading axis that does not extend in space holds the parts of each voxel: colour, a vector, a tensor.
    let is_parts = |axis: usize| {
        let kind_says = kinds
            .as_ref()
            .is_some_and(|k| !EXTENDING_KINDS.contains(&k[axis].to_ascii_lowercase().as_str()));
        let step_says = steps
            .as_ref()
            .is_some_and(|s| s[axis].is_none() && s[axis + 1..].iter().any(Option::is_some));
        kind_says || step_says
    };
    if let Some(axis) = (0..dimension).find(|&axis| is_parts(axis)) {
        if sizes[axis] != 1 {
            return Err(fields.error(
                "kinds",
                format!(
                    "axis {} holds {} parts per voxel; only scalar volumes are supported",
                    axis + 1,
                    sizes[axis]
                ),
            ));
        }
        sizes.remove(axis);
        if let Some(steps) = &mut steps {
            steps.remove(axis);
        }
        if let Some(spacings) = &mut spacings {
            spacings.remove(axis);
        }
        if let Some(kinds) = &mut kinds {
            kinds.remove(axis);
        }
    }

    let mut geometry = match (steps, spacings) {
        (Some(steps), _) => Geometry::from_steps(
            std::array::from_fn(|i| steps.get(i).copied().flatten()),
            DVec3::ZERO,
            &mut warnings,
        ),
        (None, Some(spacings)) => Geometry::from_spacings(&spacings, &mut warnings),
        (None, None) => Geometry::UNIT,
    };
    if let Some([Some(origin)]) = fields.vectors("space origin")?.as_deref()
        && origin.is_finite()
    {
        geometry.origin = *origin;
    }

    let key = |name: &str| fields.keys.get(name).and_then(|v| v.parse::<f64>().ok());
    let rescale = match (key(SLOPE_KEY), key(INTERCEPT_KEY)) {
        (Some(slope), Some(intercept))
            if slope.is_finite() && slope != 0.0 && intercept.is_finite() =>
        {
            Rescale { slope, intercept }
        }
        _ => Rescale::IDENTITY,
    };
    let payload = payload(&fields, encoding)?;
    Ok(Header {
        path: path.to_owned(),
        sizes_field: "sizes",
        sizes,
        scalar,
        endian,
        payload,
        geometry,
        rescale,
        warnings,
    })
}

fn payload(fields: &Fields, encoding: Encoding) -> Result<Payload> {
    let skip = match fields.number("byte skip", 0_i64)? {
        -1 => Skip::ToEnd,
        skip if skip >= 0 => Skip::Bytes(skip as u64),
        skip => {
            return Err(fields.error(
                "byte skip",
                format!("{skip} is not allowed; it is -1 (voxels at the file's end) or more"),
            ));
        }
    };
    let line_skip = fields.number("line skip", 0)?;
    let (path, start) = match fields.get("data file") {
        None => (fields.path.to_owned(), fields.end),
        Some(name) if name.starts_with("LIST") || name.contains('%') => {
            return Err(fields.error(
                "data file",
                "voxels in several files are not supported; join them first (unu save)",
            ));
        }
        Some(name) => {
            let beside = fields.path.parent().unwrap_or(Path::new(""));
            (beside.join(name), 0)
        }
    };
    Ok(Payload {
        path,
        start,
        line_skip,
        skip,
        encoding,
    })
}
