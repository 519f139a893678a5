//! What the accelerator costs: preprocessing, re-culling after an edit of the table, bytes and faces. And what pre-integrating
//! a table costs, which every edit of one does again.
//!
//! `cargo bench --bench octree` measures closed-form volumes; raw u8 volumes are added after `--`
//! as `PATH:256x256x178`. Prints medians of 15 runs. `-- pairs` measures the tables of pairs alone.

use std::fs;
use std::hint::black_box;
use std::time::Instant;

use glam::{DMat3, DVec3};
use hollowcast::mode::Mode;
use hollowcast::octree::{Accelerator, Hull};
use hollowcast::sample::PreIntegrated;
use hollowcast::transfer::{ControlPoint, Domain, Table, TransferFunction};
use hollowcast::volume::{Rescale, Volume, Voxels};

const EDGE: usize = 256;
const RUNS: usize = 15;

fn main() {
    // Cargo adds flags of its own for the standard harness.
    let paths = std::env::args().skip(1).filter(|a| !a.starts_with('-'));
    measure_pairs();
    if std::env::args().any(|a| a == "pairs") {
        return;
    }
    let mut volumes = vec![
        volume("shell", [EDGE; 3], shell()),
        volume("noise", [EDGE; 3], noise(1)),
        volume("specks", [EDGE; 3], noise(512)),
        volume("full", [EDGE; 3], vec![255; EDGE.pow(3)]),
    ];
    for argument in paths {
        let (path, dims) = argument.split_once(':').expect("PATH:XxYxZ");
        let dims: Vec<usize> = dims
            .split('x')
            .map(|n| n.parse().expect("a number of voxels"))
            .collect();
        let dims = dims.try_into().expect("three axes");
        volumes.push(volume(path, dims, fs::read(path).expect("readable")));
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

/// Pre-integration of small and large tables, over data that use all of them.
fn measure_pairs() {
    let bytes = volume("bytes", [2, 1, 1], vec![0, 255]);
    let words = Volume {
        voxels: Voxels::U16(vec![0, 65_535].into()),
        ..volume("words", [2, 1, 1], vec![0, 255])
    };
    for (volume, range, entries) in [
        (&bytes, [0.0, 255.0], 256),
        (&words, [0.0, 65_535.0], 4096),
        (&words, [0.0, 65_535.0], 65_536),
    ] {
        let point = |share: f64, opacity, color| ControlPoint {
            value: share * range[1],
            opacity,
            color,
        };
        let points = vec![
            point(0.1, 0.0, [0.9, 0.6, 0.4]),
            point(0.6, 0.3, [0.4, 0.6, 0.9]),
            point(1.0, 0.9, [1.0, 0.9, 0.8]),
        ];
        let function = TransferFunction::new(points, 1.0).expect("points ascend");
        let domain = Domain::new(volume, range, entries).expect("a table size");
        let table = function.bake(&domain, 0.5);
        let made = PreIntegrated::new(&table, range);
        let ms = median(|| {
            black_box(PreIntegrated::new(&table, range));
        });
        println!(
            "pre-integrating {entries:>5} entries: {:>3} squared pairs, {ms:.1} ms",
            made.nodes().rgba().len()
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
    let trees = median_of(|| {
        let accelerator = fresh();
        milliseconds(|| build_trees(&accelerator))
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
    let reculling = median(|| {
        black_box(recull(&accelerator, &table));
    });
    println!(
        "{:<24} {block:>5} {leaves:>9.2} {trees:>9.2} {cull:>9.2} {whole:>9.2} {halves:>9.2} {preprocessing:>8.2} {reculling:>8.2} {:>8.1} {:>8.2} {:>7} {:>7}",
        volume.name,
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

/// The hulls of the whole and of the halves of one axis, from one pass over the leaves.
fn recull(accelerator: &Accelerator, table: &Table) -> [Hull; 3] {
    let active = accelerator.cull(table, Mode::EmissionAbsorption);
    let half = |i| Hull::build(&active, accelerator.half_region(1, i));
    [Hull::build(&active, active.whole()), half(0), half(1)]
}

/// Median milliseconds that `work` takes.
fn median(mut work: impl FnMut()) -> f64 {
    median_of(|| milliseconds(&mut work))
}

fn median_of(mut run: impl FnMut() -> f64) -> f64 {
    let mut times: Vec<f64> = (0..RUNS).map(|_| run()).collect();
    times.sort_by(f64::total_cmp);
    times[RUNS / 2]
}

fn milliseconds(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64() * 1e3
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

fn volume(name: &str, dims: [usize; 3], voxels: Vec<u8>) -> Volume {
    assert_eq!(
        voxels.len(),
        dims.iter().product::<usize>(),
        "{name}: bytes and voxels"
    );
    Volume {
        name: name.rsplit('/').next().unwrap_or(name).to_owned(),
        dims,
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

/// Independent voxels of 0 to 255, one in `one_in` as they are and the others within 0 to 40, where the table is empty:
/// few enough visible ones (512) leave blocks active at random, the worst that merging can meet.
fn noise(one_in: u64) -> Vec<u8> {
    let mut state = 1u64;
    (0..EDGE.pow(3))
        .map(|_| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let random = state >> 33;
            let value = random as u8;
            if (random >> 8).is_multiple_of(one_in) {
                value
            } else {
                value % 41
            }
        })
        .collect()
}
