//! The modes that project along rays, with what rays have seen left out.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use proptest::prelude::*;

use super::cases::{Case, Made, cases};
use super::{METHODS, bits, draw_now};
use crate::cpu::{CpuPlan, Path, TILE, render_counted};
use crate::mode::{Mode, Window};
use crate::octree::Accelerator;
use crate::scene::Scene;
use crate::skip::{Majorants, Skip};

/// The three modes over the part of the values that is visible in a case.
fn modes(case: &Case, made: &Made) -> [Mode; 3] {
    let domain = made.table.domain();
    let last = (domain.entries - 1) as f64;
    let [low, high] = case.visible.map(|share| domain.value_from_x(share * last));
    let window = Window { low, high };
    [Mode::Mip(window), Mode::Minip(window), Mode::Mean(window)]
}

/// A plan over the blocks that are active in a mode, and bounded if the mode keeps the highest place.
fn plan(made: &Made, mode: &Mode, block: usize, skip: Skip) -> CpuPlan {
    let accelerator = Accelerator::build(&made.volume, block, 1).expect("a power of two");
    let occupancy = accelerator.cull(&made.table, *mode);
    let mut plan = CpuPlan::new(skip, &made.volume, &made.table, &occupancy).expect("it is there");
    if mode.keeps_highest() {
        let voxel_type = made.volume.voxels.voxel_type();
        let domain = made.table.domain();
        let majorants = Majorants::new(&accelerator.grid, voxel_type, domain, mode);
        plan.set_majorants(Some(Arc::new(majorants)));
    }
    plan
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    /// Every method, every path of instructions and the counting run give the bits of the box; what contributes and where
    /// first is the same, and no more samples are taken.
    #[test]
    fn projections_are_bit_identical(case in cases()) {
        let made = case.make();
        let block = case.block.next_power_of_two();
        for mode in modes(&case, &made) {
            let scene = Scene { mode, ..made.scene(case.ert) };
            let count = |plan: &CpuPlan| {
                render_counted(&scene, plan, &AtomicBool::new(false)).expect("not cancelled")
            };
            let all = count(&plan(&made, &mode, block, Skip::Box));
            let expected = bits(&all.picture);
            for skip in METHODS {
                let counted = count(&plan(&made, &mode, block, skip));
                prop_assert!(bits(&counted.picture) == expected, "{skip:?} {mode:?}");
                prop_assert_eq!(counted.counters.contributing, all.counters.contributing);
                prop_assert!(counted.first_hit == all.first_hit);
                prop_assert!(counted.counters.samples <= all.counters.samples);
                for path in Path::ALL.iter().filter(|p| p.is_available(case.dims)) {
                    let plan = plan(&made, &mode, block, skip).with(*path, TILE).expect("available");
                    prop_assert!(bits(&draw_now(&scene, &plan)) == expected, "{skip:?} {path:?}");
                }
            }
        }
    }
}
