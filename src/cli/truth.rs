//! `hollowcast truth`: a converged picture, to measure others against.

use std::fmt::Write;
use std::path::PathBuf;

use hollowcast::measure::metrics::{metrics, perceived};
use hollowcast::measure::truth::{BOUND, Truths};
use hollowcast::output::{self, Format, PngEncoding};
use hollowcast::render::{BackendChoice, Choice, Settings};
use hollowcast::skip::Skip;
use hollowcast::{Error, Result};
use serde_json::json;

use super::compare::ready;
use super::progress::Progress;
use super::report;
use super::scene_args::SceneArgs;
use super::values::{self, Step};
use super::volume_args::VolumeArgs;

const EXAMPLES: &str = "\
Examples:
  hollowcast truth scan.nrrd -o truth.exr
  hollowcast truth scan.nrrd --tf ramp:40:255:0.3 --size 128 -o truth.npy
  hollowcast truth phantom:pot:64 --mode phong --size 128 --json
  hollowcast truth scan.nrrd --size 128 --against cpu --step 0.5 --json

The reference in double precision, with exact interpolation and without early termination, refines each pixel's step by
halves from 1/4 to 1/1024 of a voxel, until two refinements differ by less than 1e-4 in every channel. What is told: the
smallest step, the largest difference between the last two refinements (the bound), and how many pixels lie at a
discontinuity, where a sample more or less decides: those are masked, that is, not compared with. Kept in
~/.cache/hollowcast/truth, which is safe to delete.";

/// Computes the picture that all pictures of a scene tend to as the step goes to 0.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Args {
    #[command(flatten)]
    volume: VolumeArgs,

    #[command(flatten)]
    scene: SceneArgs,

    /// The file to write; .exr or .npy (a .png is for looking at) [default: none]
    #[arg(short, long, value_name = "FILE", help_heading = "Output")]
    output: Option<PathBuf>,

    /// Measure how far this backend's picture (of --step, --sampler and --ert) is from it
    #[arg(long, value_name = "BACKEND", value_parser = values::named(BackendChoice::ALL, BackendChoice::name), help_heading = "Measure")]
    against: Option<BackendChoice>,

    /// Distance of samples of that picture in voxels, or with u in parts of the longest box edge
    #[arg(long, default_value = "0.5", help_heading = "Measure")]
    step: Step,

    /// Report as JSON on standard output
    #[arg(long, help_heading = "Output")]
    json: bool,
}

pub(super) fn run(args: &Args) -> Result<()> {
    // Refused before an hour of work rather than after.
    if let Some(output) = &args.output {
        Format::from_path(output)?;
        args.volume.check_output(output)?;
    }
    if args.output.is_none() && args.against.is_none() && !args.json {
        let reason = "name a file to write, or a backend to measure with --against";
        return Err(Error::setting("output", reason));
    }
    let volume = args.volume.load()?;
    let (transfer, mode) = args.scene.transfer_and_mode(&volume)?;
    let clipping = args.scene.clip.clipping(&volume)?;
    let camera = args.scene.camera.camera(&volume, 0.0);
    let step = args.step.in_box(volume.extent());
    let settings = args
        .scene
        .settings(Skip::Box, mode, 8, step.voxels, camera, &clipping);
    let progress = Progress::bar("refining");
    let truth = Truths::new(&volume, &transfer)?.of(&settings, |done| progress.set(done))?;
    drop(progress);
    if let Some(output) = &args.output {
        output::write(&truth.picture, output, PngEncoding::default())?;
    }
    let [width, height] = settings.size;
    let masked = truth.masked.iter().filter(|&&m| m).count();
    let mut object = json!({
        "volume": report::volume_json(&volume),
        "mode": mode.name(),
        "size": settings.size,
        "step_voxels": truth.step_voxels,
        "bound": truth.bound,
        "masked_pixels": masked,
        "masked_share": truth.masked_share(),
        "output": args.output.as_ref().map(|o| o.display().to_string()),
    });
    let mut text = format!(
        "{}, {width}x{height}: refined to a step of {} voxels, bound {:.1e}{}, {masked} pixels masked ({:.2} %)\n",
        report::volume_words(&volume),
        truth.step_voxels,
        truth.bound,
        if truth.bound > BOUND {
            " (it did not settle)"
        } else {
            ""
        },
        100.0 * truth.masked_share(),
    );
    if let Some(choice) = args.against {
        let mut renderer = ready(choice, &volume, &transfer)?;
        let skip = renderer.choose(&settings)?;
        let settings = Settings {
            sampler: Some(renderer.sampler(&settings)),
            ..skip.in_settings(&settings)
        };
        let picture = renderer.render(&settings)?.picture;
        report::notice_fallback(choice, renderer.info());
        let (error, look) = (metrics([(&picture, &truth)]), perceived((&picture, &truth)));
        object["measured"] = json!({
            "adapter": report::adapter_json(renderer.info()),
            "method": settings.skip.method().name,
            "sampler": renderer.sampler(&settings).name(),
            "step": step.name,
            "ert": report::decimal(settings.ert),
            "error": error,
            "psnr_db": error.psnr_db(),
            "ssim": look.ssim,
            "flip": look.flip,
        });
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "{} by {}, step {}: max {:.5}, mean {:.2e}, rms {:.2e}, PSNR {:.1} dB, SSIM {:.5}, FLIP {:.4}, {:.2} % off by over 1/255",
            report::adapter_words(renderer.info()),
            Choice::of(&settings).words(),
            step.name,
            error.max_abs,
            error.mean_abs,
            error.rms,
            error.psnr_db(),
            look.ssim,
            look.flip,
            100.0 * error.off_share,
        );
    }
    if args.json {
        return super::print_json(&object);
    }
    if let Some(output) = &args.output {
        let _ = writeln!(text, "{}", output.display());
    }
    super::print(&text)
}
