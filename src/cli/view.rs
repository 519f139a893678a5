//! `hollowcast view`: the window.

use std::path::PathBuf;

use hollowcast::Result;
use hollowcast::viewer::{self, Options};

use super::volume_args::ReadingArgs;

const EXAMPLES: &str = "\
Examples:
  hollowcast view scan.nrrd
  hollowcast view phantom:pot:128 scan.nii.gz
  hollowcast view --session session.toml
  hollowcast view pot.raw --dims 256x256x178 --type uint8 --pad-cube

F1 in the window shows keys and what the pointer does. Flags that say how a volume is read hold for every VOLUME. Pictures are drawn on a hardware GPU if there is one, else on the CPU.";

/// Opens a window to look at volumes, compare methods and edit transfer functions.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Args {
    /// Files (NRRD, MetaImage, NIfTI, raw), or phantom:NAME:SIZE
    #[arg(value_name = "VOLUME")]
    volumes: Vec<String>,

    #[command(flatten)]
    reading: ReadingArgs,

    /// Restore a session that was saved in the window
    #[arg(long, value_name = "FILE")]
    session: Option<PathBuf>,

    /// A light theme
    #[arg(long)]
    light: bool,

    /// Draw everything so much larger
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = scale)]
    scale: f32,
}

fn scale(text: &str) -> std::result::Result<f32, String> {
    text.parse()
        .ok()
        .filter(|s| (0.5..=4.0).contains(s))
        .ok_or_else(|| "expected a number from 0.5 to 4".to_owned())
}

pub(super) fn run(args: Args) -> Result<()> {
    viewer::run(&Options {
        volumes: args
            .volumes
            .iter()
            .map(|v| args.reading.source(v))
            .collect(),
        session: args.session,
        light: args.light,
        scale: args.scale,
    })
}
