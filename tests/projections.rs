//! Modes that look at values alone, where a closed form is known. These tests fail, not skip, where there is no adapter.

mod support;

use std::sync::Arc;

use glam::DVec3;
use hollowcast::mode::{Lighting, Mode, Outer, Window};
use hollowcast::render::{BackendChoice, Renderer, Settings};
use hollowcast::sample::Sampler;
use hollowcast::skip::{METHODS, Skip};
use hollowcast::volume::{Voxels, phantom};
use support::{along, renderer, settings, show, stack};

/// A red veil at 100 before a surface at `iso`, lit by a quarter of ambient light and so much from the eye.
fn two_surfaces(iso: f64, color: [f64; 3], diffuse: f64) -> Mode {
    Mode::TwoSurfaces {
        outer: Outer {
            iso: 100.0,
            color: [1.0, 0.0, 0.0],
            opacity: 0.25,
        },
        iso,
        color,
        lighting: Lighting {
            ambient: 0.25,
            diffuse,
            specular: 0.0,
            ..Lighting::default()
        },
    }
}

fn between(low: f64, high: f64) -> Window {
    Window { low, high }
}

/// Whether every channel is as expected.
fn is_near(pixel: [f32; 4], expected: [f64; 4], tolerance: f64) -> bool {
    let mut channels = pixel.into_iter().zip(expected);
    channels.all(|(a, b)| (f64::from(a) - b).abs() < tolerance)
}

#[test]
fn projections_of_a_stack_have_a_closed_form() {
    let mut renderer = renderer();
    let mut reference = Renderer::new(BackendChoice::Reference).unwrap();
    let mut cpu = Renderer::new(BackendChoice::Cpu).unwrap();
    let volume = stack(&[40, 140, 240, 90]);
    show([&mut *renderer, &mut cpu, &mut reference], &volume);
    let camera = along(&volume, DVec3::Z, 12.0);
    let window = between(40.0, 290.0);
    let v = |value: f64| (value - 40.0) / 250.0;
    // Where nothing is above the window, nothing contributes.
    let over = between(240.0, 290.0);
    // Between the layers the field is linear and sampled symmetrically: the mean is that of the layers.
    let mean = (v(40.0) + v(140.0) + v(240.0) + v(90.0)) / 4.0;
    // The first layers over the surface; the inner one lies behind.
    let two = two_surfaces(200.0, [0.0, 1.0, 1.0], 0.5);
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
                if !renderer.has(method.skip) || !renderer.has_mode(mode) {
                    continue;
                }
                let picture = renderer.render(&Settings {
                    skip: method.skip,
                    step_voxels: 0.5,
                    size: [8, 8],
                    ..settings(*mode, camera)
                });
                let pixel = picture.unwrap().picture.rgba[27];
                assert!(
                    is_near(pixel, *expected, 1e-4),
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
    let camera = along(&volume, DVec3::Z, 12.0);
    let window = between(20.0, 120.0);
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
                let expected = [grey, grey, grey, opacity];
                assert!(is_near(pixel, expected, 1e-4), "{pixel:?}");
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
    let camera = along(&volume, DVec3::X, 16.0);
    let window = between(0.0, 400.0);
    let two = two_surfaces(150.0, [0.0, 1.0, 0.0], 0.25);
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
                assert!(
                    is_near(pixel, expected, 1e-6),
                    "{mode:?} {skip:?}: {pixel:?}, not {expected:?}"
                );
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
    // A pixel per voxel, seen along z; x runs to the left.
    let camera = along(&volume, DVec3::Z, 8.0);
    let window = between(0.0, 255.0);
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
fn a_ray_leaves_out_blocks_that_lie_no_higher_than_what_it_has_seen() {
    let mut renderer = renderer();
    let mut cpu = Renderer::new(BackendChoice::Cpu).unwrap();
    let mut reference = Renderer::new(BackendChoice::Reference).unwrap();
    // Behind the bright layer there is nothing to gain; before it there is.
    let volume = stack(&[90, 240, 140, 140, 140]);
    show([&mut *renderer, &mut cpu, &mut reference], &volume);
    let (forward, backward) = (
        along(&volume, DVec3::Z, 12.0),
        along(&volume, -DVec3::Z, 12.0),
    );
    for renderer in [&mut *renderer, &mut cpu, &mut reference] {
        for method in METHODS.iter().filter(|m| m.skip.reads_majorants()) {
            if !renderer.has(method.skip) {
                continue;
            }
            let mut samples = |mode, camera| {
                let settings = Settings {
                    skip: method.skip,
                    size: [8, 8],
                    step_voxels: 0.5,
                    ..settings(mode, camera)
                };
                let by_box = renderer.count(&Settings {
                    skip: Skip::Box,
                    ..settings
                });
                let (by_box, counted) = (by_box.unwrap(), renderer.count(&settings).unwrap());
                assert_eq!(counted.picture.difference(&by_box.picture).pixels, 0);
                assert_eq!(counted.counters.contributing, by_box.counters.contributing);
                [counted, by_box].map(|c| c.counters.samples as f64 / 64.0)
            };
            let name = method.name;
            // Five layers of 8 voxels, two samples a voxel; blocks of 4 beside a layer know of it.
            let [few, all] = samples(Mode::Mip(between(40.0, 290.0)), forward);
            assert!(all > 79.0 && few < 45.0, "{name}: {few} of {all}");
            let [few, all] = samples(Mode::Mip(between(40.0, 290.0)), backward);
            // All is as high as what was seen or higher, but for one block of the last layer.
            assert!(few > 70.0 && few < 75.0, "{name}: {few} of {all}");
            // The darkest layer comes first: nothing behind it is darker.
            let [few, all] = samples(Mode::Minip(between(0.0, 150.0)), forward);
            assert!(few < 0.4 * all, "{name}: {few} of {all}");
            // Another window has other bounds than those that were kept: the bright layer ends the ray.
            let [few, all] = samples(Mode::Mip(between(40.0, 240.0)), backward);
            assert!(few > 45.0 && few < 55.0, "{name}: {few} of {all}");
        }
    }
}
