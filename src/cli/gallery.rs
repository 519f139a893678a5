//! `hollowcast gallery`: volumes in every mode there is, on one sheet.

use std::path::PathBuf;
use std::sync::Arc;

use glam::DVec3;
use hollowcast::Result;
use hollowcast::camera::Camera;
use hollowcast::lattice::Clipping;
use hollowcast::mode::{MODES, Mode};
use hollowcast::output::{self, Format, PngEncoding};
use hollowcast::render::{BackendChoice, Renderer, Settings};
use hollowcast::scene::Picture;
use hollowcast::skip::{Skip, half_axis};
use hollowcast::transfer::{PRESETS, TransferFunction};
use hollowcast::volume::{self, Statistics, Volume};

use super::camera::{self, CameraSpec};
use super::progress::Progress;
use super::values;

const EXAMPLES: &str = "\
Examples:
  hollowcast gallery data/qim3d_shell.nrrd -o docs/gallery.png

Every mode has the parameters that suit the volume. Minip, which shows what is darkest, would show the air around things:
it is given a slab through the middle, across the view.";

/// Voxels of the slab that minip is given.
const SLAB: f64 = 4.0;

/// Draws volumes in every mode, on one sheet.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Args {
    /// Files (NRRD, MetaImage, NIfTI, raw), or phantom:NAME:SIZE
    #[arg(value_name = "VOLUME", required = true)]
    volumes: Vec<String>,

    /// The sheet to write; .png, .npy or .exr
    #[arg(
        short,
        long,
        value_name = "FILE",
        default_value = "hollowcast-gallery.png"
    )]
    output: PathBuf,

    /// Width and height of each picture in pixels
    #[arg(long, value_name = "WxH", default_value = "200x200", value_parser = values::size)]
    size: [u32; 2],

    #[arg(long, value_name = "WHERE", default_value = "az=30,el=20,dist=1.4,up=z,fov=45", help = camera::HELP)]
    camera: CameraSpec,

    /// Where the pictures are made: gpu or reference, which have every mode
    #[arg(long, default_value = "gpu", value_parser = values::named(&[BackendChoice::Gpu, BackendChoice::Reference], BackendChoice::name))]
    backend: BackendChoice,
}

pub(super) fn run(args: &Args) -> Result<()> {
    Format::from_path(&args.output)?;
    let progress = Progress::spinner("drawing");
    let mut renderer = Renderer::new(args.backend)?;
    let mut pictures = Vec::new();
    for spec in &args.volumes {
        let volume = Arc::new(volume::load(spec, None)?);
        let statistics = Statistics::of(&volume);
        renderer.set_volume(Arc::clone(&volume))?;
        renderer.set_transfer(TransferFunction::from_spec(PRESETS[0].name, &statistics)?);
        for row in MODES {
            let mode = (row.suited_to)(&statistics);
            pictures.push(args.picture(&mut renderer, &volume, mode)?);
        }
    }
    drop(progress);
    output::write(&sheet(&pictures), &args.output, PngEncoding::default())?;
    super::print(&format!(
        "{}: {} pictures\n",
        args.output.display(),
        pictures.len()
    ))
}

impl Args {
    /// The volume in a mode, above the mode's name.
    fn picture(&self, renderer: &mut Renderer, volume: &Volume, mode: Mode) -> Result<Picture> {
        let camera = self.camera.camera(volume, 0.0);
        let clipping = match mode {
            Mode::Minip(_) => slab(volume, &camera)?,
            _ => Clipping::NONE,
        };
        let settings = Settings {
            skip: Skip::HalfSplit,
            mode,
            size: self.size,
            clipping,
            ..Settings::new(camera)
        };
        // White on black and black on white; surfaces on white.
        let background = match mode {
            Mode::Grey(_) | Mode::Mip(_) | Mode::Mean(_) => [0.0; 3],
            _ => [1.0; 3],
        };
        let picture = output::over(&renderer.render(&settings)?.picture, background);
        Ok(output::stacked(&[
            picture,
            output::caption(mode.name(), self.size[0]),
        ]))
    }
}

/// The slab through the middle of a volume across the axis that a camera looks along.
fn slab(volume: &Volume, camera: &Camera) -> Result<Clipping> {
    let extent = volume.extent();
    let axis = half_axis(camera.forward());
    let mut normal = DVec3::ZERO;
    normal[axis] = 1.0;
    let middle = extent[axis] * 0.5;
    let mut slab = Clipping::NONE;
    slab.keep(normal, middle - SLAB * 0.5)?;
    slab.keep(-normal, -(middle + SLAB * 0.5))?;
    Ok(slab)
}

/// The pictures in rows of as many as there are in about a square, the last one filled up with nothing.
fn sheet(pictures: &[Picture]) -> Picture {
    const GAP: u32 = 4;
    let columns = (pictures.len() as f64).sqrt().ceil() as usize;
    let columns = (columns..=pictures.len())
        .find(|c| pictures.len().is_multiple_of(*c))
        .filter(|c| *c <= columns * 2)
        .unwrap_or(columns);
    let nothing = Picture {
        size: pictures[0].size,
        rgba: vec![[0.0; 4]; pictures[0].rgba.len()],
    };
    let rows: Vec<Picture> = pictures
        .chunks(columns)
        .map(|row| {
            let mut row = row.to_vec();
            row.resize(columns, nothing.clone());
            output::side_by_side(&row, GAP)
        })
        .collect();
    output::stacked(&rows)
}
