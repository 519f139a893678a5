//! Real scans: skipping changes no bit on any backend, and both fast backends are near the f64 reference.
//!
//! The large scans that ship with the project are always tried. Those of the folder in `HOLLOWCAST_DATA` are in tests that
//! are ignored unless asked for; `scripts/test.sh` asks for them where the folder is named.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use hollowcast::measure::metrics::metrics;
use hollowcast::measure::verify::{self, Verifier, View};
use hollowcast::render::{BackendChoice, Renderer, Settings};
use hollowcast::sample::Sampler;
use hollowcast::skip::{Cuts, Skip};
use hollowcast::transfer::TransferFunction;
use hollowcast::volume::{self, Statistics};

fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("data")
        .join(name)
}

fn from_data_folder(name: &str) -> PathBuf {
    let folder =
        std::env::var_os("HOLLOWCAST_DATA").expect("HOLLOWCAST_DATA names the folder of scans");
    Path::new(&folder).join(name)
}

/// Every pair of settings on a backend, and its nearness to the reference from every kind of view.
fn check(path: &Path, backend: BackendChoice) {
    let volume = Arc::new(volume::open(path, None).unwrap());
    let transfer = TransferFunction::from_spec("translucent", &Statistics::of(&volume)).unwrap();
    let ready = |backend| {
        let mut renderer =
            Renderer::new(backend).expect("these tests need an adapter: mesa-vulkan-drivers");
        renderer.set_volume(Arc::clone(&volume)).unwrap();
        renderer.set_transfer(transfer.clone());
        renderer
    };
    let mut renderer = ready(backend);
    let mut verifier = Verifier::new(&mut renderer, &volume, &transfer, Cuts::default(), [96, 96]);
    for case in verify::pairwise() {
        if case.sampler != Sampler::Exact && backend != BackendChoice::Gpu {
            continue;
        }
        for outcome in verifier.run(&case).unwrap() {
            assert_eq!(
                outcome.differing_pixels,
                0,
                "{}: {case:?}: {outcome:?}",
                path.display()
            );
        }
    }
    let mut reference = ready(BackendChoice::Reference);
    for view in View::ALL {
        for is_parallel in [false, true] {
            let mut settings = Settings {
                skip: Skip::BeamMasks,
                sampler: Some(Sampler::Exact),
                block: 4,
                step_voxels: 0.7,
                ert: 1.0,
                size: [96, 96],
                ..Settings::new(view.camera(&volume, &transfer, is_parallel))
            };
            let ours = renderer.render(&settings).unwrap().picture;
            settings.skip = Skip::HalfSplit;
            let truth = reference.render(&settings).unwrap().picture;
            let error = metrics([(&ours, &truth)]);
            assert!(
                error.psnr_db() >= 60.0 && error.max_abs <= 2.0 / 255.0,
                "{} {view:?}: {} dB, {}",
                path.display(),
                error.psnr_db(),
                error.max_abs
            );
        }
    }
}

#[test]
fn the_shell_on_the_gpu() {
    check(&shipped("qim3d_shell.nrrd"), BackendChoice::Gpu);
}

#[test]
fn the_shell_on_the_cpu() {
    check(&shipped("qim3d_shell.nrrd"), BackendChoice::Cpu);
}

#[test]
fn the_stent_on_the_gpu() {
    check(&shipped("stent.nrrd"), BackendChoice::Gpu);
}

#[test]
fn the_stent_on_the_cpu() {
    check(&shipped("stent.nrrd"), BackendChoice::Cpu);
}

#[test]
#[ignore = "reads HOLLOWCAST_DATA"]
fn the_paper_s_teapot_the_engine_and_the_aneurism_on_the_gpu() {
    for name in ["boston_teapot.nrrd", "engine.nrrd", "aneurism.nrrd"] {
        check(&from_data_folder(name), BackendChoice::Gpu);
    }
}

#[test]
#[ignore = "reads HOLLOWCAST_DATA"]
fn every_scan_on_the_cpu() {
    let names = [
        "boston_teapot",
        "engine",
        "aneurism",
        "bonsai",
        "lhdl_trabecular",
        "lidc2_thorax",
        "tooth",
    ];
    for name in names {
        check(
            &from_data_folder(&format!("{name}.nrrd")),
            BackendChoice::Cpu,
        );
    }
}
