//! What one volume needs to be skipped through: the grid of leaves and the trees over it.

use std::ops::{Range, RangeInclusive};
use std::sync::OnceLock;

use super::occupancy::half_cut;
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

    /// The leaf coordinate on `axis` that the volume is cut at: [`Occupancy::half_cut`].
    pub fn cut(&self, axis: usize) -> usize {
        half_cut(self.grid.volume_dims[axis], self.grid.block)
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
        let activity = mode.activity(table.domain());
        let is_active = |range| {
            activity.is_active(
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::octree::testing::{self, AnyVolume};
    use crate::transfer::lookup;
    use proptest::prelude::*;

    /// Whether the interpolated table has any opacity at `x`.
    fn shows(table: &Table, x: f64) -> bool {
        let domain = table.domain();
        let (lower, f) = lookup(x, domain.entries as f64, domain.snap());
        let lower = lower as usize;
        let upper = (lower + 1).min(domain.entries - 1);
        let [a, b] = [lower, upper].map(|i| f64::from(table.rgba()[i][3]));
        a + f * (b - a) != 0.0
    }

    proptest! {
        /// A range that ends a hair beside an invisible entry is inactive only as far as shaders, with their rounding, snap
        /// onto that entry.
        #[test]
        fn an_inactive_range_may_end_only_where_shaders_snap(entry in 0u8..=255, snaps in -8.0f64..8.0) {
            let volume = testing::volume_of([256, 1, 1], crate::volume::Voxels::U8((0..=255).collect::<Vec<_>>().into()));
            let table = testing::band(&volume, 0.3, 0.7);
            let snap = table.domain().snap();
            // Also at the two entries beside the visible band, where it matters.
            for entry in [f64::from(entry), 76.0, 77.0, 178.0, 179.0] {
                let x = entry + snaps * snap;
                if !Mode::EmissionAbsorption.is_active(&table, x..=x) {
                    prop_assert!(!shows(&table, x - 0.49 * snap) && !shows(&table, x + 0.49 * snap));
                }
            }
        }

        /// Whole and halves, of every axis, find the same leaves: those whose range the table shows.
        #[test]
        fn halves_of_every_axis_find_the_leaves_of_the_whole(
            any in AnyVolume::strategy(),
            log_block in 1u32..=6,
            band in prop::array::uniform2(0.0f64..=1.0),
        ) {
            let volume = any.volume();
            let table = testing::band(&volume, band[0].min(band[1]), band[0].max(band[1]));
            let mode = Mode::EmissionAbsorption;
            let accelerator = Accelerator::build(&volume, 1 << log_block, 1).unwrap();
            let whole = accelerator.cull(&table, mode);
            for z in 0..whole.dims[2] {
                for y in 0..whole.dims[1] {
                    for x in 0..whole.dims[0] {
                        let range = accelerator.grid.range([x, y, z]);
                        let x_range = stored_range_to_x(range, volume.voxels.voxel_type(), table.domain());
                        prop_assert_eq!(whole.get([x, y, z]), mode.is_active(&table, x_range));
                    }
                }
            }
            for axis in 0..3 {
                prop_assert_eq!(&accelerator.cull_halves(axis, &table, mode), &whole);
            }
        }

        /// Contract 4: nothing shows at any table coordinate that an inactive leaf's samples can have, with the rounding
        /// that shaders snap away on top; and an active leaf has a visible entry within reach.
        #[test]
        fn an_inactive_leaf_shows_nothing(
            any in AnyVolume::strategy(),
            log_block in 1u32..=4,
            band in prop::array::uniform2(0.0f64..=1.0),
            parts in prop::collection::vec(0.0f64..=1.0, 8),
        ) {
            let volume = any.volume();
            let table = testing::band(&volume, band[0].min(band[1]), band[0].max(band[1]));
            let domain = table.domain();
            let shows = |x: f64| shows(&table, x);
            let accelerator = Accelerator::build(&volume, 1 << log_block, 1).unwrap();
            let active = accelerator.cull(&table, Mode::EmissionAbsorption);
            for z in 0..active.dims[2] {
                for y in 0..active.dims[1] {
                    for x in 0..active.dims[0] {
                        let range = accelerator.grid.range([x, y, z]);
                        let range = stored_range_to_x(range, volume.voxels.voxel_type(), domain);
                        let (low, high) = (*range.start(), *range.end());
                        if active.get([x, y, z]) {
                            let last = (domain.entries - 1) as f64;
                            let entry = |x: f64| x.clamp(0.0, last) as usize;
                            let reach = entry(low.floor())..=entry(high.ceil());
                            prop_assert!(table.rgba()[reach].iter().any(|e| e[3] != 0.0));
                        } else {
                            let rounding = domain.snap() * 0.49;
                            prop_assert!(!shows(low - rounding) && !shows(high + rounding));
                            prop_assert!(!parts.iter().any(|f| shows(low + f * (high - low))));
                        }
                    }
                }
            }
        }

        /// No other leaf boundary is nearer to the middle of the volume, and the halves meet there.
        #[test]
        fn the_cut_is_the_leaf_boundary_nearest_the_middle(nx in 1usize..400, log_block in 1u32..=6) {
            let volume = testing::volume_of([nx, 2, 1], crate::volume::Voxels::U8(vec![0; nx * 2].into()));
            let accelerator = Accelerator::build(&volume, 1 << log_block, 1).unwrap();
            let twice_off_middle = |leaf: usize| (2 * leaf * accelerator.grid.block).min(2 * nx).abs_diff(nx);
            let cut = accelerator.cut(0);
            for leaf in 0..=accelerator.grid.dims[0] {
                prop_assert!(twice_off_middle(cut) <= twice_off_middle(leaf));
            }
            let [below, above] = [0, 1].map(|half| accelerator.half_region(0, half));
            prop_assert_eq!(&below[0], &(0..cut));
            prop_assert_eq!(&above[0], &(cut..accelerator.grid.dims[0]));
            prop_assert_eq!(&below[1..], &above[1..]);
        }
    }

    #[test]
    fn only_powers_of_two_from_2_to_64_are_blocks() {
        let volume = testing::volume_of([3, 2, 1], crate::volume::Voxels::U8(vec![0; 6].into()));
        for block in 0..=130 {
            let made = Accelerator::build(&volume, block, 1);
            assert_eq!(
                made.is_ok(),
                [2, 4, 8, 16, 32, 64].contains(&block),
                "{block}"
            );
            if let Err(error) = made {
                assert!(error.to_string().starts_with("block: "), "{error}");
                assert!(error.is_bad_input());
            }
        }
    }

    #[test]
    fn trees_are_built_at_first_use_and_kept() {
        let voxels: Vec<u8> = (0..32 * 32 * 32).map(|i| (i % 255) as u8).collect();
        let volume = testing::volume_of([32; 3], crate::volume::Voxels::U8(voxels.into()));
        let accelerator = Accelerator::build(&volume, 4, 1).unwrap();
        let leaves_only = accelerator.structure_bytes();
        assert_eq!(leaves_only, 8 * 8 * 8 * size_of::<[f32; 2]>());
        let first = accelerator.halves(1);
        let with_halves = accelerator.structure_bytes();
        assert_eq!(
            with_halves,
            leaves_only + first[0].bytes() + first[1].bytes()
        );
        assert!(std::ptr::eq(first, accelerator.halves(1)));
        accelerator.whole();
        assert!(accelerator.structure_bytes() > with_halves);
    }

    /// 4 ulp of the larger magnitude on both sides of a float range; integers stay as they are.
    #[test]
    fn float_ranges_are_widened_and_integer_ranges_are_not() {
        let volume = testing::volume_of(
            [2, 1, 1],
            crate::volume::Voxels::F32(vec![-256.0, 255.0].into()),
        );
        let domain = Domain::new(&volume, [0.0, 255.0], 256).unwrap();
        let widened = stored_range_to_x([-2.0, 1.0], VoxelType::F32, &domain);
        let slack = 4.0 * 2f64.powi(-22);
        assert_eq!(widened, -2.0 - slack..=1.0 + slack);
        assert_eq!(
            stored_range_to_x([-2.0, 1.0], VoxelType::I16, &domain),
            -2.0..=1.0
        );
    }
}
