//! Who draws a hazard.

use super::eye_rays;
use super::scenery::Frame;
use crate::error::Result;
use crate::render::{Renderer, Settings};
use crate::sample::{Classification, Sampler};
use crate::scene::Picture;
use crate::skip::{METHODS, Skip};
use crate::volume::Volume;

/// A way to draw that is held against box.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Contestant {
    /// A method.
    Method(Skip),
    /// Box through the adapter's filter, in place of exact interpolation.
    Filter,
    /// Box with voxels looked up before they are interpolated, in place of after.
    PreClassified,
    /// Box on the processor with lengths in f32 from the eye, in place of from a plane before the box.
    EyeRays,
}

impl Contestant {
    /// All of them, box first.
    pub fn all() -> impl Iterator<Item = Self> {
        let others = [Self::Filter, Self::PreClassified, Self::EyeRays];
        METHODS
            .iter()
            .filter(|m| !m.is_limit)
            .map(|m| Self::Method(m.skip))
            .chain(others)
    }

    /// The name used by reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Method(skip) => skip.method().name,
            Self::Filter => "hardware-filter",
            Self::PreClassified => "pre-classified",
            Self::EyeRays => "f32-from-eye",
        }
    }

    /// Whether its pictures must be bit-identical to box's.
    pub fn is_lossless(self) -> bool {
        match self {
            Self::Method(skip) => skip.method().lossless,
            Self::Filter | Self::PreClassified | Self::EyeRays => false,
        }
    }

    /// Whether it can draw on this renderer.
    pub fn is_on(self, renderer: &Renderer) -> bool {
        match self {
            Self::Method(skip) => renderer.has(skip),
            Self::Filter | Self::PreClassified => renderer.info().backend == "gpu",
            Self::EyeRays => renderer.info().backend == "cpu",
        }
    }

    /// The settings that it draws a frame with; `None` where it does so by itself.
    pub(super) fn settings(self, frame: &Frame) -> Option<Settings> {
        match self {
            Self::Method(skip) => Some(Settings {
                skip,
                ..frame.settings
            }),
            Self::Filter => Some(Settings {
                sampler: Some(Sampler::Hardware),
                ..frame.settings
            }),
            Self::PreClassified => Some(Settings {
                classification: Classification::Pre,
                ..frame.settings
            }),
            Self::EyeRays => None,
        }
    }

    /// Its picture of a frame of the volume that the renderer has.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub(super) fn draw(
        self,
        renderer: &mut Renderer,
        volume: &Volume,
        frame: &Frame,
    ) -> Result<Picture> {
        match self.settings(frame) {
            Some(settings) => {
                renderer.set_transfer(frame.transfer.clone());
                Ok(renderer.render(&settings)?.picture)
            }
            None => eye_rays::draw(volume, frame),
        }
    }
}
