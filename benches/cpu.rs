//! The CPU backend on the Boston teapot, padded to a cube: every method, step, thread count and tile size in interleaved
//! runs, as medians.
//!
//! `HOLLOWCAST_DATA=folder cargo bench --bench cpu -- [rounds] [method...]`; the folder holds `boston_teapot.nrrd`. With
//! methods named, only those are measured.

use std::io::Read;
use std::path::Path as FilePath;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use anyhow::{Context, Result};
use glam::{DMat3, DVec3};
use hollowcast::camera::Orbit;
use hollowcast::cpu::{self, CpuPlan, Path};
use hollowcast::lattice::RayFrame;
use hollowcast::mode::Mode;
use hollowcast::octree::Occupancy;
use hollowcast::sample::Sampler;
use hollowcast::scene::{Picture, Scene};
use hollowcast::skip::Skip;
use hollowcast::transfer::{ControlPoint, Domain, Table, TransferFunction};
use hollowcast::volume::{Rescale, Volume, Voxels};

const SIZE: [u32; 2] = [512, 512];
const STEPS_OF_EDGE: [f64; 3] = [0.002, 0.005, 0.01];
const BLOCK: usize = 4;
const METHODS: [Skip; 5] = [
    Skip::Box,
    Skip::Hull,
    Skip::HalfSplit,
    Skip::DistanceMap,
    Skip::BeamMasks,
];

fn main() -> Result<()> {
    let rounds = std::env::args()
        .skip(1)
        .find_map(|a| a.parse().ok())
        .unwrap_or(9);
    let named: Vec<Skip> = std::env::args()
        .skip(1)
        .filter_map(|a| Skip::from_name(&a))
        .collect();
    let methods = if named.is_empty() {
        METHODS.to_vec()
    } else {
        named.clone()
    };
    let data = std::env::var("HOLLOWCAST_DATA").context("HOLLOWCAST_DATA names no folder")?;
    let volume = teapot(&FilePath::new(&data).join("boston_teapot.nrrd"))?;
    let edge = volume.extent().max_element();
    let views: Vec<Orbit> = [30.0, 75.0, 120.0, 165.0, 210.0, 255.0, 300.0, 345.0]
        .map(|azimuth_degrees| Orbit {
            azimuth_degrees,
            ..Orbit::default()
        })
        .to_vec();

    println!(
        "median ms a frame over {} views x {rounds} rounds, interleaved; two threads",
        views.len()
    );
    println!("cpu: processor ms of both threads; ns/smp: processor time a sample");
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
    for parts in STEPS_OF_EDGE {
        let table = table(&volume, parts * edge)?;
        let occupancy = occupancy(&volume, &table);
        let frames: Vec<RayFrame> = views
            .iter()
            .map(|v| {
                v.camera(volume.extent())
                    .ray_frame(&volume, SIZE, parts * edge)
            })
            .collect::<Result<_, _>>()?;
        let plans: Vec<CpuPlan> = methods
            .iter()
            .map(|&skip| CpuPlan::new(skip, &volume, &table, &occupancy))
            .collect::<Result<_, _>>()?;
        let times = interleaved(
            rounds,
            &plans.iter().collect::<Vec<_>>(),
            &volume,
            &table,
            &frames,
        )?;
        for (plan, ms) in plans.iter().zip(&times) {
            let mut counters = [0u64; 3];
            for frame in &frames {
                let counted = cpu::render_counted(
                    &scene(&volume, &table, frame),
                    plan,
                    &AtomicBool::new(false),
                )?;
                counters[0] += counted.counters.samples;
                counters[1] += counted.counters.contributing;
                counters[2] += counted.counters.skip_steps;
            }
            let pixels = f64::from(SIZE[0] * SIZE[1]) * frames.len() as f64;
            let per_pixel = counters.map(|c| c as f64 / pixels);
            println!(
                "{parts:>7}u {:>14} {:>9.1} {:>9.1} {:>9.1} {:>7.2} {:>7.2} {:>10.1} {:>10.1} {:>8.1} {:>7.2}",
                plan.skip().method().name,
                ms.median(),
                ms.least(),
                ms.mean_cpu(),
                times[0].median() / ms.median(),
                times[0].mean_cpu() / ms.mean_cpu(),
                per_pixel[0],
                per_pixel[1],
                per_pixel[2],
                ms.mean_cpu() * 1e6 / (per_pixel[0] * pixels / frames.len() as f64),
            );
        }
        if parts == STEPS_OF_EDGE[0] && named.is_empty() {
            variants(rounds, &volume, &table, &occupancy, &frames)?;
        }
    }
    Ok(())
}

/// Threads, tile sizes, instructions, fixed cost and preparation at the finest step.
fn variants(
    rounds: usize,
    volume: &Volume,
    table: &Table,
    occupancy: &Occupancy,
    frames: &[RayFrame],
) -> Result<()> {
    for skip in [Skip::Box, Skip::BeamMasks] {
        let plan = |tile| -> Result<CpuPlan> {
            let plan = CpuPlan::new(skip, volume, table, occupancy)?;
            let path = plan.path();
            Ok(plan.with(path, tile)?)
        };
        let tiles = [4, 8, 16, 32];
        let plans: Vec<CpuPlan> = tiles.into_iter().map(plan).collect::<Result<_>>()?;
        let times = interleaved(
            rounds,
            &plans.iter().collect::<Vec<_>>(),
            volume,
            table,
            frames,
        )?;
        for (tile, ms) in tiles.iter().zip(&times) {
            println!("  {} tile {tile:>2}: {ms}", skip.method().name);
        }
        for threads in [1, 2] {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()?;
            let ms = pool
                .install(|| interleaved(rounds.div_ceil(2), &[&plans[1]], volume, table, frames))?;
            println!("  {} threads {threads}: {}", skip.method().name, ms[0]);
        }
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
    Ok(())
}

fn scene<'a>(volume: &'a Volume, table: &'a Table, frame: &'a RayFrame) -> Scene<'a> {
    Scene {
        volume,
        table,
        frame,
        sampler: Sampler::Exact,
        mode: Mode::EmissionAbsorption,
        ert: 0.98,
    }
}

/// Milliseconds of the runs of one plan.
#[derive(Default)]
struct Times {
    /// Wall time of each run.
    wall_ms: Vec<f64>,
    /// Processor time of all runs and threads together: what other programs on the machine disturb least.
    cpu_ms: f64,
}

impl Times {
    fn median(&self) -> f64 {
        let mut sorted = self.wall_ms.clone();
        sorted.sort_by(f64::total_cmp);
        sorted[sorted.len() / 2]
    }

    fn least(&self) -> f64 {
        self.wall_ms.iter().copied().fold(f64::INFINITY, f64::min)
    }

    fn mean_cpu(&self) -> f64 {
        self.cpu_ms / self.wall_ms.len() as f64
    }
}

impl std::fmt::Display for Times {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "median {:.2} ms, least {:.2}, processor {:.2}",
            self.median(),
            self.least(),
            self.mean_cpu()
        )
    }
}

/// Processor time of this process so far, where the system tells (Linux); else 0.
fn cpu_ms() -> f64 {
    let Ok(threads) = std::fs::read_dir("/proc/self/task") else {
        return 0.0;
    };
    let nanoseconds = threads.flatten().filter_map(|thread| {
        let text = std::fs::read_to_string(thread.path().join("schedstat")).ok()?;
        text.split_whitespace().next()?.parse::<f64>().ok()
    });
    nanoseconds.sum::<f64>() * 1e-6
}

/// Times of every plan, one run of each in turn.
fn interleaved(
    rounds: usize,
    plans: &[&CpuPlan],
    volume: &Volume,
    table: &Table,
    frames: &[RayFrame],
) -> Result<Vec<Times>> {
    let mut times: Vec<Times> = plans.iter().map(|_| Times::default()).collect();
    let mut picture = Picture {
        size: SIZE,
        rgba: Vec::new(),
    };
    let cancel = AtomicBool::new(false);
    for round in 0..=rounds {
        for frame in frames {
            for (plan, times) in plans.iter().zip(&mut times) {
                let cpu = cpu_ms();
                let start = Instant::now();
                cpu::render_into(&scene(volume, table, frame), plan, &cancel, &mut picture)?;
                // The first round warms up.
                if round > 0 {
                    times.wall_ms.push(start.elapsed().as_secs_f64() * 1e3);
                    times.cpu_ms += cpu_ms() - cpu;
                }
            }
        }
    }
    Ok(times)
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

/// Blocks that are active, by the largest and smallest voxel of each with its apron.
fn occupancy(volume: &Volume, table: &Table) -> Occupancy {
    let Voxels::U8(voxels) = &volume.voxels else {
        unreachable!("the teapot is u8")
    };
    let mut occupancy = Occupancy::new(volume.dims, BLOCK);
    let [nx, ny, nz] = volume.dims;
    let span = |i: usize, n: usize| (i * BLOCK).saturating_sub(1)..((i + 1) * BLOCK + 1).min(n);
    for z in 0..occupancy.dims[2] {
        for y in 0..occupancy.dims[1] {
            for x in 0..occupancy.dims[0] {
                let (mut low, mut high) = (u8::MAX, 0);
                for vz in span(z, nz) {
                    for vy in span(y, ny) {
                        let row = &voxels[(vz * ny + vy) * nx..][span(x, nx)];
                        low = row.iter().fold(low, |m, &v| m.min(v));
                        high = row.iter().fold(high, |m, &v| m.max(v));
                    }
                }
                if table.is_visible(f64::from(low)..=f64::from(high)) {
                    occupancy.set([x, y, z]);
                }
            }
        }
    }
    occupancy
}

/// The teapot (attached NRRD, u8, gzip), centred in a cube of zeros.
fn teapot(path: &FilePath) -> Result<Volume> {
    let file = std::fs::read(path).with_context(|| path.display().to_string())?;
    let end = file
        .windows(2)
        .position(|w| w == b"\n\n")
        .context("no end of header")?;
    let header = std::str::from_utf8(&file[..end])?;
    let sizes = header
        .lines()
        .find_map(|l| l.strip_prefix("sizes: "))
        .context("no sizes")?;
    let dims: Vec<usize> = sizes
        .split_whitespace()
        .map(str::parse)
        .collect::<Result<_, _>>()?;
    let mut voxels = Vec::new();
    flate2::read::MultiGzDecoder::new(&file[end + 2..]).read_to_end(&mut voxels)?;
    let edge = *dims.iter().max().context("no axes")?;
    let mut cube = vec![0u8; edge * edge * edge];
    let pad: Vec<usize> = dims.iter().map(|n| (edge - n) / 2).collect();
    for (i, row) in voxels.chunks(dims[0]).enumerate() {
        let (y, z) = (i % dims[1] + pad[1], i / dims[1] + pad[2]);
        cube[(z * edge + y) * edge + pad[0]..][..dims[0]].copy_from_slice(row);
    }
    Ok(Volume {
        name: "boston_teapot".to_owned(),
        dims: [edge; 3],
        spacing: DVec3::ONE,
        origin: DVec3::ZERO,
        direction: DMat3::IDENTITY,
        rescale: Rescale::IDENTITY,
        voxels: Voxels::U8(cube.into()),
        warnings: Vec::new(),
    })
}
