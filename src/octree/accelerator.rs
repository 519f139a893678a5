//! What one volume needs to be skipped through: the grid of leaves and the trees over it.

use std::ops::{Range, RangeInclusive};
use std::sync::OnceLock;

use super::{LeafGrid, Occupancy, Octree};
use crate::error::{Error, Result};
use crate::mode::Mode;
use crate::transfer::{Domain, Table};
use crate::volume::{Volume, VoxelType};

/// The octrees of a volume: one of the whole and one of each half of each axis, all over one grid of leaves.
///
/// Trees are built when first asked for, and kept: a turning camera rebuilds nothing, and no edit of a table does.
#[derive(Debug)]
pub struct Accelerator {
    /// The leaves.
    pub grid: LeafGrid,
    voxel_type: VoxelType,
    whole: OnceLock<Octree>,
    halves: [OnceLock<[Octree; 2]>; 3],
}

impl Accelerator {
    /// Reads the volume into leaves of `block` voxels, each closed over `apron` more on every side.
    ///
    /// # Errors
    /// [`Error::Setting`] where `block` is not a power of two from 2 to 64.
    pub fn build(volume: &Volume, block: usize, apron: usize) -> Result<Self> {
        if !(block.is_power_of_two() && (2..=64).contains(&block)) {
            return Err(Error::setting(
                "block",
                format!("{block} is none of 2, 4, 8, 16, 32, 64"),
            ));
        }
        Ok(Self {
            grid: LeafGrid::build(volume, block, apron),
            voxel_type: volume.voxels.voxel_type(),
            whole: OnceLock::new(),
            halves: Default::default(),
        })
    }

    /// The tree over all leaves.
    pub fn whole(&self) -> &Octree {
        self.whole
            .get_or_init(|| Octree::build(&self.grid, self.grid.dims.map(|n| 0..n)))
    }

    /// The leaf coordinate on `axis` that the volume is cut at: of the leaf boundaries, the one nearest the middle of the
    /// volume (the upper of two). A volume of one leaf has an empty half.
    pub fn cut(&self, axis: usize) -> usize {
        let block = self.grid.block;
        (self.grid.volume_dims[axis] + block) / (2 * block)
    }

    /// The leaves of one half (0: below the cut, 1: above) of an axis.
    pub fn half_region(&self, axis: usize, half: usize) -> [Range<usize>; 3] {
        let mut region = self.grid.dims.map(|n| 0..n);
        if half == 0 {
            region[axis].end = self.cut(axis);
        } else {
            region[axis].start = self.cut(axis);
        }
        region
    }

    /// The trees of the halves below and above the cut of an axis.
    pub fn halves(&self, axis: usize) -> &[Octree; 2] {
        self.halves[axis].get_or_init(|| {
            let build = |half| Octree::build(&self.grid, self.half_region(axis, half));
            rayon::join(|| build(0), || build(1)).into()
        })
    }

    /// Bytes of what has been built so far: the leaves, once, and the nodes of each tree.
    pub fn structure_bytes(&self) -> usize {
        let halves = self.halves.iter().filter_map(OnceLock::get).flatten();
        let trees = self.whole.get().into_iter().chain(halves);
        self.grid.bytes() + trees.map(Octree::bytes).sum::<usize>()
    }

    /// The leaves that contribute to a picture with this table and mode, found in the tree of the whole volume.
    pub fn cull(&self, table: &Table, mode: Mode) -> Occupancy {
        self.cull_trees([self.whole()], table, mode)
    }

    /// The same leaves, found in the trees of an axis's halves: for who needs no tree of the whole.
    pub fn cull_halves(&self, axis: usize, table: &Table, mode: Mode) -> Occupancy {
        self.cull_trees(self.halves(axis), table, mode)
    }

    fn cull_trees<'a>(
        &self,
        trees: impl IntoIterator<Item = &'a Octree>,
        table: &Table,
        mode: Mode,
    ) -> Occupancy {
        let mut occupancy = Occupancy::new(self.grid.volume_dims, self.grid.block);
        let is_active = |range| {
            mode.is_active(
                table,
                stored_range_to_x(range, self.voxel_type, table.domain()),
            )
        };
        for tree in trees {
            tree.cull(&is_active, &mut occupancy);
        }
        occupancy
    }
}

/// The table coordinates that samples between two stored numbers (min, max) can have.
///
/// Interpolated integers stay between their neighbours (what rounding adds, tables snap away); floats may leave them by
/// rounding, so they get 4 ulp of the larger magnitude on both sides.
pub fn stored_range_to_x(
    [low, high]: [f32; 2],
    voxel_type: VoxelType,
    domain: &Domain,
) -> RangeInclusive<f64> {
    let slack = match voxel_type {
        VoxelType::F32 => {
            let magnitude = low.abs().max(high.abs());
            4.0 * (f64::from(magnitude.next_up()) - f64::from(magnitude))
        }
        VoxelType::U8 | VoxelType::I8 | VoxelType::U16 | VoxelType::I16 => 0.0,
    };
    domain.x_from_stored(f64::from(low) - slack)..=domain.x_from_stored(f64::from(high) + slack)
}
