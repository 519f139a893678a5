//! `hollowcast tune`: every method in every block size, and the fastest as a profile.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use hollowcast::lattice::Clipping;
use hollowcast::measure::compare::NamedStep;
use hollowcast::measure::machine::Machine;
use hollowcast::measure::profile::Profile;
use hollowcast::measure::tune::{Auto, Plan, Row, Tuning, tune};
use hollowcast::mode::Mode;
use hollowcast::output::chart::{self, Chart, Panel};
use hollowcast::output::write_atomically;
use hollowcast::render::{BLOCKS, BackendChoice, BackendInfo};
use hollowcast::skip::Skip;
use hollowcast::volume::Volume;
use hollowcast::{Error, Result};
use serde_json::{Value, json};

use super::compare::ready;
use super::progress::Progress;
use super::scene_args::{self, SceneArgs};
use super::tune_budget::{self, BudgetArgs, ErrorArgs};
use super::tune_sweep::{in_order_of_the_sweep, lines};
use super::values::{self, Step};
use super::volume_args::VolumeArgs;
use super::{report, table};

const EXAMPLES: &str = "\
Examples:
  hollowcast tune scan.nrrd
  hollowcast tune scan.nrrd --backends cpu,gpu --views 4 -o scan.profile.toml
  hollowcast render scan.nrrd --profile scan.profile.toml
  hollowcast tune scan.nrrd --max-error 0.004
  hollowcast tune scan.nrrd --psnr 45 --backends cpu,gpu
  hollowcast tune scan.nrrd --budget-ms 16
  hollowcast tune scan.nrrd --sweep block --chart blocks.svg

Every lossless method draws every view in every block size, and those that cut in several ways to do so, in interleaved
runs (A B C, A B C, ...). A view's time is the median of its runs, a row's the mean over its views: of frames after the
structures stand, without read-back. The fastest becomes a profile for `render --profile`; what auto would have chosen
without trying is told beside it. With --sweep block, sizes 2 to 64 are compared, and no profile is written.

With a budget, sampler, classification, step and early termination are searched too, unless they are given: the fastest whose error against the truth (see
`hollowcast truth --help`) stays inside it, over views all around and the worst that is found from there, or the most
accurate inside the time. Nothing is written where nothing stays inside.";

/// Finds the fastest method, block size and cuts for a volume by trying all.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Args {
    #[command(flatten)]
    volume: VolumeArgs,

    #[command(flatten)]
    scene: SceneArgs,

    #[command(flatten)]
    budget: BudgetArgs,

    #[command(flatten)]
    error: ErrorArgs,

    /// Distance of samples in voxels (of the smallest spacing), or with u in parts of the longest box edge; searched where
    /// there is a budget
    #[arg(
        long,
        default_value = "0.5",
        help_heading = "Tuning",
        conflicts_with = "budget"
    )]
    step: Step,

    /// Where the pictures are made
    #[arg(long, value_delimiter = ',', default_value = "auto", value_parser = values::named(BackendChoice::ALL, BackendChoice::name), help_heading = "Tuning")]
    backends: Vec<BackendChoice>,

    /// Edges of the leaf blocks in voxels [default: 4,8,16,32; with --sweep block 2,4,8,16,32,64]
    #[arg(long, value_name = "N", value_delimiter = ',', value_parser = scene_args::block, help_heading = "Tuning")]
    blocks: Vec<usize>,

    /// Views, evenly around the box from --camera on; a camera at a place (eye=...) is one view
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=360), help_heading = "Tuning")]
    views: u32,

    /// Timed runs of each choice in each view
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..), help_heading = "Tuning")]
    repeat: u32,

    /// The profile to write [default: the volume's name with .profile.toml, in the current folder]
    #[arg(
        short,
        long,
        value_name = "FILE",
        help_heading = "Output",
        conflicts_with = "sweep"
    )]
    output: Option<PathBuf>,

    /// Compare block sizes for every lossless method instead of looking for the fastest
    #[arg(long, value_parser = ["block"], help_heading = "Tuning", conflicts_with = "budget")]
    sweep: Option<String>,

    /// Draw the sweep as a chart: .svg or .png
    #[arg(long, value_name = "FILE", help_heading = "Output", requires = "sweep")]
    chart: Option<PathBuf>,

    /// Report as JSON on standard output instead of a table
    #[arg(long, help_heading = "Output")]
    json: bool,
}

pub(super) fn run(args: &Args) -> Result<()> {
    // Refused before an hour of work rather than after.
    let output = args.sweep.is_none().then(|| args.output());
    if let Some(output) = &output {
        args.volume.check_output(output)?;
    }
    if let Some(chart) = &args.chart {
        chart::check_path(chart)?;
        args.volume.check_output(chart)?;
    }
    if args.scene.cut.is_some() || args.scene.cuts.is_some() {
        let reason = "cuts are what is searched";
        return Err(Error::setting("cut, cuts", reason));
    }
    let volume = args.volume.load()?;
    let (transfer, mode) = args.scene.transfer_and_mode(&volume)?;
    let clipping = args.scene.clip.clipping(&volume)?;
    let mut renderers = args
        .backends
        .iter()
        .map(|&choice| ready(choice, &volume, &transfer))
        .collect::<Result<Vec<_>>>()?;
    let step = args.step.in_box(volume.extent());
    let plan = args.plan(&volume, mode, &clipping, &step);
    if let (Some(budget), Some(output)) = (args.budget.budget(), &output) {
        let task = tune_budget::Task {
            budget,
            plan: &plan,
            around: args.scene.camera.is_around(),
            output,
            json: args.json,
            tf: &args.scene.tf,
            backends: &args.backends,
            classification: args.scene.classification,
            ert: args.scene.ert,
        };
        return tune_budget::run(&args.error, &task, &mut renderers, &volume, &transfer);
    }
    let progress = Progress::bar(if args.sweep.is_some() {
        "sweeping"
    } else {
        "tuning"
    });
    let mut tuning = tune(&mut renderers, &plan, &mut |done| progress.set(done))?;
    drop(progress);
    let infos: Vec<BackendInfo> = renderers.iter().map(|r| r.info().clone()).collect();
    for (&choice, info) in args.backends.iter().zip(&infos) {
        report::notice_fallback(choice, info);
    }
    if let Some(output) = &output {
        args.save(output, &volume, &step, &infos, &tuning)?;
    } else {
        in_order_of_the_sweep(&mut tuning.rows);
    }
    if let Some(path) = &args.chart {
        args.draw(path, &volume, &tuning.rows)?;
    }
    if args.json {
        let mut object = json!({
            "machine": Machine::this(),
            "noise": tuning.noise,
            "adapters": infos.iter().map(report::adapter_json).collect::<Vec<_>>(),
            "volume": report::volume_json(&volume),
            "transfer_function": args.scene.tf,
            "step": step,
            "size": args.scene.size,
            "view_count": plan.views.len(),
            "runs_per_view": plan.rounds,
            "rows": tuning.rows,
            "auto": tuning.auto,
        });
        if let Some(output) = &output {
            object["winner"] = json!(tuning.rows[0]);
            object["profile"] = Value::from(output.display().to_string());
        }
        return super::print_json(&object);
    }
    let [width, height] = args.scene.size;
    let mut text = format!(
        "{}, {width}x{height}, step {}, {} views, {} runs each\n",
        report::volume_words(&volume),
        step.name,
        plan.views.len(),
        plan.rounds,
    );
    for info in &infos {
        text.push_str(&report::adapter_words(info));
        text.push('\n');
    }
    text.push('\n');
    text.push_str(&rows(&tuning.rows));
    // Writing to a String cannot fail.
    let _ = writeln!(text, "\n{}", tuning.noise.words());
    if let Some(output) = &output {
        text.push_str(&verdict(&tuning, output));
    }
    super::print(&text)
}

impl Args {
    /// The profile's file.
    fn output(&self) -> PathBuf {
        let beside = || PathBuf::from(format!("{}.profile.toml", self.volume.stem()));
        self.output.clone().unwrap_or_else(beside)
    }

    fn plan(&self, volume: &Volume, mode: Mode, clipping: &Clipping, step: &NamedStep) -> Plan {
        let blocks: &[usize] = match (&self.blocks[..], &self.sweep) {
            ([], Some(_)) => &scene_args::BLOCKS,
            ([], None) => &BLOCKS,
            (given, _) => given,
        };
        let views = self.scene.camera.views(volume, self.views);
        Plan {
            blocks: blocks.to_vec(),
            cuts: self.sweep.is_none(),
            settings: self.scene.settings(
                Skip::Box,
                mode,
                blocks[0],
                step.voxels,
                views[0],
                clipping,
            ),
            views,
            rounds: self.repeat as usize,
        }
    }

    /// Writes the fastest row as a profile.
    fn save(
        &self,
        output: &Path,
        volume: &Volume,
        step: &NamedStep,
        infos: &[BackendInfo],
        tuning: &Tuning,
    ) -> Result<()> {
        let fastest = &tuning.rows[0];
        let backend = BackendChoice::ALL
            .iter()
            .find(|b| b.name() == fastest.backend);
        let info = infos.iter().find(|i| i.backend == fastest.backend);
        let (&backend, info) = backend.zip(info).expect("rows are of the renderers'");
        let profile = Profile {
            backend,
            choice: fastest.choice,
            accuracy: None,
        };
        let [width, height] = self.scene.size;
        let comment = format!(
            "Fastest of {} choices for {}, --tf {},\nstep {}, {width}x{height}, on {}: {:.1} ms a frame, {:.2} times box.",
            tuning.rows.len(),
            report::volume_words(volume),
            self.scene.tf,
            step.name,
            report::adapter_words(info),
            fastest.frame_ms,
            fastest.speedup_vs_box,
        );
        let text = profile.to_toml(&comment);
        write_atomically(output, |file| {
            std::io::Write::write_all(file, text.as_bytes())
        })
    }

    /// Draws time, samples, memory and build time over the block size.
    fn draw(&self, path: &Path, volume: &Volume, rows: &[Row]) -> Result<()> {
        let [width, height] = self.scene.size;
        let panel = |y_label: &str, number: fn(&Row) -> f64| Panel {
            x_label: "block (voxels)".to_owned(),
            y_label: y_label.to_owned(),
            log_x: true,
            log_y: true,
            lines: lines(rows, self.backends.len() > 1, number),
        };
        let chart = Chart {
            title: format!("{}, {width}x{height}, step {}", volume.name, self.step),
            panels: vec![
                panel("frame (ms)", |r| r.frame_ms),
                panel("samples a pixel", |r| r.samples_per_pixel),
                panel("structures (KiB)", |r| r.structure_bytes as f64 / 1024.0),
                panel("building them (ms)", |r| r.build_ms),
            ],
        };
        chart.write(path)
    }
}

pub(super) fn rows(rows: &[Row]) -> String {
    let head = [
        "backend",
        "method",
        "block",
        "cuts",
        "frame ms",
        "quartiles",
        "x box",
        "samples/px",
        "KiB",
        "build ms",
        "pixels off",
    ];
    let cells: Vec<Vec<String>> = rows
        .iter()
        .map(|r| {
            let is_box = r.choice.skip == Skip::Box;
            vec![
                r.backend.to_owned(),
                r.method.to_owned(),
                if is_box {
                    "-".to_owned()
                } else {
                    r.block.to_string()
                },
                r.cuts.clone().unwrap_or_else(|| "-".to_owned()),
                format!("{:.2}", r.frame_ms),
                format!("{:.2}-{:.2}", r.frame_q1_ms, r.frame_q3_ms),
                format!("{:.2}", r.speedup_vs_box),
                format!("{:.1}", r.samples_per_pixel),
                r.structure_bytes.div_ceil(1024).to_string(),
                format!("{:.1}", r.build_ms),
                r.differing_pixels_vs_box.to_string(),
            ]
        })
        .collect();
    table::columns(&head, &cells, 2)
}

/// The winner, what auto would have made of it, and where it was written.
fn verdict(tuning: &Tuning, output: &Path) -> String {
    let fastest = &tuning.rows[0];
    let mut text = format!(
        "\nfastest: {} on {}, {:.2} ms a frame, {:.2} times box\n",
        fastest.choice.words(),
        fastest.backend,
        fastest.frame_ms,
        fastest.speedup_vs_box,
    );
    // Writing to a String cannot fail.
    for Auto {
        backend,
        chosen,
        frame_ms,
        over_fastest,
    } in &tuning.auto
    {
        let off = match 100.0 * (over_fastest - 1.0) {
            0.0 => "the fastest there".to_owned(),
            percent => format!("{percent:.0} % over the fastest there"),
        };
        let _ = writeln!(
            text,
            "auto on {backend}: {}, {frame_ms:.2} ms, {off}",
            chosen.join("; ")
        );
    }
    let _ = writeln!(
        text,
        "profile: {}; use it with: hollowcast render VOLUME --profile {0}",
        output.display()
    );
    text
}
