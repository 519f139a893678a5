//! WHAT is done with the samples of a ray.
//!
//! Each mode has a WGSL twin of the same name in `shaders/mode/`: `init`, `add` (one sample), `done` (may the ray stop?)
//! and `finish` (the pixel).

pub mod emission_absorption;

use std::ops::RangeInclusive;

use crate::transfer::Table;

/// The choice of mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Mode {
    /// Emission and absorption by a transfer function, front to back.
    EmissionAbsorption,
}

impl Mode {
    /// All modes.
    pub const ALL: &[Self] = &[Self::EmissionAbsorption];

    /// The name used by flags, files and shaders.
    pub fn name(self) -> &'static str {
        match self {
            Self::EmissionAbsorption => "emission-absorption",
        }
    }

    /// The name of its WGSL twin.
    pub fn shader(self) -> &'static str {
        match self {
            Self::EmissionAbsorption => "emission_absorption",
        }
    }

    /// Whether a block whose samples have table coordinates in `range` can contribute to any picture in this mode.
    ///
    /// `false` must mean that every sample of the block contributes exactly nothing.
    pub fn is_active(self, table: &Table, range: RangeInclusive<f64>) -> bool {
        match self {
            Self::EmissionAbsorption => table.is_visible(range),
        }
    }
}
