//! Arguments that choose between casting rays and drawing slices.

use clap::ValueEnum;
use hollowcast::render::SliceCount;
use hollowcast::{Error, Result};

/// What makes a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Technique {
    /// Rays through the pixels
    Rays,
    /// Polygons across the view, blended by the rasteriser: emission-absorption, grey, mip, minip on the gpu
    Slices,
}

/// `--slices N|voxel`.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Picture")]
pub(super) struct SliceArgs {
    /// Slices across the view with --renderer slices: N in all, or voxel for one per voxel on the way [default: voxel]
    #[arg(long, value_name = "N|voxel")]
    slices: Option<SliceCount>,
}

impl SliceArgs {
    /// The slices that are drawn where slices are among `techniques`.
    pub(super) fn count(&self, techniques: &[Technique]) -> Result<Option<SliceCount>> {
        match (techniques.contains(&Technique::Slices), self.slices) {
            (true, count) => Ok(Some(count.unwrap_or(SliceCount::PerVoxel))),
            (false, None) => Ok(None),
            (false, Some(_)) => Err(Error::setting("slices", "is read with --renderer slices")),
        }
    }
}
