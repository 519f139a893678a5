//! Arguments that say which volume, and how much of it, shared by all subcommands that read one.

use std::path::Path;
use std::sync::Arc;

use clap::Args;
use glam::DVec3;
use hollowcast::volume::{Crop, Endian, RawLayout, Scalar, Source, Volume};
use hollowcast::{Error, Result};

use super::progress::Progress;
use super::same_file::is_same_file;
use super::values;

/// A volume and what is done to it before anything else.
#[derive(Debug, Args)]
#[command(next_help_heading = "Volume")]
pub(super) struct VolumeArgs {
    /// A file (NRRD, MetaImage, NIfTI, raw), or phantom:NAME:SIZE
    #[arg(value_name = "VOLUME")]
    volume: String,

    #[command(flatten)]
    reading: ReadingArgs,
}

/// What is done to a volume before anything else.
#[derive(Debug, Args)]
#[command(next_help_heading = "Volume")]
pub(super) struct ReadingArgs {
    /// Keep only these voxels, TO excluded: FROM:TO per axis, an open end is the volume's (0:128,20:200,:)
    #[arg(long, value_name = "X,Y,Z")]
    crop: Option<Crop>,

    /// Average N x N x N voxels into one (after --crop)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    downsample: Option<u32>,

    /// Pad to a cube with the smallest value, as the paper's data is (after --downsample)
    #[arg(long)]
    pad_cube: bool,

    #[command(flatten)]
    raw: RawArgs,
}

/// What a raw file does not say of itself. With --dims and --type, a file is read as raw whatever it looks like.
#[derive(Debug, Args)]
#[command(next_help_heading = "Raw files without a sidecar or a telling name")]
struct RawArgs {
    /// Voxels along x, y, z
    #[arg(long, value_name = "XxYxZ", value_parser = values::dims, requires = "scalar")]
    dims: Option<[usize; 3]>,

    /// Type of one voxel: uint8, int8, uint16, int16, uint32, int32, float32, float64, ...
    #[arg(long = "type", id = "scalar", value_name = "TYPE", requires = "dims")]
    scalar: Option<Scalar>,

    /// Order of a voxel's bytes: little or big
    #[arg(
        long,
        value_name = "ORDER",
        default_value = "little",
        requires = "dims"
    )]
    endian: Endian,

    /// Bytes before the first voxel
    #[arg(long, value_name = "N", default_value_t = 0, requires = "dims")]
    skip_bytes: u64,

    /// Distances of voxels along x, y, z
    #[arg(long, value_name = "X,Y,Z", default_value = "1,1,1", value_parser = values::vector, requires = "dims")]
    spacing: [f64; 3],
}

impl RawArgs {
    fn layout(&self) -> Option<RawLayout> {
        Some(RawLayout {
            dims: self.dims?,
            scalar: self.scalar?,
            endian: self.endian,
            skip_bytes: self.skip_bytes,
            spacing: DVec3::from_array(self.spacing),
        })
    }
}

impl ReadingArgs {
    /// A volume of this name, read so.
    pub(super) fn source(&self, volume: &str) -> Source {
        Source {
            volume: volume.to_owned(),
            crop: self.crop.clone(),
            downsample: self.downsample,
            pad_cube: self.pad_cube,
            raw: self.raw.layout(),
        }
    }
}

impl VolumeArgs {
    /// Checks, before any work is done, that `output` can be written and is not the volume itself.
    pub(super) fn check_output(&self, output: &Path) -> Result<()> {
        let bad = |reason: &str| Err(Error::file(output, "output", reason));
        if output.is_dir() {
            return bad("is a folder");
        }
        let folder = output.parent().filter(|p| !p.as_os_str().is_empty());
        if folder.is_some_and(|p| !p.is_dir()) {
            return bad("its folder does not exist");
        }
        if is_same_file(output, Path::new(&self.volume)) {
            return bad("is the volume itself, which would be lost");
        }
        Ok(())
    }

    /// The volume's name without folder and extension, and without what a file's name cannot have.
    pub(super) fn stem(&self) -> String {
        let stem = Path::new(&self.volume).file_stem();
        let stem = stem.map_or(self.volume.as_str().into(), |s| s.to_string_lossy());
        stem.replace([':', '/', '\\'], "-")
    }

    /// Reads the volume and cuts it to what was asked for. What was lost in loading is told on stderr.
    pub(super) fn load(&self) -> Result<Arc<Volume>> {
        let progress = Progress::spinner("reading the volume");
        let volume = self.reading.source(&self.volume).load().map_err(suggest)?;
        drop(progress);
        for warning in &volume.warnings {
            eprintln!("warning: {warning}");
        }
        Ok(Arc::new(volume))
    }
}

/// Adds the way out to an error about a volume that is too large.
pub(super) fn suggest(error: Error) -> Error {
    match error {
        Error::Limit(text) if !text.contains("--crop") => {
            Error::Limit(format!("{text}; try --crop or --downsample 2"))
        }
        other => other,
    }
}
