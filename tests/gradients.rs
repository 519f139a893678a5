//! Volumes of gradients and depth cues: right by a closed form, near the f64 reference, and not changed in any bit by
//! skipping. These tests fail, not skip, where there is no adapter.

use std::sync::{Arc, LazyLock, Mutex, MutexGuard, PoisonError};

use glam::DVec3;
use hollowcast::camera::{Camera, Projection};
use hollowcast::measure::metrics::metrics;
use hollowcast::measure::verify::{Case, Verifier, View};
use hollowcast::mode::{MODES, Mode};
use hollowcast::render::{BackendChoice, Renderer, Settings};
use hollowcast::sample::{Gradients, Sampler};
use hollowcast::scene::Picture;
use hollowcast::skip::{Cuts, Skip};
use hollowcast::transfer::TransferFunction;
use hollowcast::volume::{Statistics, Volume, Voxels, phantom};

fn made(name: &str) -> Arc<Volume> {
    Arc::new(phantom::make(name, [38, 34, 42]).unwrap())
}

/// One renderer for all tests: devices are dear on a software driver.
fn gpu() -> MutexGuard<'static, Renderer> {
    static RENDERER: LazyLock<Mutex<Renderer>> = LazyLock::new(|| {
        let renderer = Renderer::new(BackendChoice::Gpu);
        Mutex::new(renderer.expect("these tests need an adapter: mesa-vulkan-drivers"))
    });
    RENDERER.lock().unwrap_or_else(PoisonError::into_inner)
}

fn show(renderer: &mut Renderer, volume: &Arc<Volume>) -> TransferFunction {
    let transfer = TransferFunction::from_spec("translucent", &Statistics::of(volume)).unwrap();
    renderer.set_volume(Arc::clone(volume)).unwrap();
    renderer.set_transfer(transfer.clone());
    transfer
}

/// The mode of this name as it suits a volume.
fn mode(name: &str, volume: &Volume) -> Mode {
    let row = MODES.iter().find(|row| row.name == name).unwrap();
    (row.suited_to)(&Statistics::of(volume))
}

fn settings(mode: Mode, camera: Camera) -> Settings {
    Settings {
        skip: Skip::BeamMasks,
        sampler: Some(Sampler::Exact),
        mode,
        block: 4,
        step_voxels: 0.7,
        ert: 1.0,
        size: [56, 48],
        ..Settings::new(camera)
    }
}

/// Radius of the ball's surface in voxels.
const RADIUS: f64 = 45.0;

/// A ball of 128^3 voxels in 16 bits whose wall goes over some 24 voxels from 60,000 to 0 (half a cosine).
fn ball() -> Arc<Volume> {
    let n = 128;
    let voxels: Vec<u16> = (0..n * n * n)
        .map(|i| {
            let at = [i % n, i / n % n, i / n / n].map(|c| c as f64 + 0.5 - n as f64 * 0.5);
            let off = ((DVec3::from_array(at).length() - RADIUS) / 12.0).clamp(-1.0, 1.0);
            (30_000.0 * (1.0 - (off * std::f64::consts::FRAC_PI_2).sin())).round() as u16
        })
        .collect();
    Arc::new(Volume {
        voxels: Voxels::U16(voxels.into()),
        ..phantom::make("empty", [n; 3]).unwrap()
    })
}

/// Mean and largest angle in degrees between the normals of a picture and the ball's, at rays that cross it.
fn errors(picture: &Picture, camera: &Camera, volume: &Volume) -> [f64; 2] {
    let frame = camera.ray_frame(volume, picture.size, 0.7).unwrap();
    let [width, height] = picture.size.map(|n| n as usize);
    let (mut sum, mut worst, mut hits) = (0.0_f64, 0.0_f64, 0);
    for (i, pixel) in picture.rgba.iter().enumerate() {
        let x = (i % width) as f64 - (width as f64 * 0.5 - 0.5);
        let y = (i / width) as f64 - (height as f64 * 0.5 - 0.5);
        let start = frame.start + x * frame.start_dx + y * frame.start_dy - volume.extent() * 0.5;
        let along = start.dot(frame.dir);
        let square = along * along - start.length_squared() + RADIUS * RADIUS;
        // Rays that touch the ball rather than cross it may miss by rounding.
        if square < 10.0 {
            continue;
        }
        let expected = start + (-along - square.sqrt()) * frame.dir;
        let [x, y, z, _] = pixel.map(|c| f64::from(c) * 2.0 - 1.0);
        let angle = DVec3::new(x, y, z).angle_between(expected).to_degrees();
        sum += angle;
        worst = worst.max(angle);
        hits += 1;
    }
    assert!(hits > 1000, "{hits} hits");
    [sum / f64::from(hits), worst]
}

#[test]
fn normals_of_a_ball_are_those_of_its_closed_form_to_the_volume_s_resolution() {
    let volume = ball();
    let middle = volume.extent() * 0.5;
    let camera = Camera {
        eye: middle - DVec3::new(300.0, 120.0, 80.0),
        target: middle,
        up: DVec3::Z,
        projection: Projection::Orthographic { height: 100.0 },
    };
    let normals = Mode::Normals { iso: 30_000.0 };
    let mut gpu = gpu();
    let mut reference = Renderer::new(BackendChoice::Reference).unwrap();
    let mut before = 0.0;
    // About twice what was measured, in degrees on average.
    for (gradients, bound) in [
        (Gradients::Fly, 0.06),
        (Gradients::Full, 0.06),
        (Gradients::Half, 0.06),
        (Gradients::Quarter, 0.08),
    ] {
        let settings = Settings {
            gradients,
            ..settings(normals, camera)
        };
        let mut pictures = Vec::new();
        for renderer in [&mut *gpu, &mut reference] {
            if before == 0.0 {
                show(renderer, &volume);
            }
            let picture = renderer.render(&settings).unwrap().picture;
            let [mean, worst] = errors(&picture, &camera, &volume);
            let told = format!(
                "{} {}: mean {mean:.4} degrees, at most {worst:.4}",
                renderer.info().backend,
                gradients.name()
            );
            println!("{told}");
            assert!(mean < bound, "{told}");
            pictures.push((picture, mean));
        }
        let [(ours, _), (truth, mean)] = &pictures[..] else {
            unreachable!("two renderers")
        };
        assert!(metrics([(ours, truth)]).psnr_db() >= 60.0);
        if matches!(gradients, Gradients::Half | Gradients::Quarter) {
            assert!(
                *mean > before,
                "{}: fewer gradients are worse",
                gradients.name()
            );
        }
        before = *mean;
    }
}

#[test]
fn lit_modes_with_a_volume_of_gradients_are_near_the_reference_and_counted() {
    let volume = made("pot");
    let mut gpu = gpu();
    let mut reference = Renderer::new(BackendChoice::Reference).unwrap();
    let transfer = show(&mut gpu, &volume);
    show(&mut reference, &volume);
    let camera = View::Outside.camera(&volume, &transfer, false);
    for name in ["shaded", "normals", "phong", "two-surfaces"] {
        let fly = settings(mode(name, &volume), camera);
        let on_the_fly = gpu.render(&fly).unwrap().picture;
        for (gradients, cells) in [
            (Gradients::Full, 38 * 34 * 42),
            (Gradients::Half, 19 * 17 * 21),
            (Gradients::Quarter, 10 * 9 * 11),
        ] {
            let settings = Settings { gradients, ..fly };
            // Box needs nothing else.
            let by_box = Settings {
                skip: Skip::Box,
                ..settings
            };
            assert_eq!(gpu.prepare(&by_box).unwrap().structure_bytes, 8 * cells);
            let ours = gpu.render(&settings).unwrap().picture;
            let truth = reference.render(&settings).unwrap().picture;
            let [db, off] = [&truth, &on_the_fly].map(|p| metrics([(&ours, p)]).psnr_db());
            let told = format!(
                "{name} {}: {db:.1} dB to the reference, {off:.1} to central differences",
                gradients.name()
            );
            println!("{told}");
            assert!(db >= 60.0, "{told}");
            // Of a trilinear field both are the same, but for half floats.
            assert!(gradients != Gradients::Full || off >= 80.0, "{told}");
        }
    }
}

#[test]
fn skipping_changes_no_bit_of_volumes_of_gradients_and_cues() {
    let mut gpu = gpu();
    for (name, sampler) in [("pot", Sampler::Exact), ("noise", Sampler::Hardware)] {
        let volume = made(name);
        let transfer = show(&mut gpu, &volume);
        for (name, gradients, depth_cue) in [
            ("emission-absorption", Gradients::Fly, 0.7),
            ("grey", Gradients::Fly, 0.7),
            ("shaded", Gradients::Half, 0.7),
            ("phong", Gradients::Quarter, 1.0),
            ("two-surfaces", Gradients::Full, 0.5),
        ] {
            for view in [View::Outside, View::Cavity] {
                let case = Case {
                    view,
                    is_parallel: false,
                    block: 4,
                    step_edges: 0.02,
                    ert: 0.98,
                    sampler,
                };
                let methods = [
                    Skip::Hull,
                    Skip::HalfSplit,
                    Skip::KCuts,
                    Skip::BeamMasks,
                    Skip::GridDda,
                ];
                let outcomes =
                    Verifier::new(&mut gpu, &volume, &transfer, Cuts::default(), [40, 36])
                        .with_mode(mode(name, &volume))
                        .with_shading(gradients, depth_cue)
                        .with_methods(methods.to_vec())
                        .run(&case)
                        .unwrap();
                for outcome in outcomes {
                    assert_eq!(outcome.differing_pixels, 0, "{name} {case:?}: {outcome:?}");
                }
            }
        }
    }
}

#[test]
fn a_depth_cue_darkens_what_is_far_and_no_opacity() {
    let volume = made("pot");
    let mut gpu = gpu();
    let mut reference = Renderer::new(BackendChoice::Reference).unwrap();
    let transfer = show(&mut gpu, &volume);
    show(&mut reference, &volume);
    for (view, is_parallel) in [
        (View::Outside, true),
        (View::Outside, false),
        (View::Cavity, false),
    ] {
        let camera = view.camera(&volume, &transfer, is_parallel);
        for name in [
            "emission-absorption",
            "shaded",
            "grey",
            "phong",
            "two-surfaces",
        ] {
            let plain = settings(mode(name, &volume), camera);
            let cued = Settings {
                depth_cue: 0.8,
                ..plain
            };
            let without = gpu.render(&plain).unwrap().picture;
            let ours = gpu.render(&cued).unwrap().picture;
            let truth = reference.render(&cued).unwrap().picture;
            let db = metrics([(&ours, &truth)]).psnr_db();
            println!("{name} {view:?}: {db:.1} dB");
            assert!(db >= 60.0, "{name} {view:?}: {db} dB");
            let mut darker = 0;
            for (a, b) in without.rgba.iter().zip(&ours.rgba) {
                assert_eq!(a[3], b[3], "{name}");
                assert!(
                    (0..3).all(|c| b[c] <= a[c] && b[c] >= 0.19 * a[c]),
                    "{a:?} {b:?}"
                );
                darker += usize::from(b[0] < 0.95 * a[0]);
            }
            assert!(darker > 100, "{name}: {darker}");
        }
    }
}

#[test]
fn depth_cues_of_no_sense_are_refused_in_one_line() {
    let volume = made("pot");
    let mut reference = Renderer::new(BackendChoice::Reference).unwrap();
    let mut cpu = Renderer::new(BackendChoice::Cpu).unwrap();
    let transfer = show(&mut reference, &volume);
    show(&mut cpu, &volume);
    let camera = View::Outside.camera(&volume, &transfer, false);
    let refused = |renderer: &mut Renderer, name: &str, depth_cue: f64| {
        let settings = Settings {
            depth_cue,
            ..settings(mode(name, &volume), camera)
        };
        let error = renderer.render(&settings).unwrap_err();
        let text = error.to_string();
        assert!(error.is_bad_input() && text.lines().count() == 1, "{text}");
        assert!(text.contains("depth cue"), "{text}");
    };
    for name in ["mip", "minip", "mean", "normals"] {
        refused(&mut reference, name, 0.5);
    }
    for strength in [-0.1, 1.1, f64::NAN] {
        refused(&mut reference, "phong", strength);
    }
    refused(&mut cpu, "emission-absorption", 0.5);
}
