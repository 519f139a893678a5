//! `hollowcast render`: one picture.

use std::fmt::Write;
use std::path::PathBuf;

use hollowcast::camera::Camera;
use hollowcast::lattice::Clipping;
use hollowcast::measure::profile::Profile;
use hollowcast::measure::statistics::quartiles;
use hollowcast::mode::Mode;
use hollowcast::output::{self, Curve, Depth, Format, PngEncoding};
use hollowcast::render::{
    BackendChoice, Choice, DEFAULT_BLOCK, FrameTimes, MethodChoice, Preparation, Rendered,
    Renderer, Settings,
};
use hollowcast::skip::{Cuts, Skip};
use hollowcast::{Error, Result};
use serde_json::{Value, json};

use super::explain::Explained;
use super::progress::Progress;
use super::report;
use super::scene_args::{self, SceneArgs};
use super::slice_args::{SliceArgs, Technique};
use super::values::{self, Background, Step};
use super::volume_args::VolumeArgs;

const EXAMPLES: &str = "\
Examples:
  hollowcast render scan.nrrd -o scan.png
  hollowcast render scan.nrrd --method box --backend cpu -o scan.npy
  hollowcast render pot_256x256x178_uint8.raw --tf ramp:40:255:0.3 --step 0.002u --pad-cube
  hollowcast render scan.nii.gz --camera 'eye=64,64,10;target=64,64,100;up=0,1,0' --background '#20242c'
  hollowcast render scan.nrrd --mode phong --iso 90 --light 1,-1,2 --background white
  hollowcast render scan.nrrd --mode shaded --gradients half --sampler tricubic --depth-cue 0.6 --background black
  hollowcast render scan.nrrd --mode mip --window 40:200 --background black
  hollowcast render scan.nrrd --mode mip --renderer slices --slices 106 --backend gpu
  hollowcast render scan.mha --repeat 20 --json
  hollowcast render scan.nrrd --profile scan.profile.toml
  hollowcast render scan.nrrd --explain

.png holds straight colour (sRGB-encoded unless --png-curve linear); .npy and .exr hold linear f32 colour multiplied by
opacity, before quantisation. A file of that name is replaced only once the new one is complete.

auto, the default method, chooses method, blocks and cuts for this picture and adapter; the picture is the same to the bit.
On an adapter's first use it draws some small frames to learn what work costs there, for about a second.";

/// Draws one picture of a volume.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Args {
    #[command(flatten)]
    volume: VolumeArgs,

    #[command(flatten)]
    scene: SceneArgs,

    /// What makes the picture
    #[arg(long, default_value = "rays", help_heading = "Picture")]
    renderer: Technique,

    #[command(flatten)]
    slices: SliceArgs,

    /// Where samples are taken [default: auto]
    #[arg(long, value_parser = values::method_or_auto(), help_heading = "Picture")]
    method: Option<MethodChoice>,

    /// Edge of the leaf blocks in voxels: 2, 4, 8, 16, 32 or 64 [default: 8; auto chooses it]
    #[arg(long, value_name = "N", value_parser = scene_args::block, help_heading = "Picture")]
    block: Option<usize>,

    /// What `hollowcast tune` found: method, blocks, cuts and backend, and, tuned for a budget, sampler, classification, step and --ert;
    /// what is given as a flag counts instead
    #[arg(long, value_name = "FILE", help_heading = "Picture")]
    profile: Option<PathBuf>,

    /// Distance of samples in voxels (of the smallest spacing), or with u in parts of the longest box edge [default: 0.5]
    #[arg(long, allow_negative_numbers = true, help_heading = "Picture")]
    step: Option<Step>,

    /// Where the picture is made [default: auto]
    #[arg(long, value_parser = values::named(BackendChoice::ALL, BackendChoice::name), help_heading = "Picture")]
    backend: Option<BackendChoice>,

    /// The file to write; .png, .npy or .exr
    #[arg(
        short,
        long,
        value_name = "FILE",
        default_value = "out.png",
        help_heading = "Output"
    )]
    output: PathBuf,

    /// Behind the picture: none, black, white or an sRGB colour as #rrggbb
    #[arg(
        long,
        value_name = "COLOR",
        default_value = "none",
        help_heading = "Output"
    )]
    background: Background,

    /// Bits per channel of a PNG
    #[arg(long, value_name = "BITS", default_value = "8", value_parser = ["8", "16"], help_heading = "Output")]
    png_depth: String,

    /// Curve of a PNG's colours
    #[arg(long, value_name = "CURVE", default_value = "srgb", value_parser = ["srgb", "linear"], help_heading = "Output")]
    png_curve: String,

    /// Draw the view N times after a warm-up and report median and quartiles of the frame time
    #[arg(long, value_name = "N", help_heading = "Output", value_parser = clap::value_parser!(u32).range(1..))]
    repeat: Option<u32>,

    /// Say in plain words what was chosen, what it took, and how far off it can be
    #[arg(long, help_heading = "Output")]
    explain: bool,

    /// Report as JSON on standard output
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// A frame that was timed with the fetching of its picture.
struct Run {
    times: FrameTimes,
    read_back_ms: f64,
}

pub(super) fn run(args: &Args) -> Result<()> {
    // Refused before an hour of work rather than after.
    Format::from_path(&args.output)?;
    args.volume.check_output(&args.output)?;
    let profile = args.profile.as_deref().map(Profile::read).transpose()?;
    let slices = args.slices.count(&[args.renderer])?;
    let method = match slices {
        // Nothing is skipped, whatever a profile says.
        Some(_) if args.method.is_none() => MethodChoice::Only(Skip::Box),
        _ => args.method(profile.as_ref())?,
    };
    let volume = args.volume.load()?;
    let (transfer, mode) = args.scene.transfer_and_mode(&volume)?;
    let camera = args.scene.camera.camera(&volume, 0.0);
    let clipping = args.scene.clip.clipping(&volume)?;
    let step = args.step(profile.as_ref()).in_box(volume.extent());
    let progress = Progress::spinner("drawing");
    let backend = profile.map_or(BackendChoice::Auto, |p| p.backend);
    let backend = args.backend.unwrap_or(backend);
    let mut renderer = Renderer::new(backend)?;
    renderer.set_volume(volume.clone())?;
    renderer.set_transfer(transfer.clone());
    let settings = args.settings(
        method,
        profile.as_ref(),
        mode,
        step.voxels,
        camera,
        &clipping,
    );
    let settings = Settings { slices, ..settings };
    let settings = match method {
        MethodChoice::Only(_) => settings,
        MethodChoice::Auto => renderer.choose(&settings)?.in_settings(&settings),
    };
    let preparation = renderer.prepare(&settings)?;
    let rendered = renderer.render(&settings)?;
    let mut runs = Vec::new();
    for _ in 0..args.repeat.unwrap_or(0) {
        let Rendered {
            times,
            read_back_ms,
            ..
        } = renderer.render(&settings)?;
        runs.push(Run {
            times,
            read_back_ms,
        });
    }
    let explained = args
        .explain
        .then(|| Explained::of(&mut renderer, &transfer, &settings, &preparation))
        .transpose()?;
    drop(progress);

    let picture = match args.background.0 {
        Some(color) => output::over(&rendered.picture, color),
        None => rendered.picture.clone(),
    };
    output::write(&picture, &args.output, args.png_encoding())?;
    report::notice_fallback(backend, renderer.info());

    if args.json {
        let mut object = json!({
            "adapter": report::adapter_json(renderer.info()),
            "volume": report::volume_json(&volume),
            "step": step.name,
            "asked_method": method.name(),
            "output": args.output.display().to_string(),
        });
        let more = facts(&settings, &preparation, &rendered, &runs);
        if let (Value::Object(object), Value::Object(more)) = (&mut object, more) {
            object.extend(more);
        }
        if let Some(explained) = &explained {
            object["explained"] = explained.json();
        }
        super::print_json(&object)
    } else {
        let mut text = format!(
            "{}: {}, {}x{}, {}{} with sampler {} on {}\n",
            args.output.display(),
            report::volume_words(&volume),
            settings.size[0],
            settings.size[1],
            if method == MethodChoice::Auto {
                "auto: "
            } else {
                ""
            },
            match slices {
                Some(count) => format!("slices ({count})"),
                None => Choice::of(&settings).words(),
            },
            rendered.sampler.name(),
            report::adapter_words(renderer.info()),
        );
        describe_times(&mut text, &preparation, &rendered, &runs);
        if let Some(explained) = &explained {
            text.push_str(&explained.words());
        }
        super::print(&text)
    }
}

impl Args {
    /// The method that was asked for, by flag or profile.
    fn method(&self, profile: Option<&Profile>) -> Result<MethodChoice> {
        let in_profile = profile.map(|p| MethodChoice::Only(p.choice.skip));
        let method = self.method.or(in_profile).unwrap_or(MethodChoice::Auto);
        let chosen_by_hand = [
            ("block", self.block.is_some()),
            ("cut", self.scene.cut.is_some()),
            ("cuts", self.scene.cuts.is_some()),
        ];
        match chosen_by_hand.iter().find(|(_, given)| *given) {
            Some((flag, _)) if method == MethodChoice::Auto => Err(Error::setting(
                *flag,
                "is chosen by auto; name a --method with it",
            )),
            _ => Ok(method),
        }
    }

    /// What was asked for, by flag or profile; of `auto`, what is left to choose is as it happens to be.
    fn settings(
        &self,
        method: MethodChoice,
        profile: Option<&Profile>,
        mode: Mode,
        step_voxels: f64,
        camera: Camera,
        clipping: &Clipping,
    ) -> Settings {
        let skip = match method {
            MethodChoice::Auto => Skip::Box,
            MethodChoice::Only(skip) => skip,
        };
        let block = self.block.or(profile.map(|p| p.choice.block));
        let block = block.unwrap_or(DEFAULT_BLOCK);
        let cuts = profile.map_or(Cuts::default(), |p| p.choice.cuts);
        let settings = self
            .scene
            .settings(skip, mode, block, step_voxels, camera, clipping);
        let accuracy = profile.and_then(|p| p.accuracy);
        Settings {
            cuts: self.scene.cuts_or(cuts),
            sampler: self.scene.sampler.or(accuracy.map(|a| a.sampler)),
            classification: self
                .scene
                .classification
                .or(accuracy.map(|a| a.classification))
                .unwrap_or_default(),
            ert: self
                .scene
                .ert
                .or(accuracy.map(|a| a.ert))
                .unwrap_or(settings.ert),
            ..settings
        }
    }

    /// The step that was asked for, by flag or profile.
    fn step(&self, profile: Option<&Profile>) -> Step {
        let in_profile = profile.and_then(|p| p.accuracy).map(|a| a.step_voxels);
        let voxels = || Step::voxels(in_profile.unwrap_or(0.5));
        self.step.clone().unwrap_or_else(voxels)
    }

    fn png_encoding(&self) -> PngEncoding {
        PngEncoding {
            depth: if self.png_depth == "16" {
                Depth::Sixteen
            } else {
                Depth::Eight
            },
            curve: if self.png_curve == "linear" {
                Curve::Linear
            } else {
                Curve::Srgb
            },
        }
    }
}

fn of(runs: &[Run], time: impl Fn(&Run) -> f64) -> hollowcast::measure::statistics::Quartiles {
    quartiles(&runs.iter().map(time).collect::<Vec<_>>())
}

/// What was asked for and what it cost. Without repetition the times are of the one frame, warm-up included.
fn facts(
    settings: &Settings,
    preparation: &Preparation,
    rendered: &Rendered,
    runs: &[Run],
) -> Value {
    let mut object = json!({
        "renderer": if settings.slices.is_some() { "slices" } else { "rays" },
        "slices": settings.slices.map(|count| count.to_string()),
        "method": settings.skip.method().name,
        "mode": settings.mode.name(),
        "gradients": settings.mode.takes_gradients().then(|| settings.gradients.name()),
        "depth_cue": settings.depth_cue,
        "sampler": rendered.sampler.name(),
        "classification": settings.classification.name(),
        "step_voxels": settings.step_voxels,
        "block": settings.block,
        "cut": settings.cuts.half.name(),
        "cuts": settings.cuts.slabs.to_string(),
        "size": settings.size,
        "ert": report::decimal(settings.ert),
        "table_size": settings.table_entries,
        "preprocess_ms": preparation.preprocess_ms,
        "cull_ms": preparation.cull_ms,
        "structure_bytes": preparation.structure_bytes,
        "first_frame": {
            "raster_ms": rendered.times.raster_ms,
            "cast_ms": rendered.times.cast_ms,
            "frame_ms": rendered.times.frame_ms,
            "read_back_ms": rendered.read_back_ms,
        },
    });
    if !runs.is_empty() {
        object["repeat"] = json!({
            "count": runs.len(),
            "raster_ms": of(runs, |r| r.times.raster_ms),
            "cast_ms": of(runs, |r| r.times.cast_ms),
            "frame_ms": of(runs, |r| r.times.frame_ms),
            "read_back_ms": of(runs, |r| r.read_back_ms),
            "frame_with_read_back_ms": of(runs, |r| r.times.frame_ms + r.read_back_ms),
        });
    }
    object
}

fn describe_times(text: &mut String, preparation: &Preparation, rendered: &Rendered, runs: &[Run]) {
    // Writing to a String cannot fail.
    let _ = writeln!(
        text,
        "structures {:.1} ms, culling {:.1} ms, {} KiB",
        preparation.preprocess_ms,
        preparation.cull_ms,
        preparation.structure_bytes.div_ceil(1024)
    );
    if runs.is_empty() {
        let _ = writeln!(
            text,
            "frame {:.1} ms (first, unwarmed), read-back {:.1} ms",
            rendered.times.frame_ms, rendered.read_back_ms
        );
    } else {
        let whole = of(runs, |r| r.times.frame_ms + r.read_back_ms);
        let _ = writeln!(
            text,
            "frame with read-back {:.1} ms (quartiles {:.1} to {:.1}, {} runs), of it read-back {:.1} ms",
            whole.median,
            whole.q1,
            whole.q3,
            runs.len(),
            of(runs, |r| r.read_back_ms).median
        );
    }
}
