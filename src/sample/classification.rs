//! When a sample gets its colour: after voxels are interpolated, before, or for a whole interval at once.

use crate::error::{Error, Result};

/// The choice of classification. Each has a WGSL twin in `shaders/sample/`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub enum Classification {
    /// Values are interpolated and then looked up in the table.
    #[default]
    Post,
    /// Voxels are looked up once, and their colours are interpolated. Layers thinner than the way from one voxel's value
    /// to the next one's are lost.
    Pre,
    /// Two values, at both ends of the interval between two samples, are looked up in a table of all pairs, each entry of
    /// which holds what all values between add up to (Engel, Kraus & Ertl 2001).
    PreIntegrated,
}

impl Classification {
    /// All classifications, the default first.
    pub const ALL: &[Self] = &[Self::Post, Self::Pre, Self::PreIntegrated];

    /// The name used by flags and reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Post => "post",
            Self::Pre => "pre",
            Self::PreIntegrated => "pre-integrated",
        }
    }

    /// The file in `shaders/sample/`.
    pub fn shader(self) -> &'static str {
        match self {
            Self::Post => "post",
            Self::Pre => "pre",
            Self::PreIntegrated => "pre_integrated",
        }
    }

    /// How far a sample reaches along its ray to both sides, in steps ([`crate::lattice::RayFrame::reach`]).
    pub fn reach(self) -> f64 {
        match self {
            Self::Post | Self::Pre => 0.0,
            Self::PreIntegrated => 0.5,
        }
    }

    /// Checks that a backend has this classification.
    ///
    /// # Errors
    /// [`Error::Setting`] that names the backends that do.
    pub fn check_backend(self, backend: &str) -> Result<()> {
        if self == Self::Post || backend != "cpu" {
            return Ok(());
        }
        Err(Error::setting(
            "classification",
            format!(
                "the {backend} backend has post only; gpu, reference have {}",
                self.name()
            ),
        ))
    }
}
