//! What is active under one table and mode, and what each method makes of it.

use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

use glam::DVec3;

use super::near::near_first;
use crate::cpu::CpuPlan;
use crate::mode::Activity;
use crate::octree::{Accelerator, Bricks, Cells, Hull, LeafGrid, Occupancy};
use crate::render::block_words::{BlockWords, bounded_by, cell_rule};
use crate::render::{Preparation, Settings, ms_since};
use crate::sample::{Classification, Sampler};
use crate::scene::Scene;
use crate::skip::beam_masks::BeamMasks;
use crate::skip::k_cuts::{BestCuts, Planes};
use crate::skip::{self, HalfCut, Majorants, Skip};
use crate::transfer::Table;

/// Edge in voxels, about, of the boxes that tell which tiles can show anything.
const TILE_BOX: usize = 16;

/// What is active under one table and mode.
pub(super) struct Culled {
    pub(super) id: u64,
    pub(super) activity: Activity,
    /// Whether values between voxels do not count.
    pub(super) is_by_voxel: bool,
    pub(super) table: Arc<Table>,
    pub(super) occupancy: Occupancy,
    /// By the blocks that they are of, as they were asked for first: a hull's place is its name.
    pub(super) hulls: Vec<([Range<usize>; 3], Hull)>,
    pub(super) best_cuts: [Option<BestCuts>; 3],
    /// Boxes around the active blocks, local coordinates.
    pub(super) boxes: Vec<[DVec3; 2]>,
    pub(super) cull_ms: f64,
    /// What the SIMD backend keeps, by method.
    pub(super) cpu_plans: Vec<CpuPlan>,
    pub(super) masks: Option<BeamMasks>,
    cells: Option<Arc<Cells>>,
    bricks: Option<Bricks>,
    /// What shaders of their own read of every block, by method.
    pub(super) words: Vec<BlockWords>,
    /// Those that were asked for last, and what making them took, in ms.
    majorants: Option<(Arc<Majorants>, f64)>,
}

impl Culled {
    pub(super) fn new(
        id: u64,
        settings: &Settings,
        scene: &Scene,
        table: &Arc<Table>,
        accelerator: &Accelerator,
    ) -> Self {
        let start = Instant::now();
        let is_halved = settings.skip == Skip::HalfSplit && settings.cuts.half == HalfCut::Middle;
        let halves = is_halved.then(|| skip::half_axis(settings.camera.forward()));
        let is_by_voxel = settings.classification == Classification::Pre;
        let occupancy = match halves {
            _ if is_by_voxel => {
                let apron = scene.sampler.apron();
                Occupancy::of_visible_voxels(scene.volume, table, settings.block, apron)
            }
            Some(axis) => accelerator.cull_halves(axis, table, settings.mode),
            None => accelerator.cull(table, settings.mode),
        };
        let boxes = boxes(&occupancy, scene);
        Self {
            id,
            activity: settings.mode.activity(table.domain()),
            is_by_voxel,
            table: Arc::clone(table),
            occupancy,
            hulls: Vec::new(),
            best_cuts: Default::default(),
            boxes,
            cull_ms: ms_since(start),
            cpu_plans: Vec::new(),
            masks: None,
            cells: None,
            bricks: None,
            words: Vec::new(),
            majorants: None,
        }
    }

    /// What bounds the blocks of `grid` in the scene's mode, where the settings' method asks; made at first use.
    pub(super) fn majorants(
        &mut self,
        settings: &Settings,
        scene: &Scene,
        grid: &LeafGrid,
    ) -> Option<Arc<Majorants>> {
        bounded_by(settings)?;
        let domain = *self.table.domain();
        let holds = |(kept, _): &(Arc<Majorants>, _)| kept.hold_for(&scene.mode, &domain);
        if !self.majorants.as_ref().is_some_and(holds) {
            let start = Instant::now();
            let voxel_type = scene.volume.voxels.voxel_type();
            let made = Majorants::new(grid, voxel_type, &domain, &scene.mode);
            self.majorants = Some((Arc::new(made), ms_since(start)));
        }
        self.majorants.as_ref().map(|(made, _)| Arc::clone(made))
    }

    /// The cells that contribute, made at first use.
    pub(super) fn cells(&mut self, settings: &Settings, scene: &Scene) -> Arc<Cells> {
        let made = self.cells.get_or_insert_with(|| {
            let start = Instant::now();
            let rule = cell_rule(settings, scene, &self.table);
            let cells = Cells::new(&rule, &self.occupancy);
            self.cull_ms += ms_since(start);
            Arc::new(cells)
        });
        Arc::clone(made)
    }

    /// Makes the bricks that the settings' samples may come from, at first use; whether they may come from any. Bricks hold what
    /// trilinear interpolation reads, and tell of one point of a ray whether it shows anything there.
    pub(super) fn make_bricks(&mut self, settings: &Settings, scene: &Scene) -> bool {
        let reads = settings.skip.reads_bricks()
            && scene.sampler == Sampler::Exact
            && settings.classification == Classification::Post;
        if reads && self.bricks.is_none() {
            let cells = self.cells(settings, scene);
            let start = Instant::now();
            self.bricks = Some(Bricks::new(&cells));
            self.cull_ms += ms_since(start);
        }
        reads
    }

    /// Those that were made, and their name, if they are few enough to be worth their memory.
    pub(super) fn bricks(&self) -> Option<(u64, &Bricks)> {
        let bricks = self.bricks.as_ref()?;
        bricks.are_few().then_some((self.id, bricks))
    }

    /// The majorants that the settings' method reads, if those were made last.
    pub(super) fn majorants_of(&self, settings: &Settings) -> Option<&Majorants> {
        let (made, _) = self.majorants.as_ref()?;
        bounded_by(settings).map(|_| &**made)
    }

    /// What the settings' method reads of every block, if that was made.
    pub(super) fn words_of(&self, settings: &Settings) -> Option<&BlockWords> {
        self.words.iter().find(|w| w.are_of(settings))
    }

    /// The axis that the settings' method cuts across, and where it does.
    pub(super) fn planes(
        &mut self,
        settings: &Settings,
        scene: &Scene,
        cut_samples: f64,
    ) -> (usize, Planes) {
        let axis = skip::half_axis(settings.camera.forward());
        let middle = self.occupancy.half_cut(axis);
        let block_size = scene.volume.voxel_size()[axis] * self.occupancy.block as f64;
        let cut_cost = cut_samples * scene.frame.step / block_size;
        let planes = settings
            .cuts
            .planes(settings.skip, middle, || self.best_cuts(axis), cut_cost);
        (axis, planes)
    }

    fn best_cuts(&mut self, axis: usize) -> &BestCuts {
        self.best_cuts[axis].get_or_insert_with(|| {
            let start = Instant::now();
            let best = BestCuts::new(&self.occupancy, axis);
            self.cull_ms += ms_since(start);
            best
        })
    }

    /// The blocks of each part that the settings' method rasterises, near part first.
    pub(super) fn regions(
        &mut self,
        settings: &Settings,
        scene: &Scene,
        cut_samples: f64,
    ) -> Vec<[Range<usize>; 3]> {
        if !matches!(settings.skip, Skip::Hull | Skip::HalfSplit | Skip::KCuts) {
            // The others take no rasterised parts; the backend refuses what it does not have.
            return Vec::new();
        }
        let (axis, planes) = self.planes(settings, scene, cut_samples);
        let block_size = scene.volume.voxel_size()[axis] * self.occupancy.block as f64;
        let local: Vec<f64> = planes
            .as_slice()
            .iter()
            .map(|&p| p as f64 * block_size)
            .collect();
        let slabs: Vec<_> = planes.slabs(self.occupancy.dims[axis]).collect();
        near_first(&settings.camera, axis, &local)
            .map(|slab| {
                let mut region = self.occupancy.whole();
                region[axis] = slabs[slab].clone();
                region
            })
            .collect()
    }

    /// Builds the hull of a region, unless it stands, and tells its place.
    pub(super) fn make_hull(&mut self, region: &[Range<usize>; 3]) -> usize {
        if let Some(place) = self.hulls.iter().position(|(r, _)| r == region) {
            return place;
        }
        let start = Instant::now();
        let hull = Hull::build(&self.occupancy, region.clone());
        self.hulls.push((region.clone(), hull));
        self.cull_ms += ms_since(start);
        self.hulls.len() - 1
    }

    /// What stands for the settings' method, which rasterises the hulls at these places.
    pub(super) fn preparation(
        &self,
        settings: &Settings,
        hulls: &[usize],
        accelerator: &Accelerator,
        build_ms: f64,
    ) -> Preparation {
        let words = self.words_of(settings);
        let masks = self
            .masks
            .as_ref()
            .filter(|_| settings.skip == Skip::BeamMasks);
        let bounded = bounded_by(settings);
        let majorants = self.majorants.as_ref().filter(|_| bounded.is_some());
        let hulls = hulls
            .iter()
            .map(|&i| size_of_val(&self.hulls[i].1.faces[..]));
        let bytes = accelerator.structure_bytes()
            + size_of_val(self.occupancy.words())
            + hulls.sum::<usize>()
            + words.map_or(0, |w| w.content.len() * 4)
            + masks.map_or(0, BeamMasks::bytes)
            + majorants.map_or(0, |(m, _)| m.bytes().len());
        Preparation {
            preprocess_ms: build_ms,
            cull_ms: self.cull_ms
                + words.map_or(0.0, |w| w.ms)
                + majorants.map_or(0.0, |(_, ms)| *ms),
            structure_bytes: bytes as u64,
        }
    }
}

/// Boxes around the active blocks, some blocks to each.
fn boxes(occupancy: &Occupancy, scene: &Scene) -> Vec<[DVec3; 2]> {
    let group = (TILE_BOX / occupancy.block).max(1);
    let block_size = scene.volume.voxel_size() * occupancy.block as f64;
    let mut boxes = Vec::new();
    let groups = |axis: usize| (0..occupancy.dims[axis]).step_by(group);
    for z in groups(2) {
        for y in groups(1) {
            for x in groups(0) {
                let end = |from: usize, axis: usize| (from + group).min(occupancy.dims[axis]);
                let is_active = (z..end(z, 2)).any(|z| {
                    (y..end(y, 1)).any(|y| (x..end(x, 0)).any(|x| occupancy.get([x, y, z])))
                });
                if is_active {
                    let low = DVec3::new(x as f64, y as f64, z as f64) * block_size;
                    let high = DVec3::new(end(x, 0) as f64, end(y, 1) as f64, end(z, 2) as f64)
                        * block_size;
                    boxes.push([low, high.min(scene.frame.extent)]);
                }
            }
        }
    }
    boxes
}
