//! Float voxels as they come: not always finite, nor of a size that f32 arithmetic can handle.

use rayon::prelude::*;

use super::{Rescale, Volume, Voxels, convert};
use crate::error::{Error, Result};

/// Magnitudes of the largest voxel between which nothing that is computed of voxels in f32 overflows or is flushed to zero:
/// differences of two of them, and table entries per stored unit.
const MANAGEABLE: std::ops::RangeInclusive<f32> = 1.0 / TWO_TO_64..=TWO_TO_64;
const TWO_TO_64: f32 = (1_u128 << 64) as f32;

impl Volume {
    /// These numbers in place of the voxels, treated as those of a file: what is not finite becomes the smallest finite
    /// number and is counted in a warning; huge and tiny numbers are stored by another power of two, which the rescale
    /// takes back.
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
        Ok(self.in_range_of_f32())
    }

    /// With float voxels whose largest magnitude is beyond what f32 arithmetic can handle divided by a power of two, so that
    /// it lies between 1 and 2; data values stay what they were. Exact, but for numbers 2^-126 of the largest.
    pub(super) fn in_range_of_f32(self) -> Self {
        let Voxels::F32(store) = &self.voxels else {
            return self;
        };
        let largest = store.par_iter().map(|v| v.abs()).reduce(|| 0.0, f32::max);
        if largest == 0.0 || MANAGEABLE.contains(&largest) {
            return self;
        }
        let unit = f64::from(largest).log2().floor().exp2();
        let rescale = Rescale {
            slope: self.rescale.slope * unit,
            ..self.rescale
        };
        if !rescale.slope.is_normal() {
            return self;
        }
        let scaled: Vec<f32> = store
            .par_iter()
            .map(|&v| (f64::from(v) / unit) as f32)
            .collect();
        Self {
            rescale,
            voxels: Voxels::F32(scaled.into()),
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::phantom;

    #[test]
    fn huge_and_tiny_floats_keep_their_values_and_get_stored_numbers_that_arithmetic_can_handle() {
        for numbers in [
            [3e38, -3e38, 1.0, 0.0],
            [1e-39, 2e-40, 0.0, -1e-41],
            [1e-30, -1e-31, 0.0, 5e-31],
            [1.5, -0.25, 1e-40, 0.0],
        ] {
            let volume = phantom::make("empty", [2, 2, 1]).unwrap();
            let volume = volume.with_floats(numbers.to_vec()).unwrap();
            let Voxels::F32(stored) = &volume.voxels else {
                panic!("floats stay floats")
            };
            for (&stored, &number) in stored.iter().zip(&numbers) {
                assert!(stored.abs() <= TWO_TO_64);
                let value = volume.rescale.value_from_stored(f64::from(stored));
                let off = (value - f64::from(number)).abs();
                // 2^-126 of the largest may go.
                assert!(off <= f64::from(numbers[0]) * 1e-37, "{number}: {value}");
            }
        }
    }

    #[test]
    fn what_is_not_finite_is_replaced_and_counted_and_numbers_must_be_as_many_as_voxels() {
        let volume = || phantom::make("empty", [2, 1, 1]).unwrap();
        let mended = volume().with_floats(vec![f32::NAN, 2.0]).unwrap();
        assert_eq!(mended.warnings.len(), 1);
        assert_eq!(
            bytemuck::cast_slice::<u8, f32>(mended.voxels.as_bytes()),
            [2.0, 2.0]
        );
        assert!(volume().with_floats(vec![f32::NAN; 2]).is_err());
        assert!(volume().with_floats(vec![1.0; 3]).is_err());
    }
}
