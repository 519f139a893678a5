//! The structures of the resident volume: built at first use, kept, culled again when the table's zeros move.

mod culled;
mod near;

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::Arc;
use std::time::Instant;

use glam::DVec3;

use self::culled::Culled;
use self::near::starts_near;
use super::block_words::{BlockWords, strides};
use super::gpu::Part;
use super::{Preparation, Settings, ms_since};
use crate::cpu::CpuPlan;
use crate::error::{Error, Result};
use crate::octree::{Accelerator, Bricks, Occupancy};
use crate::sample::Classification;
use crate::scene::Scene;
use crate::skip::adaptive::Gradients;
use crate::skip::beam_cells::Near;
use crate::skip::beam_masks::BeamMasks;
use crate::skip::k_cuts::CUT_SAMPLES;
use crate::skip::{HalfCut, Majorants, Plan, Skip};
use crate::transfer::Table;

/// Accelerators by block size and apron, each with what a table left of it.
#[derive(Default)]
pub(super) struct Structures {
    /// Smallest and largest stored number of the volume.
    range: [f64; 2],
    by_block: BTreeMap<(usize, usize), Kept>,
    /// What the SIMD backend keeps for box, which needs no block.
    cpu_box: Option<(Arc<Table>, CpuPlan)>,
    /// Names the culled states, so that what is on the device can be told apart.
    next_id: u64,
    /// What a cut costs on this adapter, where that was calibrated; else [`CUT_SAMPLES`].
    cut_samples: Option<f64>,
}

/// What the GPU backend needs of the structures.
pub(super) struct GpuNeeds<'a> {
    /// What is rasterised, near part first.
    pub(super) parts: Vec<Part<'a>>,
    /// What tells each tile its segments, where nothing is rasterised.
    pub(super) masks: Option<&'a BeamMasks>,
    /// What the method's own shader reads of every block.
    pub(super) blocks: Option<&'a BlockWords>,
    /// What its samples come from in place of the volume, and the name of that.
    pub(super) bricks: Option<(u64, &'a Bricks)>,
    /// Boxes around all that can be seen, local coordinates.
    pub(super) active: Vec<[DVec3; 2]>,
}

struct Kept {
    accelerator: Accelerator,
    build_ms: f64,
    /// What adaptive strides follow from, besides the table.
    gradients: Option<Gradients>,
    culled: Option<Culled>,
}

impl Structures {
    /// Notes the range of a volume's stored numbers.
    pub(super) fn set_range(&mut self, range: [f64; 2]) {
        self.range = range;
    }

    /// Smallest and largest stored number.
    pub(super) fn range(&self) -> [f64; 2] {
        self.range
    }

    /// What a cut costs, in samples on every pixel of the box.
    pub(super) fn cut_samples(&self) -> f64 {
        self.cut_samples.unwrap_or(CUT_SAMPLES)
    }

    /// Takes what a cut costs; `None`: it is not known.
    pub(super) fn set_cut_samples(&mut self, samples: Option<f64>) {
        self.cut_samples = samples;
    }

    /// Drops all that was built; what is built next has other names.
    pub(super) fn clear(&mut self) {
        self.by_block.clear();
        self.cpu_box = None;
    }

    /// Which blocks of the settings' size are active, and what they are bounded by where the settings' method asks.
    pub(super) fn occupancy(
        &mut self,
        settings: &Settings,
        scene: &Scene,
        table: &Arc<Table>,
    ) -> Result<(&Occupancy, Option<Arc<Majorants>>)> {
        let kept = self.culled(settings, scene, table)?;
        let culled = kept.culled.as_mut().expect("culled just above");
        let majorants = culled.majorants(settings, scene, &kept.accelerator.grid);
        Ok((&culled.occupancy, majorants))
    }

    /// What the GPU backend needs for the settings' method.
    pub(super) fn gpu_needs(
        &mut self,
        settings: &Settings,
        scene: &Scene,
        table: &Arc<Table>,
    ) -> Result<(GpuNeeds<'_>, Preparation)> {
        if !settings.skip.reads_blocks() {
            let needs = GpuNeeds {
                parts: Vec::new(),
                masks: None,
                blocks: None,
                bricks: None,
                active: vec![[DVec3::ZERO, scene.frame.extent]],
            };
            return Ok((needs, Preparation::default()));
        }
        let cut_samples = self.cut_samples();
        self.next_id += 1;
        let words_id = self.next_id;
        let kept = self.culled(settings, scene, table)?;
        let (accelerator, build_ms) = (&kept.accelerator, kept.build_ms);
        let culled = kept.culled.as_mut().expect("culled just above");
        if settings.skip == Skip::BeamMasks && culled.masks.is_none() {
            culled.masks = Some(BeamMasks::new(culled.occupancy.clone()));
        }
        culled.words.retain(|w| w.hold_under(table));
        if culled.words_of(settings).is_none() {
            let grid = &accelerator.grid;
            let majorants = culled.majorants(settings, scene, grid);
            let reads_cells = settings.skip.reads_cells();
            let cells = reads_cells.then(|| culled.cells(settings, scene));
            let blocks = (grid, &culled.occupancy);
            let after = (majorants.as_deref(), cells.as_deref());
            let gradients = &mut kept.gradients;
            let made = BlockWords::make(words_id, settings, scene, table, blocks, after, gradients);
            culled.words.extend(made);
        }
        let reads_bricks = culled.make_bricks(settings, scene);
        let regions = culled.regions(settings, scene, cut_samples);
        let places: Vec<usize> = regions.iter().map(|r| culled.make_hull(r)).collect();
        let culled = &*culled;
        let preparation = culled.preparation(settings, &places, accelerator, build_ms);
        let parts = regions
            .iter()
            .zip(places)
            .map(|(region, place)| Part {
                key: (culled.id, place),
                hull: &culled.hulls[place].1,
                starts_near: starts_near(&culled.occupancy, region, &settings.camera, scene),
            })
            .collect();
        let needs = GpuNeeds {
            parts,
            masks: culled
                .masks
                .as_ref()
                .filter(|_| settings.skip == Skip::BeamMasks),
            blocks: culled.words_of(settings),
            bricks: culled.bricks().filter(|_| reads_bricks),
            active: culled.boxes.clone(),
        };
        Ok((needs, preparation))
    }

    /// What finding segments on the CPU needs.
    pub(super) fn plan(
        &mut self,
        settings: &Settings,
        scene: &Scene,
        table: &Arc<Table>,
    ) -> Result<(Plan<'_>, Preparation)> {
        match settings.skip {
            Skip::Box => return Ok((Plan::Box, Preparation::default())),
            Skip::TwoStep => return Ok((Plan::TwoStep, Preparation::default())),
            _ => {}
        }
        let cut_samples = self.cut_samples();
        let kept = self.culled(settings, scene, table)?;
        let culled = kept.culled.as_mut().expect("culled just above");
        let (axis, planes) = culled.planes(settings, scene, cut_samples);
        culled.majorants(settings, scene, &kept.accelerator.grid);
        let reads_cells = settings.skip.reads_cells();
        let cells = reads_cells.then(|| culled.cells(settings, scene));
        let culled = &*culled;
        let mut preparation = culled.preparation(settings, &[], &kept.accelerator, kept.build_ms);
        let start = Instant::now();
        let plan = if settings.skip == Skip::Adaptive {
            let grid = &kept.accelerator.grid;
            let gradients = kept
                .gradients
                .get_or_insert_with(|| Gradients::new(scene.volume, grid));
            Plan::Adaptive(strides(gradients, grid, &culled.occupancy, scene))
        } else {
            let occupancy = &culled.occupancy;
            let plan = Plan::with_planes(settings.skip, occupancy, scene.frame, axis, planes)?;
            match (culled.majorants_of(settings), cells) {
                (Some(majorants), _) => plan.bounded(majorants),
                (None, Some(cells)) => plan.cut_down(Near::Distances(cells)),
                (None, None) => plan,
            }
        };
        preparation.cull_ms += ms_since(start);
        Ok((plan, preparation))
    }

    /// What the SIMD backend needs.
    pub(super) fn cpu_plan(
        &mut self,
        settings: &Settings,
        scene: &Scene,
        table: &Arc<Table>,
    ) -> Result<(&CpuPlan, Preparation)> {
        if settings.skip == Skip::HalfSplit && settings.cuts.half == HalfCut::Best {
            let reason = "the cpu backend cuts in the middle; gpu, reference have best";
            return Err(Error::setting("cut", reason));
        }
        if settings.skip == Skip::Box {
            let is_current = self
                .cpu_box
                .as_ref()
                .is_some_and(|(kept, _)| kept.shows_the_same_as(table));
            if !is_current {
                let nothing = Occupancy::new(scene.volume.dims, settings.block);
                let plan = CpuPlan::new(Skip::Box, scene.volume, table, &nothing)?;
                self.cpu_box = Some((Arc::clone(table), plan));
            }
            let (_, plan) = self.cpu_box.as_ref().expect("made just above");
            return Ok((plan, Preparation::default()));
        }
        let kept = self.culled(settings, scene, table)?;
        let culled = kept.culled.as_mut().expect("culled just above");
        let majorants = culled.majorants(settings, scene, &kept.accelerator.grid);
        let made = culled
            .cpu_plans
            .iter()
            .position(|plan| plan.skip() == settings.skip);
        let place = if let Some(place) = made {
            place
        } else {
            let start = Instant::now();
            let plan = CpuPlan::new(settings.skip, scene.volume, table, &culled.occupancy)?;
            culled.cpu_plans.push(plan);
            culled.cull_ms += ms_since(start);
            culled.cpu_plans.len() - 1
        };
        culled.cpu_plans[place].set_majorants(majorants);
        let culled = &*culled;
        let plan = &culled.cpu_plans[place];
        let mut preparation = culled.preparation(settings, &[], &kept.accelerator, kept.build_ms);
        preparation.structure_bytes += plan.bytes() as u64;
        Ok((plan, preparation))
    }

    /// The structures of the settings' block size and the sampler's apron, culled for the table and mode.
    fn culled(
        &mut self,
        settings: &Settings,
        scene: &Scene,
        table: &Arc<Table>,
    ) -> Result<&mut Kept> {
        let apron = scene.sampler.apron();
        let kept = match self.by_block.entry((settings.block, apron)) {
            Entry::Occupied(entry) => entry.into_mut(),
            Entry::Vacant(entry) => {
                let start = Instant::now();
                let accelerator = Accelerator::build(scene.volume, settings.block, apron)?;
                entry.insert(Kept {
                    accelerator,
                    build_ms: ms_since(start),
                    gradients: None,
                    culled: None,
                })
            }
        };
        let activity = settings.mode.activity(table.domain());
        let is_current = kept.culled.as_ref().is_some_and(|c| {
            let is_by_voxel = settings.classification == Classification::Pre;
            c.is_by_voxel == is_by_voxel && activity.is_that_of(table, c.activity, &c.table)
        });
        if !is_current {
            self.next_id += 1;
            kept.culled = Some(Culled::new(
                self.next_id,
                settings,
                scene,
                table,
                &kept.accelerator,
            ));
        }
        Ok(kept)
    }
}
