//! `hollowcast compare`: methods against box, in time and in pictures.

use std::cmp::Ordering::Equal;
use std::sync::Arc;

use hollowcast::lattice::Clipping;
use hollowcast::measure::compare::{Against, Comparison, Plan, ReferencePlan, Row, compare};
use hollowcast::measure::machine::Machine;
use hollowcast::mode::Mode;
use hollowcast::render::{BackendChoice, BackendInfo, MethodChoice, Renderer, SliceCount};
use hollowcast::sample::Classification;
use hollowcast::skip::{METHODS, Skip};
use hollowcast::transfer::TransferFunction;
use hollowcast::volume::{Statistics, Volume};
use hollowcast::{Error, Result};
use serde_json::{Value, json};

use super::mode_args;
use super::mode_speeds;
use super::progress::Progress;
use super::scene_args::{self, SceneArgs};
use super::slice_args::{SliceArgs, Technique};
use super::values::{self, Step};
use super::volume_args::VolumeArgs;
use super::{report, table};

const EXAMPLES: &str = "\
Examples:
  hollowcast compare scan.nrrd
  hollowcast compare scan.nrrd --methods box,hull,half-split,auto --steps 0.002u,0.005u,0.01u --json
  hollowcast compare teapot.nrrd --pad-cube --tf ramp:40:255:0.3 --blocks 4,8,16
  hollowcast compare scan.nrrd --against truth --steps 0.25,0.5,1
  hollowcast compare phantom:noise:128 --backends cpu,gpu --size 256 --repeat 5
  hollowcast compare scan.nrrd --modes all --methods box,beam-masks,grid-dda --backends gpu --steps 0.005u
  hollowcast compare phantom:shells:512x512x100 --modes mip --renderer rays,slices --slices 106 --size 800x600 --backends gpu

Every method draws every view, in interleaved runs (A B C, A B C, ...); a view's time is the median of its runs, a row's
the mean over its views. frame_ms is a frame after the structures stand, without read-back (read_back_ms). Counters and
pictures come from separate, untimed runs. psnr_vs_reference_db holds a smaller picture against the f64 reference at the same
step, without early termination, or, --against truth, the picture as it is against what it tends to: null where it is equal
or was not measured. Slices keep their own distance, whatever the step.";

/// Compares methods with bounding-box casting over an orbit of views.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Args {
    #[command(flatten)]
    pub(super) volume: VolumeArgs,

    #[command(flatten)]
    pub(super) scene: SceneArgs,

    /// The methods, on every backend that has them, and auto; box is added where it is missing [default: all methods]
    #[arg(long, value_delimiter = ',', value_parser = values::method_or_auto(), help_heading = "Comparison")]
    pub(super) methods: Vec<MethodChoice>,

    /// Modes whose speeds are compared in place of one --mode, in pictures per second; their parameters suit the data
    #[arg(long, value_delimiter = ',', value_name = "all|MODE,...", value_parser = mode_args::names(), conflicts_with = "mode", help_heading = "Comparison")]
    modes: Vec<String>,

    /// rays: the methods above; slices: slices too, beside box at least
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "rays",
        help_heading = "Comparison"
    )]
    renderer: Vec<Technique>,

    #[command(flatten)]
    slices: SliceArgs,

    /// Distances of samples in voxels, or with u in parts of the longest box edge
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "0.002u,0.005u,0.01u",
        help_heading = "Comparison"
    )]
    pub(super) steps: Vec<Step>,

    /// Edges of the leaf blocks in voxels: 2, 4, 8, 16, 32, 64; auto chooses its own
    #[arg(long, value_name = "N", value_delimiter = ',', default_value = "8", value_parser = scene_args::block, help_heading = "Comparison")]
    pub(super) blocks: Vec<usize>,

    /// Where the pictures are made; of several, those that do not have a mode are left out of it
    #[arg(long, value_delimiter = ',', default_value = "auto", value_parser = values::named(BackendChoice::ALL, BackendChoice::name), help_heading = "Comparison")]
    backends: Vec<BackendChoice>,

    /// Views, evenly around the box from --camera on; a camera at a place (eye=...) is one view
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=360), help_heading = "Comparison")]
    pub(super) views: u32,

    /// Timed runs of each method in each view
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..), help_heading = "Comparison")]
    repeat: u32,

    /// What some views are held against: the f64 reference at the same step, both sides without early termination, or the
    /// truth (see `hollowcast truth --help`), to which the step goes
    #[arg(long, default_value = "reference", value_parser = values::named(Against::ALL, Against::name), help_heading = "Comparison")]
    against: Against,

    /// Views that are held against it; 0: none
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1,
        help_heading = "Comparison"
    )]
    reference_views: usize,

    /// Size of the pictures that are held against it
    #[arg(long, value_name = "WxH", default_value = "128x128", value_parser = values::size, help_heading = "Comparison")]
    reference_size: [u32; 2],

    /// Report as JSON on standard output instead of a table
    #[arg(long, help_heading = "Comparison")]
    json: bool,
}

pub(super) fn run(args: &Args) -> Result<()> {
    let volume = args.volume.load()?;
    let (transfer, modes) = if args.modes.is_empty() {
        let (transfer, mode) = args.scene.transfer_and_mode(&volume)?;
        (transfer, vec![mode])
    } else {
        let statistics = Statistics::of(&volume);
        let modes = args.scene.mode.modes(&args.modes, &statistics)?;
        (args.scene.transfer(&statistics)?, modes)
    };
    let slices = args.slices.count(&args.renderer)?;
    let mut renderers = args
        .backends
        .iter()
        .map(|&choice| ready(choice, &volume, &transfer))
        .collect::<Result<Vec<_>>>()?;
    let infos: Vec<BackendInfo> = renderers.iter().map(|r| r.info().clone()).collect();
    if slices.is_some() && infos.iter().all(|info| info.backend != "gpu") {
        let reason = "slices are drawn by the gpu backend, which is not among --backends";
        return Err(Error::setting("renderer", reason));
    }
    for (&choice, info) in args.backends.iter().zip(&infos) {
        report::notice_fallback(choice, info);
    }
    let clipping = args.scene.clip.clipping(&volume)?;
    let modes = drawn(modes, &renderers)?;
    let mut plan = args.plan(&volume, modes[0], &clipping, &renderers);
    let mut comparisons = Vec::new();
    for mode in modes {
        plan.settings.mode = mode;
        // Asked for one mode that they do not draw, slices say so.
        plan.slices = slices.filter(|_| args.modes.is_empty() || SliceCount::draw(&mode));
        let comparison = measured(&mut renderers, &volume, &transfer, &plan)?;
        comparisons.push((mode.name(), comparison));
    }
    let (_, first) = &comparisons[0];
    match (args.json, args.modes.is_empty()) {
        (true, true) => super::print_json(&args.json(&volume, &plan, first, &infos)),
        (true, false) => {
            let mut object = args.json(&volume, &plan, first, &infos);
            object["modes"] = mode_speeds::json(&comparisons);
            let object_of = object.as_object_mut().expect("made as an object");
            object_of.remove("rows");
            object_of.remove("mode");
            super::print_json(&object)
        }
        (false, true) => {
            super::print(&heading(&volume, &plan, first, &infos))?;
            super::print(&table::comparison(&first.rows))?;
            super::print(&choices(&first.rows))?;
            super::print(&format!("\n{}\n", first.noise.words()))
        }
        (false, false) => {
            super::print(&heading(&volume, &plan, first, &infos))?;
            super::print(&mode_speeds::text(&comparisons))?;
            let noises = comparisons.iter().map(|(_, c)| &c.noise);
            let noisiest =
                noises.max_by(|a, b| a.relative.partial_cmp(&b.relative).unwrap_or(Equal));
            super::print(&format!("\n{}\n", noisiest.unwrap_or(&first.noise).words()))
        }
    }
}

/// Those of some modes that any of the backends has. Which are left out is told on stderr.
fn drawn(modes: Vec<Mode>, renderers: &[Renderer]) -> Result<Vec<Mode>> {
    let (drawn, others): (Vec<Mode>, Vec<Mode>) = modes
        .into_iter()
        .partition(|mode| renderers.iter().any(|r| r.has_mode(mode)));
    if drawn.is_empty() {
        others[0].check_backend(renderers[0].info().backend)?;
    }
    if !others.is_empty() {
        let names: Vec<&str> = others.iter().map(Mode::name).collect();
        let backends: Vec<&str> = renderers.iter().map(|r| r.info().backend).collect();
        eprintln!(
            "note: {} left out: not on {}",
            names.join(", "),
            backends.join(", ")
        );
    }
    Ok(drawn)
}

/// What auto chose, a line for each of its rows.
fn choices(rows: &[Row]) -> String {
    let lines: Vec<String> = rows
        .iter()
        .filter(|row| !row.chosen.is_empty())
        .map(|row| {
            let (backend, step) = (row.backend, &row.step);
            format!("auto on {backend} at {step}: {}", row.chosen.join("; "))
        })
        .collect();
    if lines.is_empty() {
        return String::new();
    }
    format!("\n{}\n", lines.join("\n"))
}

/// A renderer with its volume and transfer function set.
pub(super) fn ready(
    choice: BackendChoice,
    volume: &Arc<Volume>,
    transfer: &TransferFunction,
) -> Result<Renderer> {
    let mut renderer = Renderer::new(choice)?;
    renderer.set_volume(volume.clone())?;
    renderer.set_transfer(transfer.clone());
    Ok(renderer)
}

/// Runs the plan under a progress bar.
pub(super) fn measured(
    renderers: &mut [Renderer],
    volume: &Arc<Volume>,
    transfer: &TransferFunction,
    plan: &Plan,
) -> Result<Comparison> {
    let mut reference = ready(BackendChoice::Reference, volume, transfer)?;
    let progress = Progress::bar("comparing");
    compare(renderers, &mut reference, plan, &mut |done| {
        progress.set(done);
    })
}

/// What the whole table shares.
pub(super) fn heading(
    volume: &Volume,
    plan: &Plan,
    comparison: &Comparison,
    infos: &[BackendInfo],
) -> String {
    let [width, height] = plan.settings.size;
    let mut lines = vec![format!(
        "{}, {width}x{height}, {} views, {} runs each",
        report::volume_words(volume),
        plan.views.len(),
        plan.rounds,
    )];
    lines.extend(
        infos
            .iter()
            .zip(&comparison.samplers)
            .map(|(info, sampler)| {
                format!(
                    "{}, sampler {}",
                    report::adapter_words(info),
                    sampler.name()
                )
            }),
    );
    if plan.reference.views > 0 {
        let [width, height] = plan.reference.size;
        let against = match plan.reference.against {
            Against::Reference => "the f64 reference, no early termination",
            Against::Truth => "the truth",
        };
        lines.push(format!(
            "PSNR of {} of the views at {width}x{height} against {against}",
            plan.reference.views.min(plan.views.len()),
        ));
    }
    lines.join("\n") + "\n\n"
}

impl Args {
    /// Whether samples are looked up one by one in the transfer function's table, as adaptive asks.
    fn follows_table(&self, mode: &Mode) -> bool {
        let classification = self.scene.classification.unwrap_or_default();
        mode.takes_table() && classification == Classification::Post
    }

    fn plan(
        &self,
        volume: &Volume,
        mode: Mode,
        clipping: &Clipping,
        renderers: &[Renderer],
    ) -> Plan {
        let mut methods = self.methods.clone();
        if methods.is_empty() && self.renderer.contains(&Technique::Rays) {
            methods = METHODS
                .iter()
                // What is fastest of those that draw the same picture is asked of modes.
                .filter(|m| self.modes.is_empty() || (m.lossless && !m.is_limit))
                .map(|m| m.skip)
                .filter(|&m| renderers.iter().any(|r| r.has(m)))
                .filter(|&m| m != Skip::Adaptive || self.follows_table(&mode))
                .map(MethodChoice::Only)
                .collect();
        }
        let base = MethodChoice::Only(Skip::Box);
        if !methods.contains(&base) {
            methods.insert(0, base);
        }
        let views = self.scene.camera.views(volume, self.views);
        let steps: Vec<_> = self
            .steps
            .iter()
            .map(|s| s.in_box(volume.extent()))
            .collect();
        let settings = self.scene.settings(
            Skip::Box,
            mode,
            self.blocks[0],
            steps[0].voxels,
            views[0],
            clipping,
        );
        Plan {
            methods,
            slices: None,
            blocks: self.blocks.clone(),
            steps,
            views,
            settings,
            rounds: self.repeat as usize,
            reference: ReferencePlan {
                against: self.against,
                views: self.reference_views,
                size: self.reference_size,
            },
        }
    }

    fn json(
        &self,
        volume: &Volume,
        plan: &Plan,
        comparison: &Comparison,
        infos: &[BackendInfo],
    ) -> Value {
        let adapters: Vec<Value> = infos
            .iter()
            .zip(&comparison.samplers)
            .map(|(info, sampler)| {
                let mut adapter = report::adapter_json(info);
                adapter["sampler"] = sampler.name().into();
                adapter
            })
            .collect();
        json!({
            "machine": Machine::this(),
            "adapter": adapters[0],
            "adapters": adapters,
            "noise": comparison.noise,
            "volume": report::volume_json(volume),
            "transfer_function": self.scene.tf,
            "table_size": self.scene.table_size,
            "mode": plan.settings.mode.name(),
            "slices": plan.slices.map(|count| count.to_string()),
            "classification": plan.settings.classification.name(),
            "ert": report::decimal(plan.settings.ert),
            "steps": plan.steps,
            "runs_per_view": plan.rounds,
            "reference": plan.reference,
            "rows": comparison.rows,
        })
    }
}
