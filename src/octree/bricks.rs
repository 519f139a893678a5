//! Bricks: the part of a volume that shows anything, in pieces of 4x4x4 cells.

use rayon::prelude::*;

use super::Cells;
use super::cells::PER_WORD;

/// Edge of a brick in cells.
pub const BRICK: usize = 4;

/// Packed voxels at most, for each voxel of the volume: where most of it shows, there is little to skip, and each
/// of the volume's voxels would be there five times.
const MOST: usize = 2;

/// Which bricks of a volume hold a cell that contributes.
///
/// Their cells are counted from the one before the first voxel: cell c of an axis lies between the centres of voxels c - 1 and
/// c, where there are both, so that a volume of n voxels has n + 1 cells along it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Bricks {
    /// Bricks along x, y, z.
    pub dims: [usize; 3],
    /// Those that hold one, ascending: (z * dims.y + y) * dims.x + x.
    active: Vec<u32>,
    /// Voxels of the volume.
    voxels: usize,
}

impl Bricks {
    /// The bricks of a volume whose cells are these.
    pub fn new(cells: &Cells) -> Self {
        let cell_dims = cells.dims();
        let dims @ [nx, ny, nz] = cell_dims.map(|n| (n + 1).div_ceil(BRICK));
        let active = (0..ny * nz)
            .into_par_iter()
            .with_min_len(16)
            .map_init(
                || vec![0; cell_dims[0].div_ceil(PER_WORD) + 1],
                |at, row| {
                    let [ys, zs] = [(1, row % ny), (2, row / ny)].map(|(a, b)| {
                        (b * BRICK).saturating_sub(1)..(b * BRICK + BRICK - 1).min(cell_dims[a])
                    });
                    at.fill(0u32);
                    for z in zs {
                        for y in ys.clone() {
                            let row = cells.contributing(y, z);
                            at.iter_mut().zip(row).for_each(|(at, row)| *at |= row);
                        }
                    }
                    let per_word = PER_WORD / BRICK;
                    let holds = move |b: usize, at: &[u32]| {
                        // Cells move on by one: the first is the one before the first voxel.
                        let before = (b / per_word).checked_sub(1).map_or(0, |i| at[i] >> 30);
                        let word = at[b / per_word] << 2 | before;
                        word >> (b % per_word * 2 * BRICK) & 0xff != 0
                    };
                    let found = (0..nx).filter(|&b| holds(b, at));
                    found.map(|b| (row * nx + b) as u32).collect::<Vec<_>>()
                },
            )
            .flatten_iter()
            .collect();
        Self {
            dims,
            active,
            voxels: cell_dims.iter().product(),
        }
    }

    /// Whether they take no more than about twice the memory of the volume: a cell is packed with the four voxels around
    /// its edge along z, and a brick ends with the first cells of the one behind it.
    pub fn are_few(&self) -> bool {
        let per_brick = BRICK * BRICK * (BRICK + 1) * 4;
        self.active.len() * per_brick <= self.voxels * MOST
    }

    /// Where each that holds such a cell lies, in bricks along x, y, z.
    pub fn active(&self) -> impl ExactSizeIterator<Item = [usize; 3]> + '_ {
        let [nx, ny, _] = self.dims;
        self.active.iter().map(move |&i| {
            let i = i as usize;
            [i % nx, i / nx % ny, i / nx / ny]
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::mode::Mode;
    use crate::octree::testing::{self, AnyVolume};
    use crate::octree::{Accelerator, CellRule};

    proptest! {
        /// A brick is there if and only if a cell of it contributes, those before the first and behind the last voxels being
        /// the outermost's.
        #[test]
        fn a_brick_is_there_where_a_cell_of_it_contributes(
            any in AnyVolume::strategy(),
            band in prop::array::uniform2(0.0f64..=1.0),
        ) {
            let volume = any.volume();
            let table = testing::band(&volume, band[0].min(band[1]), band[0].max(band[1]));
            let (mode, apron) = (Mode::EmissionAbsorption, 1);
            let occupancy = Accelerator::build(&volume, 2, apron).unwrap().cull(&table, mode);
            let rule = CellRule { volume: &volume, table: &table, mode, apron, is_by_voxel: false };
            let bricks = Bricks::new(&Cells::new(&rule, &occupancy));
            let mut expected = Vec::new();
            let [nx, ny, nz] = bricks.dims;
            for i in 0..nx * ny * nz {
                let brick = [i % nx, i / nx % ny, i / nx / ny];
                let holds = (0..BRICK.pow(3)).any(|j| {
                    let at = [j % BRICK, j / BRICK % BRICK, j / BRICK / BRICK];
                    let cell: [usize; 3] = std::array::from_fn(|a| brick[a] * BRICK + at[a]);
                    let is_there = (0..3).all(|a| cell[a] <= volume.dims[a]);
                    is_there && rule.contributes(cell.map(|c| c.saturating_sub(1)))
                });
                if holds {
                    expected.push(brick);
                }
            }
            prop_assert_eq!(bricks.active().collect::<Vec<_>>(), expected);
        }
    }
}
