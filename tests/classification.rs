//! When samples get their colour: after voxels are interpolated, before, or for whole intervals. What each loses, that
//! skipping changes no bit of any, and how near the GPU is to the f64 reference. These tests fail, not skip, where there is
//! no adapter.

use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use glam::DVec3;
use hollowcast::camera::Orbit;
use hollowcast::measure::metrics::metrics;
use hollowcast::measure::verify::{Case, Verifier, View};
use hollowcast::mode::{Lighting, Mode};
use hollowcast::render::{BackendChoice, Renderer, Settings};
use hollowcast::sample::{Classification, Sampler};
use hollowcast::scene::Picture;
use hollowcast::skip::{Cuts, Skip};
use hollowcast::transfer::{ControlPoint, TransferFunction};
use hollowcast::volume::{self, Statistics, Volume, Voxels, phantom};

/// One renderer for all tests: devices are dear on a software driver.
fn renderer() -> MutexGuard<'static, Renderer> {
    static RENDERER: Mutex<Option<&'static Mutex<Renderer>>> = Mutex::new(None);
    let mut slot = RENDERER.lock().unwrap_or_else(PoisonError::into_inner);
    let renderer = slot.get_or_insert_with(|| {
        let renderer = Renderer::new(BackendChoice::Gpu)
            .expect("these tests need an adapter: mesa-vulkan-drivers");
        Box::leak(Box::new(Mutex::new(renderer)))
    });
    renderer.lock().unwrap_or_else(PoisonError::into_inner)
}

fn shipped(name: &str) -> Arc<Volume> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("data")
        .join(name);
    Arc::new(volume::open(&path, None).unwrap())
}

fn made(name: &str) -> Arc<Volume> {
    Arc::new(phantom::make(name, [44, 48, 40]).unwrap())
}

/// A volume of these voxels.
fn volume_of(dims: [usize; 3], voxels: Voxels) -> Arc<Volume> {
    Arc::new(Volume {
        voxels,
        ..phantom::make("empty", dims).unwrap()
    })
}

fn point(value: f64, opacity: f64, color: [f64; 3]) -> ControlPoint {
    ControlPoint {
        value,
        opacity,
        color,
    }
}

/// Visible around one value alone.
fn peak(value: f64, half_width: f64, opacity: f64) -> TransferFunction {
    let color = [0.9, 0.5, 0.2];
    let points = vec![
        point(value - half_width, 0.0, color),
        point(value, opacity, color),
        point(value + half_width, 0.0, color),
    ];
    TransferFunction::new(points, 1.0).unwrap()
}

fn translucent(volume: &Volume) -> TransferFunction {
    TransferFunction::from_spec("translucent", &Statistics::of(volume)).unwrap()
}

fn show(renderer: &mut Renderer, volume: &Arc<Volume>, transfer: &TransferFunction) {
    renderer.set_volume(Arc::clone(volume)).unwrap();
    renderer.set_transfer(transfer.clone());
}

const OTHERS: [Classification; 2] = [Classification::Pre, Classification::PreIntegrated];

#[test]
fn skipping_changes_no_bit_of_any_classification() {
    let mut renderer = renderer();
    let thin = peak(120.0, 6.0, 0.4);
    for (volume, transfer) in [
        (made("pot"), None),
        (made("shells"), Some(thin.clone())),
        (made("noise"), Some(thin)),
        (shipped("stent.nrrd"), None),
    ] {
        let transfer = transfer.unwrap_or_else(|| translucent(&volume));
        show(&mut renderer, &volume, &transfer);
        for classification in OTHERS {
            // From fine steps to some that span whole blocks.
            for (view, sampler, step_edges, block) in [
                (View::Outside, Sampler::Exact, 0.02, 4),
                (View::Cavity, Sampler::Hardware, 0.01, 8),
                (View::Wall, Sampler::Nearest, 0.03, 2),
                (View::Cavity, Sampler::Exact, 0.15, 4),
                (View::Outside, Sampler::Exact, 0.25, 2),
            ] {
                let case = Case {
                    view,
                    is_parallel: block == 2,
                    block,
                    step_edges,
                    ert: if block == 4 { 0.9 } else { 1.0 },
                    sampler,
                };
                let outcomes =
                    Verifier::new(&mut renderer, &volume, &transfer, Cuts::default(), [40, 32])
                        .with_classification(classification)
                        .run(&case)
                        .unwrap();
                for outcome in outcomes {
                    assert_eq!(
                        outcome.differing_pixels, 0,
                        "{} {classification:?}: {case:?}: {outcome:?}",
                        volume.name
                    );
                }
            }
        }
    }
}

#[test]
fn every_classification_is_within_60_db_of_the_reference() {
    let mut renderer = renderer();
    let mut reference = Renderer::new(BackendChoice::Reference).unwrap();
    let thin = peak(120.0, 6.0, 0.4);
    for (volume, transfer) in [
        (made("pot"), None),
        (made("shells"), Some(thin)),
        (shipped("qim3d_shell.nrrd"), None),
        (shipped("stent.nrrd"), None),
    ] {
        let transfer = transfer.unwrap_or_else(|| translucent(&volume));
        show(&mut renderer, &volume, &transfer);
        show(&mut reference, &volume, &transfer);
        for classification in OTHERS {
            for mode in [Mode::EmissionAbsorption, Mode::Shaded(Lighting::default())] {
                for view in [View::Outside, View::Cavity] {
                    let settings = Settings {
                        skip: Skip::HalfSplit,
                        sampler: Some(Sampler::Exact),
                        classification,
                        mode,
                        block: 4,
                        step_voxels: 0.8,
                        ert: 1.0,
                        size: [48, 40],
                        ..Settings::new(view.camera(&volume, &transfer, false))
                    };
                    let [ours, truth] = [&mut *renderer, &mut reference]
                        .map(|r| r.render(&settings).unwrap().picture);
                    let error = metrics([(&ours, &truth)]);
                    let told = format!(
                        "{} {} {} {view:?}: {:.1} dB, at most {:.2e}",
                        volume.name,
                        classification.name(),
                        mode.name(),
                        error.psnr_db(),
                        error.max_abs
                    );
                    println!("{told}");
                    assert!(truth.rgba.iter().any(|p| p[3] > 0.01), "{told}");
                    assert!(error.psnr_db() >= 60.0, "{told}");
                }
            }
        }
    }
}

/// A ball whose values fall from its centre outwards by 8 a voxel, 64 voxels each way.
fn ball() -> Arc<Volume> {
    let n = 64;
    let voxels: Vec<u8> = (0..n * n * n)
        .map(|i| {
            let at = [i % n, i / n % n, i / n / n].map(|c| c as f64 + 0.5);
            let radius = (DVec3::from_array(at) - n as f64 * 0.5).length();
            (250.0 - 8.0 * radius).clamp(0.0, 255.0).round() as u8
        })
        .collect();
    volume_of([n; 3], Voxels::U8(voxels.into()))
}

fn reference_picture(
    volume: &Arc<Volume>,
    transfer: &TransferFunction,
    step: f64,
    classification: Classification,
) -> Picture {
    let mut reference = Renderer::new(BackendChoice::Reference).unwrap();
    show(&mut reference, volume, transfer);
    let settings = Settings {
        skip: Skip::GridDda,
        classification,
        step_voxels: step,
        ert: 1.0,
        size: [48, 48],
        ..Settings::new(Orbit::default().camera(volume.extent()))
    };
    reference.render(&settings).unwrap().picture
}

/// Figures 1 and 2 of the paper on 3D textures on standard accelerators: a translucent layer thinner than the way from one
/// voxel to the next, of voxels that have their colours and of values that are looked up once they are interpolated.
#[test]
fn colours_of_voxels_lose_a_thin_translucent_layer() {
    let volume = ball();
    let layer = peak(124.0, 3.0, 0.6);
    let truth = reference_picture(&volume, &layer, 0.02, Classification::Post);
    let [post, pre] = [Classification::Post, Classification::Pre].map(|classification| {
        let ours = reference_picture(&volume, &layer, 0.1, classification);
        metrics([(&ours, &truth)])
    });
    println!(
        "post {:.1} dB, at most {:.3}; pre {:.1} dB, at most {:.3}",
        post.psnr_db(),
        post.max_abs,
        pre.psnr_db(),
        pre.max_abs
    );
    assert!(post.psnr_db() > pre.psnr_db() + 15.0);
    assert!(pre.max_abs > 0.1 && post.max_abs < 0.05);
}

#[test]
fn a_thin_peak_is_missed_by_samples_far_apart_and_not_by_intervals() {
    let volume = ball();
    // Three eighths of a voxel thick.
    let layer = peak(124.0, 3.0, 0.6);
    let truth = reference_picture(&volume, &layer, 0.02, Classification::Post);
    let [post, pre_integrated] = [Classification::Post, Classification::PreIntegrated].map(|c| {
        let ours = reference_picture(&volume, &layer, 2.0, c);
        metrics([(&ours, &truth)])
    });
    println!(
        "2 voxels a step: post {:.1} dB, at most {:.3}; pre-integrated {:.1} dB, at most {:.3}",
        post.psnr_db(),
        post.max_abs,
        pre_integrated.psnr_db(),
        pre_integrated.max_abs
    );
    assert!(pre_integrated.psnr_db() > post.psnr_db() + 15.0);
}

#[test]
fn without_interpolation_colours_of_voxels_are_those_of_their_values() {
    let volume = made("pot");
    let mut reference = Renderer::new(BackendChoice::Reference).unwrap();
    show(&mut reference, &volume, &translucent(&volume));
    let [post, pre] = [Classification::Post, Classification::Pre].map(|classification| {
        let settings = Settings {
            sampler: Some(Sampler::Nearest),
            classification,
            size: [32, 32],
            ..Settings::new(Orbit::default().camera(volume.extent()))
        };
        reference.render(&settings).unwrap().picture
    });
    assert_eq!(post, pre);
}

#[test]
fn sixteen_bits_use_all_of_the_large_table() {
    let mut renderer = renderer();
    // Neighbouring values at both ends and in the middle of the range: one shows, the other does not.
    let n = 12;
    for shown in [1u16, 32_768, 65_534] {
        let voxels: Vec<u16> = (0..n * n * n)
            .map(|i| match i % 4 {
                0 => 0,
                1 => 65_535,
                2 => shown,
                _ => shown + 1 - 2 * (shown % 2),
            })
            .collect();
        let volume = volume_of([n; 3], Voxels::U16(voxels.into()));
        let transfer = peak(f64::from(shown), 1.0, 0.5);
        show(&mut renderer, &volume, &transfer);
        // Along x, through the centres of voxels: a quarter of them shows.
        let share = |renderer: &mut Renderer, table_entries| {
            let settings = Settings {
                sampler: Some(Sampler::Nearest),
                step_voxels: 1.0,
                ert: 1.0,
                size: [16, 16],
                table_entries,
                ..Settings::new(Orbit::default().camera(volume.extent()))
            };
            let counters = renderer.count(&settings).unwrap().counters;
            counters.contributing as f64 / counters.samples as f64
        };
        let all = share(&mut renderer, 65_536);
        assert!((all - 0.25).abs() < 0.05, "{shown}: {all} of samples show");
        // One entry in sixteen cannot tell the two apart.
        let some = share(&mut renderer, 4096);
        assert!(
            !(0.05..=0.45).contains(&some),
            "{shown}: {some} of samples show"
        );
    }
}

#[test]
fn what_a_classification_does_not_go_with_is_refused_in_one_line() {
    let volume = made("pot");
    let transfer = translucent(&volume);
    let base = Settings::new(Orbit::default().camera(volume.extent()));
    let refused = |renderer: &mut Renderer, settings: Settings, field: &str| {
        show(renderer, &volume, &transfer);
        let error = renderer.render(&settings).unwrap_err();
        let told = error.to_string();
        assert!(error.is_bad_input() && told.lines().count() == 1, "{told}");
        assert!(told.starts_with(field), "{told}");
    };
    let mut cpu = Renderer::new(BackendChoice::Cpu).unwrap();
    let mut gpu = renderer();
    for classification in OTHERS {
        let settings = Settings {
            classification,
            ..base
        };
        refused(&mut cpu, settings, "classification");
        let skip = Skip::Adaptive;
        refused(&mut gpu, Settings { skip, ..settings }, "method");
        let mode = Mode::Normals { iso: 40.0 };
        refused(&mut gpu, Settings { mode, ..settings }, "classification");
    }
}
