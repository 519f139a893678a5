//! Which blocks hold a voxel that the table shows: what is empty where voxels get their colour before they are interpolated.

use rayon::prelude::*;

use super::Occupancy;
use crate::transfer::Table;
use crate::volume::Volume;
use crate::with_voxels;

impl Occupancy {
    /// The blocks of `block` voxels in whose closed support, `apron` more voxels on every side, a voxel is visible by the
    /// table. Values between voxels do not count: interpolated colours are zero where all of theirs are. Reads every voxel.
    pub fn of_visible_voxels(volume: &Volume, table: &Table, block: usize, apron: usize) -> Self {
        let mut occupancy = Self::new(volume.dims, block);
        let [nx, ny, nz] = volume.dims;
        let domain = table.domain();
        let around = |voxel: usize, axis: usize| {
            let last = volume.dims[axis].div_ceil(block) - 1;
            voxel.saturating_sub(apron) / block..=((voxel + apron) / block).min(last)
        };
        with_voxels!(&volume.voxels, voxels => {
            let slices: Vec<Self> = (0..nz.div_ceil(block))
                .into_par_iter()
                .map(|layer| {
                    // Of one layer of blocks along z, as a volume of its own.
                    let mut found = Self::new([nx, ny, block], block);
                    let slices = (layer * block).saturating_sub(apron)..((layer + 1) * block + apron).min(nz);
                    for (i, row) in voxels[slices.start * nx * ny..slices.end * nx * ny].chunks_exact(nx).enumerate() {
                        for (x, &stored) in row.iter().enumerate() {
                            let at = domain.x_from_stored(f64::from(stored));
                            if table.is_visible(at..=at) {
                                for by in around(i % ny, 1) {
                                    for bx in around(x, 0) {
                                        found.set([bx, by, 0]);
                                    }
                                }
                            }
                        }
                    }
                    found
                })
                .collect();
            for (z, slice) in slices.iter().enumerate() {
                for y in 0..occupancy.dims[1] {
                    occupancy.row_mut(y, z).copy_from_slice(slice.row(y, 0));
                }
            }
        });
        occupancy
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::octree::testing::{self, AnyVolume};

    proptest! {
        #[test]
        fn a_block_is_empty_where_no_voxel_of_its_support_is_visible(
            any in AnyVolume::strategy(),
            log_block in 1u32..=4,
        ) {
            let volume = any.volume();
            let table = testing::band(&volume, 0.3, 0.7);
            let block = 1 << log_block;
            let occupancy = Occupancy::of_visible_voxels(&volume, &table, block, 1);
            let [bx, by, bz] = occupancy.dims;
            for i in 0..bx * by * bz {
                let at = [i % bx, i / bx % by, i / bx / by];
                let support: [_; 3] = std::array::from_fn(|a| {
                    (at[a] * block).saturating_sub(1)..((at[a] + 1) * block + 1).min(volume.dims[a])
                });
                let mut is_visible = false;
                for z in support[2].clone() {
                    for y in support[1].clone() {
                        for x in support[0].clone() {
                            let stored = f64::from(testing::stored(&volume, [x, y, z]));
                            let at = table.domain().x_from_stored(stored);
                            is_visible |= table.is_visible(at..=at);
                        }
                    }
                }
                prop_assert_eq!(occupancy.get(at), is_visible);
            }
        }
    }
}
