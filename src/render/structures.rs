//! The structures of the resident volume: built at first use, kept, culled again when the table's zeros move.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

use glam::DVec3;

use super::gpu::Part;
use super::{Preparation, Settings};
use crate::camera::{Camera, Projection};
use crate::cpu::CpuPlan;
use crate::error::Result;
use crate::octree::{Accelerator, Hull, Occupancy};
use crate::scene::Scene;
use crate::skip::beam_masks::BeamMasks;
use crate::skip::{self, Plan, Skip};
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
}

/// What the GPU backend needs of the structures.
pub(super) struct GpuNeeds<'a> {
    /// What is rasterised, near part first.
    pub(super) parts: Vec<Part<'a>>,
    /// What tells each tile its segments, where nothing is rasterised.
    pub(super) masks: Option<&'a BeamMasks>,
    /// Boxes around all that can be seen, local coordinates.
    pub(super) active: Vec<[DVec3; 2]>,
}

struct Kept {
    accelerator: Accelerator,
    build_ms: f64,
    culled: Option<Culled>,
}

/// What is active under one table and mode.
struct Culled {
    id: u64,
    mode: crate::mode::Mode,
    table: Arc<Table>,
    occupancy: Occupancy,
    whole: Option<Hull>,
    halves: [Option<[Hull; 2]>; 3],
    /// Boxes around the active blocks, local coordinates.
    boxes: Vec<[DVec3; 2]>,
    cull_ms: f64,
    /// What the SIMD backend keeps, by method.
    cpu_plans: Vec<CpuPlan>,
    masks: Option<BeamMasks>,
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

    /// What the GPU backend needs for the settings' method.
    pub(super) fn gpu_needs(
        &mut self,
        settings: &Settings,
        scene: &Scene,
        table: &Arc<Table>,
    ) -> Result<(GpuNeeds<'_>, Preparation)> {
        if settings.skip == Skip::Box {
            let needs = GpuNeeds {
                parts: Vec::new(),
                masks: None,
                active: vec![[DVec3::ZERO, scene.frame.extent]],
            };
            return Ok((needs, Preparation::default()));
        }
        let kept = self.culled(settings, scene, table)?;
        let regions = regions(settings, scene, &kept.accelerator);
        let (accelerator, build_ms) = (&kept.accelerator, kept.build_ms);
        let culled = kept.culled.as_mut().expect("culled just above");
        culled.make_hulls(&regions);
        if settings.skip == Skip::BeamMasks && culled.masks.is_none() {
            culled.masks = Some(BeamMasks::new(culled.occupancy.clone()));
        }
        let culled = &*culled;
        let preparation = culled.preparation(accelerator, build_ms);
        let parts = regions
            .iter()
            .map(|region| Part {
                key: (culled.id, region.key()),
                hull: culled.hull(region),
                starts_near: starts_near(
                    &culled.occupancy,
                    &region.blocks,
                    &settings.camera,
                    scene,
                ),
            })
            .collect();
        let needs = GpuNeeds {
            parts,
            masks: culled
                .masks
                .as_ref()
                .filter(|_| settings.skip == Skip::BeamMasks),
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
        if settings.skip == Skip::Box {
            return Ok((Plan::Box, Preparation::default()));
        }
        let kept = self.culled(settings, scene, table)?;
        let culled = kept.culled.as_ref().expect("culled just above");
        let occupancy = &culled.occupancy;
        let plan = Plan::new(settings.skip, occupancy, settings.camera.forward())?;
        Ok((plan, culled.preparation(&kept.accelerator, kept.build_ms)))
    }

    /// What the SIMD backend needs.
    pub(super) fn cpu_plan(
        &mut self,
        settings: &Settings,
        scene: &Scene,
        table: &Arc<Table>,
    ) -> Result<(&CpuPlan, Preparation)> {
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
        let mut preparation = culled.preparation(&kept.accelerator, kept.build_ms);
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
                    culled: None,
                })
            }
        };
        let is_current = kept
            .culled
            .as_ref()
            .is_some_and(|c| c.mode == settings.mode && c.table.shows_the_same_as(table));
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

/// A part of the volume that is rasterised on its own.
struct Region {
    /// `None`: the whole; else axis and half (0: low).
    half: Option<(usize, usize)>,
    blocks: [Range<usize>; 3],
}

impl Region {
    fn key(&self) -> u8 {
        self.half
            .map_or(0, |(axis, half)| 1 + (axis * 2 + half) as u8)
    }
}

/// The regions of a method, near one first.
fn regions(settings: &Settings, scene: &Scene, accelerator: &Accelerator) -> Vec<Region> {
    match settings.skip {
        // The others take no rasterised parts; the backend refuses what it does not have.
        Skip::Box | Skip::BeamMasks | Skip::DistanceMap => Vec::new(),
        Skip::Hull => vec![Region {
            half: None,
            blocks: accelerator.grid.dims.map(|n| 0..n),
        }],
        Skip::HalfSplit => {
            let camera = &settings.camera;
            let axis = skip::half_axis(camera.forward());
            let cut = accelerator.cut(axis) as f64
                * settings.block as f64
                * scene.volume.voxel_size()[axis];
            // A ray crosses the cut at most once, so the half on the camera's side comes first for every pixel.
            let low_first = match camera.projection {
                Projection::Perspective { .. } => camera.eye[axis] < cut,
                Projection::Orthographic { .. } => camera.forward()[axis] > 0.0,
            };
            let order = if low_first { [0, 1] } else { [1, 0] };
            order
                .map(|half| Region {
                    half: Some((axis, half)),
                    blocks: accelerator.half_region(axis, half),
                })
                .into()
        }
    }
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
        let halves =
            (settings.skip == Skip::HalfSplit).then(|| skip::half_axis(settings.camera.forward()));
        let occupancy = match halves {
            Some(axis) => accelerator.cull_halves(axis, table, settings.mode),
            None => accelerator.cull(table, settings.mode),
        };
        let boxes = boxes(&occupancy, scene);
        Self {
            id,
            mode: settings.mode,
            table: Arc::clone(table),
            occupancy,
            whole: None,
            halves: Default::default(),
            boxes,
            cull_ms: ms_since(start),
            cpu_plans: Vec::new(),
            masks: None,
        }
    }

    fn make_hulls(&mut self, regions: &[Region]) {
        let start = Instant::now();
        for region in regions {
            match region.half {
                None if self.whole.is_none() => {
                    self.whole = Some(Hull::build(&self.occupancy, region.blocks.clone()));
                }
                Some((axis, _)) if self.halves[axis].is_none() => {
                    let [a, b] = [0, 1].map(|half| {
                        let region = regions.iter().find(|r| r.half == Some((axis, half)));
                        region.map_or_else(Hull::default, |r| {
                            Hull::build(&self.occupancy, r.blocks.clone())
                        })
                    });
                    self.halves[axis] = Some([a, b]);
                }
                _ => continue,
            }
            self.cull_ms += ms_since(start);
        }
    }

    fn hull(&self, region: &Region) -> &Hull {
        match region.half {
            None => self.whole.as_ref(),
            Some((axis, half)) => self.halves[axis].as_ref().map(|h| &h[half]),
        }
        .expect("hulls are made before they are drawn")
    }

    fn preparation(&self, accelerator: &Accelerator, build_ms: f64) -> Preparation {
        Preparation {
            preprocess_ms: build_ms,
            cull_ms: self.cull_ms,
            structure_bytes: accelerator.structure_bytes() as u64 + self.bytes(),
        }
    }

    fn bytes(&self) -> u64 {
        let hulls = self
            .whole
            .iter()
            .chain(self.halves.iter().flatten().flatten());
        (size_of_val(self.occupancy.words())
            + hulls.map(|h| size_of_val(&h.faces[..])).sum::<usize>()
            + self.masks.as_ref().map_or(0, BeamMasks::bytes)) as u64
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

fn ms_since(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}
