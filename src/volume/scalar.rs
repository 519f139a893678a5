//! The number types that files hold: more than a [`super::Volume`] keeps.

use bytemuck::Pod;
use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};

/// The type of one number in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Scalar {
    /// 8 bits unsigned.
    U8,
    /// 8 bits signed.
    I8,
    /// 16 bits unsigned.
    U16,
    /// 16 bits signed.
    I16,
    /// 32 bits unsigned.
    U32,
    /// 32 bits signed.
    I32,
    /// 64 bits unsigned.
    U64,
    /// 64 bits signed.
    I64,
    /// 16-bit float.
    F16,
    /// 32-bit float.
    F32,
    /// 64-bit float.
    F64,
}

/// Every type, with the name that reports use first and then what files and users call it.
///
/// The long names are those of the NRRD format definition (teem.sourceforge.net/nrrd/format.html, "type").
const NAMES: &[(Scalar, &[&str])] = &[
    (
        Scalar::U8,
        &["uint8", "u8", "unsigned char", "uchar", "uint8_t"],
    ),
    (Scalar::I8, &["int8", "i8", "signed char", "int8_t"]),
    (
        Scalar::U16,
        &[
            "uint16",
            "u16",
            "unsigned short",
            "ushort",
            "unsigned short int",
            "uint16_t",
        ],
    ),
    (
        Scalar::I16,
        &[
            "int16",
            "i16",
            "short",
            "short int",
            "signed short",
            "signed short int",
            "int16_t",
        ],
    ),
    (
        Scalar::U32,
        &["uint32", "u32", "unsigned int", "uint", "uint32_t"],
    ),
    (
        Scalar::I32,
        &["int32", "i32", "int", "signed int", "int32_t"],
    ),
    (
        Scalar::U64,
        &[
            "uint64",
            "u64",
            "unsigned long long",
            "ulonglong",
            "unsigned long long int",
            "uint64_t",
        ],
    ),
    (
        Scalar::I64,
        &[
            "int64",
            "i64",
            "long long",
            "longlong",
            "long long int",
            "signed long long",
            "signed long long int",
            "int64_t",
        ],
    ),
    (Scalar::F16, &["float16", "f16", "half"]),
    (Scalar::F32, &["float32", "f32", "float"]),
    (Scalar::F64, &["float64", "f64", "double"]),
];

impl Scalar {
    /// Bytes per number.
    pub fn bytes(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 | Self::F16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::U64 | Self::I64 | Self::F64 => 8,
        }
    }

    /// The name used by files, flags and reports, such as `uint8` or `float32`.
    pub fn name(self) -> &'static str {
        NAMES
            .iter()
            .find(|(scalar, _)| *scalar == self)
            .map_or("", |(_, names)| names[0])
    }

    /// The type of this name, in any of the spellings that users and NRRD files have.
    pub fn from_name(name: &str) -> Option<Self> {
        NAMES
            .iter()
            .find(|(_, names)| names.iter().any(|n| n.eq_ignore_ascii_case(name)))
            .map(|&(scalar, _)| scalar)
    }
}

impl std::str::FromStr for Scalar {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        Self::from_name(name).ok_or_else(|| {
            Error::setting(
                "type",
                format!(
                    "\"{name}\" is none of uint8, int8, uint16, int16, uint32, int32, uint64, int64, float16, \
                     float32, float64"
                ),
            )
        })
    }
}

/// The order of a number's bytes in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Endian {
    /// Lowest byte first.
    Little,
    /// Highest byte first.
    Big,
}

impl Endian {
    /// This machine's order.
    pub const NATIVE: Self = if cfg!(target_endian = "big") {
        Self::Big
    } else {
        Self::Little
    };

    /// The name used by flags.
    pub fn name(self) -> &'static str {
        match self {
            Self::Little => "little",
            Self::Big => "big",
        }
    }

    /// `little` or `big`.
    pub fn from_name(name: &str) -> Option<Self> {
        match name.to_ascii_lowercase().as_str() {
            "little" | "le" => Some(Self::Little),
            "big" | "be" => Some(Self::Big),
            _ => None,
        }
    }
}

impl std::str::FromStr for Endian {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        Self::from_name(name).ok_or_else(|| {
            Error::setting("endian", format!("\"{name}\" is neither little nor big"))
        })
    }
}

macro_rules! as_text {
    ($type:ty) => {
        impl From<$type> for String {
            fn from(value: $type) -> Self {
                value.name().to_owned()
            }
        }

        impl TryFrom<String> for $type {
            type Error = Error;

            fn try_from(name: String) -> Result<Self> {
                name.parse()
            }
        }
    };
}
as_text!(Scalar);
as_text!(Endian);

/// A number as it lies in a file.
pub(super) trait Element: Pod + Send + Sync {
    /// The number with its bytes turned round.
    fn swapped(self) -> Self;
    /// The number that a text file spells.
    fn parse(text: &str) -> Option<Self>;
}

macro_rules! elements {
    ($($integer:ty),*; $($float:ty),*) => {
        $(impl Element for $integer {
            fn swapped(self) -> Self {
                self.swap_bytes()
            }
            fn parse(text: &str) -> Option<Self> {
                text.parse().ok()
            }
        })*
        $(impl Element for $float {
            fn swapped(self) -> Self {
                Self::from_bits(self.to_bits().swap_bytes())
            }
            fn parse(text: &str) -> Option<Self> {
                text.parse().ok()
            }
        })*
    };
}
elements!(u8, i8, u16, i16, u32, i32, u64, i64; f32, f64);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_names_one_type_and_every_type_names_itself() {
        for (i, (scalar, names)) in NAMES.iter().enumerate() {
            assert_eq!(Scalar::from_name(scalar.name()), Some(*scalar));
            for name in *names {
                assert!(NAMES[..i].iter().all(|(_, other)| !other.contains(name)));
                assert_eq!(name.parse::<Scalar>().ok(), Some(*scalar));
            }
        }
        assert!("block".parse::<Scalar>().is_err());
    }
}
