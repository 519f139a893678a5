//! Parsers of single values. Each error says what was expected.

use std::fmt;
use std::str::FromStr;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use glam::DVec3;
use hollowcast::measure::compare::NamedStep;
use hollowcast::output::linear_from_srgb;
use hollowcast::render::MethodChoice;
use hollowcast::skip::{METHODS, Skip};

/// One of the library's named choices; an unknown name is answered with those that there are.
pub(super) fn named<T: Copy + Send + Sync + 'static>(
    all: &'static [T],
    name: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(all.iter().map(|&t| name(t))).map(move |given| {
        all.iter()
            .copied()
            .find(|&t| name(t) == given)
            .expect("clap has checked the name")
    })
}

/// A skipping method, explained in the help text by its row of the table.
pub(super) fn method() -> impl TypedValueParser<Value = Skip> {
    let values = METHODS
        .iter()
        .map(|m| PossibleValue::new(m.name).help(m.summary));
    PossibleValuesParser::new(values)
        .map(|given| Skip::from_name(&given).expect("clap has checked the name"))
}

/// A skipping method, or `auto`.
pub(super) fn method_or_auto() -> impl TypedValueParser<Value = MethodChoice> {
    let auto = PossibleValue::new(MethodChoice::Auto.name())
        .help("what promises to take least time for this picture on this adapter");
    let methods = METHODS
        .iter()
        .map(|m| PossibleValue::new(m.name).help(m.summary));
    PossibleValuesParser::new([auto].into_iter().chain(methods))
        .map(|given| MethodChoice::from_name(&given).expect("clap has checked the name"))
}

/// Width and height: `640x480`, or `512` for both.
pub(super) fn size(text: &str) -> Result<[u32; 2], String> {
    const MOST: u32 = 16384;
    let (width, height) = text.split_once(['x', 'X']).unwrap_or((text, text));
    let edge = |s: &str| s.parse().ok().filter(|n| (1..=MOST).contains(n));
    match (edge(width), edge(height)) {
        (Some(width), Some(height)) => Ok([width, height]),
        _ => Err(format!("expected WIDTHxHEIGHT, each 1 to {MOST}")),
    }
}

/// A distance of samples, in voxels or (with `u`) in parts of the longest box edge.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Step {
    text: String,
    number: f64,
    in_edges: bool,
}

impl Step {
    /// So many voxels.
    pub(super) fn voxels(number: f64) -> Self {
        Self {
            text: number.to_string(),
            number,
            in_edges: false,
        }
    }
}

impl FromStr for Step {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (number, in_edges) = match text.strip_suffix('u') {
            Some(number) => (number, true),
            None => (text, false),
        };
        match number.parse() {
            Ok(number) if number > 0.0 && f64::is_finite(number) => Ok(Self {
                text: text.to_owned(),
                number,
                in_edges,
            }),
            _ => Err("expected a positive number of voxels (0.5), or of parts of the longest box edge (0.002u)".to_owned()),
        }
    }
}

impl fmt::Display for Step {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl Step {
    /// The step in a box of these edges (local units, which are voxels of the smallest spacing).
    pub(super) fn in_box(&self, extent: DVec3) -> NamedStep {
        let unit = if self.in_edges {
            extent.max_element()
        } else {
            1.0
        };
        NamedStep {
            name: self.text.clone(),
            voxels: self.number * unit,
        }
    }
}

/// Opacity at which a ray stops; `off` (or 1): never.
pub(super) fn ert(text: &str) -> Result<f32, String> {
    if text == "off" {
        return Ok(1.0);
    }
    text.parse()
        .ok()
        .filter(|t| (0.0..=1.0).contains(t))
        .ok_or_else(|| "expected an opacity from 0 to 1, or off".to_owned())
}

/// What stands behind the picture, in linear light; `None`: nothing, the picture stays transparent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Background(pub(super) Option<[f32; 3]>);

impl FromStr for Background {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let hex = match text {
            "none" => return Ok(Self(None)),
            "black" => "000000",
            "white" => "ffffff",
            _ => text.strip_prefix('#').unwrap_or(text),
        };
        let digits = hex.len() == 6 && hex.bytes().all(|b| b.is_ascii_hexdigit());
        let number = u32::from_str_radix(hex, 16)
            .ok()
            .filter(|_| digits)
            .ok_or("expected none, black, white or an sRGB colour as #rrggbb")?;
        let channel = |shift: u32| {
            let encoded = f64::from(number >> shift & 255) / 255.0;
            linear_from_srgb(encoded) as f32
        };
        Ok(Self(Some([channel(16), channel(8), channel(0)])))
    }
}

/// Three comma-separated values.
fn three<T>(text: &str, parse: impl Fn(&str) -> Option<T>) -> Option<[T; 3]> {
    let parts: Vec<T> = text.split(',').map(parse).collect::<Option<_>>()?;
    parts.try_into().ok()
}

/// Voxels along x, y, z: `256x256x178` or `256,256,178`.
pub(super) fn dims(text: &str) -> Result<[usize; 3], String> {
    three(&text.replace('x', ","), |s| {
        s.parse().ok().filter(|&n| n > 0)
    })
    .ok_or_else(|| "expected three positive numbers of voxels, as 256x256x178".to_owned())
}

/// Three finite numbers.
pub(super) fn vector(text: &str) -> Result<[f64; 3], String> {
    three(text, |s| {
        s.trim().parse().ok().filter(|n| f64::is_finite(*n))
    })
    .ok_or_else(|| "expected three numbers, as 1,1,2.5".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_count_in_voxels_or_in_edges() {
        let extent = DVec3::new(100.0, 250.0, 50.0);
        let voxels = |s: &str| s.parse::<Step>().unwrap().in_box(extent).voxels;
        assert_eq!(voxels("0.5"), 0.5);
        assert_eq!(voxels("0.002u"), 0.5);
        for bad in ["", "u", "0", "-1", "nan", "inf", "1v"] {
            assert!(bad.parse::<Step>().is_err(), "{bad}");
        }
    }

    #[test]
    fn backgrounds_are_given_encoded_and_used_linear() {
        let linear = |s: &str| s.parse::<Background>().unwrap().0;
        assert_eq!(linear("none"), None);
        assert_eq!(linear("white"), Some([1.0; 3]));
        let [r, g, b] = linear("#bc8000").unwrap();
        assert!((r - 0.5029).abs() < 1e-4 && (g - 0.2159).abs() < 1e-4 && b == 0.0);
        for bad in ["red", "#fff", "#12345g", "+12345"] {
            assert!(bad.parse::<Background>().is_err(), "{bad}");
        }
    }

    #[test]
    fn sizes_and_dims() {
        assert_eq!(size("640x480"), Ok([640, 480]));
        assert_eq!(size("96"), Ok([96, 96]));
        assert!(size("0x5").is_err() && size("5x").is_err() && size("99999").is_err());
        assert_eq!(dims("4x5x6"), Ok([4, 5, 6]));
        assert!(dims("4x5").is_err() && dims("4x5x0").is_err());
    }
}
