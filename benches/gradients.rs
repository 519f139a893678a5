//! How many gradients are enough: volumes of them at full, half and quarter resolution beside central differences of the
//! samples' own field. Their bytes, the error of the normals that surfaces have by them, and what it does to a lit picture.
//!
//! `cargo bench --bench gradients -- [--charts DIR] [FILE...]`. Without files: a smooth ball, whose normals are known, and the
//! two scans that ship with the project. Angles are in degrees, over all pixels of two views whose ray hits the surface at
//! the end of the background; of the ball against its closed form, of all others against central differences on the fly. PSNR
//! is that of the `phong` pictures against the ones on the fly.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Result, ensure};
use glam::DVec3;
use hollowcast::camera::{Camera, Orbit};
use hollowcast::measure::metrics::metrics;
use hollowcast::mode::{MODES, Mode};
use hollowcast::output::chart::{Chart, Line, Panel};
use hollowcast::render::{BackendChoice, Renderer, Settings};
use hollowcast::sample::{Gradients, Sampler};
use hollowcast::scene::Picture;
use hollowcast::skip::Skip;
use hollowcast::transfer::TransferFunction;
use hollowcast::volume::{self, Statistics, Volume, Voxels, phantom};

/// Width and height of every picture.
const SIZE: [u32; 2] = [224, 224];
/// Views, by their turn about the vertical in degrees.
const AZIMUTHS: [f64; 2] = [30.0, 150.0];
/// Edge of the ball's volume and radius of its surface, in voxels.
const BALL: (usize, f64) = (128, 45.0);

fn main() -> Result<()> {
    let (mut charts, mut files) = (None, Vec::new());
    let mut args = std::env::args().skip(1).filter(|a| a != "--bench");
    while let Some(arg) = args.next() {
        if arg == "--charts" {
            charts = args.next().map(PathBuf::from);
            ensure!(charts.is_some(), "--charts needs a folder");
        } else {
            files.push(PathBuf::from(arg));
        }
    }
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("data");
    if files.is_empty() {
        files = ["qim3d_shell.nrrd", "stent.nrrd"]
            .map(|f| data.join(f))
            .to_vec();
    }
    let mut renderer = Renderer::new(BackendChoice::Gpu)?;
    println!(
        "{}, {}x{} pixels",
        renderer.info().adapter,
        SIZE[0],
        SIZE[1]
    );
    println!("volume          gradients      bytes  of voxels'   mean deg    95 % deg   phong dB");
    let mut rows = vec![(
        "ball".to_owned(),
        measure(&mut renderer, "ball", &Arc::new(ball()), true)?,
    )];
    for file in files {
        let name = file
            .file_stem()
            .map_or_else(String::new, |s| s.to_string_lossy().into_owned());
        let volume = Arc::new(volume::open(&file, None)?);
        rows.push((name.clone(), measure(&mut renderer, &name, &volume, false)?));
    }
    if let Some(folder) = charts {
        std::fs::create_dir_all(&folder)?;
        for ending in ["svg", "png"] {
            chart(&rows).write(&folder.join(format!("gradients.{ending}")))?;
        }
    }
    Ok(())
}

/// What one source of gradients costs and how well it does.
struct Row {
    per_voxel: f64,
    mean_degrees: f64,
    psnr_db: f64,
}

fn measure(
    renderer: &mut Renderer,
    name: &str,
    volume: &Arc<Volume>,
    is_ball: bool,
) -> Result<Vec<Row>> {
    let statistics = Statistics::of(volume);
    renderer.set_volume(Arc::clone(volume))?;
    renderer.set_transfer(TransferFunction::from_spec("translucent", &statistics)?);
    let suited = |name: &str| {
        let row = MODES.iter().find(|row| row.name == name);
        row.map_or(Mode::EmissionAbsorption, |row| (row.suited_to)(&statistics))
    };
    let (mut normals, mut phong) = (suited("normals"), suited("phong"));
    if is_ball {
        for mode in [&mut normals, &mut phong] {
            if let Mode::Normals { iso } | Mode::Phong { iso, .. } = mode {
                *iso = 30_000.0;
            }
        }
    }
    let mut draw = |mode, camera, gradients| -> Result<(Picture, u64)> {
        let settings = Settings {
            skip: Skip::BeamMasks,
            sampler: Some(Sampler::Exact),
            mode,
            gradients,
            size: SIZE,
            ..Settings::new(camera)
        };
        // Box needs nothing else.
        let by_box = Settings {
            skip: Skip::Box,
            ..settings
        };
        let bytes = renderer.prepare(&by_box)?.structure_bytes;
        Ok((renderer.render(&settings)?.picture, bytes))
    };
    let cameras = AZIMUTHS.map(|azimuth_degrees| {
        let orbit = Orbit {
            azimuth_degrees,
            distance_edges: 1.5,
            ..Orbit::default()
        };
        orbit.camera(volume.extent())
    });
    let mut truth = Vec::new();
    for camera in cameras {
        let mut by_fly = |mode| draw(mode, camera, Gradients::Fly);
        truth.push((by_fly(normals)?.0, by_fly(phong)?.0));
    }
    let mut rows = Vec::new();
    for &gradients in Gradients::ALL {
        let (mut degrees, mut pairs, mut bytes) = (Vec::new(), Vec::new(), 0);
        for (camera, (by_fly, lit_by_fly)) in cameras.iter().zip(&truth) {
            let ours;
            (ours, bytes) = draw(normals, *camera, gradients)?;
            degrees.extend(if is_ball {
                angles(&ours, &known_normals(volume, camera)?)
            } else {
                angles(&ours, &normals_of(by_fly))
            });
            pairs.push((draw(phong, *camera, gradients)?.0, lit_by_fly));
        }
        degrees.sort_by(f64::total_cmp);
        let row = Row {
            per_voxel: bytes as f64 / volume.bytes() as f64,
            mean_degrees: degrees.iter().sum::<f64>() / degrees.len() as f64,
            psnr_db: metrics(pairs.iter().map(|(a, b)| (a, *b))).psnr_db(),
        };
        println!(
            "{name:<16}{:<8}{bytes:>12}{:>12.3}{:>11.3}{:>12.3}{:>11.1}",
            gradients.name(),
            row.per_voxel,
            row.mean_degrees,
            degrees[degrees.len() * 95 / 100],
            row.psnr_db
        );
        rows.push(row);
    }
    Ok(rows)
}

/// A ball in 16 bits whose wall goes over some 24 voxels from 60,000 to 0 (half a cosine).
fn ball() -> Volume {
    let (n, radius) = BALL;
    let voxels: Vec<u16> = (0..n * n * n)
        .map(|i| {
            let at = [i % n, i / n % n, i / n / n].map(|c| c as f64 + 0.5 - n as f64 * 0.5);
            let off = ((DVec3::from_array(at).length() - radius) / 12.0).clamp(-1.0, 1.0);
            (30_000.0 * (1.0 - (off * std::f64::consts::FRAC_PI_2).sin())).round() as u16
        })
        .collect();
    let empty = phantom::make("empty", [n; 3]).expect("a size in range");
    Volume {
        voxels: Voxels::U16(voxels.into()),
        ..empty
    }
}

/// The ball's normals by its closed form, where a ray crosses it.
fn known_normals(volume: &Volume, camera: &Camera) -> Result<Vec<Option<DVec3>>> {
    let frame = camera.ray_frame(volume, SIZE, 0.5)?;
    let [width, height] = SIZE.map(f64::from);
    let pixels = (0..SIZE[0] * SIZE[1]).map(|i| {
        let x = f64::from(i % SIZE[0]) - (width * 0.5 - 0.5);
        let y = f64::from(i / SIZE[0]) - (height * 0.5 - 0.5);
        let start = frame.start + x * frame.start_dx + y * frame.start_dy - volume.extent() * 0.5;
        let dir = (frame.dir + x * frame.dir_dx + y * frame.dir_dy).normalize();
        let along = start.dot(dir);
        let square = along * along - start.length_squared() + BALL.1 * BALL.1;
        // Rays that touch the ball rather than cross it may miss by rounding.
        (square > 10.0).then(|| start + (-along - square.sqrt()) * dir)
    });
    Ok(pixels.collect())
}

/// The normals that a picture of them shows.
fn normals_of(picture: &Picture) -> Vec<Option<DVec3>> {
    let normal = |p: &[f32; 4]| {
        let [x, y, z, opacity] = p.map(f64::from);
        (opacity > 0.0).then(|| DVec3::new(x, y, z) * 2.0 - 1.0)
    };
    picture.rgba.iter().map(normal).collect()
}

/// Degrees between a picture's normals and these, where both are.
fn angles(picture: &Picture, expected: &[Option<DVec3>]) -> Vec<f64> {
    let pairs = normals_of(picture).into_iter().zip(expected);
    pairs
        .filter_map(|(a, b)| Some(a?.angle_between((*b)?).to_degrees()))
        .collect()
}

/// Error and picture over bytes.
fn chart(volumes: &[(String, Vec<Row>)]) -> Chart {
    let lines = |y: fn(&Row) -> f64| {
        let line = |(name, rows): &(String, Vec<Row>)| Line {
            name: name.clone(),
            points: rows.iter().map(|r| [r.per_voxel, y(r)]).collect(),
        };
        volumes.iter().map(line).collect()
    };
    let panel = |y_label: &str, log_y, lines| Panel {
        x_label: "bytes of gradients per byte of voxels".to_owned(),
        y_label: y_label.to_owned(),
        log_x: true,
        log_y,
        lines,
    };
    Chart {
        title: "Gradients at full, half and quarter resolution".to_owned(),
        panels: vec![
            panel(
                "mean error of normals in degrees",
                true,
                lines(|r| r.mean_degrees),
            ),
            panel("PSNR of phong in dB", false, lines(|r| r.psnr_db)),
        ],
    }
}
