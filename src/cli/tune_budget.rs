//! `hollowcast tune` for a budget of error or time.

use std::fmt::Write;
use std::path::Path;
use std::sync::Arc;

use hollowcast::Result;
use hollowcast::measure::budget::{self, Budget, Found, THRESHOLDS};
use hollowcast::measure::machine::Machine;
use hollowcast::measure::profile::Profile;
use hollowcast::measure::truth::Truths;
use hollowcast::measure::tune;
use hollowcast::output::write_atomically;
use hollowcast::render::{BackendChoice, Renderer};
use hollowcast::sample::Classification;
use hollowcast::transfer::TransferFunction;
use hollowcast::volume::Volume;
use serde_json::json;

use super::progress::Progress;
use super::{report, values};

/// What must be kept.
#[derive(Debug, clap::Args)]
#[group(id = "budget", multiple = false)]
pub(super) struct BudgetArgs {
    /// Keep the largest error of any channel below this (full scale is 1), and be as fast as that allows
    #[arg(
        long,
        value_name = "ERROR",
        help_heading = "Budget",
        allow_negative_numbers = true
    )]
    max_error: Option<f64>,

    /// Keep every view's PSNR above this, and be as fast as that allows
    #[arg(
        long,
        value_name = "DB",
        help_heading = "Budget",
        allow_negative_numbers = true
    )]
    psnr: Option<f64>,

    /// Keep a frame's time below this, and be as accurate as that allows
    #[arg(
        long,
        value_name = "MS",
        help_heading = "Budget",
        allow_negative_numbers = true
    )]
    budget_ms: Option<f64>,
}

/// How errors are measured.
#[derive(Debug, clap::Args)]
pub(super) struct ErrorArgs {
    /// Views all around that errors are measured on, besides the worst that are found from there
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..=1000), help_heading = "Budget")]
    error_views: u32,

    /// Size of the pictures that errors are measured on
    #[arg(long, value_name = "WxH", default_value = "64x64", value_parser = values::size, help_heading = "Budget")]
    error_size: [u32; 2],
}

impl BudgetArgs {
    pub(super) fn budget(&self) -> Option<Budget> {
        let error = self.max_error.map(Budget::MaxError);
        let psnr = self.psnr.map(Budget::Psnr);
        error.or(psnr).or(self.budget_ms.map(Budget::BudgetMs))
    }
}

/// What is asked for.
pub(super) struct Task<'a> {
    pub(super) budget: Budget,
    pub(super) plan: &'a tune::Plan,
    /// Whether the camera may be anywhere around the box; else only where it is.
    pub(super) around: bool,
    pub(super) output: &'a Path,
    pub(super) json: bool,
    pub(super) tf: &'a str,
    pub(super) backends: &'a [BackendChoice],
    /// What is given and not searched.
    pub(super) classification: Option<Classification>,
    pub(super) ert: Option<f32>,
}

pub(super) fn run(
    args: &ErrorArgs,
    task: &Task,
    renderers: &mut [Renderer],
    volume: &Arc<Volume>,
    transfer: &TransferFunction,
) -> Result<()> {
    let plan = budget::Plan {
        budget: task.budget,
        tuning: task.plan.clone(),
        error_views: if task.around {
            args.error_views as usize
        } else {
            0
        },
        error_size: args.error_size,
        classifications: match task.classification {
            Some(given) => vec![given],
            None => Classification::ALL.to_vec(),
        },
        thresholds: match task.ert {
            Some(given) => vec![given],
            None => THRESHOLDS.to_vec(),
        },
    };
    let progress = Progress::bar("tuning");
    let mut truths = Truths::new(volume, transfer)?;
    let found = budget::search(renderers, &mut truths, &plan, &mut |done| {
        progress.set(done);
    })?;
    drop(progress);
    for (&choice, renderer) in task.backends.iter().zip(renderers.iter()) {
        report::notice_fallback(choice, renderer.info());
    }
    let info = renderers[found.renderer].info();
    let kept = kept(task.budget, &found, args.error_size);
    save(task, volume, renderers, &found, &kept)?;
    if task.json {
        return super::print_json(&json!({
            "machine": Machine::this(),
            "adapter": report::adapter_json(info),
            "volume": report::volume_json(volume),
            "transfer_function": task.tf,
            "size": plan.tuning.settings.size,
            "budget": task.budget,
            "sampler": found.accuracy.sampler.name(),
            "classification": found.accuracy.classification.name(),
            "step_voxels": found.accuracy.step_voxels,
            "ert": report::decimal(found.accuracy.ert),
            "error": found.error,
            "expected_error": found.expected,
            "error_views": found.views,
            "error_size": args.error_size,
            "noise": found.tuning.noise,
            "rows": found.tuning.rows,
            "winner": found.tuning.rows[0],
            "profile": task.output.display().to_string(),
        }));
    }
    let [width, height] = plan.tuning.settings.size;
    let mut text = format!(
        "{}, {width}x{height}, {}\n{}\n\n",
        report::volume_words(volume),
        found.accuracy.words(),
        report::adapter_words(info),
    );
    text.push_str(&super::tune::rows(&found.tuning.rows));
    // Writing to a String cannot fail.
    let _ = writeln!(
        text,
        "\n{}\n{kept}\nprofile: {}; use it with: hollowcast render VOLUME --profile {1}",
        found.tuning.noise.words(),
        task.output.display(),
    );
    super::print(&text)
}

/// What was kept of the budget, and by what margin.
fn kept(budget: Budget, found: &Found, [width, height]: [u32; 2]) -> String {
    let fastest = &found.tuning.rows[0];
    let sought = if found.was_climbed {
        ", the worst found among them"
    } else {
        ""
    };
    let over = format!("over {} views of {width}x{height}{sought}", found.views);
    let decibels = |error: f64| -20.0 * error.log10();
    match budget {
        Budget::MaxError(limit) => format!(
            "largest error {:.5} of {limit} allowed (margin {:.0} %; {:.5} with the standard deviation of the views added), {over}",
            found.error,
            100.0 * (1.0 - found.error / limit),
            found.expected,
        ),
        Budget::Psnr(limit) if found.error == 0.0 => {
            format!("no error where {limit} dB were asked for, {over}")
        }
        Budget::Psnr(limit) => format!(
            "least PSNR {:.2} dB of {limit} dB asked for (margin {:.2} dB; {:.2} dB with the standard deviation of the views added), {over}",
            decibels(found.error),
            decibels(found.error) - limit,
            decibels(found.expected),
        ),
        Budget::BudgetMs(limit) => format!(
            "{:.2} ms a frame of {limit} ms allowed (margin {:.0} %); largest error {:.5} {over}",
            fastest.frame_ms,
            100.0 * (1.0 - fastest.frame_ms / limit),
            found.error,
        ),
    }
}

/// Writes the fastest method with its accuracy as a profile.
fn save(
    task: &Task,
    volume: &Volume,
    renderers: &[Renderer],
    found: &Found,
    kept: &str,
) -> Result<()> {
    let info = renderers[found.renderer].info();
    let fastest = &found.tuning.rows[0];
    let backend = BackendChoice::ALL
        .iter()
        .find(|b| b.name() == info.backend)
        .expect("every backend can be chosen");
    let profile = Profile {
        backend: *backend,
        choice: fastest.choice,
        accuracy: Some(found.accuracy),
    };
    let [width, height] = task.plan.settings.size;
    let comment = format!(
        "Tuned for {}, --tf {}, {width}x{height}, on {}: {:.1} ms a frame.\n{kept}.",
        report::volume_words(volume),
        task.tf,
        report::adapter_words(info),
        fastest.frame_ms,
    );
    let text = profile.to_toml(&comment);
    write_atomically(task.output, |file| {
        std::io::Write::write_all(file, text.as_bytes())
    })
}
