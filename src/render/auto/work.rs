//! The work that a frame will be to each method, counted along a bundle of its rays.
//!
//! Every ray stands for the tile of pixels that it goes through. How far early termination lets it come, and what it
//! meets on the way, is found once, by the f64 reference; what a method samples of that follows from the occupancy alone.

use std::cell::Cell;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

use super::Choice;
use crate::lattice::{Ray, RayFrame};
use crate::octree::{CellRule, Occupancy};
use crate::reference;
use crate::scene::Scene;
use crate::skip::beam_cells::{BeamCells, Near};
use crate::skip::beam_masks::{BeamMasks, Collapse, TileRuns};
use crate::skip::distance_map::DistanceMap;
use crate::skip::k_cuts::{BestCuts, Planes};
use crate::skip::{self, Bound, Majorants, Plan, Segments, Skip};

/// Edge in pixels of the tiles that the marchers draw.
const TILE: u32 = 8;

/// Rays of a bundle along each edge of the picture, at most.
const RAYS: u32 = 16;

/// Number of terms of [`Work::terms`].
pub(super) const TERMS: usize = 8;

/// What a frame takes, summed over its pixels.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Work {
    /// Pixels cleared: those of the picture, and of every layer of depth that is rasterised.
    pub(super) cleared: f64,
    /// Pixels whose rays are set up.
    pub(super) launched: f64,
    /// Samples marched, before early termination.
    pub(super) samples: f64,
    /// Samples that add something.
    pub(super) contributing: f64,
    /// Segments, or steps of a traversal.
    pub(super) steps: f64,
    /// Pixels of rasterised faces.
    pub(super) fragments: f64,
    /// What is looked at once per frame: faces, or layers of all tiles.
    pub(super) elements: f64,
}

impl Work {
    /// The numbers that a cost line has coefficients for; the first counts the frame itself.
    pub(super) fn terms(&self) -> [f64; TERMS] {
        [
            1.0,
            self.cleared,
            self.launched,
            self.samples,
            self.contributing,
            self.steps,
            self.fragments,
            self.elements,
        ]
    }
}

/// An occupancy with what methods make of it, each at first use.
#[derive(Debug)]
pub(super) struct Level {
    pub(super) occupancy: Occupancy,
    /// What its blocks are bounded by, in modes that keep the highest place of their window.
    majorants: Option<Majorants>,
    masks: BeamMasks,
    faces: usize,
    distances: OnceLock<Arc<DistanceMap>>,
    best_cuts: [OnceLock<BestCuts>; 3],
}

impl Level {
    pub(super) fn new(occupancy: Occupancy, majorants: Option<Majorants>) -> Self {
        Self {
            masks: BeamMasks::new(occupancy.clone()),
            faces: occupancy.exposed_faces(),
            occupancy,
            majorants,
            distances: OnceLock::new(),
            best_cuts: Default::default(),
        }
    }

    fn distances(&self) -> &Arc<DistanceMap> {
        self.distances
            .get_or_init(|| Arc::new(DistanceMap::new(&self.occupancy)))
    }

    /// The same in blocks twice as large.
    pub(super) fn coarser(&self) -> Self {
        let majorants = self.majorants.as_ref().map(Majorants::coarser);
        Self::new(self.occupancy.coarser(), majorants)
    }
}

/// Rays spread over a picture.
pub(super) struct Bundle<'a> {
    scene: &'a Scene<'a>,
    /// What makes a cell contribute.
    rule: CellRule<'a>,
    rays: Vec<BundleRay>,
    /// Pixels of the picture for each ray.
    weight: f64,
    /// The view's dominant axis, which half-split and k-cuts cut across.
    axis: usize,
}

/// One ray with what the marcher finds on it.
struct BundleRay {
    ray: Ray<f64>,
    pixel: [u32; 2],
    /// The tile that it stands for.
    tile: [Range<u32>; 2],
    /// One past the last sample that early termination lets it take.
    end: u32,
    contributing: u64,
    /// The samples that raised the highest place in the window, and to what; empty in modes that do not keep it.
    rises: Vec<(u32, f64)>,
}

impl BundleRay {
    /// What methods are told of the ray before sample `k` ([`Segments::next`]).
    fn highest_before(&self, k: u32, is_kept: bool) -> f64 {
        if !is_kept {
            return f64::NAN;
        }
        let seen = self.rises.partition_point(|(rise, _)| *rise < k);
        seen.checked_sub(1).map_or(0.0, |last| self.rises[last].1)
    }
}

impl<'a> Bundle<'a> {
    pub(super) fn new(scene: &'a Scene<'a>, rule: CellRule<'a>, forward: glam::DVec3) -> Self {
        let frame: &RayFrame = scene.frame;
        let tiles = frame.size.map(|n| n.div_ceil(TILE));
        let count = tiles.map(|n| n.min(RAYS));
        let (pixels, tiles): (Vec<[u32; 2]>, Vec<_>) = (0..count[0] * count[1])
            .map(|i| {
                let at = [i % count[0], i / count[0]];
                // Not the same place in every tile: that would look at the lattice of pixels through another.
                let within = [(i * 5 + at[1] * 3) % TILE, (i * 3 + at[1] * 2) % TILE];
                let tile: [Range<u32>; 2] = std::array::from_fn(|a| {
                    let tile = (2 * at[a] + 1) * tiles[a] / (2 * count[a]);
                    tile * TILE..((tile + 1) * TILE).min(frame.size[a])
                });
                let pixel =
                    std::array::from_fn(|a| (tile[a].start + within[a]).min(tile[a].end - 1));
                (pixel, tile)
            })
            .unzip();
        let found = reference::work_of(scene, &Plan::Box, &pixels);
        let basis = frame.basis::<f64>();
        let rays: Vec<BundleRay> = pixels
            .iter()
            .zip(tiles)
            .zip(found)
            .map(|((pixel, tile), found)| {
                let ray = basis.ray(f64::from(pixel[0]), f64::from(pixel[1]));
                BundleRay {
                    end: ray.k_near as u32 + found.counters.samples as u32,
                    contributing: found.counters.contributing,
                    rises: found.rises,
                    ray,
                    pixel: *pixel,
                    tile,
                }
            })
            .collect();
        Self {
            weight: f64::from(frame.size[0]) * f64::from(frame.size[1]) / rays.len() as f64,
            scene,
            rule,
            rays,
            axis: skip::half_axis(forward),
        }
    }

    /// The work of a frame by this choice over the occupancy of its block size; `None` where nothing is known of how the
    /// method finds its segments. `coarse` tells the tiles that a GPU launches.
    pub(super) fn work(
        &self,
        backend: &str,
        choice: &Choice,
        level: &Level,
        coarse: &Level,
        cut_samples: f64,
    ) -> Option<Work> {
        let occupancy = &level.occupancy;
        let mut work = Work {
            cleared: 1.0,
            ..Work::default()
        };
        let tiles = (self.weight * self.rays.len() as f64) / f64::from(TILE * TILE);
        // On the CPU, hulls too are those of the beams of tiles.
        let collapse = match (choice.skip, backend) {
            (Skip::BeamMasks, _) => Some(Collapse::Runs),
            (Skip::Hull, "cpu") => Some(Collapse::Hull),
            (Skip::HalfSplit, "cpu") => Some(Collapse::Halves),
            _ => None,
        };
        if let Some(collapse) = collapse {
            let mut looked_at = 0;
            self.along_beams(level, collapse, &mut work, &mut looked_at);
            let work = self.of_all_pixels(work);
            return Some(Work {
                elements: tiles * looked_at as f64 / self.rays.len() as f64,
                ..work
            });
        }
        // Tiles of a GPU's picture whose beams meet nothing are not launched, but for box.
        let launched = (backend == "gpu" && choice.skip != Skip::Box).then_some(coarse);
        if choice.skip == Skip::DistanceMap {
            let bound = Bound::by(level.majorants.as_ref());
            self.along_rays(launched, &mut work, |bundled| {
                Box::new(level.distances().segments(bundled.ray, bound))
            });
            return Some(self.of_all_pixels(work));
        }
        if choice.skip == Skip::BeamCells {
            // Few cells are asked for: looking at their voxels takes less than the distances of all.
            let (map, near) = (Arc::clone(level.distances()), Near::Rule(self.rule));
            let frame = self.scene.frame;
            let beams = BeamCells::with_map(map, occupancy.volume_dims, frame, near);
            let leaps = Cell::new(0);
            self.along_rays(launched, &mut work, |bundled| {
                let runs = beams.runs(bundled.pixel);
                leaps.set(leaps.get() + runs.steps);
                Box::new(beams.segments(bundled.ray, bundled.pixel, runs))
            });
            return Some(Work {
                elements: tiles * f64::from(leaps.get()) / self.rays.len() as f64,
                ..self.of_all_pixels(work)
            });
        }
        let planes = self.planes(choice, level, cut_samples);
        let frame = self.scene.frame;
        let plan = Plan::with_planes(choice.skip, occupancy, frame, self.axis, planes).ok()?;
        let plan = match &level.majorants {
            Some(majorants) => plan.bounded(majorants),
            None => plan,
        };
        // No lossless method asks what shows.
        self.along_rays(launched, &mut work, |bundled| {
            plan.segments(&bundled.ray, bundled.pixel, &|_| false)
        });
        if choice.skip == Skip::SegmentList {
            let walk = Plan::new(Skip::GridDda, occupancy, frame).ok()?;
            work.steps += self.steps_of_listing(launched, &walk);
        }
        let is_rasterised =
            backend == "gpu" && matches!(choice.skip, Skip::Hull | Skip::HalfSplit | Skip::KCuts);
        if !is_rasterised {
            return Some(self.of_all_pixels(work));
        }
        // Hulls are rasterised: front and back of each part.
        let parts = planes.as_slice().len() + 1;
        work.cleared += 2.0 * parts as f64;
        for ray in &self.rays {
            work.fragments += 2.0 * entries(&ray.ray, occupancy) / self.rays.len() as f64;
        }
        let work = self.of_all_pixels(work);
        Some(Work {
            elements: level.faces as f64,
            ..work
        })
    }

    /// Where a method cuts: as [`crate::render::Renderer::draw`] will.
    fn planes(&self, choice: &Choice, level: &Level, cut_samples: f64) -> Planes {
        let (axis, occupancy) = (self.axis, &level.occupancy);
        let block_size = self.scene.volume.voxel_size()[axis] * occupancy.block as f64;
        choice.cuts.planes(
            choice.skip,
            occupancy.half_cut(axis),
            || level.best_cuts[axis].get_or_init(|| BestCuts::new(occupancy, axis)),
            cut_samples * self.scene.frame.step / block_size,
        )
    }

    /// The rays that meet the box, in tiles whose beams meet what is active in `launched`, or in all.
    fn launched_rays(&self, launched: Option<&Level>) -> impl Iterator<Item = &BundleRay> {
        let mut runs = TileRuns::default();
        self.rays.iter().filter(move |bundled| {
            let [x, y] = bundled.tile.clone();
            bundled.ray.k_near < bundled.ray.k_end
                && launched.is_none_or(|level| {
                    let frame = self.scene.frame;
                    level.masks.find(frame, x, y, Collapse::Hull, &mut runs);
                    !runs.is_empty()
                })
        })
    }

    /// Blocks that a pixel's ray walks through while its segments are listed: as far as there are any, whatever its march
    /// will come to.
    fn steps_of_listing(&self, launched: Option<&Level>, walk: &Plan) -> f64 {
        let share = 1.0 / self.rays.len() as f64;
        let steps = self.launched_rays(launched).map(|bundled| {
            let mut segments = walk.segments(&bundled.ray, [0; 2], &|_| false);
            let mut k = 0;
            while let Some(segment) = segments.next(k, f64::NAN) {
                k = segment.end;
            }
            f64::from(segments.steps()) * share
        });
        steps.sum()
    }

    /// Adds what a method does per pixel whose rays find their own segments.
    fn along_rays<'s>(
        &self,
        launched: Option<&Level>,
        work: &mut Work,
        segments: impl Fn(&BundleRay) -> Box<dyn Segments + 's>,
    ) {
        let share = 1.0 / self.rays.len() as f64;
        let is_kept = self.scene.mode.keeps_highest();
        for bundled in self.launched_rays(launched) {
            let BundleRay {
                ray,
                end,
                contributing,
                ..
            } = bundled;
            let mut segments = segments(bundled);
            let mut samples = 0;
            let mut k = ray.k_near as u32;
            while k < *end
                && let Some(segment) = segments.next(k, bundled.highest_before(k, is_kept))
            {
                samples += segment.end.min(*end).saturating_sub(segment.start);
                k = segment.end;
            }
            work.launched += share;
            work.samples += f64::from(samples) * share;
            work.contributing += *contributing as f64 * share;
            work.steps += f64::from(segments.steps()) * share;
        }
    }

    /// Adds what a method does per pixel whose tiles find the segments; `looked_at` counts the layers that they try.
    fn along_beams(
        &self,
        level: &Level,
        collapse: Collapse,
        work: &mut Work,
        looked_at: &mut usize,
    ) {
        let share = 1.0 / self.rays.len() as f64;
        let mut runs = TileRuns::default();
        for BundleRay {
            ray,
            tile: [x, y],
            end,
            contributing,
            ..
        } in &self.rays
        {
            let (x, y) = (x.clone(), y.clone());
            level
                .masks
                .find(self.scene.frame, x, y, collapse, &mut runs);
            *looked_at += layers_tried(&runs, &level.occupancy);
            if runs.is_empty() {
                continue;
            }
            let mut k = ray.k_near;
            let mut samples = 0.0;
            let mut steps = 0;
            for i in 0..runs.len() {
                if k >= f64::from(*end) {
                    break;
                }
                let [first, last] = runs.range(ray, i);
                let first = first.max(k);
                samples += (last.min(f64::from(*end)) - first).max(0.0);
                steps += 1;
                k = last.max(k);
            }
            work.launched += share;
            work.samples += samples * share;
            work.contributing += *contributing as f64 * share;
            work.steps += f64::from(steps) * share;
        }
    }

    /// Work per pixel, times the pixels.
    fn of_all_pixels(&self, work: Work) -> Work {
        let pixels = self.weight * self.rays.len() as f64;
        Work {
            cleared: work.cleared * pixels,
            launched: work.launched * pixels,
            samples: work.samples * pixels,
            contributing: work.contributing * pixels,
            steps: work.steps * pixels,
            fragments: work.fragments * pixels,
            elements: work.elements,
        }
    }
}

/// Layers that finding these runs looked at, about: groups of eight first, then each of those that are met.
fn layers_tried(runs: &TileRuns, occupancy: &Occupancy) -> usize {
    let Some(axis) = runs.axis() else { return 0 };
    let groups = occupancy.dims[axis].div_ceil(8);
    let size = (occupancy.block * 8) as f64;
    let met = runs.spans().iter().map(|span| {
        let length = (span[1] - span[0]).abs();
        if length.is_finite() {
            1.0 + (length / size).floor()
        } else {
            1.0
        }
    });
    groups + 8 * (met.sum::<f64>() as usize).min(groups)
}

/// How often the ray goes into an active block from elsewhere, to within blocks that it only grazes.
fn entries(ray: &Ray<f64>, occupancy: &Occupancy) -> f64 {
    let block = occupancy.block as f64;
    let fastest = ray.delta.iter().fold(0.0, |m: f64, d| m.max(d.abs()));
    if ray.k_end <= ray.k_near || fastest == 0.0 {
        return 0.0;
    }
    let stride = (0.5 * block / fastest).max(1.0);
    let mut entries = 0;
    let mut inside = false;
    let mut k = ray.k_near;
    while k < ray.k_end {
        let at = ray.at(k);
        let now = occupancy.get(std::array::from_fn(|a| {
            ((at[a] / block) as usize).min(occupancy.dims[a] - 1)
        }));
        entries += u32::from(now && !inside);
        inside = now;
        k += stride;
    }
    f64::from(entries)
}
