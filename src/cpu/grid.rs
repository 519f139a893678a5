//! Voxels as packets read them: in place, by the linear index of a cell's lowest corner.

use super::packet::{LANES, Packet, Voxel};
use crate::sample;

/// A volume's voxels and their layout.
#[derive(Debug, Clone, Copy)]
pub(super) struct Grid<'a, V> {
    pub(super) voxels: &'a [V],
    pub(super) dims: [usize; 3],
}

/// Where a sample lies: the cell of eight voxels around it and the fraction within.
#[derive(Clone, Copy)]
pub(super) struct Cell<P: Packet> {
    /// Column of the lowest corner.
    pub(super) x: P::Index,
    /// Row of the lowest corner: `z * dims.y + y`.
    pub(super) row: P::Index,
    /// Fraction per axis, 0 to 1 (exclusive).
    pub(super) fraction: [P; 3],
}

impl<V: Voxel> Grid<'_, V> {
    /// The cell around a grid position. Positions within half a voxel of the box's faces, or outside, are moved to the
    /// outermost voxel centres first, which repeats the outermost voxels: there the fraction is 0 and the neighbour
    /// above, which may be any voxel, does not count.
    #[inline(always)]
    pub(super) fn cell<P: Packet>(&self, position: [P; 3]) -> Cell<P> {
        let mut lower = [P::splat(0.0); 3];
        let mut fraction = lower;
        for a in 0..3 {
            let upper = P::splat(self.dims[a] as f64 - 0.5);
            let inside = position[a].max(P::splat(0.5)).min(upper);
            (lower[a], fraction[a]) = sample::cell(inside);
        }
        Cell {
            x: lower[0].to_index(),
            row: P::mul_add_index(lower[2].to_index(), self.dims[1], lower[1].to_index()),
            fraction,
        }
    }

    /// The interpolated voxels, in stored units.
    #[inline(always)]
    pub(super) fn value<P: Packet>(&self, cell: Cell<P>) -> P {
        let lower = P::mul_add_index(cell.row, self.dims[0], cell.x);
        sample::trilinear(P::corners(self, lower), cell.fraction)
    }

    /// The corners of eight cells, `[z][y][x][lane]`, lane by lane; beyond the array's end: its last voxel.
    #[inline(always)]
    pub(super) fn corner_lanes(&self, lower: [usize; LANES]) -> [[[[f32; LANES]; 2]; 2]; 2] {
        let [row, plane] = [self.dims[0], self.dims[0] * self.dims[1]];
        let last = self.voxels.len() - 1;
        std::array::from_fn(|z| {
            std::array::from_fn(|y| {
                std::array::from_fn(|x| {
                    lower.map(|i| self.voxels[(i + z * plane + y * row + x).min(last)].to_f32())
                })
            })
        })
    }

    /// [`Self::corner_lanes`] out of line, for the few cells at the array's end that a vector path must not gather.
    #[cold]
    #[inline(never)]
    #[cfg(target_arch = "x86_64")]
    pub(super) fn corner_lanes_at_end(&self, lower: [u32; LANES]) -> [[[[f32; LANES]; 2]; 2]; 2] {
        self.corner_lanes(lower.map(|i| i as usize))
    }
}
