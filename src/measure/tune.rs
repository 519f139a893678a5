//! Exhaustive search: every method in every block size and cut that a backend has, on one volume, table, step and set of
//! views, in interleaved runs ([`super::race`]).

use serde::Serialize;

use super::compare::settings_on;
use super::race::{Entrant, Noise, Outcome, race};
use crate::camera::Camera;
use crate::error::{Error, Result};
use crate::render::{Choice, Renderer, Settings};
use crate::skip::{HalfCut, Skip, SlabCount};

/// Slabs that k-cuts is tried with besides as many as pay.
const SLABS: [usize; 3] = [2, 4, 8];

/// What is searched.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Block sizes in voxels.
    pub blocks: Vec<usize>,
    /// Whether the places and numbers of cuts are searched too, and with them what auto chooses; else they are as they are
    /// unless told otherwise.
    pub cuts: bool,
    /// The views that every row is taken over.
    pub views: Vec<Camera>,
    /// All other settings; skip, block, cuts and camera are set from the lists above.
    pub settings: Settings,
    /// Timed runs of every choice in every view.
    pub rounds: usize,
}

/// One choice on one backend.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// `gpu`, `cpu` or `reference`.
    pub backend: &'static str,
    /// The method's name.
    pub method: &'static str,
    /// Block size in voxels (without meaning for box).
    pub block: usize,
    /// Where half-split or k-cuts cuts; `None` for the others.
    pub cuts: Option<String>,
    /// A frame after the structures stand, without read-back: the median of each view's rounds, averaged over the views.
    pub frame_ms: f64,
    /// The first quartile of that: of each view's rounds, averaged over the views.
    pub frame_q1_ms: f64,
    /// The third quartile.
    pub frame_q3_ms: f64,
    /// `frame_ms` of box on the same backend over this row's.
    pub speedup_vs_box: f64,
    /// Samples taken per pixel of the picture.
    pub samples_per_pixel: f64,
    /// Memory of all that stands besides the volume.
    pub structure_bytes: u64,
    /// Building, classifying and culling for all views.
    pub build_ms: f64,
    /// Pixels with any bit different from box's, summed over the views.
    pub differing_pixels_vs_box: u64,
    /// What the row's frames were drawn with.
    #[serde(skip)]
    pub choice: Choice,
}

/// What `auto` would have chosen on one backend.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Auto {
    /// The backend.
    pub backend: &'static str,
    /// Each view's choice, in words, each once.
    pub chosen: Vec<String>,
    /// Its frame time, from the rows that it chose.
    pub frame_ms: f64,
    /// That over the fastest row's of this backend.
    pub over_fastest: f64,
}

/// What [`tune`] found.
#[derive(Debug, Clone)]
pub struct Tuning {
    /// The fastest first.
    pub rows: Vec<Row>,
    /// One for each renderer, where cuts are searched too.
    pub auto: Vec<Auto>,
    /// Of all times.
    pub noise: Noise,
}

/// Tries everything on each of the renderers, whose volume and transfer function are set.
///
/// `progress` is told how much of the work is done, 0 to 1.
///
/// # Errors
/// [`Error::Setting`] where there is nothing to try; whatever a renderer reports.
///
/// # Panics
/// Never: what auto chooses is tried.
pub fn tune(
    renderers: &mut [Renderer],
    plan: &Plan,
    progress: &mut dyn FnMut(f64),
) -> Result<Tuning> {
    for (field, empty) in [
        ("blocks", plan.blocks.is_empty()),
        ("views", plan.views.is_empty()),
        ("backends", renderers.is_empty()),
        ("repeat", plan.rounds == 0),
    ] {
        if empty {
            return Err(Error::setting(field, "must be at least one"));
        }
    }
    let mut tried: Vec<(usize, Choice)> = Vec::new();
    let mut automatic: Vec<Vec<Choice>> = Vec::new();
    for (i, renderer) in renderers.iter_mut().enumerate() {
        let mut choices = choices(renderer, plan);
        if plan.cuts {
            let views = views(renderer, plan);
            let chosen = views.iter().map(|settings| renderer.choose(settings));
            let chosen = chosen.collect::<Result<Vec<_>>>()?;
            for choice in &chosen {
                // Of blocks that are not searched.
                if !choices.contains(choice) {
                    choices.push(*choice);
                }
            }
            automatic.push(chosen);
        }
        tried.extend(choices.into_iter().map(|choice| (i, choice)));
    }
    let entrants: Vec<Entrant> = tried
        .iter()
        .map(|&(renderer, choice)| Entrant {
            renderer,
            views: views(&renderers[renderer], plan)
                .iter()
                .map(|settings| choice.in_settings(settings))
                .collect(),
        })
        .collect();
    let outcomes = race(renderers, &entrants, plan.rounds, progress)?;

    let fastest = |renderer: usize| {
        let own = tried
            .iter()
            .zip(&outcomes)
            .filter(|((r, _), _)| *r == renderer);
        own.map(|(_, o)| o.mean(|t| t.frame_ms))
            .fold(f64::INFINITY, f64::min)
    };
    let auto = automatic
        .iter()
        .enumerate()
        .map(|(renderer, chosen)| {
            let frame_ms = ms_of_views(renderer, chosen, &tried, &outcomes);
            let mut words: Vec<String> = chosen.iter().map(Choice::words).collect();
            words.dedup();
            Auto {
                backend: renderers[renderer].info().backend,
                chosen: words,
                frame_ms,
                over_fastest: frame_ms / fastest(renderer),
            }
        })
        .collect();
    let [width, height] = plan.settings.size.map(f64::from);
    let pixels = width * height * plan.views.len() as f64;
    let mut rows: Vec<Row> = tried
        .iter()
        .zip(&outcomes)
        .map(|((renderer, choice), outcome)| {
            let base = tried
                .iter()
                .position(|(r, c)| r == renderer && c.skip == Skip::Box)
                .map_or(f64::NAN, |i| outcomes[i].mean(|t| t.frame_ms));
            let frame = outcome.quartiles(|t| t.frame_ms);
            let frame_ms = frame.median;
            Row {
                backend: renderers[*renderer].info().backend,
                method: choice.skip.method().name,
                block: choice.block,
                cuts: choice.cut_words(),
                frame_ms,
                frame_q1_ms: frame.q1,
                frame_q3_ms: frame.q3,
                speedup_vs_box: base / frame_ms,
                samples_per_pixel: outcome.counters.samples as f64 / pixels,
                structure_bytes: outcome.preparation.structure_bytes,
                build_ms: outcome.preparation.preprocess_ms + outcome.preparation.cull_ms,
                differing_pixels_vs_box: outcome.differing_pixels,
                choice: *choice,
            }
        })
        .collect();
    rows.sort_by(|a, b| a.frame_ms.total_cmp(&b.frame_ms));
    Ok(Tuning {
        rows,
        auto,
        noise: Noise::of(&outcomes, plan.rounds),
    })
}

/// The plan's views as a renderer draws them.
fn views(renderer: &Renderer, plan: &Plan) -> Vec<Settings> {
    let settings = settings_on(renderer.info().backend, &plan.settings);
    let views = plan.views.iter();
    views
        .map(|&camera| Settings { camera, ..settings })
        .collect()
}

/// All that is tried on a renderer, box first.
fn choices(renderer: &Renderer, plan: &Plan) -> Vec<Choice> {
    let mut choices = renderer.candidates(&plan.blocks);
    if !plan.cuts {
        choices.retain(|c| c.skip != Skip::HalfSplit || c.cuts.half == HalfCut::default());
        return choices;
    }
    let with_slabs = choices.iter().flat_map(|&choice| {
        let slabs = if choice.skip == Skip::KCuts {
            &SLABS[..]
        } else {
            &[]
        };
        let others = slabs.iter().map(move |&slabs| {
            let mut other = choice;
            other.cuts.slabs = SlabCount::AtMost(slabs);
            other
        });
        [choice].into_iter().chain(others)
    });
    with_slabs.collect()
}

/// The frame time of one choice for each view, of those that were tried.
fn ms_of_views(
    renderer: usize,
    chosen: &[Choice],
    tried: &[(usize, Choice)],
    outcomes: &[Outcome],
) -> f64 {
    let views = chosen.iter().enumerate().map(|(view, choice)| {
        let place = tried.iter().position(|t| *t == (renderer, *choice));
        outcomes[place.expect("what auto chose is tried")].median(view, |t| t.frame_ms)
    });
    views.sum::<f64>() / chosen.len() as f64
}
