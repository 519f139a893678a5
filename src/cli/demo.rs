//! `hollowcast demo`: the main job on a scan that the program carries with it.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use hollowcast::Result;
use hollowcast::camera::Orbit;
use hollowcast::measure::compare::{Against, Plan, ReferencePlan, Row};
use hollowcast::output::{self, PngEncoding, heat};
use hollowcast::render::{BackendChoice, BackendInfo, MethodChoice, Settings};
use hollowcast::scene::CountedPicture;
use hollowcast::skip::{METHODS, Skip};
use hollowcast::transfer::{PRESETS, TransferFunction};
use hollowcast::volume::{self, Statistics, Volume};

use super::compare::{heading, measured, ready};
use super::{report, table, values};

const EXAMPLES: &str = "\
Examples:
  hollowcast demo
  hollowcast demo --backend cpu --size 256 -o pictures

Writes methods.png (every method side by side: the same picture) and samples.png (how many samples each took
per pixel), and prints the comparison. The scan is the micro-CT of a sea shell; see data/README.md for its origin.";

/// The scan: a shell whose whorls wind around emptiness.
const SHELL: &[u8] = include_bytes!("../../data/qim3d_shell.nrrd");

/// Shows the main job on a scan that ships with the program.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Args {
    /// The folder for the pictures; it is made where it is missing
    #[arg(short, long, value_name = "FOLDER", default_value = "hollowcast-demo")]
    output: PathBuf,

    /// Where the pictures are made
    #[arg(long, default_value = "auto", value_parser = values::named(BackendChoice::ALL, BackendChoice::name))]
    backend: BackendChoice,

    /// Width and height in pixels [default: 512x512, smaller where the backend is slow]
    #[arg(long, value_name = "WxH", value_parser = values::size)]
    size: Option<[u32; 2]>,
}

pub(super) fn run(args: &Args) -> Result<()> {
    output::make_folder(&args.output)?;
    let volume = Arc::new(shell()?);
    let transfer = TransferFunction::from_spec(PRESETS[0].name, &Statistics::of(&volume))?;
    let mut renderers = [ready(args.backend, &volume, &transfer)?];
    let info = renderers[0].info().clone();
    report::notice_fallback(args.backend, &info);
    let size = args.size.unwrap_or_else(|| size_for(&info));
    let methods: Vec<Skip> = METHODS
        .iter()
        .filter(|m| m.lossless && !m.is_limit)
        .map(|m| m.skip)
        .filter(|&m| renderers[0].has(m))
        .collect();
    let plan = plan(&volume, size, &methods);

    let comparison = measured(&mut renderers, &volume, &transfer, &plan)?;
    let counted = methods
        .iter()
        .map(|&skip| {
            renderers[0].count(&Settings {
                skip,
                ..plan.settings
            })
        })
        .collect::<Result<Vec<_>>>()?;
    let pictures = write_methods(&args.output, &methods, &counted)?;
    let heat_maps = write_samples(&args.output, &methods, &counted)?;

    let files = format!(
        "{}: the same picture by every method, side by side\n{}: samples per pixel of each\n",
        pictures.display(),
        heat_maps.display()
    );
    super::print(
        &[
            heading(&volume, &plan, &comparison, &[info]),
            table::comparison(&comparison.rows),
            verdict(&comparison.rows),
            files,
        ]
        .concat(),
    )
}

/// A size that the backend draws in a moment.
fn size_for(info: &BackendInfo) -> [u32; 2] {
    let edge = match (info.backend, info.is_software) {
        ("reference", _) => 128,
        ("gpu", true) => 256,
        _ => 512,
    };
    [edge, edge]
}

fn plan(volume: &Volume, size: [u32; 2], methods: &[Skip]) -> Plan {
    let view = |azimuth_degrees: f64| {
        Orbit {
            azimuth_degrees,
            distance_edges: 1.5,
            ..Orbit::default()
        }
        .camera(volume.extent())
    };
    let views = vec![view(30.0), view(120.0)];
    let step = 0.5;
    Plan {
        methods: methods.iter().map(|&m| MethodChoice::Only(m)).collect(),
        slices: None,
        blocks: vec![8],
        steps: vec![hollowcast::measure::compare::NamedStep {
            name: step.to_string(),
            voxels: step,
        }],
        settings: Settings {
            step_voxels: step,
            size,
            ..Settings::new(views[0])
        },
        views,
        rounds: 3,
        reference: ReferencePlan {
            against: Against::Reference,
            views: 1,
            size: size.map(|n| n.min(64)),
        },
    }
}

/// What the table says, in a sentence.
fn verdict(rows: &[Row]) -> String {
    let differing: u64 = rows.iter().map(|r| r.differing_pixels_vs_box).sum();
    let told: Vec<String> = rows
        .iter()
        .filter(|r| r.method != "box")
        .map(|r| format!("{} {:.2}x", r.method, r.speedup_vs_box))
        .collect();
    let exact = if differing == 0 {
        "not one pixel differs from box".to_owned()
    } else {
        format!("{differing} pixels DIFFER from box, which is an error of this program")
    };
    format!("\nas fast as box: {}; {exact}\n", told.join(", "))
}

fn write_methods(folder: &Path, methods: &[Skip], counted: &[CountedPicture]) -> Result<PathBuf> {
    let panels: Vec<_> = methods
        .iter()
        .zip(counted)
        .map(|(skip, c)| {
            let picture = output::over(&c.picture, [0.0; 3]);
            output::stacked(&[
                output::caption(skip.method().name, picture.size[0]),
                picture,
            ])
        })
        .collect();
    let path = folder.join("methods.png");
    output::write(
        &output::side_by_side(&panels, 4),
        &path,
        PngEncoding::default(),
    )?;
    Ok(path)
}

fn write_samples(folder: &Path, methods: &[Skip], counted: &[CountedPicture]) -> Result<PathBuf> {
    let most = counted
        .iter()
        .flat_map(|c| c.samples.iter().copied())
        .max()
        .unwrap_or(0);
    let panels: Vec<_> = methods
        .iter()
        .zip(counted)
        .map(|(skip, c)| {
            let pixels = c.samples.len() as f64;
            let mean = c.counters.samples as f64 / pixels;
            let size = c.picture.size;
            output::stacked(&[
                output::caption(&format!("{} {mean:.1}", skip.method().name), size[0]),
                heat::map(&c.samples, size, most),
            ])
        })
        .collect();
    let maps = output::side_by_side(&panels, 4);
    let legend = heat::legend(most, "samples per pixel", maps.size[0]);
    let path = folder.join("samples.png");
    output::write(
        &output::stacked(&[maps, legend]),
        &path,
        PngEncoding::default(),
    )?;
    Ok(path)
}

/// Reads the shell through a file of its own, for readers take files.
fn shell() -> Result<Volume> {
    let path = std::env::temp_dir().join(format!("hollowcast-shell-{}.nrrd", std::process::id()));
    output::write_atomically(&path, |file| file.write_all(SHELL))?;
    let read = volume::open(&path, None);
    // A leftover in the temporary folder is no reason to fail.
    let _ = fs::remove_file(&path);
    Ok(Volume {
        name: "shell".to_owned(),
        ..read?
    })
}
