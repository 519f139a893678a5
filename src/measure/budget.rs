//! Tuning for a budget: the fastest settings whose error stays inside it, or the most accurate inside a time.
//!
//! Errors do not depend on the method, which is lossless, nor on blocks and cuts. So sampler, step and early termination are
//! searched first, on small pictures of views all around ([`super::errors`]): of each sampler and threshold the largest step
//! whose error is inside. Of these the fastest, by auto's choice of method, is held against the worst view that climbing
//! finds, and the search repeated with that view among the others until it stands. Then every method in every block size
//! is timed with it ([`super::tune`]).

use serde::Serialize;

use super::bounds::ert_bound;
use super::compare::settings_on;
use super::errors::{Accuracy, Errors, Measure, Views, all_around};
use super::race::{Entrant, race};
use super::statistics::median;
use super::truth::Truths;
use super::tune::{self, Tuning, tune};
use crate::error::{Error, Result};
use crate::mode::Mode;
use crate::render::{Renderer, Settings};
use crate::sample::Sampler;

/// What must be kept.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Budget {
    /// Largest error of any channel, in parts of full scale.
    MaxError(f64),
    /// Least PSNR of any view, in decibels.
    Psnr(f64),
    /// Longest frame, averaged over the timed views, in ms.
    BudgetMs(f64),
}

impl Budget {
    /// The error that is measured, and how large it may be.
    fn measure(self) -> (Measure, f64) {
        match self {
            Self::MaxError(limit) => (Measure::MaxAbs, limit),
            Self::Psnr(db) => (Measure::Rms, 10.0_f64.powf(-db / 20.0)),
            Self::BudgetMs(_) => (Measure::MaxAbs, f64::INFINITY),
        }
    }

    /// # Errors
    /// [`Error::Setting`] for a number out of range.
    fn check(self) -> Result<()> {
        let (field, number) = match self {
            Self::MaxError(n) => ("max-error", n),
            Self::Psnr(n) => ("psnr", n),
            Self::BudgetMs(n) => ("budget-ms", n),
        };
        if number > 0.0 && number.is_finite() {
            Ok(())
        } else {
            Err(Error::setting(field, "must be a positive number"))
        }
    }
}

/// What is searched.
#[derive(Debug, Clone)]
pub struct Plan {
    /// What must be kept.
    pub budget: Budget,
    /// Views that are timed, blocks, rounds and the settings that all share; of these, sampler (unless it is given), step and
    /// early termination are searched.
    pub tuning: tune::Plan,
    /// Views, all around, that errors are measured on at first; 0: only those that are timed, and no others are sought.
    pub error_views: usize,
    /// Size of the pictures that errors are measured on.
    pub error_size: [u32; 2],
}

/// What was found.
#[derive(Debug, Clone)]
pub struct Found {
    /// Index of the renderer.
    pub renderer: usize,
    /// Sampler, step and early termination.
    pub accuracy: Accuracy,
    /// The largest error of all views; the worst that climbing found is among them. As the budget measures it: the largest of
    /// any channel, or (for PSNR) the root of the mean square.
    pub error: f64,
    /// What other views are expected to stay below: [`Errors::expected`].
    pub expected: f64,
    /// Views that errors were measured on.
    pub views: usize,
    /// Every method in every block size with this accuracy, the fastest first.
    pub tuning: Tuning,
}

/// Steps that are tried, in voxels of the smallest spacing: from two voxels down by the root of 2.
pub fn steps() -> Vec<f64> {
    (0..=12)
        .map(|i| 2.0 * 0.5_f64.powf(0.5 * f64::from(i)))
        .collect()
}

/// Thresholds of early termination that are tried.
pub const THRESHOLDS: [f32; 8] = [0.9, 0.95, 0.98, 0.99, 0.995, 0.998, 0.999, 1.0];
/// How often the search is repeated with a worse view.
const REPEATS: usize = 6;
/// Frames that a time is the median of while times are only compared with the budget.
const QUICK_ROUNDS: usize = 3;

/// An accuracy on one of the renderers, and its errors.
#[derive(Debug, Clone)]
struct Contender {
    renderer: usize,
    accuracy: Accuracy,
    errors: Errors,
}

/// Searches on the renderers, whose volume and transfer function are set, as those of `truths` are.
///
/// `progress` is told how much of the work is done, 0 to 1: an estimate.
///
/// # Errors
/// [`Error::Setting`] where nothing stays inside the budget, which tells how near it came; whatever a renderer reports.
pub fn search(
    renderers: &mut [Renderer],
    truths: &mut Truths,
    plan: &Plan,
    progress: &mut dyn FnMut(f64),
) -> Result<Found> {
    plan.budget.check()?;
    let cameras = match (plan.error_views, plan.tuning.views.first()) {
        (0, _) | (_, None) => plan.tuning.views.clone(),
        (count, Some(camera)) => all_around(camera, count),
    };
    let (measure, _) = plan.budget.measure();
    let settings = Settings {
        size: plan.error_size,
        ..plan.tuning.settings
    };
    let mut views = Views::new(truths, &settings, measure, &cameras, &mut |done| {
        progress(0.3 * done);
    })?;
    let (_, limit) = plan.budget.measure();
    let mut told = 0.3;
    // What frames by auto's choice may take; less where the frames of the search turn out to have been lucky.
    let mut quick_ms = match plan.budget {
        Budget::BudgetMs(ms) => ms,
        Budget::MaxError(_) | Budget::Psnr(_) => f64::INFINITY,
    };
    for _ in 0..REPEATS {
        let Contender {
            renderer,
            accuracy,
            mut errors,
        } = if quick_ms.is_finite() {
            most_accurate(renderers, &views, plan, quick_ms)?
        } else {
            fastest(renderers, &views, plan)?
        };
        told = 0.5 * (told + 0.7);
        progress(told);
        if plan.error_views > 0 {
            errors = views.climb(&mut renderers[renderer], &accuracy)?;
            if errors.expected() > limit {
                continue;
            }
        }
        let tuning_plan = tune::Plan {
            settings: accuracy.in_settings(&plan.tuning.settings),
            ..plan.tuning.clone()
        };
        let own = &mut renderers[renderer..=renderer];
        let tuning = tune(own, &tuning_plan, &mut |done| {
            progress(told + (1.0 - told) * done);
        })?;
        let frame_ms = tuning.rows[0].frame_ms;
        if let Budget::BudgetMs(ms) = plan.budget
            && frame_ms > ms
        {
            quick_ms *= 0.9 * ms / frame_ms;
            continue;
        }
        return Ok(Found {
            renderer,
            accuracy,
            error: errors.largest(),
            expected: errors.expected(),
            views: views.len(),
            tuning,
        });
    }
    Err(match plan.budget {
        Budget::BudgetMs(ms) => {
            let reason = format!("no frames stay below {ms} ms: their times vary too much");
            Error::setting("budget-ms", reason)
        }
        Budget::MaxError(_) | Budget::Psnr(_) => {
            let reason = "every search found a worse view; ask for a little less";
            Error::setting("max-error, psnr", reason)
        }
    })
}

/// Every sampler and threshold that a renderer is tried with.
///
/// Where the largest error counts, a threshold is only tried if what it can leave out at most ([`ert_bound`]) is inside the
/// budget: the rays that it costs most, which stop just before something bright, are so few that views seldom show one.
fn kinds(renderers: &[Renderer], plan: &Plan) -> Result<Vec<(usize, Sampler, f32)>> {
    let settings = &plan.tuning.settings;
    let composites = matches!(
        settings.mode,
        Mode::EmissionAbsorption | Mode::Shaded(_) | Mode::Grey(_)
    );
    let thresholds = if composites { &THRESHOLDS[..] } else { &[1.0] };
    let limit = match plan.budget {
        Budget::MaxError(limit) => limit,
        Budget::Psnr(_) | Budget::BudgetMs(_) => f64::INFINITY,
    };
    let mut kinds = Vec::new();
    for (i, renderer) in renderers.iter().enumerate() {
        let (_, transfer) = renderer.scene()?;
        let is_inside = |&ert: &f32| {
            let settings = Settings { ert, ..*settings };
            ert_bound(transfer, &settings).is_none_or(|bound| bound.error <= limit)
        };
        let thresholds: Vec<f32> = thresholds.iter().copied().filter(is_inside).collect();
        let backend = renderer.info().backend;
        let samplers = match settings_on(backend, settings).sampler {
            Some(only) => vec![only],
            // Only graphics adapters have a filter.
            None if backend == "gpu" => vec![Sampler::Hardware, Sampler::Exact],
            None => vec![Sampler::Exact],
        };
        for sampler in samplers {
            kinds.extend(thresholds.iter().map(|&ert| (i, sampler, ert)));
        }
    }
    Ok(kinds)
}

/// The fastest contender whose errors are expected to stay inside the budget.
fn fastest(renderers: &mut [Renderer], views: &Views, plan: &Plan) -> Result<Contender> {
    let (_, limit) = plan.budget.measure();
    let mut inside: Vec<Contender> = Vec::new();
    let mut nearest: Option<(f64, Accuracy)> = None;
    for (renderer, sampler, ert) in kinds(renderers, plan)? {
        // The coarsest step inside: errors fall with the step, but for noise that climbing is there for.
        let steps = steps();
        let (mut coarse, mut fine) = (0, steps.len());
        let mut found = None;
        while coarse < fine {
            let middle = usize::midpoint(coarse, fine);
            let accuracy = Accuracy {
                sampler,
                step_voxels: steps[middle],
                ert,
            };
            let errors = views.errors(&mut renderers[renderer], &accuracy, limit)?;
            let expected = errors.expected();
            if nearest
                .as_ref()
                .is_none_or(|(least, _)| errors.largest() < *least)
            {
                nearest = Some((errors.largest(), accuracy));
            }
            if expected <= limit {
                found = Some(Contender {
                    renderer,
                    accuracy,
                    errors,
                });
                fine = middle;
            } else {
                coarse = middle + 1;
            }
        }
        inside.extend(found);
    }
    if inside.is_empty() {
        let near = nearest.map_or_else(String::new, |(error, accuracy)| {
            format!(
                "; nearest came {}: {}",
                accuracy.words(),
                in_budget(plan.budget, error)
            )
        });
        let (field, asked) = match plan.budget {
            Budget::Psnr(db) => ("psnr", format!("{db} dB")),
            Budget::MaxError(error) => ("max-error", error.to_string()),
            Budget::BudgetMs(ms) => ("budget-ms", ms.to_string()),
        };
        return Err(Error::setting(
            field,
            format!("nothing stays inside {asked}{near}"),
        ));
    }
    // Of one sampler, what is coarser and stops earlier is faster: no need to time the others.
    let all = inside.clone();
    inside.retain(|c| {
        !all.iter().any(|other| {
            other.renderer == c.renderer
                && other.accuracy.sampler == c.accuracy.sampler
                && other.accuracy != c.accuracy
                && other.accuracy.step_voxels >= c.accuracy.step_voxels
                && other.accuracy.ert <= c.accuracy.ert
        })
    });
    let times = times(renderers, plan, &inside)?;
    let fastest = (0..inside.len()).min_by(|&a, &b| times[a].total_cmp(&times[b]));
    Ok(inside.swap_remove(fastest.expect("there is one")))
}

/// An error as the budget names it.
fn in_budget(budget: Budget, error: f64) -> String {
    match budget {
        Budget::Psnr(_) => format!("{:.1} dB", -20.0 * error.log10()),
        _ => format!("off by {error:.5}"),
    }
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

/// The contender with the least error of those that take no longer than `ms`: of each sampler and threshold the one with the
/// smallest step that does.
fn most_accurate(
    renderers: &mut [Renderer],
    views: &Views,
    plan: &Plan,
    ms: f64,
) -> Result<Contender> {
    let mut best: Option<Contender> = None;
    let mut shortest = f64::INFINITY;
    for (renderer, sampler, ert) in kinds(renderers, plan)? {
        let steps = steps();
        let (mut coarse, mut fine) = (0, steps.len());
        while coarse < fine {
            let middle = usize::midpoint(coarse, fine);
            let accuracy = Accuracy {
                sampler,
                step_voxels: steps[middle],
                ert,
            };
            let time = quick_time(&mut renderers[renderer], plan, &accuracy)?;
            shortest = shortest.min(time);
            if time <= ms {
                coarse = middle + 1;
            } else {
                fine = middle;
            }
        }
        // Time grows towards finer steps: the last that fits is the one before.
        if let Some(&step_voxels) = coarse.checked_sub(1).and_then(|i| steps.get(i)) {
            let accuracy = Accuracy {
                sampler,
                step_voxels,
                ert,
            };
            let errors = views.errors(&mut renderers[renderer], &accuracy, f64::INFINITY)?;
            if best
                .as_ref()
                .is_none_or(|b| errors.largest() < b.errors.largest())
            {
                best = Some(Contender {
                    renderer,
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
