//! The command line: one file per subcommand; arguments that several take in files of their own.

mod bench;
mod bench_pictures;
mod bench_report;
mod camera;
mod clip_args;
mod compare;
mod demo;
mod explain;
mod gallery;
mod info;
mod mode_args;
mod mode_speeds;
mod phantom;
mod progress;
mod render;
mod report;
mod same_file;
mod scene_args;
mod slice_args;
mod stability;
mod suite_words;
mod table;
mod truth;
mod tune;
mod tune_budget;
mod tune_sweep;
mod values;
mod verify;
#[cfg(feature = "viewer")]
mod view;
mod volume_args;

use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;

use clap::error::ErrorKind;
use clap::{Parser, Subcommand};
use hollowcast::{Error, Result};

const EXAMPLES: &str = "\
Examples:
  hollowcast demo                                          the main job on a scan that ships with the program
  hollowcast info scan.nrrd                                what is in a file, and how much of it is empty
  hollowcast render scan.nrrd -o scan.png                  one picture
  hollowcast render scan.mhd --tf ramp:40:255:0.3 --camera az=120,el=35,dist=1.8 -o scan.exr
  hollowcast compare scan.nii.gz --steps 0.002u,0.005u,0.01u --json > rows.json
  hollowcast tune scan.nrrd                                the fastest method, blocks and cuts, as a profile for render
  hollowcast tune scan.nrrd --max-error 0.004              the fastest that is this exact, measured against the truth
  hollowcast truth scan.nrrd -o truth.exr                  the picture that all tend to as the step goes to 0
  hollowcast verify scan.nrrd                              does skipping change one bit?
  hollowcast gallery scan.nrrd -o modes.png                every mode there is, on one sheet
  hollowcast stability                                     where does each method fail?
  hollowcast bench benches/quick.toml -o results.jsonl     a suite of measurements
  hollowcast report results.jsonl -o report.html           and what they say, as a page
  hollowcast phantom pot 256 -o pot.nrrd                   a test volume

VOLUME is a file (NRRD, MetaImage, NIfTI, raw) or phantom:NAME:SIZE.
Exit codes: 0 done, 1 it failed, 2 the input is at fault. RUST_LOG=hollowcast=debug tells more on stderr.";

/// Renders hollow volumes without sampling their emptiness, and without changing one bit of the picture.
#[derive(Debug, Parser)]
#[command(name = "hollowcast", version, after_help = EXAMPLES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Render(render::Args),
    Compare(compare::Args),
    Tune(tune::Args),
    Truth(truth::Args),
    Verify(verify::Args),
    Stability(stability::Args),
    Bench(bench::Args),
    Report(bench_report::Args),
    Info(info::Args),
    Phantom(phantom::Args),
    Gallery(gallery::Args),
    Demo(demo::Args),
    #[cfg(feature = "viewer")]
    View(view::Args),
}

/// Runs the command that the process was started with.
pub(crate) fn main() -> ExitCode {
    tracing_subscriber::fmt()
        .with_env_filter(
            tracing_subscriber::EnvFilter::try_from_default_env()
                .unwrap_or_else(|_| "hollowcast=warn".into()),
        )
        .with_writer(io::stderr)
        .without_time()
        .with_target(false)
        .init();
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(e) => return answer_without_command(&e),
    };
    let done = match cli.command {
        Command::Render(args) => render::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Tune(args) => tune::run(&args),
        Command::Truth(args) => truth::run(&args),
        Command::Verify(args) => verify::run(&args),
        Command::Stability(args) => stability::run(&args),
        Command::Bench(args) => bench::run(&args),
        Command::Report(args) => bench_report::run(&args),
        Command::Info(args) => info::run(&args),
        Command::Phantom(args) => phantom::run(&args),
        Command::Gallery(args) => gallery::run(&args),
        Command::Demo(args) => demo::run(&args),
        #[cfg(feature = "viewer")]
        Command::View(args) => view::run(args),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            eprintln!("error: {}", one_line(&e.to_string()));
            ExitCode::from(if e.is_bad_input() { 2 } else { 1 })
        }
    }
}

/// What clap has to say instead of a command: help and version as they are, errors in one line.
fn answer_without_command(answer: &clap::Error) -> ExitCode {
    match answer.kind() {
        ErrorKind::DisplayHelp
        | ErrorKind::DisplayVersion
        | ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            // Nobody is left to tell where even this cannot be printed.
            let _ = answer.print();
        }
        _ => eprintln!("{}", message(answer)),
    }
    ExitCode::from(answer.exit_code() as u8)
}

/// An error of clap's without its hints, in one line.
fn message(answer: &clap::Error) -> String {
    let text = answer.render().to_string();
    let told = text
        .lines()
        .filter(|line| !line.starts_with("Usage:") && !line.starts_with("For more information"));
    one_line(&told.collect::<Vec<_>>().join("\n"))
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Prints to standard output. A reader that has seen enough and went away is no error.
fn print(text: &str) -> Result<()> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != io::ErrorKind::BrokenPipe => {
            Err(Error::io(Path::new("standard output"), e))
        }
        _ => Ok(()),
    }
}

/// Prints a JSON document.
fn print_json(value: &serde_json::Value) -> Result<()> {
    print(&format!("{value:#}\n"))
}
