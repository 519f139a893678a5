//! Single rays in double precision.

use super::{Drawing, Renderer, Settings};
use crate::error::{Error, Result};
use crate::reference::{self, Traced};
use crate::skip::Skip;

impl Renderer {
    /// What the reference sees at places (column, row) of the picture, of which whole numbers are the middles of pixels,
    /// before it is rounded to f32.
    ///
    /// # Errors
    /// As [`Self::draw`]; [`Error::Setting`] where this renderer is not the reference, or for beam masks, which know whole
    /// pixels only.
    pub fn trace(&mut self, settings: &Settings, places: &[[f64; 2]]) -> Result<Vec<Traced>> {
        if settings.skip == Skip::BeamMasks {
            return Err(Error::setting(
                "method",
                "beam-masks know whole pixels only",
            ));
        }
        self.with_drawing(settings, |drawing, _| match drawing {
            Drawing::Reference(scene, plan, progress) => {
                reference::trace(scene, plan, places, progress)
            }
            Drawing::Gpu(..) | Drawing::Cpu(..) => Err(Error::setting(
                "backend",
                "only reference traces single rays",
            )),
        })
    }
}
