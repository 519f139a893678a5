//! Transfer functions from what a user writes: a preset's name, a shorthand or a TOML file, and back to TOML.

use std::path::Path;

use serde::Deserialize;

use super::preset::{PRESETS, warm_ramp};
use super::{ControlPoint, TransferFunction};
use crate::error::{Error, Result};
use crate::text_file::{self, WRITTEN_BYTES};
use crate::volume::Statistics;

/// A file's content.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default = "one_voxel")]
    reference_length_voxels: f64,
    points: Vec<Point>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Point {
    value: f64,
    opacity: f64,
    color: [f64; 3],
}

fn one_voxel() -> f64 {
    1.0
}

impl TransferFunction {
    /// The transfer function that a user asks for: a preset's name (see [`super::PRESETS`]), a shorthand
    /// `ramp:LOW:HIGH:OPACITY` (data values, opacity per voxel), the text of a TOML file itself (which begins with one of
    /// its fields), or the path of one.
    ///
    /// # Errors
    /// [`Error::Setting`] where it is none of these or out of range; [`Error::Io`], [`Error::File`] for a file that
    /// cannot be read or is not right.
    pub fn from_spec(spec: &str, statistics: &Statistics) -> Result<Self> {
        if let Some(preset) = PRESETS.iter().find(|p| p.name == spec) {
            return preset.transfer_function(statistics);
        }
        if let Some(ramp) = spec.strip_prefix("ramp:") {
            return from_ramp(ramp);
        }
        if ["points", "reference_length_voxels"]
            .iter()
            .any(|field| spec.starts_with(field) && spec.contains('='))
        {
            return Self::from_toml(spec);
        }
        let path = Path::new(spec);
        if !path.exists() && path.extension().is_none() {
            let names: Vec<&str> = PRESETS.iter().map(|p| p.name).collect();
            return Err(Error::setting(
                "transfer function",
                format!(
                    "\"{}\" is none of {}, no ramp:LOW:HIGH:OPACITY and no file",
                    spec.escape_debug(),
                    names.join(", ")
                ),
            ));
        }
        Self::from_file(path)
    }

    /// Reads a TOML file.
    ///
    /// # Errors
    /// [`Error::Io`] where it cannot be read, [`Error::File`] naming the field that is wrong.
    pub fn from_file(path: &Path) -> Result<Self> {
        let text = text_file::read(path, WRITTEN_BYTES)?;
        Self::from_toml(&text).map_err(|e| e.in_file(path))
    }

    /// Parses a TOML file's text.
    ///
    /// # Errors
    /// [`Error::Setting`] naming the line or field that is wrong.
    pub fn from_toml(text: &str) -> Result<Self> {
        let file: File = toml::from_str(text).map_err(|e| {
            let field = match e.span() {
                Some(span) => {
                    let before = text.get(..span.start).unwrap_or_default();
                    format!("line {}", before.matches('\n').count() + 1)
                }
                None => "transfer function".into(),
            };
            Error::setting(field, e.message().trim().replace('\n', " "))
        })?;
        let points = file.points.into_iter().map(|p| ControlPoint {
            value: p.value,
            opacity: p.opacity,
            color: p.color,
        });
        Self::new(points.collect(), file.reference_length_voxels)
    }

    /// The TOML text that [`Self::from_toml`] reads the same function from.
    pub fn to_toml(&self) -> String {
        use std::fmt::Write as _;
        let mut text = format!(
            "reference_length_voxels = {:?}\npoints = [\n",
            self.reference_length_voxels
        );
        for p in &self.points {
            let [r, g, b] = p.color;
            // Writing to a string cannot fail. {:?} prints the shortest text that reads back as the same number.
            let _ = writeln!(
                text,
                "    {{ value = {:?}, opacity = {:?}, color = [{r:?}, {g:?}, {b:?}] }},",
                p.value, p.opacity
            );
        }
        text + "]\n"
    }
}

/// `LOW:HIGH:OPACITY`.
fn from_ramp(ramp: &str) -> Result<TransferFunction> {
    let bad = || {
        Error::setting(
            "ramp",
            format!(
                "\"{}\" is not of the form LOW:HIGH:OPACITY with LOW < HIGH, as in ramp:40:255:0.3",
                ramp.escape_debug()
            ),
        )
    };
    let numbers: Vec<f64> = ramp
        .split(':')
        .map(|n| n.parse().map_err(|_| bad()))
        .collect::<Result<_>>()?;
    match numbers[..] {
        [low, high, opacity] if low < high && (high - low).is_finite() => {
            TransferFunction::new(warm_ramp(low, high, opacity).to_vec(), 1.0)
        }
        _ => Err(bad()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::phantom;

    fn from_spec(spec: &str) -> Result<TransferFunction> {
        let volume = phantom::make("sphere", [16; 3])?;
        TransferFunction::from_spec(spec, &Statistics::of(&volume))
    }

    #[test]
    fn a_ramp_rises_evenly_from_nothing() {
        let tf = from_spec("ramp:40:255:0.3").unwrap();
        assert_eq!(tf.at(0.0).1, 0.0);
        assert_eq!(tf.at(40.0).1, 0.0);
        assert_eq!(tf.at(255.0).1, 0.3);
        for value in [41.0, 100.0, 147.5, 200.0] {
            assert!((tf.at(value).1 - 0.3 * (value - 40.0) / 215.0).abs() < 1e-15);
        }
        for bad in [
            "ramp:",
            "ramp:1:2",
            "ramp:2:1:0.3",
            "ramp:a:2:0.3",
            "ramp:0:inf:0.3",
            "ramp:0:nan:0.3",
            "ramp:1:2:3",
        ] {
            assert!(from_spec(bad).unwrap_err().is_bad_input(), "{bad}");
        }
    }

    #[test]
    fn what_is_written_as_toml_reads_back_the_same() {
        for spec in ["ramp:-1e-3:255:0.3", "translucent", "surface", "grey"] {
            let tf = from_spec(spec).unwrap();
            assert_eq!(TransferFunction::from_toml(&tf.to_toml()).unwrap(), tf);
            assert_eq!(from_spec(&tf.to_toml()).unwrap(), tf);
        }
    }

    #[test]
    fn errors_are_one_line_that_names_file_and_field() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("tf.toml");
        for (text, field) in [
            (
                "points = [{ value = 1, opacity = 2.0, color = [0, 0, 0] }]",
                "points[0].opacity",
            ),
            ("points = []", "points"),
            ("\npoint = 3\npoints = []", "line 2: unknown field"),
            (
                "points = [{ value = 1, opacity = 0.5, colour = [0, 0, 0] }]",
                "line 1: unknown field",
            ),
            (
                "points = [{ value = 1, opacity = 0.5, color = [0, 0] }]",
                "line 1: ",
            ),
            (
                "reference_length_voxels = 0\npoints = [{ value = 1, opacity = 0.5, color = [0, 0, 0] }]",
                "reference_length_voxels",
            ),
            ("points = [", "line 1: "),
        ] {
            std::fs::write(&path, text).unwrap();
            let error = from_spec(path.to_str().unwrap()).unwrap_err();
            let line = error.to_string();
            assert!(error.is_bad_input() && !line.contains('\n'), "{line}");
            assert!(
                line.contains(path.to_str().unwrap()) && line.contains(field),
                "{line}"
            );
        }
        assert!(
            from_spec("transluscent")
                .unwrap_err()
                .to_string()
                .contains("translucent")
        );
        assert!(from_spec("missing.toml").unwrap_err().is_bad_input());
    }
}
