//! Methods against each other: each at each step and block size over the same views, in interleaved runs.
//!
//! Times come from drawing alone, without read-back; counters and pictures from separate, untimed runs. Structures are
//! built before the clock starts and reported by their own times.

use serde::Serialize;

use super::metrics::metrics;
use super::statistics::{interleaved, median};
use crate::camera::Camera;
use crate::error::{Error, Result};
use crate::render::{FrameTimes, Preparation, Renderer, Settings};
use crate::sample::Sampler;
use crate::scene::{Counters, Picture};
use crate::skip::Skip;

/// A step by the name that the user gave it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NamedStep {
    /// As given: `0.5` (voxels) or `0.002u` (parts of the longest box edge).
    pub name: String,
    /// In voxels of the smallest spacing.
    pub voxels: f64,
}

/// What is compared.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The methods; [`Skip::Box`] must be one of them, it is what the others are compared with. A backend that does not
    /// have one leaves it out.
    pub methods: Vec<Skip>,
    /// Block sizes in voxels.
    pub blocks: Vec<usize>,
    /// Steps.
    pub steps: Vec<NamedStep>,
    /// The views that every row is taken over.
    pub views: Vec<Camera>,
    /// All other settings; skip, block, step and camera are set from the lists above.
    pub settings: Settings,
    /// Timed runs of every method in every view.
    pub rounds: usize,
    /// Against what pictures are held for [`Row::psnr_vs_reference_db`].
    pub reference: ReferencePlan,
}

/// How much of the comparison is repeated by the f64 reference, which is slow. Both sides are then drawn at this size,
/// without early termination (design contract 7), the reference with the exact sampler and no skipping.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct ReferencePlan {
    /// Views, spread over those of the plan; 0: none, and no PSNR is reported.
    pub views: usize,
    /// Width and height of the pictures that are compared.
    pub size: [u32; 2],
}

/// One method at one step and block size on one backend.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// `gpu`, `cpu` or `reference`.
    pub backend: &'static str,
    /// The method's name.
    pub method: &'static str,
    /// The step as the user gave it.
    pub step: String,
    /// Block size in voxels (without meaning for box).
    pub block: usize,
    /// Width and height of the pictures.
    pub size: [u32; 2],
    /// Views that the row is taken over.
    pub view_count: usize,
    /// Building leaves and trees for all views.
    pub preprocess_ms: f64,
    /// Classifying and culling them.
    pub cull_ms: f64,
    /// Finding the segments: the median of each view's rounds, averaged over the views; so are the next three.
    pub raster_ms: f64,
    /// Marching the segments.
    pub cast_ms: f64,
    /// A frame after the structures stand, raster included, read-back excluded.
    pub frame_ms: f64,
    /// Fetching the picture of the first view, once.
    pub read_back_ms: f64,
    /// `frame_ms` of box with the same settings on the same backend over this row's.
    pub speedup_vs_box: f64,
    /// Samples taken per pixel of the picture.
    pub samples_per_pixel: f64,
    /// Samples that added something.
    pub contributing_samples_per_pixel: f64,
    /// Segments asked for, or steps of a traversal.
    pub skip_steps_per_pixel: f64,
    /// Memory of all that stands besides the volume.
    pub structure_bytes: u64,
    /// Pixels with any bit different from box's, summed over the views.
    pub differing_pixels_vs_box: u64,
    /// Largest difference of any channel from box's.
    pub max_abs_diff_vs_box: f64,
    /// PSNR against the f64 reference ([`ReferencePlan`]); infinite (in JSON: null) where the pictures are equal, `None`
    /// where it was not measured.
    pub psnr_vs_reference_db: Option<f64>,
}

/// What [`compare`] found.
#[derive(Debug, Clone)]
pub struct Comparison {
    /// By step, block, backend and method, in the order of the plan.
    pub rows: Vec<Row>,
    /// The sampler that each backend used.
    pub samplers: Vec<Sampler>,
}

/// One method on one backend, and what has been seen of it.
struct Contestant {
    renderer: usize,
    skip: Skip,
    preparation: Preparation,
    /// Of the current view.
    runs: Vec<FrameTimes>,
    /// Median of each view so far.
    views: Vec<FrameTimes>,
    counters: Counters,
    differing: u64,
    max_abs: f64,
    read_back_ms: f64,
}

/// Runs the plan on each of the renderers, whose volume and transfer function are set, as those of `reference` are.
///
/// `progress` is told how much of the work is done, 0 to 1.
///
/// # Errors
/// [`Error::Setting`] where the plan lacks box or has nothing to run; whatever a renderer reports.
///
/// # Panics
/// Never: that box is in the plan is checked.
pub fn compare(
    renderers: &mut [Renderer],
    reference: &mut Renderer,
    plan: &Plan,
    progress: &mut dyn FnMut(f64),
) -> Result<Comparison> {
    if !plan.methods.contains(&Skip::Box) {
        return Err(Error::setting(
            "methods",
            "box is missing: it is what the others are compared with",
        ));
    }
    for (field, empty) in [
        ("blocks", plan.blocks.is_empty()),
        ("steps", plan.steps.is_empty()),
        ("views", plan.views.is_empty()),
        ("backends", renderers.is_empty()),
        ("repeat", plan.rounds == 0),
    ] {
        if empty {
            return Err(Error::setting(field, "must be at least one"));
        }
    }
    let groups = plan.steps.len() * plan.blocks.len();
    let mut comparison = Comparison {
        rows: Vec::new(),
        samplers: vec![Sampler::Exact; renderers.len()],
    };
    for &skip in &plan.methods {
        if !renderers.iter().any(|renderer| renderer.has(skip)) {
            skip.check_backend(renderers[0].info().backend)?;
        }
    }
    for (s, step) in plan.steps.iter().enumerate() {
        let truth = references(reference, plan, step)?;
        for (b, &block) in plan.blocks.iter().enumerate() {
            let settings = Settings {
                block,
                step_voxels: step.voxels,
                ..plan.settings
            };
            let before = (s * plan.blocks.len() + b) as f64;
            let mut part = |f: f64| progress((before + f) / groups as f64);
            let contestants = run_group(
                renderers,
                plan,
                &settings,
                &mut comparison.samplers,
                &mut part,
            )?;
            for c in &contestants {
                let psnr = psnr(&mut renderers[c.renderer], c.skip, plan, &settings, &truth)?;
                let base = contestants
                    .iter()
                    .find(|o| o.renderer == c.renderer && o.skip == Skip::Box)
                    .expect("box is in every plan");
                let backend = renderers[c.renderer].info().backend;
                comparison
                    .rows
                    .push(row(c, base, backend, plan, step, block, psnr));
            }
        }
    }
    Ok(comparison)
}

/// All methods on all backends at one step and block size.
fn run_group(
    renderers: &mut [Renderer],
    plan: &Plan,
    settings: &Settings,
    samplers: &mut [Sampler],
    progress: &mut dyn FnMut(f64),
) -> Result<Vec<Contestant>> {
    let mut contestants: Vec<Contestant> = (0..renderers.len())
        .flat_map(|renderer| plan.methods.iter().map(move |&skip| (renderer, skip)))
        .filter(|&(renderer, skip)| renderers[renderer].has(skip))
        .map(|(renderer, skip)| Contestant {
            renderer,
            skip,
            preparation: Preparation::default(),
            runs: Vec::new(),
            views: Vec::new(),
            counters: Counters::default(),
            differing: 0,
            max_abs: 0.0,
            read_back_ms: 0.0,
        })
        .collect();
    for (v, &camera) in plan.views.iter().enumerate() {
        let settings = Settings {
            camera,
            ..*settings
        };
        let backends: Vec<&str> = renderers.iter().map(|r| r.info().backend).collect();
        let of = |c: &Contestant| settings_on(backends[c.renderer], c.skip, &settings);
        let mut pictures = Vec::new();
        for c in &mut contestants {
            let renderer = &mut renderers[c.renderer];
            c.prepare(renderer.prepare(&of(c))?);
            let counted = renderer.count(&of(c))?;
            c.counters.samples += counted.counters.samples;
            c.counters.contributing += counted.counters.contributing;
            c.counters.skip_steps += counted.counters.skip_steps;
            if v == 0 {
                let rendered = renderer.render(&of(c))?;
                c.read_back_ms = rendered.read_back_ms;
                samplers[c.renderer] = rendered.sampler;
                let difference = rendered.picture.difference(&counted.picture);
                if difference.pixels > 0 {
                    return Err(Error::Gpu(format!(
                        "{}: {} pixels of the counted picture differ from the drawn one",
                        c.skip.method().name,
                        difference.pixels
                    )));
                }
            } else {
                // The counting run warms up nothing but itself.
                renderer.draw(&of(c))?;
            }
            pictures.push(counted.picture);
        }
        compare_with_box(&mut contestants, &pictures);
        for i in interleaved(contestants.len(), plan.rounds) {
            let c = &mut contestants[i];
            let times = renderers[c.renderer].draw(&of(c))?;
            c.runs.push(times);
        }
        contestants.iter_mut().for_each(Contestant::close_view);
        progress((v + 1) as f64 / plan.views.len() as f64);
    }
    Ok(contestants)
}

impl Contestant {
    /// Keeps the times of all that stands: more axes may be built with every view.
    fn prepare(&mut self, seen: Preparation) {
        let p = &mut self.preparation;
        p.preprocess_ms = p.preprocess_ms.max(seen.preprocess_ms);
        p.cull_ms = p.cull_ms.max(seen.cull_ms);
        p.structure_bytes = p.structure_bytes.max(seen.structure_bytes);
    }

    fn close_view(&mut self) {
        let of =
            |time: fn(&FrameTimes) -> f64| median(&self.runs.iter().map(time).collect::<Vec<_>>());
        self.views.push(FrameTimes {
            raster_ms: of(|t| t.raster_ms),
            cast_ms: of(|t| t.cast_ms),
            frame_ms: of(|t| t.frame_ms),
        });
        self.runs.clear();
    }

    fn mean(&self, time: fn(&FrameTimes) -> f64) -> f64 {
        self.views.iter().map(time).sum::<f64>() / self.views.len() as f64
    }
}

/// The settings as a backend can draw them: only graphics adapters have a filter.
fn settings_on(backend: &str, skip: Skip, settings: &Settings) -> Settings {
    let sampler = if backend == "gpu" {
        settings.sampler
    } else {
        Some(Sampler::Exact)
    };
    Settings {
        skip,
        sampler,
        ..*settings
    }
}

/// Holds each picture of one view against box's on the same backend.
fn compare_with_box(contestants: &mut [Contestant], pictures: &[Picture]) {
    let base: Vec<usize> = contestants
        .iter()
        .map(|c| {
            contestants
                .iter()
                .position(|o| o.renderer == c.renderer && o.skip == Skip::Box)
                .expect("box is in every plan")
        })
        .collect();
    for (i, c) in contestants.iter_mut().enumerate() {
        let difference = pictures[i].difference(&pictures[base[i]]);
        c.differing += difference.pixels;
        c.max_abs = c.max_abs.max(difference.max_abs);
    }
}

/// The cameras that the reference repeats.
fn reference_views(plan: &Plan) -> impl Iterator<Item = Camera> {
    let count = plan.reference.views.min(plan.views.len());
    (0..count).map(move |i| plan.views[i * plan.views.len() / count])
}

fn reference_settings(plan: &Plan, settings: &Settings, skip: Skip, camera: Camera) -> Settings {
    Settings {
        skip,
        camera,
        ert: 1.0,
        size: plan.reference.size,
        ..*settings
    }
}

/// The reference's pictures at one step; they depend on no block size.
fn references(reference: &mut Renderer, plan: &Plan, step: &NamedStep) -> Result<Vec<Picture>> {
    let settings = Settings {
        step_voxels: step.voxels,
        sampler: Some(Sampler::Exact),
        ..plan.settings
    };
    reference_views(plan)
        .map(|camera| {
            let settings = reference_settings(plan, &settings, Skip::Box, camera);
            Ok(reference.render(&settings)?.picture)
        })
        .collect()
}

fn psnr(
    renderer: &mut Renderer,
    skip: Skip,
    plan: &Plan,
    settings: &Settings,
    truth: &[Picture],
) -> Result<Option<f64>> {
    if truth.is_empty() {
        return Ok(None);
    }
    let pictures: Vec<Picture> = reference_views(plan)
        .map(|camera| {
            let settings = reference_settings(plan, settings, skip, camera);
            let settings = settings_on(renderer.info().backend, skip, &settings);
            Ok(renderer.render(&settings)?.picture)
        })
        .collect::<Result<_>>()?;
    Ok(Some(metrics(pictures.iter().zip(truth)).psnr_db()))
}

fn row(
    c: &Contestant,
    base: &Contestant,
    backend: &'static str,
    plan: &Plan,
    step: &NamedStep,
    block: usize,
    psnr: Option<f64>,
) -> Row {
    let size = plan.settings.size;
    let pixels = f64::from(size[0]) * f64::from(size[1]) * plan.views.len() as f64;
    let frame_ms = c.mean(|t| t.frame_ms);
    Row {
        backend,
        method: c.skip.method().name,
        step: step.name.clone(),
        block,
        size,
        view_count: plan.views.len(),
        preprocess_ms: c.preparation.preprocess_ms,
        cull_ms: c.preparation.cull_ms,
        raster_ms: c.mean(|t| t.raster_ms),
        cast_ms: c.mean(|t| t.cast_ms),
        frame_ms,
        read_back_ms: c.read_back_ms,
        speedup_vs_box: base.mean(|t| t.frame_ms) / frame_ms,
        samples_per_pixel: c.counters.samples as f64 / pixels,
        contributing_samples_per_pixel: c.counters.contributing as f64 / pixels,
        skip_steps_per_pixel: c.counters.skip_steps as f64 / pixels,
        structure_bytes: c.preparation.structure_bytes,
        differing_pixels_vs_box: c.differing,
        max_abs_diff_vs_box: c.max_abs,
        psnr_vs_reference_db: psnr,
    }
}
