//! The B-spline sampler: bounded by its 64 voxels, so that skipping with two voxels of apron changes no bit; near the f64
//! reference. These tests fail, not skip, where there is no adapter.

use std::sync::Arc;

use hollowcast::lattice::Clipping;
use hollowcast::measure::metrics::metrics;
use hollowcast::measure::verify::{Case, Verifier, View};
use hollowcast::mode::{MODES, Mode};
use hollowcast::octree::LeafGrid;
use hollowcast::render::{BackendChoice, Renderer, Settings};
use hollowcast::sample::{Sampler, bspline, cell};
use hollowcast::skip::{Cuts, Skip};
use hollowcast::transfer::TransferFunction;
use hollowcast::volume::{Statistics, Volume, Voxels, phantom};
use support::{check_bits, renderer, shipped, show};

mod support;

/// Methods that share one compiled marcher with box: compiling 64 loads for each mode is dear.
const METHODS: [Skip; 4] = [Skip::Hull, Skip::HalfSplit, Skip::KCuts, Skip::BeamMasks];

fn made(name: &str, dims: [usize; 3]) -> Arc<Volume> {
    Arc::new(phantom::make(name, dims).unwrap())
}

fn modes(volume: &Volume) -> Vec<Mode> {
    let statistics = Statistics::of(volume);
    MODES
        .iter()
        .map(|row| (row.suited_to)(&statistics))
        .collect()
}

fn check(renderer: &mut Renderer, volume: &Arc<Volume>, sampler: Sampler, modes: &[Mode]) {
    let transfer = show([&mut *renderer], volume);
    for mode in modes {
        for view in View::ALL {
            let verifier = Verifier::new(renderer, volume, &transfer, Cuts::default(), [28, 24])
                .with_mode(*mode)
                .with_methods(METHODS.to_vec());
            check_bits(
                verifier,
                view,
                sampler,
                &format!("{} {mode:?}", volume.name),
            );
        }
    }
}

#[test]
fn skipping_changes_no_bit_in_any_mode() {
    let mut renderer = renderer();
    for volume in [
        made("pot", [26, 24, 28]),
        made("noise", [24; 3]),
        shipped("qim3d_shell.nrrd"),
        shipped("stent.nrrd"),
    ] {
        let modes = modes(&volume);
        check(&mut renderer, &volume, Sampler::Tricubic, &modes);
        // Compiled with 64 loads for every sample, each mode is dear: emission-absorption, mip and phong.
        let few = [modes[0], modes[3], modes[7]];
        check(&mut renderer, &volume, Sampler::TricubicExact, &few);
        println!("{}: no bit", volume.name);
    }
}

#[test]
fn skipping_changes_no_bit_by_the_reference() {
    let mut reference = Renderer::new(BackendChoice::Reference).unwrap();
    let volume = made("pot", [26, 24, 28]);
    check(&mut reference, &volume, Sampler::Tricubic, &modes(&volume));
}

/// Sparse points, whose support only a second voxel of apron holds.
#[test]
fn points_that_only_the_second_voxel_of_the_apron_knows_are_drawn() {
    let n = 32;
    let voxels: Vec<u8> = (0..n * n * n)
        .map(|i: usize| {
            let at = [i % n, i / n % n, i / n / n];
            // In the second layer of their blocks of four: a trilinear sample of the block before does not reach them.
            let is_point = at.iter().all(|c| c % 8 == 5);
            if is_point { 255 } else { 0 }
        })
        .collect();
    let volume = Arc::new(Volume {
        voxels: Voxels::U8(voxels.into()),
        ..phantom::make("empty", [n; 3]).unwrap()
    });
    let mut renderer = renderer();
    renderer.set_volume(Arc::clone(&volume)).unwrap();
    let transfer = TransferFunction::from_spec("ramp:0:60:0.3", &Statistics::of(&volume)).unwrap();
    renderer.set_transfer(transfer.clone());
    let case = Case {
        view: View::Outside,
        is_parallel: true,
        block: 4,
        step_edges: 0.01,
        ert: 1.0,
        sampler: Sampler::TricubicExact,
    };
    // Structures of the other apron are there already, and must not be taken.
    for sampler in [Sampler::Exact, Sampler::TricubicExact] {
        let outcomes = Verifier::new(&mut renderer, &volume, &transfer, Cuts::default(), [64, 64])
            .run(&Case { sampler, ..case })
            .unwrap();
        for outcome in outcomes {
            assert_eq!(outcome.differing_pixels, 0, "{sampler:?} {outcome:?}");
        }
    }
}

#[test]
fn pictures_are_within_60_db_of_the_reference() {
    let mut renderer = renderer();
    let mut reference = Renderer::new(BackendChoice::Reference).unwrap();
    for volume in [made("pot", [36, 32, 40]), shipped("qim3d_shell.nrrd")] {
        let transfer = show([&mut *renderer, &mut reference], &volume);
        for mode in modes(&volume) {
            let settings = Settings {
                skip: Skip::BeamMasks,
                sampler: Some(Sampler::TricubicExact),
                mode,
                block: 4,
                step_voxels: 0.9,
                ert: 1.0,
                size: [40, 36],
                clipping: Clipping::NONE,
                ..Settings::new(View::Outside.camera(&volume, &transfer, false))
            };
            let ours = renderer.render(&settings).unwrap().picture;
            let truth = reference.render(&settings).unwrap().picture;
            let error = metrics([(&ours, &truth)]);
            let told = format!("{} {}: {:.1} dB", volume.name, mode.name(), error.psnr_db());
            println!("{told}");
            assert!(error.psnr_db() >= 60.0, "{told}");
        }
    }
}

#[test]
fn every_sample_of_a_block_and_half_a_voxel_around_lies_in_its_range() {
    let volume = made("noise", [13, 12, 11]);
    let Voxels::U8(voxels) = &volume.voxels else {
        panic!("phantoms are bytes")
    };
    let sample = |at: [f64; 3]| {
        let cells = at.map(cell);
        let mut sum = 0.0;
        for i in 0..64_usize {
            let taps = [i % 4, i / 4 % 4, i / 16];
            let (mut weight, mut index) = (1.0, 0);
            for a in (0..3).rev() {
                let last = (volume.dims[a] - 1) as f64;
                let voxel = (cells[a].0 - 1.0 + taps[a] as f64).clamp(0.0, last);
                weight *= bspline(cells[a].1)[taps[a]];
                index = index * volume.dims[a] + voxel as usize;
            }
            sum += weight * f64::from(voxels[index]);
        }
        sum
    };
    let grid = LeafGrid::build(&volume, 4, Sampler::Tricubic.apron());
    for i in 0..20_000_usize {
        // Some low-discrepancy points (Roberts 2018).
        let at: [f64; 3] = [0.819_172_5, 0.671_043_6, 0.549_700_5].map(|g| (i as f64 * g).fract());
        let place: [f64; 3] = std::array::from_fn(|a| at[a] * volume.dims[a] as f64);
        let value = sample(place);
        for off in [-0.4375, 0.0, 0.4375] {
            let leaf = place.map(|c| ((c + off).max(0.0) / 4.0) as usize);
            let leaf = std::array::from_fn(|a| leaf[a].min(grid.dims[a] - 1));
            let [low, high] = grid.range(leaf).map(f64::from);
            assert!(low - 1e-9 <= value && value <= high + 1e-9, "{place:?}");
        }
    }
}

#[test]
fn weights_are_those_of_the_cubic_b_spline() {
    assert_eq!(bspline(0.0), [1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0, 0.0]);
    for i in 0..=100 {
        let f = f64::from(i) / 100.0;
        let w = bspline(f);
        assert!(w.iter().all(|&w| w >= 0.0));
        assert!((w.iter().sum::<f64>() - 1.0).abs() < 1e-15);
        // Linear data stay as they are: the mean of the voxels' places is the sample's.
        let mean: f64 = (-1..=2).zip(w).map(|(i, w)| f64::from(i) * w).sum();
        assert!((mean - f).abs() < 1e-15);
    }
}

#[test]
fn the_cpu_backend_refuses_it_in_one_line() {
    let mut cpu = Renderer::new(BackendChoice::Cpu).unwrap();
    let volume = made("pot", [16; 3]);
    let transfer = show([&mut cpu], &volume);
    let error = cpu
        .render(&Settings {
            sampler: Some(Sampler::Tricubic),
            ..Settings::new(View::Outside.camera(&volume, &transfer, false))
        })
        .unwrap_err();
    assert!(error.is_bad_input() && error.to_string().lines().count() == 1);
}
