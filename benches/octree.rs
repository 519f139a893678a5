//! What the accelerator costs: preprocessing, re-culling after an edit of the table, bytes and faces.
//!
//! `cargo bench --bench octree` measures closed-form volumes; raw u8 volumes of 256^3 voxels are added by path after
//! `--`. Prints medians of 15 runs.

use std::fs;
use std::hint::black_box;
use std::time::Instant;

use glam::{DMat3, DVec3};
use hollowcast::mode::Mode;
use hollowcast::octree::{Accelerator, Hull};
use hollowcast::transfer::{ControlPoint, Domain, Table, TransferFunction};
use hollowcast::volume::{Rescale, Volume, Voxels};

const EDGE: usize = 256;
const RUNS: usize = 15;

fn main() {
    // Cargo adds flags of its own for the standard harness.
    let paths = std::env::args().skip(1).filter(|a| !a.starts_with('-'));
    let mut volumes = vec![
        volume("shell", shell()),
        volume("noise", noise()),
        volume("full", vec![255; EDGE.pow(3)]),
    ];
    for path in paths {
        let voxels = fs::read(&path).expect("the volume can be read");
        assert_eq!(voxels.len(), EDGE.pow(3), "{path} has 256^3 bytes");
        volumes.push(volume(&path, voxels));
    }

    println!(
        "{:<24} {:>5} {:>9} {:>9} {:>9} {:>9} {:>9} {:>8} {:>8} {:>8} {:>8} {:>7} {:>7}",
        "volume",
        "block",
        "leaves_ms",
        "trees_ms",
        "cull_ms",
        "hull_ms",
        "halves_ms",
        "prep_ms",
        "recul_ms",
        "active_%",
        "MB",
        "faces",
        "halves"
    );
    for volume in &volumes {
        for block in [4, 8, 16] {
            measure(volume, block);
        }
    }
    for volume in &volumes {
        let both = median(|| {
            for block in [4, 8] {
                black_box(preprocess(volume, block));
            }
        });
        println!(
            "{:<24} preprocessing at 4 and at 8: {both:.1} ms",
            volume.name
        );
    }
}

fn measure(volume: &Volume, block: usize) {
    let table = table(volume);
    let mode = Mode::EmissionAbsorption;
    let fresh = || Accelerator::build(volume, block, 1).expect("a valid block");
    let leaves = median(|| {
        black_box(fresh());
    });
    let with_trees = median(|| {
        build_trees(&fresh());
    });
    let accelerator = fresh();
    build_trees(&accelerator);
    let cull = median(|| {
        black_box(accelerator.cull(&table, mode));
    });
    let occupancy = accelerator.cull(&table, mode);
    let axis = 1;
    let hull_of = |region| Hull::build(&occupancy, region);
    let whole = median(|| {
        black_box(hull_of(occupancy.whole()));
    });
    let halves = median(|| {
        for half in 0..2 {
            black_box(hull_of(accelerator.half_region(axis, half)));
        }
    });
    let preprocessing = median(|| {
        black_box(preprocess(volume, block));
    });
    // Whole and halves each in trees of their own, as a caller that draws both would.
    let reculling = median(|| {
        black_box(recull(&accelerator, &table));
    });
    println!(
        "{:<24} {block:>5} {leaves:>9.2} {:>9.2} {cull:>9.2} {whole:>9.2} {halves:>9.2} {preprocessing:>8.2} {reculling:>8.2} {:>8.1} {:>8.2} {:>7} {:>7}",
        volume.name,
        with_trees - leaves,
        100.0 * occupancy.count() as f64 / occupancy.dims.iter().product::<usize>() as f64,
        accelerator.structure_bytes() as f64 / 1e6,
        hull_of(occupancy.whole()).faces.len(),
        (0..2)
            .map(|half| hull_of(accelerator.half_region(axis, half)).faces.len())
            .sum::<usize>(),
    );
}

fn build_trees(accelerator: &Accelerator) {
    accelerator.whole();
    for axis in 0..3 {
        accelerator.halves(axis);
    }
}

/// Leaves, all trees, and one table culled with its hulls.
fn preprocess(volume: &Volume, block: usize) -> [Hull; 3] {
    let accelerator = Accelerator::build(volume, block, 1).expect("a valid block");
    build_trees(&accelerator);
    recull(&accelerator, &table(volume))
}

/// The hulls of the whole and of the halves of one axis.
fn recull(accelerator: &Accelerator, table: &Table) -> [Hull; 3] {
    let axis = 1;
    let whole = accelerator.cull(table, Mode::EmissionAbsorption);
    let halves = accelerator.cull_halves(axis, table, Mode::EmissionAbsorption);
    let half = |i| Hull::build(&halves, accelerator.half_region(axis, i));
    [Hull::build(&whole, whole.whole()), half(0), half(1)]
}

/// Median milliseconds.
fn median(mut work: impl FnMut()) -> f64 {
    let mut times: Vec<f64> = (0..RUNS)
        .map(|_| {
            let start = Instant::now();
            work();
            start.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[RUNS / 2]
}

/// Transparent up to 40, rising to 0.3 at 255.
fn table(volume: &Volume) -> Table {
    let point = |value, opacity| ControlPoint {
        value,
        opacity,
        color: [0.9, 0.6, 0.4],
    };
    TransferFunction::new(vec![point(40.0, 0.0), point(255.0, 0.3)], 1.0)
        .expect("points ascend")
        .bake(
            &Domain::new(volume, [0.0, 255.0], 256).expect("256 is a table size"),
            1.0,
        )
}

fn volume(name: &str, voxels: Vec<u8>) -> Volume {
    Volume {
        name: name.rsplit('/').next().unwrap_or(name).to_owned(),
        dims: [EDGE; 3],
        spacing: DVec3::ONE,
        origin: DVec3::ZERO,
        direction: DMat3::IDENTITY,
        rescale: Rescale::IDENTITY,
        voxels: Voxels::U8(voxels.into()),
        warnings: Vec::new(),
    }
}

/// A hollow sphere: radius 100 voxels, wall 6, falling off over one voxel.
fn shell() -> Vec<u8> {
    (0..EDGE.pow(3))
        .map(|i| {
            let at = [i % EDGE, i / EDGE % EDGE, i / EDGE / EDGE].map(|c| c as f64 + 0.5 - 128.0);
            let r = at.iter().map(|c| c * c).sum::<f64>().sqrt();
            ((3.5 - (r - 97.0).abs()).clamp(0.0, 1.0) * 200.0) as u8
        })
        .collect()
}

/// Independent voxels, each 0 to 44: about a tenth of them are visible.
fn noise() -> Vec<u8> {
    let mut state = 1u64;
    (0..EDGE.pow(3))
        .map(|_| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            ((state >> 33) % 45) as u8
        })
        .collect()
}
