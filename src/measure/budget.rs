//! Tuning for a budget: the fastest settings whose error stays inside it, or the most accurate inside a time.
//!
//! Errors do not depend on the method, which is lossless, nor on blocks and cuts. So sampler, classification, step and early
//! termination are searched first, on small pictures of views all around ([`super::errors`]): of each of them the largest
//! step whose error is inside. Of these the fastest, by auto's choice of method, is held against the worst view that climbing
//! finds, and the search repeated with that view among the others until it stands. Then every method in every block size
//! is timed with it ([`super::tune`]).

mod contenders;

use serde::Serialize;

use self::contenders::{Contender, fastest, most_accurate};
use super::errors::{Accuracy, Measure, Views, all_around};
use super::truth::Truths;
use super::tune::{self, Tuning, tune};
use crate::error::{Error, Result};
use crate::render::{Renderer, Settings};
use crate::sample::Classification;

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
    /// Views that are timed, blocks, rounds and the settings that all share; of these, sampler (unless it is given),
    /// classification, step and early termination are searched.
    pub tuning: tune::Plan,
    /// Classifications that are tried, where backend and mode have them.
    pub classifications: Vec<Classification>,
    /// Thresholds of early termination that are tried, in modes that composite.
    pub thresholds: Vec<f32>,
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
    /// Sampler, classification, step and early termination.
    pub accuracy: Accuracy,
    /// The largest error of all views; the worst that climbing found is among them. As the budget measures it: the largest of
    /// any channel, or (for PSNR) the root of the mean square.
    pub error: f64,
    /// What other views are expected to stay below: [`crate::measure::errors::Errors::expected`].
    pub expected: f64,
    /// Views that errors were measured on.
    pub views: usize,
    /// Whether worse ones were sought from the worst of these.
    pub was_climbed: bool,
    /// Every method in every block size with this accuracy, the fastest first.
    pub tuning: Tuning,
}

/// Steps that are tried, in voxels of the smallest spacing: from two voxels down by the root of 2.
pub fn steps() -> Vec<f64> {
    (0..=12)
        .map(|i| 2.0 * 0.5_f64.powf(0.5 * f64::from(i)))
        .collect()
}

/// Thresholds of early termination that are worth trying.
pub const THRESHOLDS: [f32; 8] = [0.9, 0.95, 0.98, 0.99, 0.995, 0.998, 0.999, 1.0];
/// How often the search is repeated with a worse view.
const REPEATS: usize = 6;

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
            was_climbed: plan.error_views > 0,
            tuning,
        });
    }
    Err(match plan.budget {
        Budget::BudgetMs(ms) => {
            let reason = format!("no frames stay below {ms} ms: their times vary too much");
            Error::setting("budget-ms", reason)
        }
        Budget::MaxError(_) => Error::setting(
            "max-error",
            "every search was followed by a view that is worse; allow a little more",
        ),
        Budget::Psnr(_) => Error::setting(
            "psnr",
            "every search was followed by a view that is worse; ask for a little less",
        ),
    })
}
