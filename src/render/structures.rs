//! The structures of the resident volume: built at first use, kept, culled again when the table's zeros move.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

use glam::DVec3;

use super::gpu::Part;
use super::{Preparation, Settings, ms_since};
use crate::camera::{Camera, Projection};
use crate::cpu::CpuPlan;
use crate::error::{Error, Result};
use crate::mode::Activity;
use crate::octree::{Accelerator, Hull, LeafGrid, Occupancy};
use crate::sample::Classification;
use crate::scene::Scene;
use crate::skip::adaptive::{Gradients, Strides};
use crate::skip::beam_masks::BeamMasks;
use crate::skip::k_cuts::{BestCuts, CUT_SAMPLES, Planes};
use crate::skip::{self, HalfCut, Plan, Skip};
use crate::transfer::Table;

/// Edge in voxels, about, of the boxes that tell which tiles can show anything.
const TILE_BOX: usize = 16;

/// Accelerators by block size, each with what a table left of it.
#[derive(Default)]
pub(super) struct Structures {
    /// Smallest and largest stored number of the volume.
    range: [f64; 2],
    by_block: BTreeMap<usize, Kept>,
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
    /// What the method's own shader reads of every block, and its name.
    pub(super) blocks: Option<(u64, &'a [u32])>,
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

/// What is active under one table and mode.
struct Culled {
    id: u64,
    activity: Activity,
    /// Whether values between voxels do not count.
    is_by_voxel: bool,
    table: Arc<Table>,
    occupancy: Occupancy,
    /// By the blocks that they are of, as they were asked for first: a hull's place is its name.
    hulls: Vec<([Range<usize>; 3], Hull)>,
    best_cuts: [Option<BestCuts>; 3],
    /// Boxes around the active blocks, local coordinates.
    boxes: Vec<[DVec3; 2]>,
    cull_ms: f64,
    /// What the SIMD backend keeps, by method.
    cpu_plans: Vec<CpuPlan>,
    masks: Option<BeamMasks>,
    /// What shaders of their own read of every block, by method.
    words: Vec<Words>,
}

/// What one method's shader reads of every block.
struct Words {
    /// Names them among all that is on the device.
    id: u64,
    skip: Skip,
    /// The table that they were made for.
    table: Arc<Table>,
    content: Vec<u32>,
    /// What making them took.
    ms: f64,
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

    /// Takes what a cut costs.
    pub(super) fn set_cut_samples(&mut self, samples: f64) {
        self.cut_samples = Some(samples);
    }

    /// Drops all that was built; what is built next has other names.
    pub(super) fn clear(&mut self) {
        self.by_block.clear();
        self.cpu_box = None;
    }

    /// Which blocks of the settings' size are active.
    pub(super) fn occupancy(
        &mut self,
        settings: &Settings,
        scene: &Scene,
        table: &Arc<Table>,
    ) -> Result<&Occupancy> {
        let kept = self.culled(settings, scene, table)?;
        Ok(&kept.culled.as_ref().expect("culled just above").occupancy)
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
        if settings.skip == Skip::Adaptive {
            // What its words say of blocks follows from the whole table, not only from where it shows anything.
            let is_current = |w: &Words| w.skip != settings.skip || Arc::ptr_eq(&w.table, table);
            culled.words.retain(is_current);
        }
        if culled.words_of(settings.skip).is_none() {
            let start = Instant::now();
            let words = match settings.skip {
                Skip::Adaptive => {
                    let grid = &kept.accelerator.grid;
                    let gradients = kept
                        .gradients
                        .get_or_insert_with(|| Gradients::new(scene.volume, grid));
                    Some(strides(gradients, grid, &culled.occupancy, scene).words())
                }
                skip => skip.block_words(&culled.occupancy),
            };
            if let Some(words) = words {
                culled.words.push(Words {
                    id: words_id,
                    skip: settings.skip,
                    table: Arc::clone(table),
                    content: words,
                    ms: ms_since(start),
                });
            }
        }
        let regions = culled.regions(settings, scene, cut_samples);
        let places: Vec<usize> = regions.iter().map(|r| culled.make_hull(r)).collect();
        let culled = &*culled;
        let preparation = culled.preparation(settings.skip, &places, accelerator, build_ms);
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
            blocks: culled.words_of(settings.skip),
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
        let culled = &*culled;
        let mut preparation =
            culled.preparation(settings.skip, &[], &kept.accelerator, kept.build_ms);
        let start = Instant::now();
        let plan = if settings.skip == Skip::Adaptive {
            let grid = &kept.accelerator.grid;
            let gradients = kept
                .gradients
                .get_or_insert_with(|| Gradients::new(scene.volume, grid));
            Plan::Adaptive(strides(gradients, grid, &culled.occupancy, scene))
        } else {
            Plan::with_planes(settings.skip, &culled.occupancy, scene.frame, axis, planes)?
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
        if !culled
            .cpu_plans
            .iter()
            .any(|plan| plan.skip() == settings.skip)
        {
            let start = Instant::now();
            let plan = CpuPlan::new(settings.skip, scene.volume, table, &culled.occupancy)?;
            culled.cpu_plans.push(plan);
            culled.cull_ms += ms_since(start);
        }
        let culled = &*culled;
        let plan = culled
            .cpu_plans
            .iter()
            .find(|plan| plan.skip() == settings.skip);
        let plan = plan.expect("made just above");
        let mut preparation =
            culled.preparation(settings.skip, &[], &kept.accelerator, kept.build_ms);
        preparation.structure_bytes += plan.bytes() as u64;
        Ok((plan, preparation))
    }

    /// The structures of the settings' block size, culled for the table and mode.
    fn culled(
        &mut self,
        settings: &Settings,
        scene: &Scene,
        table: &Arc<Table>,
    ) -> Result<&mut Kept> {
        let kept = match self.by_block.entry(settings.block) {
            Entry::Occupied(entry) => entry.into_mut(),
            Entry::Vacant(entry) => {
                let start = Instant::now();
                let accelerator =
                    Accelerator::build(scene.volume, settings.block, scene.sampler.apron())?;
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

/// Slabs between `planes` (local coordinates along `axis`), in an order that serves every ray of the camera: outward from
/// the one that the eye is in, or from the first one that parallel rays meet. A ray leaves that slab upwards or downwards
/// and never turns, so that the slabs of the other side are none of its own, whichever side is listed first.
fn near_first(camera: &Camera, axis: usize, planes: &[f64]) -> impl Iterator<Item = usize> {
    let nearest = match camera.projection {
        Projection::Perspective { .. } => planes.partition_point(|&p| p <= camera.eye[axis]),
        Projection::Orthographic { .. } if camera.forward()[axis] > 0.0 => 0,
        Projection::Orthographic { .. } => planes.len(),
    };
    (nearest..=planes.len()).chain((0..nearest).rev())
}

/// Whether an active block of a region lies where rays start, give or take the larger of one sample and half a voxel:
/// its front face may be clipped there.
fn starts_near(
    occupancy: &Occupancy,
    region: &[Range<usize>; 3],
    camera: &Camera,
    scene: &Scene,
) -> bool {
    let block_size = scene.volume.voxel_size() * occupancy.block as f64;
    // Faces grow up to half a voxel and are clipped a 64th before the eye's plane, more towards a wide picture's corners.
    let reach = scene.frame.step.max(0.5) + 1.0;
    let is_touched = |low: DVec3, high: DVec3| match camera.projection {
        Projection::Perspective { .. } => {
            camera.eye.cmpge(low - reach).all() && camera.eye.cmple(high + reach).all()
        }
        Projection::Orthographic { .. } => {
            // Depth of the box before the eye's plane: from its nearest to its farthest corner.
            let forward = camera.forward();
            let centre = ((low + high) * 0.5 - camera.eye).dot(forward);
            let half = ((high - low) * 0.5).dot(forward.abs());
            (centre - half..=centre + half).contains(&0.0) || (centre.abs() - half).abs() <= reach
        }
    };
    // Only blocks near the eye (or its plane) are looked at one by one.
    let bounds = |b: [usize; 3], e: [usize; 3]| {
        let v = |b: [usize; 3]| DVec3::from_array(b.map(|n| n as f64)) * block_size;
        is_touched(v(b), v(e))
    };
    if !bounds(
        region.clone().map(|r| r.start),
        region.clone().map(|r| r.end),
    ) {
        return false;
    }
    region[2].clone().any(|z| {
        bounds(
            [region[0].start, region[1].start, z],
            [region[0].end, region[1].end, z + 1],
        ) && region[1].clone().any(|y| {
            bounds([region[0].start, y, z], [region[0].end, y + 1, z + 1])
                && region[0]
                    .clone()
                    .any(|x| occupancy.get([x, y, z]) && bounds([x, y, z], [x + 1, y + 1, z + 1]))
        })
    })
}

impl Culled {
    fn new(
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
            words: Vec::new(),
        }
    }

    /// What a method's own shader reads, and its name.
    fn words_of(&self, skip: Skip) -> Option<(u64, &[u32])> {
        let found = self.words.iter().find(|w| w.skip == skip)?;
        Some((found.id, &found.content))
    }

    /// The axis that the settings' method cuts across, and where it does.
    fn planes(&mut self, settings: &Settings, scene: &Scene, cut_samples: f64) -> (usize, Planes) {
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
    fn regions(
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
    fn make_hull(&mut self, region: &[Range<usize>; 3]) -> usize {
        if let Some(place) = self.hulls.iter().position(|(r, _)| r == region) {
            return place;
        }
        let start = Instant::now();
        let hull = Hull::build(&self.occupancy, region.clone());
        self.hulls.push((region.clone(), hull));
        self.cull_ms += ms_since(start);
        self.hulls.len() - 1
    }

    /// What stands for one method, which rasterises the hulls at these places.
    fn preparation(
        &self,
        skip: Skip,
        hulls: &[usize],
        accelerator: &Accelerator,
        build_ms: f64,
    ) -> Preparation {
        let words = self.words.iter().find(|w| w.skip == skip);
        let masks = self.masks.as_ref().filter(|_| skip == Skip::BeamMasks);
        let hulls = hulls
            .iter()
            .map(|&i| size_of_val(&self.hulls[i].1.faces[..]));
        let bytes = accelerator.structure_bytes()
            + size_of_val(self.occupancy.words())
            + hulls.sum::<usize>()
            + words.map_or(0, |w| w.content.len() * 4)
            + masks.map_or(0, BeamMasks::bytes);
        Preparation {
            preprocess_ms: build_ms,
            cull_ms: self.cull_ms + words.map_or(0.0, |w| w.ms),
            structure_bytes: bytes as u64,
        }
    }
}

/// The strides that adaptive takes in a scene.
fn strides(
    gradients: &Gradients,
    grid: &LeafGrid,
    occupancy: &Occupancy,
    scene: &Scene,
) -> Strides {
    Strides::new(occupancy, gradients, grid, scene.table, scene.frame.step)
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
