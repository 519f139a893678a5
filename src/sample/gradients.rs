//! Where the gradient around a sample comes from: the field itself, or a volume of gradients at lower resolution.
//!
//! A volume of gradients is a grid of cells of 1, 2 or 4 voxels an edge. A cell holds the mean of its voxels' central
//! differences (over two voxels, voxels beyond the box repeated), not of their directions: means and interpolation of
//! differences are those of a smoother field, and voxels where nothing changes count for nothing. Between the cells' middles
//! it is interpolated trilinearly. At full resolution that is what central differences of the trilinear field are, by
//! linearity, except in the outermost half voxel.

use super::{cell, trilinear};

/// The choice of gradients.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Gradients {
    /// Central differences of the sampled field, wherever a mode asks.
    Fly,
    /// A volume of gradients, one per voxel.
    Full,
    /// One per two voxels an edge.
    Half,
    /// One per four voxels an edge.
    Quarter,
}

impl Gradients {
    /// All choices.
    pub const ALL: &[Self] = &[Self::Fly, Self::Full, Self::Half, Self::Quarter];

    /// The name used by flags and reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fly => "fly",
            Self::Full => "full",
            Self::Half => "half",
            Self::Quarter => "quarter",
        }
    }

    /// Edge of a cell in voxels, where there is a volume of gradients.
    pub fn cell_edge(self) -> Option<usize> {
        match self {
            Self::Fly => None,
            Self::Full => Some(1),
            Self::Half => Some(2),
            Self::Quarter => Some(4),
        }
    }
}

/// The gradient at a grid position, from cells of `edge` voxels: stored numbers per two voxels, along each axis.
///
/// The cells are computed as they are needed: what `shaders/gradients.wgsl` stores and `shaders/gradient/exact.inc.wgsl`
/// reads, in f64 and without the rounding of half floats.
pub(crate) fn interpolated<V: Copy + Into<f64>>(
    voxels: &[V],
    dims: [usize; 3],
    edge: usize,
    at: [f64; 3],
) -> [f64; 3] {
    let [x, y, z] = at.map(|c| cell(c / edge as f64));
    let along = |axis: usize, lower: f64, upper: usize| {
        let last = dims[axis].div_ceil(edge) - 1;
        (lower as i64 + upper as i64).clamp(0, last as i64) as usize
    };
    let mut corners = [[[[0.0; 2]; 2]; 2]; 3];
    for (dz, dy, dx) in (0..8).map(|i| (i >> 2, i >> 1 & 1, i & 1)) {
        let place = [along(0, x.0, dx), along(1, y.0, dy), along(2, z.0, dz)];
        let gradient = of_cell(voxels, dims, edge, place);
        for axis in 0..3 {
            corners[axis][dz][dy][dx] = gradient[axis];
        }
    }
    corners.map(|corners| trilinear(corners, [x.1, y.1, z.1]))
}

/// The mean of the central differences of a cell's voxels: stored numbers per two voxels, along each axis.
fn of_cell<V: Copy + Into<f64>>(
    voxels: &[V],
    dims: [usize; 3],
    edge: usize,
    cell: [usize; 3],
) -> [f64; 3] {
    let along = |axis: usize| cell[axis] * edge..((cell[axis] + 1) * edge).min(dims[axis]);
    let stored =
        |at: [usize; 3]| -> f64 { voxels[(at[2] * dims[1] + at[1]) * dims[0] + at[0]].into() };
    let mut sum = [0.0; 3];
    for z in along(2) {
        for y in along(1) {
            for x in along(0) {
                for (axis, sum) in sum.iter_mut().enumerate() {
                    let (mut before, mut after) = ([x, y, z], [x, y, z]);
                    before[axis] = before[axis].saturating_sub(1);
                    after[axis] = (after[axis] + 1).min(dims[axis] - 1);
                    *sum += stored(after) - stored(before);
                }
            }
        }
    }
    let count = along(0).len() * along(1).len() * along(2).len();
    sum.map(|s| s / count as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gradient_of_a_linear_field_is_the_same_in_cells_of_any_edge() {
        let dims = [9, 8, 7];
        let mut voxels = Vec::new();
        for z in 0..dims[2] {
            for y in 0..dims[1] {
                voxels.extend((0..dims[0]).map(|x| 3.0 * x as f64 - 2.0 * y as f64 + z as f64));
            }
        }
        for edge in [1, 2] {
            // Away from the box's faces, where voxels repeat.
            let gradient = interpolated(&voxels, dims, edge, [4.1, 3.9, 3.4]);
            for (got, expected) in gradient.into_iter().zip([6.0, -4.0, 2.0]) {
                assert!((got - expected).abs() < 1e-12, "{edge}: {gradient:?}");
            }
        }
    }

    #[test]
    fn a_cell_holds_the_mean_of_its_voxels_and_the_last_one_of_those_there_are() {
        let voxels = [0.0, 1.0, 4.0, 9.0, 16.0];
        let of = |edge, x| of_cell(&voxels, [5, 1, 1], edge, [x, 0, 0])[0];
        assert_eq!([of(1, 0), of(1, 2), of(1, 4)], [1.0, 8.0, 7.0]);
        assert_eq!([of(2, 0), of(2, 1), of(2, 2)], [2.5, 10.0, 7.0]);
    }
}
