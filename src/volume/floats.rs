//! Float voxels as they come: not always finite.

use super::{Volume, convert};
use crate::error::{Error, Result};

impl Volume {
    /// These numbers in place of the voxels, treated as those of a file: what is not finite becomes the smallest finite
    /// number and is counted in a warning.
    ///
    /// # Errors
    /// [`Error::Setting`] where there are not as many as the volume has voxels, or none is finite.
    pub fn with_floats(mut self, numbers: Vec<f32>) -> Result<Self> {
        if numbers.len() != self.len() {
            let reason = format!("{} numbers for {} voxels", numbers.len(), self.len());
            return Err(Error::setting("voxels", reason));
        }
        let (voxels, warnings) = convert::finite(numbers.into())
            .ok_or_else(|| Error::setting("voxels", "none is a finite number"))?;
        self.voxels = voxels;
        self.warnings.extend(warnings);
        Ok(self)
    }
}
