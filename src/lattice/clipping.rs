//! Clip planes: they shorten rays before the march and move no sample.

use glam::{DMat3, DVec3};

use crate::error::{Error, Result};

/// The most planes of a [`Clipping`]: the faces of a box and six more.
pub const MAX_CLIP_PLANES: usize = 12;

/// Half-spaces whose intersection is all that is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clipping {
    planes: [[f64; 4]; MAX_CLIP_PLANES],
    count: usize,
}

impl Clipping {
    /// Nothing is clipped.
    pub const NONE: Self = Self {
        planes: [[0.0; 4]; MAX_CLIP_PLANES],
        count: 0,
    };

    /// Keeps only positions (local coordinates) with `normal . position >= offset` of what was kept so far.
    ///
    /// # Errors
    /// [`Error::Setting`] where the normal has no length, a number is not finite, or there are [`MAX_CLIP_PLANES`].
    pub fn keep(&mut self, normal: DVec3, offset: f64) -> Result<()> {
        let length = normal.length();
        if !(normal.is_finite() && offset.is_finite()) {
            return Err(Error::setting("clip plane", "must be finite numbers"));
        }
        if length == 0.0 {
            return Err(Error::setting("clip plane", "its normal has no length"));
        }
        if self.count == MAX_CLIP_PLANES {
            return Err(Error::setting(
                "clip plane",
                format!("there are more than {MAX_CLIP_PLANES}, those of the clip box included"),
            ));
        }
        let [x, y, z] = (normal / length).to_array();
        self.planes[self.count] = [x, y, z, -offset / length];
        self.count += 1;
        Ok(())
    }

    /// Keeps what lies in `ranges` of voxels along x, y and z (an open end clips nothing) and where
    /// `nx * x + ny * y + nz * z >= d` for all of `planes`, all in voxels of edges `voxel_size` (local units).
    ///
    /// # Errors
    /// As [`Self::keep`].
    pub fn in_voxels(
        ranges: &[[Option<f64>; 2]; 3],
        planes: &[[f64; 4]],
        voxel_size: DVec3,
    ) -> Result<Self> {
        let grid_from_local = 1.0 / voxel_size;
        let mut clipping = Self::NONE;
        for (range, normal) in ranges.iter().zip([DVec3::X, DVec3::Y, DVec3::Z]) {
            for (at, side) in [(range[0], 1.0), (range[1], -1.0)] {
                if let Some(at) = at {
                    clipping.keep(side * normal * grid_from_local, side * at)?;
                }
            }
        }
        for &[x, y, z, offset] in planes {
            clipping.keep(DVec3::new(x, y, z) * grid_from_local, offset)?;
        }
        Ok(clipping)
    }

    /// The planes: unit normal and distance, `normal . position + distance >= 0` where positions are kept.
    #[inline(always)]
    pub fn planes(&self) -> &[[f64; 4]] {
        &self.planes[..self.count]
    }

    /// Whether nothing is left of a box [0, extent].
    pub fn leaves_nothing_of(&self, extent: DVec3) -> bool {
        let faces = [DVec3::X, DVec3::Y, DVec3::Z]
            .into_iter()
            .flat_map(|n| [(n, 0.0), (-n, n.dot(extent))]);
        let planes: Vec<(DVec3, f64)> = self
            .planes()
            .iter()
            .map(|&[x, y, z, distance]| (DVec3::new(x, y, z), distance))
            .chain(faces)
            .collect();
        // What is left of a box is bounded: if there is any of it, it has a corner where three planes meet.
        let slack = 1e-9 * extent.max_element();
        let is_left = |p: DVec3| planes.iter().all(|(n, d)| n.dot(p) + d >= -slack);
        let corners = (0..planes.len()).flat_map(|i| {
            let planes = &planes;
            (0..i).flat_map(move |j| (0..j).map(move |k| [i, j, k].map(|i| planes[i])))
        });
        !corners
            .filter_map(|[a, b, c]| {
                let normals = DMat3::from_cols(a.0, b.0, c.0).transpose();
                let meets = normals.determinant().abs() > 1e-12;
                meets.then(|| normals.inverse() * -DVec3::new(a.1, b.1, c.1))
            })
            .any(is_left)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clipping(planes: &[([f64; 3], f64)]) -> Clipping {
        let mut clipping = Clipping::NONE;
        for &(normal, offset) in planes {
            clipping.keep(DVec3::from_array(normal), offset).unwrap();
        }
        clipping
    }

    #[test]
    fn planes_that_leave_nothing_are_found() {
        let extent = DVec3::new(10.0, 20.0, 30.0);
        let nothing = |planes: &[([f64; 3], f64)]| clipping(planes).leaves_nothing_of(extent);
        assert!(!nothing(&[]));
        assert!(!nothing(&[([1.0, 0.0, 0.0], 9.0)]));
        assert!(nothing(&[([1.0, 0.0, 0.0], 11.0)]));
        // Each leaves something, both together do not.
        assert!(nothing(&[
            ([0.0, 2.0, 0.0], 30.0),
            ([0.0, -1.0, 0.0], -10.0)
        ]));
        // A corner of the box is cut off, or nothing but it left.
        assert!(!nothing(&[([1.0, 1.0, 1.0], 59.0)]));
        assert!(nothing(&[([1.0, 1.0, 1.0], 61.0)]));
    }

    #[test]
    fn planes_without_direction_or_number_are_refused() {
        let mut clipping = Clipping::NONE;
        assert!(clipping.keep(DVec3::ZERO, 1.0).is_err());
        assert!(clipping.keep(DVec3::X, f64::NAN).is_err());
        for _ in 0..MAX_CLIP_PLANES {
            clipping.keep(DVec3::X, 0.0).unwrap();
        }
        assert!(clipping.keep(DVec3::X, 0.0).is_err());
    }
}
