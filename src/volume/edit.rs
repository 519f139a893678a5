//! Smaller and larger volumes from a volume. Each keeps its voxels' places in the world.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::{Volume, Voxels};
use crate::error::{Error, Result};
use crate::with_voxels;

impl Volume {
    /// A volume with the same description and other voxels, the first of which lies at grid position `first` (voxel
    /// centres at whole numbers) of this one.
    fn derived(&self, dims: [usize; 3], spacing: DVec3, first: DVec3, voxels: Voxels) -> Self {
        Self {
            name: self.name.clone(),
            dims,
            spacing,
            origin: self.origin + self.direction * (first * self.spacing),
            direction: self.direction,
            rescale: self.rescale,
            voxels,
            warnings: self.warnings.clone(),
        }
    }

    /// The voxels in these ranges along x, y, z.
    ///
    /// # Errors
    /// [`Error::Setting`] where a range is empty or leaves the volume.
    pub fn crop(&self, ranges: &[Range<usize>; 3]) -> Result<Self> {
        for ((range, &dim), axis) in ranges.iter().zip(&self.dims).zip(["x", "y", "z"]) {
            if range.is_empty() || range.end > dim {
                return Err(Error::setting(
                    "crop",
                    format!(
                        "{axis} from {} to {} is empty or leaves the volume's {dim} voxels",
                        range.start, range.end
                    ),
                ));
            }
        }
        let dims = [ranges[0].len(), ranges[1].len(), ranges[2].len()];
        let voxels = with_voxels!(&self.voxels, v => rows(v, dims, |v, row, y, z| {
            let from = ((z + ranges[2].start) * self.dims[1] + y + ranges[1].start) * self.dims[0];
            row.copy_from_slice(&v[from + ranges[0].start..from + ranges[0].end]);
        }));
        let first = DVec3::from_array([0, 1, 2].map(|i| ranges[i].start as f64));
        Ok(self.derived(dims, self.spacing, first, voxels))
    }

    /// Means over boxes of `n` voxels per axis, rounded for integer types. Where `n` does not divide an axis, its last
    /// boxes are means of the voxels that are left.
    ///
    /// # Errors
    /// [`Error::Setting`] where `n` is 0.
    pub fn downsample(&self, n: usize) -> Result<Self> {
        if n == 0 {
            return Err(Error::setting("downsample", "must be at least 1"));
        }
        let dims = self.dims.map(|d| d.div_ceil(n));
        // An axis shorter than a box has its mean in the axis' middle, not in the box's.
        let first = DVec3::from_array(self.dims.map(|d| (d.min(n) - 1) as f64 * 0.5));
        let voxels = with_voxels!(&self.voxels, v => rows(v, dims, |v, row, y, z| {
            let span = |i: usize, axis: usize| i * n..((i + 1) * n).min(self.dims[axis]);
            let mut sums = vec![0.0; row.len()];
            for z in span(z, 2) {
                for y in span(y, 1) {
                    let from = (z * self.dims[1] + y) * self.dims[0];
                    let line = &v[from..from + self.dims[0]];
                    for (sum, voxels) in sums.iter_mut().zip(line.chunks(n)) {
                        *sum += voxels.iter().map(|&s| f64::from(s)).sum::<f64>();
                    }
                }
            }
            let lines = span(y, 1).len() * span(z, 2).len();
            for (x, (out, sum)) in row.iter_mut().zip(&sums).enumerate() {
                *out = Mean::mean(sum / (lines * span(x, 0).len()) as f64);
            }
        }));
        Ok(self.derived(dims, self.spacing * n as f64, first, voxels))
    }

    /// The volume in a cube of its longest dimension, centred (the odd voxel goes to the upper side), filled up with
    /// its smallest stored number: how Yu et al. 2016 bring the 256x256x178 teapot to 256^3.
    ///
    /// # Errors
    /// [`Error::Limit`] where there is not enough memory.
    pub fn pad_cube(&self) -> Result<Self> {
        let edge = self.dims.into_iter().max().unwrap_or(1);
        let dims = [edge; 3];
        if edge
            .checked_pow(3)
            .and_then(|n| n.checked_mul(self.voxels.voxel_type().bytes()))
            .is_none_or(|bytes| Vec::<u8>::new().try_reserve_exact(bytes).is_err())
        {
            return Err(Error::Limit(format!(
                "{}: memory for a cube of {edge} voxels per edge could not be had; crop or downsample first",
                self.name
            )));
        }
        let before = self.dims.map(|d| (edge - d) / 2);
        let low = super::statistics::stored_range(self)[0];
        let voxels = with_voxels!(&self.voxels, v => rows(v, dims, |v, row, y, z| {
            row.fill(Mean::mean(low));
            let (Some(y), Some(z)) = (y.checked_sub(before[1]), z.checked_sub(before[2])) else {
                return;
            };
            if y < self.dims[1] && z < self.dims[2] {
                let from = (z * self.dims[1] + y) * self.dims[0];
                row[before[0]..before[0] + self.dims[0]]
                    .copy_from_slice(&v[from..from + self.dims[0]]);
            }
        }));
        let first = DVec3::from_array(before.map(|b| -(b as f64)));
        Ok(self.derived(dims, self.spacing, first, voxels))
    }
}

/// A stored number from a mean of stored numbers.
trait Mean: Copy + Default + Send + Sync {
    fn mean(mean: f64) -> Self;
}

macro_rules! means {
    ($($type:ident: $variant:ident, $mean:expr;)*) => {$(
        impl Mean for $type {
            fn mean(mean: f64) -> Self {
                ($mean)(mean) as $type
            }
        }
        impl From<Vec<$type>> for Voxels {
            fn from(voxels: Vec<$type>) -> Self {
                Self::$variant(voxels.into())
            }
        }
    )*};
}
means! {
    u8: U8, f64::round;
    i8: I8, f64::round;
    u16: U16, f64::round;
    i16: I16, f64::round;
    f32: F32, |mean| mean;
}

/// Voxels made row by row in parallel, `row(source, voxels, y, z)`.
fn rows<T: Mean>(
    source: &[T],
    dims: [usize; 3],
    row: impl Fn(&[T], &mut [T], usize, usize) + Sync,
) -> Voxels
where
    Voxels: From<Vec<T>>,
{
    let mut voxels = vec![T::default(); dims.iter().product()];
    voxels
        .par_chunks_mut(dims[0])
        .enumerate()
        .for_each(|(i, line)| row(source, line, i % dims[1], i / dims[1]));
    voxels.into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::phantom;
    use glam::DMat3;

    fn oblique(dims: [usize; 3]) -> Volume {
        Volume {
            spacing: DVec3::new(0.5, 1.0, 2.0),
            origin: DVec3::new(10.0, -3.0, 7.0),
            direction: DMat3::from_rotation_z(0.3),
            ..phantom::make("noise", dims).unwrap()
        }
    }

    fn world(volume: &Volume, grid: [usize; 3]) -> DVec3 {
        let at = DVec3::from_array(grid.map(|i| i as f64));
        volume.origin + volume.direction * (at * volume.spacing)
    }

    fn voxel(volume: &Volume, [x, y, z]: [usize; 3]) -> f64 {
        with_voxels!(&volume.voxels, v => f64::from(v[(z * volume.dims[1] + y) * volume.dims[0] + x]))
    }

    #[test]
    fn cropped_and_padded_voxels_keep_their_value_and_place() {
        let whole = oblique([9, 6, 5]);
        let crop = whole.crop(&[2..7, 1..6, 3..4]).unwrap();
        assert_eq!(crop.dims, [5, 5, 1]);
        let padded = whole.pad_cube().unwrap();
        assert_eq!(padded.dims, [9; 3]);
        for [x, y, z] in [[0, 0, 0], [4, 4, 0], [2, 3, 0]] {
            let from = [x + 2, y + 1, z + 3];
            assert_eq!(voxel(&crop, [x, y, z]), voxel(&whole, from));
            assert!((world(&crop, [x, y, z]) - world(&whole, from)).length() < 1e-12);
            let to = [from[0], from[1] + 1, from[2] + 2];
            assert_eq!(voxel(&padded, to), voxel(&whole, from));
            assert!((world(&padded, to) - world(&whole, from)).length() < 1e-12);
        }
        let low = crate::volume::statistics::stored_range(&whole)[0];
        assert_eq!(voxel(&padded, [4, 0, 4]), low);
        assert_eq!(voxel(&padded, [4, 4, 8]), low);
    }

    #[test]
    fn a_crop_that_leaves_the_volume_is_refused() {
        let whole = oblique([4, 4, 4]);
        for ranges in [[0..5, 0..4, 0..4], [0..4, 2..2, 0..4]] {
            let error = whole.crop(&ranges).unwrap_err();
            assert!(error.is_bad_input() && error.to_string().starts_with("crop: "));
        }
        assert!(whole.downsample(0).is_err());
    }

    #[test]
    fn downsampled_voxels_are_means_at_the_middle_of_their_boxes() {
        let whole = oblique([8, 7, 6]);
        let half = whole.downsample(2).unwrap();
        assert_eq!(half.dims, [4, 4, 3]);
        assert_eq!(half.spacing, whole.spacing * 2.0);
        let mut mean = 0.0;
        for i in 0..8 {
            mean += voxel(&whole, [2 + (i & 1), 4 + (i >> 1 & 1), i >> 2]) / 8.0;
        }
        assert_eq!(voxel(&half, [1, 2, 0]), mean.round());
        let middle = (world(&whole, [2, 4, 0]) + world(&whole, [3, 5, 1])) * 0.5;
        assert!((world(&half, [1, 2, 0]) - middle).length() < 1e-12);
        // The last row in y is a single voxel.
        let mut rest = 0.0;
        for i in 0..4 {
            rest += voxel(&whole, [i & 1, 6, i >> 1]) / 4.0;
        }
        assert_eq!(voxel(&half, [0, 3, 0]), rest.round());
        assert_eq!(
            whole.downsample(1).unwrap().voxels.as_bytes(),
            whole.voxels.as_bytes()
        );
    }
}
