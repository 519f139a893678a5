//! WHAT is done with the samples of a ray.
//!
//! Each mode has a WGSL twin of the same name in `shaders/mode/`, which asks for what it needs of a sample: `mode_sample`
//! takes one (its value, or its classified colour, or the gradient around it) into a state of four numbers, `mode_done`
//! tells whether the ray may stop, `mode_finish` makes the pixel. A state of zeros is a ray that has seen nothing, and
//! its pixel is all zero: so a ray that no method launches has the pixel of one whose samples all contributed nothing.
//!
//! A mode carries its own parameters, in data values; [`Parameters`] are the same in table coordinates.

pub mod activity;
mod check;
pub mod cue;
pub mod emission_absorption;
pub mod parameters;
pub mod surface;

use std::ops::RangeInclusive;

use serde::{Deserialize, Serialize};

use crate::transfer::{Domain, Table, threshold};
use crate::volume::Statistics;

pub use activity::Activity;
pub use cue::DepthCue;
pub use parameters::Parameters;
pub use surface::{Light, Lighting};

/// The choice of mode, with its parameters.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Mode {
    /// Emission and absorption by a transfer function, front to back.
    EmissionAbsorption,
    /// Emission and absorption lit by the gradient at each sample.
    Shaded(Lighting),
    /// Emission and absorption without a table: the place in the window is grey value and opacity per voxel (of the
    /// smallest spacing) alike.
    Grey(Window),
    /// White whose opacity is the highest place in the window along the ray.
    Mip(Window),
    /// Black whose opacity is the deepest distance below the window's upper end: on white, the lowest place in it.
    Minip(Window),
    /// White whose opacity is the mean place in the window over all samples inside the box.
    Mean(Window),
    /// The normal of the first surface as colour.
    Normals {
        /// The data value from which on matter is solid.
        iso: f64,
    },
    /// The first surface, lit.
    Phong {
        /// The data value from which on matter is solid.
        iso: f64,
        /// Linear colour of the surface.
        color: [f64; 3],
        /// How it is lit.
        lighting: Lighting,
    },
    /// A translucent surface before a lit one.
    TwoSurfaces {
        /// The outer surface: the same colour everywhere.
        outer: Outer,
        /// The data value from which on the inner surface is solid; above the outer one's.
        iso: f64,
        /// Linear colour of the inner surface.
        color: [f64; 3],
        /// How the inner surface is lit.
        lighting: Lighting,
    },
}

/// Data values between which brightness goes from 0 to 1. Samples below count as 0, those above as 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Window {
    /// Data value of 0.
    pub low: f64,
    /// Data value of 1.
    pub high: f64,
}

/// The outer surface of [`Mode::TwoSurfaces`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Outer {
    /// The data value that it lies at.
    pub iso: f64,
    /// Linear, not premultiplied.
    pub color: [f64; 3],
    /// Above 0, at most 1.
    pub opacity: f64,
}

/// A mode's row in the table that every part of the program reads.
#[derive(Debug)]
pub struct ModeRow {
    /// The name used by flags, files and reports.
    pub name: &'static str,
    /// The file in `shaders/mode/` that draws it.
    pub shader: &'static str,
    /// The backends that have it.
    pub backends: &'static [&'static str],
    /// One line for help texts.
    pub summary: &'static str,
    /// Whether it looks samples up in the transfer function's table.
    pub takes_table: bool,
    /// The mode with parameters that suit data of these statistics.
    pub suited_to: fn(&Statistics) -> Mode,
}

/// All modes, the default first.
pub const MODES: &[ModeRow] = &[
    ModeRow {
        name: "emission-absorption",
        shader: "emission_absorption",
        backends: &["gpu", "cpu", "reference"],
        summary: "colour and opacity by the transfer function, front to back",
        takes_table: true,
        suited_to: |_| Mode::EmissionAbsorption,
    },
    ModeRow {
        name: "shaded",
        shader: "shaded",
        backends: &["gpu", "reference"],
        summary: "the same, lit by the gradient at each sample",
        takes_table: true,
        suited_to: |_| Mode::Shaded(Lighting::default()),
    },
    ModeRow {
        name: "grey",
        shader: "grey",
        backends: &["gpu", "reference"],
        summary: "the value itself is brightness and opacity per voxel",
        takes_table: false,
        suited_to: |s| Mode::Grey(Window::above_background(s)),
    },
    ModeRow {
        name: "mip",
        shader: "mip",
        backends: &["gpu", "cpu", "reference"],
        summary: "the highest value of each ray, as the opacity of white",
        takes_table: false,
        suited_to: |s| Mode::Mip(Window::above_background(s)),
    },
    ModeRow {
        name: "minip",
        shader: "minip",
        backends: &["gpu", "cpu", "reference"],
        summary: "the lowest value of each ray, as the opacity of black: look at it on white",
        takes_table: false,
        suited_to: |s| Mode::Minip(Window::whole(s)),
    },
    ModeRow {
        name: "mean",
        shader: "mean",
        backends: &["gpu", "cpu", "reference"],
        summary: "the mean of each ray inside the box, as the opacity of white",
        takes_table: false,
        suited_to: |s| Mode::Mean(Window::above_background(s)),
    },
    ModeRow {
        name: "normals",
        shader: "normals",
        backends: &["gpu", "reference"],
        summary: "the first surface, its normal as colour",
        takes_table: false,
        suited_to: |s| Mode::Normals {
            iso: iso_above_background(s),
        },
    },
    ModeRow {
        name: "phong",
        shader: "phong",
        backends: &["gpu", "reference"],
        summary: "the first surface, lit",
        takes_table: false,
        suited_to: |s| Mode::Phong {
            iso: iso_above_background(s),
            color: WARM,
            lighting: Lighting::default(),
        },
    },
    ModeRow {
        name: "two-surfaces",
        shader: "two_surfaces",
        backends: &["gpu", "reference"],
        summary: "a translucent surface before a lit one",
        takes_table: false,
        suited_to: |s| {
            let iso = iso_above_background(s);
            Mode::TwoSurfaces {
                outer: Outer {
                    iso,
                    color: WARM,
                    opacity: 0.3,
                },
                iso: (iso + s.value_range()[1].max(iso + 1.0)) * 0.5,
                color: IVORY,
                lighting: Lighting::default(),
            }
        },
    },
];

/// Surfaces, where no colour was asked for.
const WARM: [f64; 3] = [0.9, 0.6, 0.4];
/// What is seen through them.
const IVORY: [f64; 3] = [1.0, 0.95, 0.85];

impl Mode {
    /// This mode's row.
    ///
    /// # Panics
    /// Never: every mode has a row.
    pub fn row(&self) -> &'static ModeRow {
        let name = match self {
            Self::EmissionAbsorption => "emission-absorption",
            Self::Shaded(_) => "shaded",
            Self::Grey(_) => "grey",
            Self::Mip(_) => "mip",
            Self::Minip(_) => "minip",
            Self::Mean(_) => "mean",
            Self::Normals { .. } => "normals",
            Self::Phong { .. } => "phong",
            Self::TwoSurfaces { .. } => "two-surfaces",
        };
        MODES
            .iter()
            .find(|row| row.name == name)
            .expect("every mode has a row")
    }

    /// The name used by flags, files and reports.
    pub fn name(&self) -> &'static str {
        self.row().name
    }

    /// Whether it looks samples up in the transfer function's table.
    pub fn takes_table(&self) -> bool {
        self.row().takes_table
    }

    /// Whether a ray keeps the highest place in the window, so that blocks that lie no higher can be left out.
    pub fn keeps_highest(&self) -> bool {
        matches!(self, Self::Mip(_) | Self::Minip(_))
    }

    /// Whether it looks at gradients.
    pub fn takes_gradients(&self) -> bool {
        matches!(
            self,
            Self::Shaded(_) | Self::Normals { .. } | Self::Phong { .. } | Self::TwoSurfaces { .. }
        )
    }

    /// Whether a block whose samples have table coordinates in `range` can contribute to any picture in this mode.
    ///
    /// `false` must mean that every sample of the block contributes exactly nothing.
    pub fn is_active(&self, table: &Table, range: RangeInclusive<f64>) -> bool {
        self.activity(table.domain()).is_active(table, range)
    }

    /// What makes a block contribute, over values in `domain`.
    pub fn activity(&self, domain: &Domain) -> Activity {
        Activity::of(self, domain)
    }
}

impl Window {
    /// From where the background ends to the highest value.
    pub fn above_background(statistics: &Statistics) -> Self {
        let low = threshold(statistics);
        let [_, high] = statistics.value_range();
        // Of data that are nothing but background, nothing is above it.
        let high = if high > low { high } else { low + 1.0 };
        Self { low, high }
    }

    /// From the lowest to the highest value: what is lowest is background more often than not.
    pub fn whole(statistics: &Statistics) -> Self {
        let [low, high] = statistics.value_range();
        let high = if high > low { high } else { low + 1.0 };
        Self { low, high }
    }
}

/// Half a bin above the highest value that counts as background, so that this one is not solid.
fn iso_above_background(statistics: &Statistics) -> f64 {
    threshold(statistics) + 0.5 * statistics.width * statistics.rescale.slope.abs()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::phantom;

    #[test]
    fn every_row_makes_its_own_mode_with_parameters_in_range() {
        for name in ["pot", "noise", "empty", "full", "ramp"] {
            let statistics = Statistics::of(&phantom::make(name, [12; 3]).unwrap());
            for row in MODES {
                let mode = (row.suited_to)(&statistics);
                assert_eq!(mode.name(), row.name);
                mode.check().unwrap();
            }
        }
    }

    #[test]
    fn what_suits_a_volume_hides_its_background() {
        let statistics = Statistics::of(&phantom::make("pot", [24; 3]).unwrap());
        let window = Window::above_background(&statistics);
        assert!(window.low >= 0.0 && window.low < 100.0 && window.high >= 200.0);
        let empty = Statistics::of(&phantom::make("empty", [4; 3]).unwrap());
        assert!(iso_above_background(&empty) > 0.0);
    }
}
