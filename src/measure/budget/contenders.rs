//! Who is in question for a budget, and the best of them.

use super::{Budget, Plan, steps};
use crate::error::{Error, Result};
use crate::measure::bounds::ert_bound;
use crate::measure::compare::settings_on;
use crate::measure::errors::{Accuracy, Errors, Views};
use crate::measure::race::{Entrant, race};
use crate::measure::statistics::median;
use crate::mode::Mode;
use crate::render::{Renderer, Settings, check_classification};
use crate::sample::{Classification, Sampler};

/// Frames that a time is the median of while times are only compared with the budget.
const QUICK_ROUNDS: usize = 3;

/// An accuracy on one of the renderers, and its errors.
#[derive(Debug, Clone)]
pub(super) struct Contender {
    pub(super) renderer: usize,
    pub(super) accuracy: Accuracy,
    pub(super) errors: Errors,
}

/// How samples are taken on one of the renderers; step and early termination are searched for each.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Kind {
    renderer: usize,
    sampler: Sampler,
    classification: Classification,
}

impl Kind {
    fn accuracy(self, step_voxels: f64, ert: f32) -> Accuracy {
        Accuracy {
            sampler: self.sampler,
            classification: self.classification,
            step_voxels,
            ert,
        }
    }
}

/// All that the renderers have of what the plan asks for.
fn kinds(renderers: &[Renderer], plan: &Plan) -> Vec<Kind> {
    let settings = &plan.tuning.settings;
    let mut kinds = Vec::new();
    for (renderer, drawing) in renderers.iter().enumerate() {
        let backend = drawing.info().backend;
        let samplers = match settings_on(backend, settings).sampler {
            Some(only) => vec![only],
            // Only graphics adapters have a filter.
            None if backend == "gpu" => vec![Sampler::Hardware, Sampler::Exact],
            None => vec![Sampler::Exact],
        };
        for sampler in samplers {
            let with = |classification: &Classification| Kind {
                renderer,
                sampler,
                classification: *classification,
            };
            let is_possible = |kind: &Kind| {
                let settings = kind.accuracy(1.0, 1.0).in_settings(settings);
                check_classification(&settings, backend).is_ok()
            };
            let all = plan.classifications.iter().map(with);
            kinds.extend(all.filter(is_possible));
        }
    }
    kinds
}

/// The thresholds of early termination that are tried, the latest first.
///
/// Where the largest error counts, a threshold is only tried if what it can leave out at most ([`ert_bound`]) is inside the
/// budget: the rays that it costs most, which stop just before something bright, are so few that views seldom show one.
fn thresholds(renderer: &Renderer, plan: &Plan) -> Result<Vec<f32>> {
    let settings = &plan.tuning.settings;
    let composites = matches!(
        settings.mode,
        Mode::EmissionAbsorption | Mode::Shaded(_) | Mode::Grey(_)
    );
    if !composites {
        return Ok(vec![1.0]);
    }
    let limit = match plan.budget {
        Budget::MaxError(limit) => limit,
        Budget::Psnr(_) | Budget::BudgetMs(_) => f64::INFINITY,
    };
    let (_, transfer) = renderer.scene()?;
    let is_inside = |&ert: &f32| {
        let settings = Settings { ert, ..*settings };
        ert_bound(transfer, &settings).is_none_or(|bound| bound.error <= limit)
    };
    let mut thresholds: Vec<f32> = plan.thresholds.iter().copied().filter(is_inside).collect();
    thresholds.sort_by(|a, b| b.total_cmp(a));
    Ok(thresholds)
}

/// The fastest contender whose errors are expected to stay inside the budget.
pub(super) fn fastest(renderers: &mut [Renderer], views: &Views, plan: &Plan) -> Result<Contender> {
    let (_, limit) = plan.budget.measure();
    let mut inside: Vec<Contender> = Vec::new();
    for kind in kinds(renderers, plan) {
        let steps = steps();
        // Stopping earlier adds to the error: no coarser step is inside than with the threshold before.
        let mut coarsest = 0;
        for ert in thresholds(&renderers[kind.renderer], plan)? {
            // The coarsest step inside: errors fall with the step, but for noise that climbing is there for.
            let (mut coarse, mut fine) = (coarsest, steps.len());
            let mut found = None;
            while coarse < fine {
                let middle = usize::midpoint(coarse, fine);
                let accuracy = kind.accuracy(steps[middle], ert);
                let errors = views.errors(&mut renderers[kind.renderer], &accuracy, limit)?;
                if errors.expected() <= limit {
                    found = Some(Contender {
                        renderer: kind.renderer,
                        accuracy,
                        errors,
                    });
                    fine = middle;
                } else {
                    coarse = middle + 1;
                }
            }
            coarsest = coarse;
            if found.is_none() {
                break;
            }
            inside.extend(found);
        }
    }
    if inside.is_empty() {
        return Err(nothing(renderers, views, plan)?);
    }
    // Of what differs in these two alone, the coarser that stops earlier is faster: no need to time the others.
    let is_beaten = |by: &Contender, c: &Contender| {
        let (a, b) = (by.accuracy, c.accuracy);
        (by.renderer, a.sampler, a.classification) == (c.renderer, b.sampler, b.classification)
            && a != b
            && a.step_voxels >= b.step_voxels
            && a.ert <= b.ert
    };
    let all = inside.clone();
    inside.retain(|c| !all.iter().any(|by| is_beaten(by, c)));
    let times = times(renderers, plan, &inside)?;
    let fastest = (0..inside.len()).min_by(|&a, &b| times[a].total_cmp(&times[b]));
    Ok(inside.swap_remove(fastest.expect("there is one")))
}

/// Why there is none, and how near what comes nearest comes: of each kind the finest step that stops latest.
fn nothing(renderers: &mut [Renderer], views: &Views, plan: &Plan) -> Result<Error> {
    let finest = *steps().last().expect("there are some");
    let mut nearest: Option<(f64, Accuracy)> = None;
    for kind in kinds(renderers, plan) {
        let renderer = &mut renderers[kind.renderer];
        let Some(&latest) = thresholds(renderer, plan)?.first() else {
            continue;
        };
        let accuracy = kind.accuracy(finest, latest);
        let expected = views.errors(renderer, &accuracy, f64::INFINITY)?.expected();
        if nearest.is_none_or(|(least, _)| expected < least) {
            nearest = Some((expected, accuracy));
        }
    }
    let (field, asked) = match plan.budget {
        Budget::Psnr(db) => ("psnr", format!("{db} dB")),
        Budget::MaxError(error) => ("max-error", error.to_string()),
        Budget::BudgetMs(ms) => ("budget-ms", ms.to_string()),
    };
    let why = match (plan.budget, nearest) {
        (_, None) => "early termination alone can leave out more, whatever the step".to_owned(),
        (Budget::Psnr(_), Some((error, accuracy))) => {
            let db = -20.0 * error.log10();
            format!("nearest comes {}: {db:.1} dB", accuracy.words())
        }
        (_, Some((error, accuracy))) => {
            format!("nearest comes {}: off by {error:.5}", accuracy.words())
        }
    };
    Ok(Error::setting(
        field,
        format!("nothing stays inside {asked}; {why}"),
    ))
}

/// Frame times by auto's choice of method.
fn times(renderers: &mut [Renderer], plan: &Plan, contenders: &[Contender]) -> Result<Vec<f64>> {
    if contenders.len() == 1 {
        return Ok(vec![0.0]);
    }
    let entrants = contenders
        .iter()
        .map(|c| {
            let views = plan.tuning.views.iter().map(|&camera| {
                let settings = Settings {
                    camera,
                    ..c.accuracy.in_settings(&plan.tuning.settings)
                };
                Ok(renderers[c.renderer]
                    .choose(&settings)?
                    .in_settings(&settings))
            });
            Ok(Entrant {
                renderer: c.renderer,
                views: views.collect::<Result<_>>()?,
            })
        })
        .collect::<Result<Vec<_>>>()?;
    let outcomes = race(renderers, &entrants, plan.tuning.rounds, &mut |_| ())?;
    Ok(outcomes.iter().map(|o| o.mean(|t| t.frame_ms)).collect())
}

/// The contender with the least error of those that take no longer than `ms`: of each kind and threshold the one with the
/// smallest step that does.
pub(super) fn most_accurate(
    renderers: &mut [Renderer],
    views: &Views,
    plan: &Plan,
    ms: f64,
) -> Result<Contender> {
    let mut best: Option<Contender> = None;
    let mut shortest = f64::INFINITY;
    for kind in kinds(renderers, plan) {
        let steps = steps();
        for ert in thresholds(&renderers[kind.renderer], plan)? {
            let renderer = &mut renderers[kind.renderer];
            let (mut coarse, mut fine) = (0, steps.len());
            while coarse < fine {
                let middle = usize::midpoint(coarse, fine);
                let time = quick_time(renderer, plan, &kind.accuracy(steps[middle], ert))?;
                shortest = shortest.min(time);
                if time <= ms {
                    coarse = middle + 1;
                } else {
                    fine = middle;
                }
            }
            // Time grows towards finer steps: the last that fits is the one before.
            let Some(last) = coarse.checked_sub(1) else {
                continue;
            };
            let accuracy = kind.accuracy(steps[last], ert);
            let errors = views.errors(renderer, &accuracy, f64::INFINITY)?;
            let is_better = |b: &Contender| errors.largest() < b.errors.largest();
            if best.as_ref().is_none_or(is_better) {
                best = Some(Contender {
                    renderer: kind.renderer,
                    accuracy,
                    errors,
                });
            }
        }
    }
    best.ok_or_else(|| {
        let reason = format!("nothing is drawn in {ms} ms; the fastest took {shortest:.1} ms");
        Error::setting("budget-ms", reason)
    })
}

/// The frame time by auto's choice of method, averaged over the views.
fn quick_time(renderer: &mut Renderer, plan: &Plan, accuracy: &Accuracy) -> Result<f64> {
    let mut sum = 0.0;
    for &camera in &plan.tuning.views {
        let settings = Settings {
            camera,
            ..accuracy.in_settings(&plan.tuning.settings)
        };
        let settings = renderer.choose(&settings)?.in_settings(&settings);
        renderer.draw(&settings)?;
        let frames = (0..QUICK_ROUNDS).map(|_| Ok(renderer.draw(&settings)?.frame_ms));
        sum += median(&frames.collect::<Result<Vec<f64>>>()?);
    }
    Ok(sum / plan.tuning.views.len() as f64)
}
