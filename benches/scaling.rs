//! How a frame's time grows with voxels and with pixels: every method on nested shells, each size in interleaved runs.
//!
//! `cargo bench --bench scaling -- [gpu|cpu] [rounds] [--charts DIR]`. Steps are half a voxel, so that twice the voxels
//! an axis are twice the samples of box. The exponent is the slope of log time over log voxels an axis.

use std::path::PathBuf;
use std::sync::Arc;

use anyhow::{Context, Result};
use hollowcast::camera::Orbit;
use hollowcast::measure::race::{Entrant, Outcome, race};
use hollowcast::measure::statistics::line_through;
use hollowcast::output::chart::{Chart, Line, Panel};
use hollowcast::render::{BackendChoice, Renderer, Settings};
use hollowcast::skip::{METHODS, Skip};
use hollowcast::transfer::TransferFunction;
use hollowcast::volume::{self, Statistics};

const SCENE: &str = "phantom:shells";
const TABLE: &str = "ramp:40:255:0.3";
/// Voxels an axis, at pictures of [`PIXELS`]`[0]` squared.
const VOXELS: [usize; 4] = [64, 128, 256, 512];
/// Pixels an axis, at volumes of [`VOXELS`]`[1]` cubed.
const PIXELS: [u32; 3] = [256, 512, 1024];
const BLOCK: usize = 4;

/// Milliseconds a frame of every method at every size.
type Growth = Vec<(Skip, Vec<[f64; 2]>)>;

fn main() -> Result<()> {
    let (mut backend, mut rounds, mut charts) = (BackendChoice::Gpu, 3, None);
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        match word.as_str() {
            "--bench" => {}
            "gpu" => backend = BackendChoice::Gpu,
            "cpu" => backend = BackendChoice::Cpu,
            "--charts" => {
                charts = Some(PathBuf::from(
                    words.next().context("--charts: no folder follows")?,
                ));
            }
            number => {
                rounds = number
                    .parse()
                    .with_context(|| format!("{number}: not a number"))?;
            }
        }
    }
    let mut renderers = [Renderer::new(backend)?];
    println!(
        "{SCENE}, {TABLE}, steps of half a voxel, blocks of {BLOCK}, {}",
        backend.name()
    );

    let mut by_voxels = Growth::new();
    for voxels in VOXELS {
        measure(
            &mut renderers,
            voxels,
            PIXELS[0],
            rounds,
            voxels as f64,
            &mut by_voxels,
        )?;
    }
    let mut by_pixels = Growth::new();
    for pixels in PIXELS {
        measure(
            &mut renderers,
            VOXELS[1],
            pixels,
            rounds,
            f64::from(pixels),
            &mut by_pixels,
        )?;
    }
    println!(
        "\n{:<16} {:>22} {:>22}",
        "method", "exponent, voxels/axis", "exponent, pixels/axis"
    );
    for ((skip, voxels), (_, pixels)) in by_voxels.iter().zip(&by_pixels) {
        println!(
            "{:<16} {:>22.2} {:>22.2}",
            skip.method().name,
            exponent(voxels),
            exponent(pixels)
        );
    }
    if let Some(folder) = charts {
        std::fs::create_dir_all(&folder)?;
        let panel = |x_label: &str, growth: Growth| Panel {
            x_label: x_label.to_owned(),
            y_label: "ms a frame".to_owned(),
            log_x: true,
            log_y: true,
            lines: growth
                .into_iter()
                .map(|(skip, points)| Line {
                    name: skip.method().name.to_owned(),
                    points,
                })
                .collect(),
        };
        let chart = Chart {
            title: format!("Nested shells, {}", backend.name()),
            panels: vec![
                panel("voxels an axis", by_voxels),
                panel("pixels an axis", by_pixels),
            ],
        };
        for ending in ["svg", "png"] {
            chart.write(&folder.join(format!("scaling-{}.{ending}", backend.name())))?;
        }
    }
    Ok(())
}

/// Races all methods at one size, prints them and appends their times at `x`.
fn measure(
    renderers: &mut [Renderer; 1],
    voxels: usize,
    pixels: u32,
    rounds: usize,
    x: f64,
    growth: &mut Growth,
) -> Result<()> {
    let volume = Arc::new(volume::load(&format!("{SCENE}:{voxels}"), None)?);
    let transfer = TransferFunction::from_spec(TABLE, &Statistics::of(&volume))?;
    let extent = volume.extent();
    renderers[0].set_volume(Arc::clone(&volume))?;
    renderers[0].set_transfer(transfer);
    let skips: Vec<Skip> = METHODS
        .iter()
        .filter(|m| m.lossless)
        .map(|m| m.skip)
        .filter(|&skip| renderers[0].has(skip))
        .collect();
    let entrants: Vec<Entrant> = skips
        .iter()
        .map(|&skip| Entrant {
            renderer: 0,
            views: [30.0, 120.0]
                .map(|azimuth_degrees| Settings {
                    skip,
                    block: BLOCK,
                    size: [pixels; 2],
                    table_entries: 256,
                    ..Settings::new(
                        Orbit {
                            azimuth_degrees,
                            ..Orbit::default()
                        }
                        .camera(extent),
                    )
                })
                .to_vec(),
        })
        .collect();
    let outcomes = race(renderers, &entrants, rounds, &mut |_| {})?;
    println!("\n{voxels}^3 voxels, {pixels} x {pixels} pixels");
    for (i, (&skip, outcome)) in skips.iter().zip(&outcomes).enumerate() {
        let frame_ms = |outcome: &Outcome| outcome.mean(|t| t.frame_ms);
        let ms = frame_ms(outcome);
        println!(
            "  {:<16} {ms:>9.2} ms  {:>6.2} x box  {} pixels off",
            skip.method().name,
            frame_ms(&outcomes[0]) / ms,
            outcome.differing_pixels
        );
        if growth.len() <= i {
            growth.push((skip, Vec::new()));
        }
        growth[i].1.push([x, ms]);
    }
    Ok(())
}

/// Slope of log y over log x.
fn exponent(points: &[[f64; 2]]) -> f64 {
    let logs: Vec<[f64; 2]> = points.iter().map(|p| p.map(f64::ln)).collect();
    line_through(&logs)[1]
}
