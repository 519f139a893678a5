//! Single rays in double precision.

use std::sync::Arc;

use super::{Drawing, Renderer, Settings};
use crate::error::{Error, Result};
use crate::reference::{self, Traced};
use crate::skip::Skip;
use crate::transfer::TransferFunction;
use crate::volume::Volume;

impl Renderer {
    /// What is drawn: volume and transfer function.
    ///
    /// # Errors
    /// [`Error::Setting`] where one was not set.
    pub fn scene(&self) -> Result<(&Arc<Volume>, &TransferFunction)> {
        let unset = |field| Error::setting(field, "none was set");
        let volume = self.volume.as_ref().ok_or_else(|| unset("volume"))?;
        let transfer = self.transfer.as_ref().ok_or_else(|| unset("tf"))?;
        Ok((volume, transfer))
    }

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
