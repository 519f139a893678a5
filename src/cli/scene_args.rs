//! Arguments that say how a volume is drawn, shared by `render`, `compare` and `demo`.

use clap::Args;
use hollowcast::Result;
use hollowcast::camera::Camera;
use hollowcast::lattice::Clipping;
use hollowcast::mode::Mode;
use hollowcast::render::Settings;
use hollowcast::sample::{Classification, Sampler};
use hollowcast::skip::{Cuts, HalfCut, Skip, SlabCount};
use hollowcast::transfer::{PRESETS, TransferFunction};
use hollowcast::volume::{Statistics, Volume};

use super::camera::{self, CameraSpec};
use super::clip_args::ClipArgs;
use super::mode_args::ModeArgs;
use super::values;

pub(super) use hollowcast::octree::BLOCKS;

/// What a picture is made of, besides the choices that a subcommand has one or several of.
#[derive(Debug, Args)]
#[command(next_help_heading = "Picture")]
pub(super) struct SceneArgs {
    #[arg(long, value_name = "NAME|RAMP|FILE", default_value = PRESETS[0].name, help = tf_help())]
    pub(super) tf: String,

    /// Entries of the table that the transfer function is baked into: 256, 4096 or 65536
    #[arg(long, value_name = "N", default_value_t = 4096)]
    pub(super) table_size: usize,

    #[command(flatten)]
    pub(super) mode: ModeArgs,

    #[command(flatten)]
    pub(super) clip: ClipArgs,

    /// How one sample is taken [default: hardware on a hardware adapter, else exact]
    #[arg(long, value_parser = values::named(Sampler::ALL, Sampler::name))]
    pub(super) sampler: Option<Sampler>,

    /// When samples get their colour: from the interpolated value (post), voxel by voxel before colours are interpolated
    /// (pre), or for all values between two samples at once (pre-integrated) [default: post]
    #[arg(long, value_parser = values::named(Classification::ALL, Classification::name))]
    pub(super) classification: Option<Classification>,

    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "512x512", value_parser = values::size)]
    pub(super) size: [u32; 2],

    /// Where half-split cuts: in the middle, or where one plane saves most [default: middle]
    #[arg(long, value_parser = values::named(HalfCut::ALL, HalfCut::name))]
    pub(super) cut: Option<HalfCut>,

    /// Into how many slabs k-cuts cuts: auto (as many as pay), at most N (2 to 8), or middle (two halves)
    /// [default: auto]
    #[arg(long, value_name = "auto|N|middle")]
    pub(super) cuts: Option<SlabCount>,

    #[arg(long, value_name = "WHERE", default_value = "az=30,el=20,dist=2,up=z,fov=45", help = camera::HELP)]
    pub(super) camera: CameraSpec,

    /// Opacity at which a ray stops; off: never [default: 0.98]
    #[arg(long, allow_negative_numbers = true, value_name = "OPACITY", value_parser = values::ert)]
    pub(super) ert: Option<f32>,
}

impl SceneArgs {
    /// The settings of one picture.
    pub(super) fn settings(
        &self,
        skip: Skip,
        mode: Mode,
        block: usize,
        step_voxels: f64,
        camera: Camera,
        clipping: &Clipping,
    ) -> Settings {
        Settings {
            skip,
            cuts: self.cuts(),
            sampler: self.sampler,
            classification: self.classification.unwrap_or_default(),
            mode,
            gradients: self.mode.gradients(),
            depth_cue: self.mode.depth_cue,
            block,
            step_voxels,
            size: self.size,
            clipping: *clipping,
            table_entries: self.table_size,
            ert: self.ert.unwrap_or(Settings::new(camera).ert),
            ..Settings::new(camera)
        }
    }

    /// Where the methods that cut do so.
    pub(super) fn cuts(&self) -> Cuts {
        self.cuts_or(Cuts::default())
    }

    /// The same, where what was not given is that of `others`.
    pub(super) fn cuts_or(&self, others: Cuts) -> Cuts {
        Cuts {
            half: self.cut.unwrap_or(others.half),
            slabs: self.cuts.unwrap_or(others.slabs),
        }
    }

    /// The transfer function for data of these statistics.
    pub(super) fn transfer(&self, statistics: &Statistics) -> Result<TransferFunction> {
        TransferFunction::from_spec(&self.tf, statistics)
    }

    /// The transfer function and the mode for this volume.
    pub(super) fn transfer_and_mode(&self, volume: &Volume) -> Result<(TransferFunction, Mode)> {
        let statistics = Statistics::of(volume);
        let transfer = self.transfer(&statistics)?;
        let mode = self.mode.mode(&statistics)?;
        let [low, high] = statistics.value_range();
        if mode.takes_table() && !transfer.shows_any_of([low, high]) {
            eprintln!("warning: the transfer function shows nothing of the data ({low} to {high})");
        }
        Ok((transfer, mode))
    }
}

/// What `--tf` takes.
pub(super) fn tf_help() -> String {
    let presets: Vec<String> = PRESETS
        .iter()
        .map(|p| format!("{} ({})", p.name, p.summary))
        .collect();
    format!(
        "Colour and opacity: ramp:FROM:TO:OPACITY (data values, opacity per voxel), a TOML file of control points or its \
         text, or a preset that looks at the histogram: {}",
        presets.join(", ")
    )
}

/// Checks a block size, which clap's own message for a list of numbers would not explain.
pub(super) fn block(text: &str) -> std::result::Result<usize, String> {
    text.parse()
        .ok()
        .filter(|b| BLOCKS.contains(b))
        .ok_or_else(|| "expected 2, 4, 8, 16, 32 or 64 voxels".to_owned())
}
