//! Methods against each other: each at each step and block size over the same views, in interleaved runs ([`super::race`]).

use serde::Serialize;

use super::metrics::{Metrics, metrics, perceived};
use super::race::{Entrant, Noise, Outcome, race};
use super::truth::{Truth, Truths};
use crate::camera::Camera;
use crate::error::{Error, Result};
use crate::render::{Choice, MethodChoice, Renderer, Settings, SliceCount};
use crate::sample::Sampler;
use crate::scene::Picture;
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
    /// The methods; box must be one of them, it is what the others are compared with. A backend that does not have one
    /// leaves it out.
    pub methods: Vec<MethodChoice>,
    /// Slices, drawn beside the methods by every backend that is a GPU.
    pub slices: Option<SliceCount>,
    /// Block sizes in voxels.
    pub blocks: Vec<usize>,
    /// Steps.
    pub steps: Vec<NamedStep>,
    /// The views that every row is taken over.
    pub views: Vec<Camera>,
    /// All other settings; skip, block, step and camera are set from the lists above. A backend that does not have their mode
    /// is left out.
    pub settings: Settings,
    /// Timed runs of every method in every view.
    pub rounds: usize,
    /// Against what pictures are held for [`Row::psnr_vs_reference_db`].
    pub reference: ReferencePlan,
}

/// What pictures are held against.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Against {
    /// The f64 reference at the same step, with the exact sampler and no skipping; both sides without early termination.
    /// What is left is the sampler's coarseness and the rounding.
    Reference,
    /// The truth ([`super::truth`]), and the picture as it is, with early termination: all of its error.
    Truth,
}

impl Against {
    /// All that there are.
    pub const ALL: &[Self] = &[Self::Reference, Self::Truth];

    /// The name used by flags and reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Reference => "reference",
            Self::Truth => "truth",
        }
    }
}

/// How much of the comparison is held against f64 pictures, which are slow. Both sides are then drawn at this size.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct ReferencePlan {
    /// What the pictures are held against.
    pub against: Against,
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
    /// The method's name, or `slices`.
    pub method: &'static str,
    /// What `auto` chose, in words, each choice once; only where the method is `auto`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub chosen: Vec<String>,
    /// The step as the user gave it.
    pub step: String,
    /// Block size in voxels (without meaning for box and auto).
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
    /// The first quartile of that: of each view's rounds, averaged over the views.
    pub frame_q1_ms: f64,
    /// The third quartile.
    pub frame_q3_ms: f64,
    /// Both passes of a frame by the adapter's own clock; `None` where it has none.
    pub gpu_ms: Option<f64>,
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
    /// PSNR against the f64 reference or the truth ([`ReferencePlan`]); infinite (in JSON: null) where the pictures are equal,
    /// `None` where it was not measured.
    pub psnr_vs_reference_db: Option<f64>,
    /// The same pictures' largest difference of any channel.
    pub max_abs_diff_vs_reference: Option<f64>,
    /// Their mean absolute difference.
    pub mean_abs_diff_vs_reference: Option<f64>,
    /// The share of their pixels that are off by more than 1/255.
    pub off_share_vs_reference: Option<f64>,
    /// Structural similarity, the mean over the views; `None` too where the pictures are too small for it.
    pub ssim_vs_reference: Option<f64>,
    /// FLIP, likewise.
    pub flip_vs_reference: Option<f64>,
}

/// What [`compare`] found.
#[derive(Debug, Clone)]
pub struct Comparison {
    /// By step, block, backend and method, in the order of the plan.
    pub rows: Vec<Row>,
    /// The sampler that each backend used.
    pub samplers: Vec<Sampler>,
    /// Of all times.
    pub noise: Noise,
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
    let box_choice = MethodChoice::Only(Skip::Box);
    if !plan.methods.contains(&box_choice) {
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
    let mode = &plan.settings.mode;
    if !renderers.iter().any(|renderer| renderer.has_mode(mode)) {
        mode.check_backend(renderers[0].info().backend)?;
    }
    for method in &plan.methods {
        if let MethodChoice::Only(skip) = method
            && !renderers.iter().any(|renderer| renderer.has(*skip))
        {
            skip.check_backend(renderers[0].info().backend)?;
        }
    }
    let [width, height] = plan.settings.size.map(f64::from);
    let pixels = width * height * plan.views.len() as f64;
    let truths = truths(reference, plan)?;
    let groups = plan.steps.len() * plan.blocks.len();
    let mut comparison = Comparison {
        rows: Vec::new(),
        samplers: vec![Sampler::Exact; renderers.len()],
        noise: Noise::of(&[], plan.rounds),
    };
    let mut all: Vec<Outcome> = Vec::new();
    for (s, step) in plan.steps.iter().enumerate() {
        let truth = match plan.reference.against {
            Against::Reference => references(reference, plan, step)?,
            Against::Truth => truths.clone(),
        };
        for (b, &block) in plan.blocks.iter().enumerate() {
            let settings = Settings {
                block,
                step_voxels: step.voxels,
                ..plan.settings
            };
            let before = (s * plan.blocks.len() + b) as f64;
            let mut part = |f: f64| progress((before + f) / groups as f64);
            let (methods, entrants) = entrants(renderers, plan, &settings)?;
            let outcomes = race(renderers, &entrants, plan.rounds, &mut part)?;
            for ((method, entrant), outcome) in methods.iter().zip(&entrants).zip(&outcomes) {
                let renderer = &mut renderers[entrant.renderer];
                let error = error(renderer, entrant, plan, &truth)?;
                let base = (0..entrants.len())
                    .find(|&i| {
                        entrants[i].renderer == entrant.renderer && methods[i] == Some(box_choice)
                    })
                    .expect("box is in every plan");
                comparison.samplers[entrant.renderer] = outcome.sampler;
                let frame = outcome.quartiles(|t| t.frame_ms);
                let speedup = outcomes[base].mean(|t| t.frame_ms) / frame.median;
                comparison.rows.push(Row {
                    backend: renderer.info().backend,
                    method: method.map_or("slices", MethodChoice::name),
                    chosen: chosen(*method, entrant),
                    step: step.name.clone(),
                    block,
                    size: plan.settings.size,
                    view_count: plan.views.len(),
                    preprocess_ms: outcome.preparation.preprocess_ms,
                    cull_ms: outcome.preparation.cull_ms,
                    raster_ms: outcome.mean(|t| t.raster_ms),
                    cast_ms: outcome.mean(|t| t.cast_ms),
                    frame_ms: frame.median,
                    frame_q1_ms: frame.q1,
                    frame_q3_ms: frame.q3,
                    gpu_ms: outcome.gpu_ms(),
                    read_back_ms: outcome.read_back_ms,
                    speedup_vs_box: speedup,
                    samples_per_pixel: outcome.counters.samples as f64 / pixels,
                    contributing_samples_per_pixel: outcome.counters.contributing as f64 / pixels,
                    skip_steps_per_pixel: outcome.counters.skip_steps as f64 / pixels,
                    structure_bytes: outcome.preparation.structure_bytes,
                    differing_pixels_vs_box: outcome.differing_pixels,
                    max_abs_diff_vs_box: outcome.max_abs,
                    psnr_vs_reference_db: error.map(|(e, _)| e.psnr_db()),
                    max_abs_diff_vs_reference: error.map(|(e, _)| e.max_abs),
                    mean_abs_diff_vs_reference: error.map(|(e, _)| e.mean_abs),
                    off_share_vs_reference: error.map(|(e, _)| e.off_share),
                    ssim_vs_reference: error.and_then(|(_, [ssim, _])| finite(ssim)),
                    flip_vs_reference: error.and_then(|(_, [_, flip])| finite(flip)),
                });
            }
            all.extend(outcomes);
        }
    }
    comparison.noise = Noise::of(&all, plan.rounds);
    Ok(comparison)
}

/// All methods on all backends that have them and the mode, and slices where they are drawn, which are no method.
fn entrants(
    renderers: &mut [Renderer],
    plan: &Plan,
    settings: &Settings,
) -> Result<(Vec<Option<MethodChoice>>, Vec<Entrant>)> {
    let mut methods = Vec::new();
    let mut entrants = Vec::new();
    for (renderer, drawing) in renderers.iter_mut().enumerate() {
        if !drawing.has_mode(&settings.mode) {
            continue;
        }
        for &method in &plan.methods {
            if matches!(method, MethodChoice::Only(skip) if !drawing.has(skip)) {
                continue;
            }
            let views = plan.views.iter().map(|&camera| {
                let settings = Settings {
                    camera,
                    ..settings_on(drawing.info().backend, settings)
                };
                Ok(match method {
                    MethodChoice::Only(skip) => Settings { skip, ..settings },
                    MethodChoice::Auto => drawing.choose(&settings)?.in_settings(&settings),
                })
            });
            entrants.push(Entrant {
                renderer,
                views: views.collect::<Result<_>>()?,
            });
            methods.push(Some(method));
        }
        if plan.slices.is_some() && drawing.info().backend == "gpu" {
            let views = plan.views.iter().map(|&camera| Settings {
                camera,
                skip: Skip::Box,
                slices: plan.slices,
                ..*settings
            });
            entrants.push(Entrant {
                renderer,
                views: views.collect(),
            });
            methods.push(None);
        }
    }
    Ok((methods, entrants))
}

/// What an entrant's choices were, if it had any.
fn chosen(method: Option<MethodChoice>, entrant: &Entrant) -> Vec<String> {
    if method != Some(MethodChoice::Auto) {
        return Vec::new();
    }
    let mut words: Vec<String> = Vec::new();
    for settings in &entrant.views {
        let of_view = Choice::of(settings).words();
        if !words.contains(&of_view) {
            words.push(of_view);
        }
    }
    words
}

/// The settings as a backend can draw them: only graphics adapters have a filter. What else it does not have it refuses.
pub fn settings_on(backend: &str, settings: &Settings) -> Settings {
    let sampler = match settings.sampler {
        Some(Sampler::Hardware) if backend != "gpu" => Some(Sampler::Exact),
        sampler => sampler,
    };
    Settings {
        sampler,
        ..*settings
    }
}

/// The views that the reference repeats.
fn reference_views(plan: &Plan) -> impl Iterator<Item = usize> {
    let count = plan.reference.views.min(plan.views.len());
    let views = plan.views.len();
    (0..count).map(move |i| i * views / count)
}

/// The settings that a picture is held against the others by.
fn reference_settings(plan: &Plan, settings: &Settings) -> Settings {
    Settings {
        ert: match plan.reference.against {
            // Design contract 7.
            Against::Reference => 1.0,
            Against::Truth => settings.ert,
        },
        size: plan.reference.size,
        ..*settings
    }
}

/// The reference's pictures at one step; they depend on no block size.
fn references(reference: &mut Renderer, plan: &Plan, step: &NamedStep) -> Result<Vec<Truth>> {
    reference_views(plan)
        .map(|view| {
            let settings = Settings {
                skip: Skip::Box,
                camera: plan.views[view],
                step_voxels: step.voxels,
                ..settings_on("reference", &plan.settings)
            };
            let settings = reference_settings(plan, &settings);
            let picture = reference.render(&settings)?.picture;
            Ok(Truth {
                masked: vec![false; picture.rgba.len()],
                picture,
                step_voxels: step.voxels,
                bound: f64::INFINITY,
            })
        })
        .collect()
}

/// The truths of the views, which depend on no step.
fn truths(reference: &Renderer, plan: &Plan) -> Result<Vec<Truth>> {
    if plan.reference.against != Against::Truth || plan.reference.views == 0 {
        return Ok(Vec::new());
    }
    let mut truths = Truths::like(reference)?;
    reference_views(plan)
        .map(|view| {
            let settings = Settings {
                camera: plan.views[view],
                ..plan.settings
            };
            truths.of(&reference_settings(plan, &settings), |_| ())
        })
        .collect()
}

/// How far an entrant's pictures are from these, and the means of their SSIM and FLIP.
fn error(
    renderer: &mut Renderer,
    entrant: &Entrant,
    plan: &Plan,
    truth: &[Truth],
) -> Result<Option<(Metrics, [f64; 2])>> {
    if truth.is_empty() {
        return Ok(None);
    }
    let pictures: Vec<Picture> = reference_views(plan)
        .map(|view| {
            let settings = reference_settings(plan, &entrant.views[view]);
            Ok(renderer.render(&settings)?.picture)
        })
        .collect::<Result<_>>()?;
    let seen = pictures.iter().zip(truth).map(perceived);
    let [ssim, flip] = seen.fold([0.0; 2], |[ssim, flip], s| [ssim + s.ssim, flip + s.flip]);
    let views = truth.len() as f64;
    let metrics = metrics(pictures.iter().zip(truth));
    Ok(Some((metrics, [ssim / views, flip / views])))
}

fn finite(number: f64) -> Option<f64> {
    number.is_finite().then_some(number)
}
