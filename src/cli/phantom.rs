//! `hollowcast phantom`: test volumes whose every voxel is a formula.

use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser};
use hollowcast::volume::{Packing, phantom, write_nrrd};
use hollowcast::{Error, Result};

use super::progress::Progress;
use super::{report, values};

const EXAMPLES: &str = "\
Examples:
  hollowcast phantom pot 256 -o pot.nrrd
  hollowcast phantom menger 243x243x81 -o sponge.nrrd --gzip

Wherever a VOLUME is asked for, phantom:pot:256 does the same without a file.";

/// Writes a test volume as NRRD.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Args {
    /// What is in it
    #[arg(value_parser = names())]
    name: String,

    /// Voxels per edge, or along x, y, z: 256 or 256x256x178
    #[arg(value_parser = edges)]
    size: Size,

    /// The file to write
    #[arg(short, long, value_name = "FILE.nrrd")]
    output: PathBuf,

    /// Compress the voxels; the file can then not be memory-mapped
    #[arg(long)]
    gzip: bool,
}

/// Voxels along x, y, z.
#[derive(Debug, Clone, Copy)]
struct Size([usize; 3]);

fn names() -> PossibleValuesParser {
    PossibleValuesParser::new(
        phantom::NAMES
            .iter()
            .map(|&(name, summary)| PossibleValue::new(name).help(summary)),
    )
}

fn edges(text: &str) -> std::result::Result<Size, String> {
    match text.parse() {
        Ok(edge) if edge > 0 => Ok(Size([edge; 3])),
        _ => values::dims(text)
            .map(Size)
            .map_err(|_| "expected a number of voxels, or three as 256x256x178".to_owned()),
    }
}

pub(super) fn run(args: &Args) -> Result<()> {
    if args
        .output
        .extension()
        .is_none_or(|e| !e.eq_ignore_ascii_case("nrrd"))
    {
        return Err(Error::file(
            &args.output,
            "extension",
            "phantoms are written as .nrrd only",
        ));
    }
    let packing = if args.gzip {
        Packing::Gzip
    } else {
        Packing::Raw
    };
    let progress = Progress::spinner("making the phantom");
    let volume = phantom::make(&args.name, args.size.0)?;
    write_nrrd(&volume, &args.output, packing)?;
    drop(progress);
    super::print(&format!(
        "{}: {}\n",
        args.output.display(),
        report::volume_words(&volume)
    ))
}
