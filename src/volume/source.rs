//! Which volume, and how much of it: what is read, and what is done to it before anything else.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::{RawLayout, Volume, load};
use crate::error::Result;

/// A volume as the command names it, with the flags that say how it is read.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Source {
    /// A file, or `phantom:NAME:SIZE`.
    pub volume: String,
    /// Keeps only these voxels.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub crop: Option<Crop>,
    /// Then averages so many voxels along each axis into one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub downsample: Option<u32>,
    /// Then pads to a cube with the smallest value.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub pad_cube: bool,
    /// Reads the file as raw voxels, whatever it looks like.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub raw: Option<RawLayout>,
}

impl Source {
    /// A volume that is taken as it is.
    pub fn new(volume: &str) -> Self {
        Self {
            volume: volume.to_owned(),
            ..Self::default()
        }
    }

    /// Reads the volume and cuts it to what is asked for.
    ///
    /// # Errors
    /// As [`load`]; [`crate::Error::Setting`] where there is nothing to crop or to average.
    pub fn load(&self) -> Result<Volume> {
        let mut volume = load(&self.volume, self.raw.as_ref())?;
        if let Some(crop) = &self.crop {
            volume = volume.crop(&crop.ranges(volume.dims))?;
        }
        if let Some(n) = self.downsample {
            volume = volume.downsample(n as usize)?;
        }
        if self.pad_cube {
            volume = volume.pad_cube()?;
        }
        Ok(volume)
    }
}

/// Half-open voxel ranges of the three axes; an open end is the volume's. As text: `0:128,20:200,:`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Crop([(usize, Option<usize>); 3]);

impl Crop {
    /// The ranges in a volume of these dims.
    pub fn ranges(&self, dims: [usize; 3]) -> [Range<usize>; 3] {
        std::array::from_fn(|a| self.0[a].0..self.0[a].1.unwrap_or(dims[a]))
    }
}

impl FromStr for Crop {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let range = |s: &str| {
            let (from, to) = s.split_once(':')?;
            let from = if from.is_empty() {
                0
            } else {
                from.parse().ok()?
            };
            let to = if to.is_empty() {
                None
            } else {
                Some(to.parse().ok()?)
            };
            to.is_none_or(|to| to > from).then_some((from, to))
        };
        let ranges: Option<Vec<_>> = text.split(',').map(range).collect();
        ranges
            .and_then(|ranges| ranges.try_into().ok())
            .map(Self)
            .ok_or_else(|| {
                "expected FROM:TO per axis, TO excluded, as 0:128,20:200,: for all of z".to_owned()
            })
    }
}

impl TryFrom<String> for Crop {
    type Error = String;

    fn try_from(text: String) -> std::result::Result<Self, String> {
        text.parse()
    }
}

impl fmt::Display for Crop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, (from, to)) in self.0.iter().enumerate() {
            let comma = if i > 0 { "," } else { "" };
            write!(f, "{comma}{from}:")?;
            if let Some(to) = to {
                write!(f, "{to}")?;
            }
        }
        Ok(())
    }
}

impl From<Crop> for String {
    fn from(crop: Crop) -> Self {
        crop.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::{Endian, Scalar};

    #[test]
    fn crops_are_ranges_whose_ends_may_be_open() {
        let crop: Crop = "1:3,:,2:".parse().unwrap();
        assert_eq!(crop.ranges([9, 8, 7]), [1..3, 0..8, 2..7]);
        assert_eq!(crop.to_string().parse(), Ok(crop));
        for bad in ["3:3,:,:", "1:2,:", "1,2,3"] {
            assert!(bad.parse::<Crop>().is_err(), "{bad}");
        }
    }

    #[test]
    fn a_source_is_read_as_its_flags_say_and_kept_as_text() {
        let source = Source {
            crop: Some("1:,:,:8".parse().unwrap()),
            downsample: Some(2),
            pad_cube: true,
            ..Source::new("phantom:pot:12")
        };
        assert_eq!(source.load().unwrap().dims, [6; 3]);
        let raw = Source {
            raw: Some(RawLayout {
                endian: Endian::Big,
                skip_bytes: 7,
                ..RawLayout::new([3, 4, 5], Scalar::U16)
            }),
            ..source
        };
        let text = toml::to_string(&raw).unwrap();
        assert_eq!(toml::from_str::<Source>(&text).unwrap(), raw);
    }
}
