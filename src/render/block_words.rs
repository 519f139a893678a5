//! What methods with a shader of their own read of every block: made at first use, kept as long as it is true.

use std::sync::Arc;
use std::time::Instant;

use super::{Settings, ms_since};
use crate::mode::Mode;
use crate::octree::{CellRule, Cells, LeafGrid, Occupancy};
use crate::sample::Classification;
use crate::scene::Scene;
use crate::skip::adaptive::{Gradients, Strides};
use crate::skip::{Majorants, Skip};
use crate::transfer::Table;

/// What one method's shader reads of every block.
pub(super) struct BlockWords {
    /// Names them among all that is on the device.
    pub(super) id: u64,
    skip: Skip,
    /// The mode whose majorants come last, if any do.
    bounded: Option<Mode>,
    /// The table that they were made for.
    table: Arc<Table>,
    /// As `shaders/shared/blocks` reads them.
    pub(super) content: Vec<u32>,
    /// Whether majorants come after what is known of blocks.
    pub(super) has_majorants: bool,
    /// Where what comes after that begins: majorants, or the cells.
    pub(super) after_blocks: u32,
    /// What making them took.
    pub(super) ms: f64,
}

/// The mode whose majorants the settings' method reads.
pub(super) fn bounded_by(settings: &Settings) -> Option<Mode> {
    Some(settings.mode).filter(|mode| mode.keeps_highest() && settings.skip.reads_majorants())
}

impl BlockWords {
    /// Makes those of the settings' method over the blocks of `grid`, of which `occupancy` says which are active; `majorants`,
    /// by what they are bounded, and `cells` follow where it reads them. `None` where it reads none of all these. What strides
    /// follow from is built at first use.
    pub(super) fn make(
        id: u64,
        settings: &Settings,
        scene: &Scene,
        table: &Arc<Table>,
        (grid, occupancy): (&LeafGrid, &Occupancy),
        (majorants, cells): (Option<&Majorants>, Option<&Cells>),
        gradients: &mut Option<Gradients>,
    ) -> Option<Self> {
        let start = Instant::now();
        let mut content = match settings.skip {
            Skip::Adaptive => {
                let gradients = gradients.get_or_insert_with(|| Gradients::new(scene.volume, grid));
                strides(gradients, grid, occupancy, scene).words()
            }
            skip => skip.block_words(occupancy)?,
        };
        let after_blocks = content.len() as u32;
        if let Some(majorants) = majorants {
            content.extend(majorants.words());
        }
        if let Some(cells) = cells {
            content.extend_from_slice(cells.words());
        }
        Some(Self {
            id,
            skip: settings.skip,
            bounded: bounded_by(settings),
            table: Arc::clone(table),
            content,
            has_majorants: majorants.is_some(),
            after_blocks,
            ms: ms_since(start),
        })
    }

    /// Whether they are those of the settings' method and mode.
    pub(super) fn are_of(&self, settings: &Settings) -> bool {
        self.skip == settings.skip && self.bounded == bounded_by(settings)
    }

    /// Whether they hold under this table, which shows the same as theirs: strides follow from more of a table than where it
    /// shows anything.
    pub(super) fn hold_under(&self, table: &Arc<Table>) -> bool {
        self.skip != Skip::Adaptive || Arc::ptr_eq(&self.table, table)
    }
}

/// What makes a cell contribute to the settings' pictures.
pub(super) fn cell_rule<'a>(
    settings: &Settings,
    scene: &Scene<'a>,
    table: &'a Table,
) -> CellRule<'a> {
    CellRule {
        volume: scene.volume,
        table,
        mode: settings.mode,
        apron: scene.sampler.apron(),
        is_by_voxel: settings.classification == Classification::Pre,
    }
}

/// The strides that adaptive takes in a scene.
pub(super) fn strides(
    gradients: &Gradients,
    grid: &LeafGrid,
    occupancy: &Occupancy,
    scene: &Scene,
) -> Strides {
    Strides::new(occupancy, gradients, grid, scene.table, scene.frame.step)
}
