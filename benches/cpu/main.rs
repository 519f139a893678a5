//! The CPU backend on the Boston teapot, padded to a cube: what a sample and a frame cost, how that goes with threads,
//! tiles and steps, and what memory and gathers would allow. Interleaved runs, medians.
//!
//! `HOLLOWCAST_DATA=folder cargo bench --bench cpu -- [rounds] [method...] [--charts DIR]`; the folder holds
//! `boston_teapot.nrrd`. With methods named, only those are measured, and no variants. `--charts` writes `cpu.svg` and
//! `cpu.png`.

mod limits;
mod runs;

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use anyhow::{Context, Result};
use hollowcast::camera::Orbit;
use hollowcast::cpu::{self, CpuPlan, Path};
use hollowcast::lattice::RayFrame;
use hollowcast::measure::statistics::line_through;
use hollowcast::mode::Mode;
use hollowcast::octree::{Accelerator, Occupancy};
use hollowcast::output::chart::{Chart, Line, Panel};
use hollowcast::sample::Sampler;
use hollowcast::scene::Scene;
use hollowcast::skip::Skip;
use hollowcast::transfer::{ControlPoint, Domain, Table, TransferFunction};
use hollowcast::volume::{self, Volume, Voxels};

use limits::Width;
use runs::{Times, cpu_ms, interleaved};

const SIZE: [u32; 2] = [512, 512];
/// The paper's three steps and a coarser one, for the line through them.
const STEPS_OF_EDGE: [f64; 4] = [0.002, 0.005, 0.01, 0.02];
const BLOCK: usize = 4;
const METHODS: [Skip; 5] = [
    Skip::Box,
    Skip::Hull,
    Skip::HalfSplit,
    Skip::DistanceMap,
    Skip::BeamMasks,
];
const TILES: [u32; 5] = [4, 8, 16, 32, 64];

struct Arguments {
    rounds: usize,
    methods: Vec<Skip>,
    variants: bool,
    charts: Option<PathBuf>,
}

fn arguments() -> Result<Arguments> {
    let mut parsed = Arguments {
        rounds: 9,
        methods: Vec::new(),
        variants: false,
        charts: None,
    };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        if word == "--charts" {
            parsed.charts = Some(words.next().context("--charts: no folder follows")?.into());
        } else if let Ok(rounds) = word.parse() {
            parsed.rounds = rounds;
        } else if let Some(skip) = Skip::from_name(&word) {
            parsed.methods.push(skip);
        } else if word != "--bench" {
            anyhow::bail!("{word}: neither a number of rounds nor a method");
        }
    }
    if parsed.methods.is_empty() {
        (parsed.methods, parsed.variants) = (METHODS.to_vec(), true);
    }
    Ok(parsed)
}

fn main() -> Result<()> {
    let arguments = arguments()?;
    let data = std::env::var("HOLLOWCAST_DATA").context("HOLLOWCAST_DATA names no folder")?;
    let file = PathBuf::from(data).join("boston_teapot.nrrd");
    let volume = volume::open(&file, None)?.pad_cube()?;
    let edge = volume.extent().max_element();
    let views: Vec<Orbit> = [30.0, 75.0, 120.0, 165.0, 210.0, 255.0, 300.0, 345.0]
        .map(|azimuth_degrees| Orbit {
            azimuth_degrees,
            ..Orbit::default()
        })
        .to_vec();
    let leaves = Accelerator::build(&volume, BLOCK, Sampler::Exact.apron())?;

    println!(
        "median ms a frame over {} views x {} rounds, interleaved; {} threads",
        views.len(),
        arguments.rounds,
        rayon::current_num_threads(),
    );
    println!("cpu: processor ms of all threads; ns/smp: processor time a sample");
    println!(
        "{:>8} {:>14} {:>9} {:>9} {:>9} {:>7} {:>7} {:>10} {:>10} {:>8} {:>7}",
        "step",
        "method",
        "median",
        "least",
        "cpu",
        "x box",
        "x cpu",
        "samples/px",
        "contrib/px",
        "skip/px",
        "ns/smp"
    );
    let mut panels = Vec::new();
    // Per method: samples a pixel and median ms, step by step.
    let mut costs: Vec<Vec<[f64; 2]>> = vec![Vec::new(); arguments.methods.len()];
    for parts in STEPS_OF_EDGE {
        let table = table(&volume, parts * edge)?;
        let occupancy = leaves.cull(&table, Mode::EmissionAbsorption);
        let frames: Vec<RayFrame> = views
            .iter()
            .map(|v| {
                v.camera(volume.extent())
                    .ray_frame(&volume, SIZE, parts * edge)
            })
            .collect::<Result<_, _>>()?;
        let plans: Vec<CpuPlan> = arguments
            .methods
            .iter()
            .map(|&skip| CpuPlan::new(skip, &volume, &table, &occupancy))
            .collect::<Result<_, _>>()?;
        let all: Vec<&CpuPlan> = plans.iter().collect();
        let times = interleaved(arguments.rounds, &all, &volume, &table, &frames)?;
        for (i, (plan, ms)) in plans.iter().zip(&times).enumerate() {
            let [samples, contributing, skips] = work_per_pixel(plan, &volume, &table, &frames)?;
            costs[i].push([samples, ms.median()]);
            println!(
                "{parts:>7}u {:>14} {:>9.1} {:>9.1} {:>9.1} {:>7.2} {:>7.2} {samples:>10.1} {contributing:>10.1} {skips:>8.1} {:>7.2}",
                plan.skip().method().name,
                ms.median(),
                ms.least(),
                ms.mean_cpu(),
                times[0].median() / ms.median(),
                times[0].mean_cpu() / ms.mean_cpu(),
                ms.mean_cpu() * 1e6 / (samples * pixels()),
            );
        }
        if parts == STEPS_OF_EDGE[0] && arguments.variants {
            panels = variants(arguments.rounds, &volume, &table, &occupancy, &frames)?;
            // Beside what gathers alone would cost: what a sample of each method does.
            if let Some(limits) = panels.last_mut() {
                limits.lines.extend(measured(&plans, &times, &costs));
            }
        }
    }
    println!("wall time = fixed + cost of a sample x samples, over the steps:");
    for (skip, costs) in arguments.methods.iter().zip(&costs) {
        let [fixed, slope] = line_through(costs);
        println!(
            "{:>14}: {fixed:.2} ms a frame + {:.2} ns a sample",
            skip.method().name,
            slope * 1e6 / pixels()
        );
    }
    if let Some(folder) = &arguments.charts {
        let lines = arguments
            .methods
            .iter()
            .zip(costs)
            .map(|(skip, points)| Line {
                name: skip.method().name.to_owned(),
                points,
            });
        let mut all = vec![Panel {
            x_label: "samples a pixel".to_owned(),
            y_label: "ms a frame".to_owned(),
            log_x: true,
            log_y: true,
            lines: lines.collect(),
        }];
        all.append(&mut panels);
        std::fs::create_dir_all(folder)?;
        let chart = Chart {
            title: "CPU backend: Boston teapot, 512 x 512".to_owned(),
            panels: all,
        };
        chart.write(&folder.join("cpu.svg"))?;
        chart.write(&folder.join("cpu.png"))?;
    }
    Ok(())
}

/// Processor time of a sample, by method, over all working sets alike.
fn measured(plans: &[CpuPlan], times: &[Times], costs: &[Vec<[f64; 2]>]) -> Vec<Line> {
    let rows = plans.iter().zip(times).zip(costs);
    rows.filter_map(|((plan, ms), costs)| {
        let [samples, _] = costs.last()?;
        let ns = ms.mean_cpu() * 1e6 / (samples * pixels());
        Some(Line {
            name: plan.skip().method().name.to_owned(),
            points: vec![[f64::from(1 << 14), ns], [f64::from(1 << 24), ns]],
        })
    })
    .collect()
}

fn pixels() -> f64 {
    f64::from(SIZE[0] * SIZE[1])
}

/// Samples, contributing samples and skip steps of a plan, a pixel.
fn work_per_pixel(
    plan: &CpuPlan,
    volume: &Volume,
    table: &Table,
    frames: &[RayFrame],
) -> Result<[f64; 3]> {
    let mut sums = [0u64; 3];
    for frame in frames {
        let never = AtomicBool::new(false);
        let counters = cpu::render_counted(&scene(volume, table, frame), plan, &never)?.counters;
        sums[0] += counters.samples;
        sums[1] += counters.contributing;
        sums[2] += counters.skip_steps;
    }
    Ok(sums.map(|n| n as f64 / (pixels() * frames.len() as f64)))
}

/// Threads, tile sizes, instructions, fixed cost, preparation and limits at the finest step; charts of the first two and
/// the last.
fn variants(
    rounds: usize,
    volume: &Volume,
    table: &Table,
    occupancy: &Occupancy,
    frames: &[RayFrame],
) -> Result<Vec<Panel>> {
    let panel = |x_label: &str, y_label: &str| Panel {
        x_label: x_label.to_owned(),
        y_label: y_label.to_owned(),
        log_x: true,
        log_y: true,
        lines: Vec::new(),
    };
    let mut tile_panel = panel("edge of a tile, pixels", "ms a frame");
    let mut thread_panel = panel("threads", "ms a frame");
    for skip in [Skip::Box, Skip::BeamMasks] {
        let name = skip.method().name;
        let plan = |tile| -> Result<CpuPlan> {
            let plan = CpuPlan::new(skip, volume, table, occupancy)?;
            let path = plan.path();
            Ok(plan.with(path, tile)?)
        };
        let plans: Vec<CpuPlan> = TILES.into_iter().map(plan).collect::<Result<_>>()?;
        let all: Vec<&CpuPlan> = plans.iter().collect();
        let times = interleaved(rounds, &all, volume, table, frames)?;
        for (tile, ms) in TILES.iter().zip(&times) {
            println!("  {name} tile {tile:>2}: {ms}");
        }
        tile_panel.lines.push(Line {
            name: name.to_owned(),
            points: (TILES.iter().zip(&times))
                .map(|(&tile, ms)| [f64::from(tile), ms.median()])
                .collect(),
        });
        let plan = CpuPlan::new(skip, volume, table, occupancy)?;
        let mut points = Vec::new();
        for threads in [1, 2, 4] {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()?;
            let ms =
                pool.install(|| interleaved(rounds.div_ceil(2), &[&plan], volume, table, frames))?;
            println!("  {name} threads {threads}: {}", ms[0]);
            points.push([threads as f64, ms[0].median()]);
        }
        thread_panel.lines.push(Line {
            name: name.to_owned(),
            points,
        });
    }
    let scalar =
        CpuPlan::new(Skip::BeamMasks, volume, table, occupancy)?.with(Path::Scalar, cpu::TILE)?;
    let ms = interleaved(1, &[&scalar], volume, table, frames)?;
    println!("  beam-masks scalar twin: {}", ms[0]);
    // One active block in a corner: what a frame costs whatever it shows.
    let mut one = Occupancy::new(volume.dims, BLOCK);
    one.set([0, 0, 0]);
    let plan = CpuPlan::new(Skip::BeamMasks, volume, table, &one)?;
    let ms = interleaved(rounds, &[&plan], volume, table, frames)?;
    println!("  fixed cost (one active block): {}", ms[0]);
    for skip in [Skip::BeamMasks, Skip::DistanceMap] {
        let mut times = Times::default();
        for _ in 0..rounds {
            let (cpu, start) = (cpu_ms(), Instant::now());
            std::hint::black_box(CpuPlan::new(skip, volume, table, occupancy)?);
            times.wall_ms.push(start.elapsed().as_secs_f64() * 1e3);
            times.cpu_ms += cpu_ms() - cpu;
        }
        println!("  plan {}: {times}", skip.method().name);
    }
    let mut limit_panel = limit_panel(volume, panel("working set, bytes", "ns a sample, a thread"));
    limit_panel.y_label.push_str(": limits and measured");
    Ok(vec![tile_panel, thread_panel, limit_panel])
}

/// What gathers and memory alone would cost a sample, by the bytes that are worked on.
fn limit_panel(volume: &Volume, mut panel: Panel) -> Panel {
    let Voxels::U8(voxels) = &volume.voxels else {
        unreachable!("the teapot is u8")
    };
    for (width, name) in [
        (Width::Eight, "gathers of 8"),
        (Width::Sixteen, "gathers of 16"),
    ] {
        let mut points = Vec::new();
        for bytes in [1 << 14, 1 << 17, 1 << 20, 1 << 24] {
            let bytes = &voxels[..voxels.len().min(bytes)];
            let Some(ns) = limits::ns_per_word(bytes, width) else {
                println!("  {name}: this processor has none");
                break;
            };
            let sample = ns * limits::WORDS_PER_SAMPLE;
            println!(
                "  {name} from {:>8} bytes: {ns:.3} ns a word, {sample:.2} ns a sample and thread",
                bytes.len()
            );
            points.push([bytes.len() as f64, sample]);
        }
        panel.lines.push(Line {
            name: name.to_owned(),
            points,
        });
    }
    let rate = limits::bytes_per_ns(voxels);
    println!(
        "  memory: {rate:.1} GB/s a thread in order: all voxels once in {:.2} ms",
        voxels.len() as f64 / (rate * rayon::current_num_threads() as f64) * 1e-6
    );
    panel
}

fn scene<'a>(volume: &'a Volume, table: &'a Table, frame: &'a RayFrame) -> Scene<'a> {
    Scene {
        ert: 0.98,
        ..Scene::new(volume, table, frame)
    }
}

/// Transparent up to 40, rising to an opacity of 0.3 a voxel at 255.
fn table(volume: &Volume, step: f64) -> Result<Table> {
    let color = [0.9, 0.6, 0.4];
    let point = |value, opacity| ControlPoint {
        value,
        opacity,
        color,
    };
    let function = TransferFunction::new(vec![point(40.0, 0.0), point(255.0, 0.3)], 1.0)?;
    Ok(function.bake(&Domain::new(volume, [0.0, 255.0], 256)?, step))
}
