//! `hollowcast verify`: does skipping change a bit?

use std::fmt::Write;

use hollowcast::measure::verify::{self, Case, Verifier};
use hollowcast::render::{BackendChoice, Renderer};
use hollowcast::sample::Sampler;
use hollowcast::skip::Skip;
use hollowcast::{Error, Result};
use serde_json::json;

use super::progress::Progress;
use super::scene_args::SceneArgs;
use super::volume_args::VolumeArgs;
use super::{report, values};

const EXAMPLES: &str = "\
Examples:
  hollowcast verify scan.nrrd
  hollowcast verify phantom:pot:128 --backend gpu --size 96
  hollowcast verify teapot.nrrd --backend gpu --full --tf ramp:40:255:0.3

Draws the volume from outside, from inside a cavity and from inside a wall; perspective and orthographic; blocks 4, 8, 16
and 32; the paper's three steps; early termination at 0.98 and off; and counts the pixels in which a method differs from box
in any bit. With --full, all of it with one sampler (the adapter's filter where there is one, or --sampler); without, a
selection in which every pair of settings occurs, samplers included. Exit code 1 where a pixel differs. --camera and --ert
are part of what is tried, and not read.";

/// Compares every lossless method with box, bit by bit, over views and settings.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Args {
    #[command(flatten)]
    volume: VolumeArgs,

    #[command(flatten)]
    scene: SceneArgs,

    /// Every combination of settings instead of every pair
    #[arg(long, help_heading = "Verification")]
    full: bool,

    /// The methods that are compared with box [default: all lossless ones]
    #[arg(long, value_delimiter = ',', value_parser = values::method(), help_heading = "Verification")]
    methods: Vec<Skip>,

    /// Where the pictures are made
    #[arg(long, default_value = "auto", value_parser = values::named(BackendChoice::ALL, BackendChoice::name), help_heading = "Verification")]
    backend: BackendChoice,

    /// Report as JSON on standard output
    #[arg(long, help_heading = "Verification")]
    json: bool,
}

/// What was found of one method.
struct Tally {
    method: &'static str,
    differing_pixels: u64,
    max_abs: f64,
    worst: Option<Case>,
}

pub(super) fn run(args: &Args) -> Result<()> {
    let volume = args.volume.load()?;
    let (transfer, mode) = args.scene.transfer_and_mode(&volume)?;
    let mut renderer = Renderer::new(args.backend)?;
    renderer.set_volume(volume.clone())?;
    renderer.set_transfer(transfer.clone());
    let backend = renderer.info().backend;
    let sampler = args.scene.sampler.unwrap_or(match backend {
        "gpu" => Sampler::Hardware,
        _ => Sampler::Exact,
    });
    let mut cases = if args.full {
        verify::matrix(&[sampler])
    } else {
        verify::pairwise()
    };
    // Only graphics adapters have a filter.
    cases.retain(|case| backend == "gpu" || case.sampler == Sampler::Exact);

    let progress = Progress::bar("verifying");
    let mut tallies: Vec<Tally> = Vec::new();
    let mut verifier = Verifier::new(
        &mut renderer,
        &volume,
        &transfer,
        args.scene.cuts(),
        args.scene.size,
    )
    .with_mode(mode)
    .with_shading(args.scene.mode.gradients(), args.scene.mode.depth_cue)
    .with_clipping(args.scene.clip.clipping(&volume)?);
    if !args.methods.is_empty() {
        verifier = verifier.with_methods(args.methods.clone());
    }
    for (i, case) in cases.iter().enumerate() {
        for outcome in verifier.run(case)? {
            let method = outcome.skip.method().name;
            let at = tallies
                .iter()
                .position(|t| t.method == method)
                .unwrap_or_else(|| {
                    tallies.push(Tally {
                        method,
                        differing_pixels: 0,
                        max_abs: 0.0,
                        worst: None,
                    });
                    tallies.len() - 1
                });
            let tally = &mut tallies[at];
            tally.differing_pixels += outcome.differing_pixels;
            if outcome.differing_pixels > 0 && outcome.max_abs >= tally.max_abs {
                tally.max_abs = outcome.max_abs;
                tally.worst = Some(*case);
            }
        }
        progress.set((i + 1) as f64 / cases.len() as f64);
    }
    drop(progress);

    let [width, height] = args.scene.size;
    if args.json {
        let rows: Vec<_> = tallies
            .iter()
            .map(|t| {
                json!({
                    "method": t.method,
                    "differing_pixels_vs_box": t.differing_pixels,
                    "max_abs_diff_vs_box": t.max_abs,
                    "worst_case": t.worst.map(|case| format!("{case:?}")),
                })
            })
            .collect();
        super::print_json(&json!({
            "adapter": report::adapter_json(renderer.info()),
            "volume": report::volume_json(&volume),
            "size": [width, height],
            "cases": cases.len(),
            "rows": rows,
        }))?;
    } else {
        let mut text = format!(
            "{}, {width}x{height}, {} settings, on {}\n",
            report::volume_words(&volume),
            cases.len(),
            report::adapter_words(renderer.info()),
        );
        for t in &tallies {
            // Writing to a String cannot fail.
            let _ = write!(
                text,
                "{:<16}{} pixels differ from box",
                t.method, t.differing_pixels
            );
            if let Some(case) = t.worst {
                let _ = write!(text, ", by up to {:.3e} in {case:?}", t.max_abs);
            }
            text.push('\n');
        }
        super::print(&text)?;
    }
    let failed: Vec<_> = tallies
        .iter()
        .filter(|t| t.differing_pixels > 0)
        .map(|t| t.method)
        .collect();
    if failed.is_empty() {
        Ok(())
    } else {
        Err(Error::Gpu(format!(
            "not bit-identical to box: {}",
            failed.join(", ")
        )))
    }
}
