//! Every mode on the GPU: near the f64 reference, not changed in any bit by skipping, and right where a closed form is
//! known. These tests fail, not skip, where there is no adapter.

use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use glam::DVec3;
use hollowcast::camera::{Camera, Orbit, Projection};
use hollowcast::lattice::Clipping;
use hollowcast::measure::metrics::metrics;
use hollowcast::measure::verify::{Case, Verifier, View};
use hollowcast::mode::{Light, Lighting, MODES, Mode, Outer, Window};
use hollowcast::render::{BackendChoice, Renderer, Settings};
use hollowcast::sample::Sampler;
use hollowcast::scene::Picture;
use hollowcast::skip::{Cuts, METHODS, Skip};
use hollowcast::transfer::TransferFunction;
use hollowcast::volume::{self, Rescale, Statistics, Volume, Voxels, phantom};

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

/// Gives renderers a volume, and the transfer function that suits it.
fn show<'a>(
    renderers: impl IntoIterator<Item = &'a mut Renderer>,
    volume: &Arc<Volume>,
) -> TransferFunction {
    let transfer = TransferFunction::from_spec("translucent", &Statistics::of(volume)).unwrap();
    for renderer in renderers {
        renderer.set_volume(Arc::clone(volume)).unwrap();
        renderer.set_transfer(transfer.clone());
    }
    transfer
}

fn settings(mode: Mode, camera: Camera) -> Settings {
    Settings {
        skip: Skip::HalfSplit,
        sampler: Some(Sampler::Exact),
        mode,
        block: 4,
        step_voxels: 0.7,
        ert: 1.0,
        size: [80, 72],
        ..Settings::new(camera)
    }
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

/// Whether a renderer's backend has a mode.
fn has(renderer: &Renderer, mode: &Mode) -> bool {
    mode.check_backend(renderer.info().backend).is_ok()
}

/// The same numbers, of which data values are the negatives.
fn turned_round(volume: &Volume) -> Arc<Volume> {
    let Voxels::U8(voxels) = &volume.voxels else {
        panic!("phantoms are bytes")
    };
    Arc::new(Volume {
        voxels: Voxels::U8(voxels.iter().map(|v| 255 - v).collect::<Vec<_>>().into()),
        rescale: Rescale {
            slope: -1.0,
            intercept: 255.0,
        },
        ..phantom::make("empty", volume.dims).unwrap()
    })
}

/// All modes as they suit a volume, with light that does not come from the eye where one is lit.
fn modes(volume: &Volume) -> Vec<Mode> {
    let statistics = Statistics::of(volume);
    let aside = Light::From([1.0, -2.0, 1.5]);
    let mut modes: Vec<Mode> = MODES
        .iter()
        .map(|row| (row.suited_to)(&statistics))
        .collect();
    for mode in &mut modes {
        if let Mode::Shaded(lighting) | Mode::TwoSurfaces { lighting, .. } = mode {
            lighting.light = aside;
        }
    }
    modes
}

/// The data values of the surfaces that a mode looks for.
fn surfaces(mode: &Mode) -> Vec<f64> {
    match *mode {
        Mode::Normals { iso } | Mode::Phong { iso, .. } => vec![iso],
        Mode::TwoSurfaces { outer, iso, .. } => vec![outer.iso, iso],
        _ => Vec::new(),
    }
}

/// Pixels whose ray has a sample within 1e-4 of the data's range of a surface, up to its hit: where its first hit is
/// another one if the surface lies that much higher or lower.
fn undecided(reference: &mut Renderer, volume: &Volume, settings: &Settings) -> Vec<bool> {
    let [low, high] = Statistics::of(volume).value_range();
    let margin = 1e-4 * (high - low);
    let mut undecided = vec![false; (settings.size[0] * settings.size[1]) as usize];
    for iso in surfaces(&settings.mode) {
        let [below, above] = [iso - margin, iso + margin].map(|iso| {
            let mode = Mode::Normals { iso };
            let counted = reference.count(&Settings { mode, ..*settings });
            counted.unwrap().first_hit
        });
        for (i, undecided) in undecided.iter_mut().enumerate() {
            *undecided |= below[i] != above[i];
        }
    }
    undecided
}

fn without(picture: &Picture, masked: &[bool]) -> Picture {
    let mut picture = picture.clone();
    for (pixel, _) in picture.rgba.iter_mut().zip(masked).filter(|(_, m)| **m) {
        *pixel = [0.0; 4];
    }
    picture
}

fn check_against_reference(volumes: &[Arc<Volume>]) {
    let mut renderer = renderer();
    let mut cpu = Renderer::new(BackendChoice::Cpu).unwrap();
    let mut reference = Renderer::new(BackendChoice::Reference).unwrap();
    let (mut pixels, mut masked_pixels) = (0, 0);
    for volume in volumes {
        let transfer = show([&mut *renderer, &mut cpu, &mut reference], volume);
        for mode in modes(volume) {
            for view in [View::Outside, View::Cavity] {
                let settings = settings(mode, view.camera(volume, &transfer, false));
                let truth = reference.render(&settings).unwrap().picture;
                assert!(
                    matches!(mode, Mode::Minip(_)) || truth.rgba.iter().any(|p| p[3] > 0.01),
                    "{} {mode:?} {view:?} shows nothing",
                    volume.name
                );
                let masked = undecided(&mut reference, volume, &settings);
                if !surfaces(&mode).is_empty() {
                    pixels += masked.len();
                    masked_pixels += masked.iter().filter(|m| **m).count();
                }
                for renderer in [&mut *renderer, &mut cpu] {
                    if !has(renderer, &mode) {
                        continue;
                    }
                    let ours = renderer.render(&settings).unwrap().picture;
                    let [ours, truth] = [&ours, &truth].map(|p| without(p, &masked));
                    let error = metrics([(&ours, &truth)]);
                    let told = format!(
                        "{} {} {} {view:?}: {:.1} dB, at most {:.2e}",
                        renderer.info().backend,
                        volume.name,
                        mode.name(),
                        error.psnr_db(),
                        error.max_abs
                    );
                    println!("{told}");
                    assert!(error.psnr_db() >= 60.0, "{told}");
                }
            }
        }
    }
    println!("{masked_pixels} of {pixels} pixels masked");
    assert!(
        masked_pixels * 1000 <= pixels,
        "{masked_pixels} of {pixels}"
    );
}

#[test]
fn every_mode_of_phantoms_is_within_60_db_of_the_reference() {
    let turned = turned_round(&made("pot"));
    check_against_reference(&[made("pot"), made("capsules"), made("gyroid"), turned]);
}

#[test]
fn every_mode_of_the_shell_is_within_60_db_of_the_reference() {
    check_against_reference(&[shipped("qim3d_shell.nrrd")]);
}

#[test]
fn every_mode_of_the_stent_is_within_60_db_of_the_reference() {
    check_against_reference(&[shipped("stent.nrrd")]);
}

#[test]
fn skipping_changes_no_bit_in_any_mode() {
    let mut renderer = renderer();
    let mut cpu = Renderer::new(BackendChoice::Cpu).unwrap();
    let mut reference = Renderer::new(BackendChoice::Reference).unwrap();
    let volumes = [
        made("pot"),
        made("noise"),
        turned_round(&made("shells")),
        shipped("qim3d_shell.nrrd"),
        shipped("stent.nrrd"),
    ];
    for volume in &volumes {
        let transfer = show([&mut *renderer, &mut cpu, &mut reference], volume);
        for mode in modes(volume) {
            for (view, sampler) in [
                (View::Outside, Sampler::Exact),
                (View::Cavity, Sampler::Hardware),
                (View::Wall, Sampler::Nearest),
            ] {
                let case = Case {
                    view,
                    is_parallel: view == View::Outside,
                    block: 4,
                    step_edges: 0.02,
                    ert: 0.98,
                    sampler,
                };
                for (renderer, sampler) in [
                    (&mut *renderer, sampler),
                    (&mut cpu, Sampler::Exact),
                    (&mut reference, Sampler::Exact),
                ] {
                    if !has(renderer, &mode) {
                        continue;
                    }
                    let outcomes =
                        Verifier::new(renderer, volume, &transfer, Cuts::default(), [48, 40])
                            .with_mode(mode)
                            .run(&Case { sampler, ..case })
                            .unwrap();
                    for outcome in outcomes {
                        assert_eq!(
                            outcome.differing_pixels, 0,
                            "{} {mode:?}: {case:?}: {outcome:?}",
                            volume.name
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn clipping_is_the_same_for_every_method_and_backend() {
    let mut renderer = renderer();
    let mut cpu = Renderer::new(BackendChoice::Cpu).unwrap();
    let mut reference = Renderer::new(BackendChoice::Reference).unwrap();
    let volume = made("pot");
    let transfer = show([&mut *renderer, &mut cpu, &mut reference], &volume);
    let middle = volume.extent() * 0.5;
    let mut clipping = Clipping::NONE;
    for (normal, at) in [
        (DVec3::new(-1.0, 0.3, 0.2), middle),
        (DVec3::Z, middle * 0.5),
        (-DVec3::Z, middle * 1.6),
    ] {
        clipping.keep(normal, normal.dot(at)).unwrap();
    }
    let statistics = Statistics::of(&volume);
    let mean = Mode::Mean(Window::above_background(&statistics));
    for mode in [Mode::EmissionAbsorption, mean] {
        for view in View::ALL {
            let settings = Settings {
                clipping,
                ..settings(mode, view.camera(&volume, &transfer, false))
            };
            let truth = reference.render(&settings).unwrap().picture;
            for renderer in [&mut *renderer, &mut cpu, &mut reference] {
                let by_box = renderer.render(&Settings {
                    skip: Skip::Box,
                    ..settings
                });
                let by_box = by_box.unwrap().picture;
                let error = metrics([(&by_box, &truth)]);
                assert!(
                    error.psnr_db() >= 60.0,
                    "{} {view:?}: {} dB",
                    renderer.info().backend,
                    error.psnr_db()
                );
                for method in METHODS.iter().filter(|m| m.lossless) {
                    if !renderer.has(method.skip) {
                        continue;
                    }
                    let picture = renderer.render(&Settings {
                        skip: method.skip,
                        ..settings
                    });
                    assert_eq!(
                        picture.unwrap().picture.difference(&by_box).pixels,
                        0,
                        "{} {} {view:?}",
                        renderer.info().backend,
                        method.name
                    );
                }
            }
            let whole = Settings {
                clipping: Clipping::NONE,
                ..settings
            };
            let whole = reference.render(&whole).unwrap().picture;
            assert!(whole.difference(&truth).pixels > 0, "{view:?}");
        }
    }
}

#[test]
fn each_mode_skips_what_it_can() {
    let mut renderer = renderer();
    let mut reference = Renderer::new(BackendChoice::Reference).unwrap();
    let volume = made("pot");
    show([&mut *renderer, &mut reference], &volume);
    let camera = Orbit::default().camera(volume.extent());
    for mode in modes(&volume) {
        let [all, few] = [Skip::Box, Skip::HalfSplit].map(|skip| {
            let settings = Settings {
                skip,
                ..settings(mode, camera)
            };
            renderer.count(&settings).unwrap().counters
        });
        assert_eq!(all.contributing, few.contributing, "{mode:?}");
        // The background is the lowest value: all of it matters to minip.
        if !matches!(mode, Mode::Minip(_)) {
            assert!(
                few.samples * 2 < all.samples,
                "{mode:?}: {} of {}",
                few.samples,
                all.samples
            );
        }
    }
}

/// A ball whose numbers fall evenly from its middle outwards, in 16 bits.
fn smooth_ball(n: usize) -> Arc<Volume> {
    let middle = n as f64 * 0.5;
    let voxels: Vec<u16> = (0..n * n * n)
        .map(|i| {
            let at = [i % n, i / n % n, i / n / n].map(|c| c as f64 + 0.5 - middle);
            let radius = DVec3::from_array(at).length();
            (60_000.0 * (1.0 - radius / n as f64)).round() as u16
        })
        .collect();
    Arc::new(Volume {
        voxels: Voxels::U16(voxels.into()),
        ..phantom::make("empty", [n; 3]).unwrap()
    })
}

#[test]
fn normals_of_a_ball_are_those_of_its_closed_form() {
    let mut renderer = renderer();
    let mut reference = Renderer::new(BackendChoice::Reference).unwrap();
    let n = 128;
    let volume = smooth_ball(n);
    show([&mut *renderer, &mut reference], &volume);
    let radius = 0.35 * n as f64;
    let iso = 60_000.0 * (1.0 - 0.35);
    let middle = volume.extent() * 0.5;
    let camera = Camera {
        eye: middle - DVec3::new(300.0, 120.0, 80.0),
        target: middle,
        up: DVec3::Z,
        projection: Projection::Orthographic { height: 100.0 },
    };
    let settings = Settings {
        size: [96, 96],
        ..settings(Mode::Normals { iso }, camera)
    };
    let frame = camera
        .ray_frame(&volume, settings.size, settings.step_voxels)
        .unwrap();
    for renderer in [&mut *renderer, &mut reference] {
        let picture = renderer.render(&settings).unwrap().picture;
        let (mut sum, mut worst, mut hits) = (0.0_f64, 0.0_f64, 0);
        for (i, pixel) in picture.rgba.iter().enumerate() {
            let at = [i % 96, i / 96].map(|c| c as f64 - 47.5);
            let start = frame.start + at[0] * frame.start_dx + at[1] * frame.start_dy - middle;
            let dir = frame.dir;
            let along = start.dot(dir);
            let square = along * along - start.length_squared() + radius * radius;
            // Rays that touch the ball rather than cross it may miss by rounding.
            let is_edge = square.abs() < 10.0;
            if is_edge {
                continue;
            }
            assert_eq!(pixel[3] > 0.0, square > 0.0, "pixel {i}");
            if square > 0.0 {
                let expected = (start + (-along - square.sqrt()) * dir) / radius;
                let [x, y, z, _] = pixel.map(|c| f64::from(c) * 2.0 - 1.0);
                let cos = DVec3::new(x, y, z).normalize().dot(expected);
                let degrees = cos.clamp(-1.0, 1.0).acos().to_degrees();
                sum += degrees;
                worst = worst.max(degrees);
                hits += 1;
            }
        }
        let mean = sum / f64::from(hits);
        println!(
            "{}: mean {mean:.3} degrees, at most {worst:.3}, {hits} hits",
            renderer.info().backend
        );
        assert!(hits > 2000 && mean < 1.0, "{mean} degrees on average");
    }
}

/// Stacks of material along z that every ray of an upright parallel view passes.
fn stack(values: &[u8]) -> Arc<Volume> {
    let (n, layer) = (24, 8);
    let voxels: Vec<u8> = (0..n * n * layer * values.len())
        .map(|i| values[i / (n * n * layer)])
        .collect();
    Arc::new(Volume {
        dims: [n, n, layer * values.len()],
        voxels: Voxels::U8(voxels.into()),
        ..phantom::make("empty", [1; 3]).unwrap()
    })
}

#[test]
fn projections_of_a_stack_have_a_closed_form() {
    let mut renderer = renderer();
    let mut reference = Renderer::new(BackendChoice::Reference).unwrap();
    let mut cpu = Renderer::new(BackendChoice::Cpu).unwrap();
    let volume = stack(&[40, 140, 240, 90]);
    show([&mut *renderer, &mut cpu, &mut reference], &volume);
    let middle = volume.extent() * 0.5;
    let camera = Camera {
        eye: middle - DVec3::Z * 100.0,
        target: middle,
        up: DVec3::Y,
        projection: Projection::Orthographic { height: 12.0 },
    };
    let window = Window {
        low: 40.0,
        high: 290.0,
    };
    let v = |value: f64| (value - 40.0) / 250.0;
    // Where nothing is above the window, nothing contributes.
    let over = Window {
        low: 240.0,
        high: 290.0,
    };
    // Between the layers the field is linear and sampled symmetrically: the mean is that of the layers.
    let mean = (v(40.0) + v(140.0) + v(240.0) + v(90.0)) / 4.0;
    // The first layers over the surface; the inner one lies behind.
    let two = Mode::TwoSurfaces {
        outer: Outer {
            iso: 100.0,
            color: [1.0, 0.0, 0.0],
            opacity: 0.25,
        },
        iso: 200.0,
        color: [0.0, 1.0, 1.0],
        lighting: Lighting {
            ambient: 0.25,
            diffuse: 0.5,
            specular: 0.0,
            ..Lighting::default()
        },
    };
    let lit = 0.75 * 0.75;
    let expected = [
        (Mode::Mip(window), [v(240.0); 4]),
        (Mode::Minip(window), [0.0, 0.0, 0.0, 1.0 - v(40.0)]),
        (Mode::Mean(window), [mean; 4]),
        (Mode::Mip(over), [0.0; 4]),
        (Mode::Mean(over), [0.0; 4]),
        (Mode::Grey(over), [0.0; 4]),
        (two, [0.25, lit, lit, 1.0]),
        (Mode::Normals { iso: 100.0 }, [0.5, 0.5, 0.0, 1.0]),
    ];
    for renderer in [&mut *renderer, &mut cpu, &mut reference] {
        for method in METHODS.iter().filter(|m| m.lossless) {
            for (mode, expected) in &expected {
                if !renderer.has(method.skip) || !has(renderer, mode) {
                    continue;
                }
                let picture = renderer.render(&Settings {
                    skip: method.skip,
                    step_voxels: 0.5,
                    size: [8, 8],
                    ..settings(*mode, camera)
                });
                let pixel = picture.unwrap().picture.rgba[27].map(f64::from);
                let is_near = pixel
                    .iter()
                    .zip(expected)
                    .all(|(a, b)| (a - b).abs() < 1e-4);
                assert!(
                    is_near,
                    "{} {} {mode:?}: {pixel:?}, not {expected:?}",
                    renderer.info().backend,
                    method.name
                );
            }
        }
    }
}

#[test]
fn grey_of_homogeneous_matter_has_the_opacity_of_its_chord_at_any_step() {
    let mut renderer = renderer();
    let mut reference = Renderer::new(BackendChoice::Reference).unwrap();
    let volume = stack(&[30]);
    show([&mut *renderer, &mut reference], &volume);
    let middle = volume.extent() * 0.5;
    let camera = Camera {
        eye: middle - DVec3::Z * 100.0,
        target: middle,
        up: DVec3::Y,
        projection: Projection::Orthographic { height: 12.0 },
    };
    let window = Window {
        low: 20.0,
        high: 120.0,
    };
    // A tenth of the window: that opacity per voxel, over eight voxels; and that grey.
    let opacity = 1.0 - 0.9_f64.powi(8);
    let grey = 0.1 * opacity;
    for renderer in [&mut *renderer, &mut reference] {
        for step_voxels in [0.25, 0.5, 1.0, 2.0] {
            let picture = renderer.render(&Settings {
                step_voxels,
                size: [8, 8],
                ..settings(Mode::Grey(window), camera)
            });
            for pixel in picture.unwrap().picture.rgba {
                for (channel, expected) in pixel.into_iter().zip([grey, grey, grey, opacity]) {
                    assert!((f64::from(channel) - expected).abs() < 1e-4, "{pixel:?}");
                }
            }
        }
    }
}

#[test]
fn a_picture_in_many_dispatches_is_finished_once() {
    // So many samples that the march stops, stores its state and goes on; rays that are done must be left alone.
    let mut renderer = renderer();
    let volume = Arc::new(phantom::make("full", [24; 3]).unwrap());
    show([&mut *renderer], &volume);
    let middle = volume.extent() * 0.5;
    let camera = Camera {
        eye: middle - DVec3::X * 100.0,
        target: middle,
        up: DVec3::Z,
        projection: Projection::Orthographic { height: 16.0 },
    };
    let window = Window {
        low: 0.0,
        high: 400.0,
    };
    let two = Mode::TwoSurfaces {
        outer: Outer {
            iso: 100.0,
            color: [1.0, 0.0, 0.0],
            opacity: 0.25,
        },
        iso: 150.0,
        color: [0.0, 1.0, 0.0],
        lighting: Lighting {
            ambient: 0.25,
            diffuse: 0.25,
            specular: 0.0,
            ..Lighting::default()
        },
    };
    for (mode, expected) in [
        (Mode::Mean(window), [0.5; 4]),
        (two, [0.25, 0.375, 0.0, 1.0]),
    ] {
        for skip in [Skip::Box, Skip::BeamMasks] {
            let picture = renderer.render(&Settings {
                skip,
                step_voxels: 24.0 / 60_000.0,
                size: [8, 8],
                ..settings(mode, camera)
            });
            for pixel in picture.unwrap().picture.rgba {
                let is_near = pixel
                    .iter()
                    .zip(expected)
                    .all(|(a, b)| (a - b).abs() < 1e-6);
                assert!(is_near, "{mode:?} {skip:?}: {pixel:?}, not {expected:?}");
            }
        }
    }
}

#[test]
fn the_nearest_sampler_shows_voxels_as_they_are() {
    let mut renderer = renderer();
    let mut reference = Renderer::new(BackendChoice::Reference).unwrap();
    let volume = Arc::new(phantom::make("noise", [8; 3]).unwrap());
    let Voxels::U8(voxels) = &volume.voxels else {
        panic!("phantoms are bytes")
    };
    show([&mut *renderer, &mut reference], &volume);
    let middle = volume.extent() * 0.5;
    // A pixel per voxel, seen along z; x runs to the left.
    let camera = Camera {
        eye: middle - DVec3::Z * 100.0,
        target: middle,
        up: DVec3::Y,
        projection: Projection::Orthographic { height: 8.0 },
    };
    let window = Window {
        low: 0.0,
        high: 255.0,
    };
    for renderer in [&mut *renderer, &mut reference] {
        for skip in [Skip::Box, Skip::HalfSplit] {
            let picture = renderer.render(&Settings {
                skip,
                sampler: Some(Sampler::Nearest),
                step_voxels: 0.4,
                size: [8, 8],
                ..settings(Mode::Mip(window), camera)
            });
            for (i, pixel) in picture.unwrap().picture.rgba.into_iter().enumerate() {
                let [x, y] = [7 - i % 8, 7 - i / 8];
                let highest = (0..8).map(|z| voxels[(z * 8 + y) * 8 + x]).max().unwrap();
                assert!((pixel[0] - f32::from(highest) / 255.0).abs() < 1e-5, "{i}");
            }
        }
    }
}

#[test]
fn a_surface_beyond_all_data_is_an_empty_picture() {
    let mut renderer = renderer();
    let mut reference = Renderer::new(BackendChoice::Reference).unwrap();
    let volume = made("sphere");
    show([&mut *renderer, &mut reference], &volume);
    let camera = Orbit::default().camera(volume.extent());
    for renderer in [&mut *renderer, &mut reference] {
        for skip in [Skip::Box, Skip::HalfSplit] {
            let settings = Settings {
                skip,
                ..settings(Mode::Normals { iso: 300.0 }, camera)
            };
            let picture = renderer.render(&settings).unwrap().picture;
            assert!(picture.rgba.iter().all(|p| *p == [0.0; 4]));
        }
    }
}
