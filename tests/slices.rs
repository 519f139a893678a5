//! Slices against rays: the same picture, as near as samples on planes and samples on rays are. These tests fail, not skip,
//! where there is no adapter.

mod support;

use std::sync::Arc;

use glam::DVec3;
use hollowcast::camera::{Camera, Orbit, Projection};
use hollowcast::lattice::Clipping;
use hollowcast::measure::metrics::metrics;
use hollowcast::measure::verify::View;
use hollowcast::mode::{Mode, Window};
use hollowcast::render::{BackendChoice, Renderer, Settings, SliceCount};
use hollowcast::sample::Classification;
use hollowcast::skip::Skip;
use hollowcast::transfer::{ControlPoint, TransferFunction};
use hollowcast::volume::{Statistics, Volume, Voxels, phantom};
use support::{along, made, modes, renderer, settings, show, stack};

/// The settings of rays a voxel a step, and of slices a voxel apart.
fn rays_and_slices(mode: Mode, camera: Camera) -> [Settings; 2] {
    let rays = Settings {
        skip: Skip::Box,
        step_voxels: 1.0,
        ..settings(mode, camera)
    };
    let slices = Some(SliceCount::PerVoxel);
    [rays, Settings { slices, ..rays }]
}

#[test]
fn slices_a_voxel_apart_draw_what_rays_a_voxel_a_step_draw() {
    let mut renderer = renderer();
    let mut worst = f64::INFINITY;
    for name in ["pot", "capsules", "gyroid"] {
        let volume = made(name);
        let transfer = show([&mut *renderer], &volume);
        for mode in modes(&volume).into_iter().filter(SliceCount::draw) {
            let mut half = Clipping::NONE;
            let normal = DVec3::new(1.0, 0.4, -0.3);
            half.keep(normal, normal.dot(volume.extent() * 0.5))
                .unwrap();
            for (view, is_parallel, clipping) in [
                (View::Outside, false, Clipping::NONE),
                (View::Outside, true, half),
                (View::Cavity, false, Clipping::NONE),
            ] {
                let camera = view.camera(&volume, &transfer, is_parallel);
                let [rays, slices] = rays_and_slices(mode, camera).map(|settings| {
                    let settings = Settings {
                        clipping,
                        ..settings
                    };
                    renderer.render(&settings).unwrap().picture
                });
                let db = metrics([(&slices, &rays)]).psnr_db();
                println!("{name} {} {view:?}: {db:.1} dB", mode.name());
                worst = worst.min(db);
            }
        }
    }
    assert!(worst >= WORST_DB, "{worst} dB");
}

/// What the least alike of the pictures above measure, less a little.
const WORST_DB: f64 = 21.5;

/// Values that rise along z from the middle of the first voxel to that of the last, the fourth: 16 bits.
fn ramp() -> Arc<Volume> {
    let voxels: Vec<u16> = (0..16 * 16 * 4).map(|i| 8000 * (i / 256)).collect();
    Arc::new(Volume {
        voxels: Voxels::U16(voxels.into()),
        ..phantom::make("empty", [16, 16, 4]).unwrap()
    })
}

fn point(value: f64, opacity: f64, color: [f64; 3]) -> ControlPoint {
    ControlPoint {
        value,
        opacity,
        color,
    }
}

/// Seen along the ramp, whose colour goes from blue to red at an opacity of a half per voxel.
#[test]
fn slices_converge_with_the_square_of_their_distance() {
    let mut renderer = renderer();
    let volume = ramp();
    renderer.set_volume(Arc::clone(&volume)).unwrap();
    let points = vec![
        point(0.0, 0.5, [0.0, 0.0, 1.0]),
        point(24_000.0, 0.5, [1.0, 0.0, 0.0]),
    ];
    renderer.set_transfer(TransferFunction::new(points, 1.0).unwrap());
    let kappa = std::f64::consts::LN_2;
    // Integral of (p + q z) kappa exp(-kappa z) over [a, b].
    let piece = |p: f64, q: f64, a: f64, b: f64| {
        let antiderivative = |z: f64| -(p + q * z + q / kappa) * (-kappa * z).exp();
        antiderivative(b) - antiderivative(a)
    };
    let third = 1.0 / 3.0;
    let red = piece(-0.5 * third, third, 0.5, 3.5) + piece(1.0, 0.0, 3.5, 4.0);
    let errors = [8, 16, 32, 64, 128, 256].map(|count| {
        let picture = renderer.render(&Settings {
            skip: Skip::Box,
            size: [8, 8],
            table_entries: 65_536,
            slices: Some(SliceCount::Exactly(count)),
            ..settings(Mode::EmissionAbsorption, along(&volume, DVec3::Z, 8.0))
        });
        let pixel = picture.unwrap().picture.rgba[27].map(f64::from);
        assert!((pixel[3] - 0.9375).abs() < 1e-5, "{pixel:?}");
        (pixel[0] - red).abs()
    });
    // The least-squares slope of their logarithms over five halvings of the distance.
    let slope = errors
        .iter()
        .enumerate()
        .map(|(i, e)| (2.5 - i as f64) * e.log2());
    let slope = slope.sum::<f64>() / 17.5;
    println!("slope {slope:.3}, errors {errors:?}");
    assert!((slope - 2.0).abs() < 0.15, "{slope}: {errors:?}");
}

#[test]
fn more_slices_are_nearer_to_what_rays_converge_to() {
    let mut renderer = renderer();
    let mut reference = Renderer::new(BackendChoice::Reference).unwrap();
    for name in ["pot", "capsules"] {
        let volume = made(name);
        let transfer = show([&mut *renderer, &mut reference], &volume);
        let camera = View::Outside.camera(&volume, &transfer, false);
        for mode in modes(&volume).into_iter().filter(SliceCount::draw) {
            let rays = Settings {
                step_voxels: 0.02,
                size: [40, 36],
                ..settings(mode, camera)
            };
            let truth = reference.render(&rays).unwrap().picture;
            let db = [27, 54, 108, 216, 432, 864].map(|count| {
                let slices = Settings {
                    skip: Skip::Box,
                    slices: Some(SliceCount::Exactly(count)),
                    ..rays
                };
                let picture = renderer.render(&slices).unwrap().picture;
                metrics([(&picture, &truth)]).psnr_db()
            });
            println!("{name} {}: {db:.1?} dB", mode.name());
            assert!(
                db.is_sorted() && db[5] > db[0] + 15.0,
                "{name} {mode:?}: {db:?}"
            );
        }
    }
}

/// A layer an eighth of a voxel thick, between slices a voxel apart.
#[test]
fn pre_integrated_slices_do_not_miss_what_lies_between_them() {
    let mut renderer = renderer();
    let mut reference = Renderer::new(BackendChoice::Reference).unwrap();
    let volume = made("capsules");
    let statistics = Statistics::of(&volume);
    let [_, high] = statistics.value_range();
    let points = [(0.48, 0.0), (0.5, 0.6), (0.52, 0.0)]
        .map(|(share, opacity)| point(share * high, opacity, [0.9, 0.5, 0.2]));
    let transfer = TransferFunction::new(points.to_vec(), 1.0).unwrap();
    for renderer in [&mut *renderer, &mut reference] {
        renderer.set_volume(Arc::clone(&volume)).unwrap();
        renderer.set_transfer(transfer.clone());
    }
    let camera = View::Outside.camera(&volume, &transfer, false);
    let rays = Settings {
        step_voxels: 0.02,
        size: [40, 36],
        ..settings(Mode::EmissionAbsorption, camera)
    };
    let truth = reference.render(&rays).unwrap().picture;
    let [post, pre, pre_integrated] = [
        Classification::Post,
        Classification::Pre,
        Classification::PreIntegrated,
    ]
    .map(|classification| {
        let slices = Settings {
            skip: Skip::Box,
            classification,
            slices: Some(SliceCount::PerVoxel),
            ..rays
        };
        let picture = renderer.render(&slices).unwrap().picture;
        metrics([(&picture, &truth)]).psnr_db()
    });
    println!("post {post:.1} dB, pre {pre:.1} dB, pre-integrated {pre_integrated:.1} dB");
    assert!(pre_integrated > post + 10.0 && pre_integrated > pre + 10.0);
}

#[test]
fn opacity_of_homogeneous_matter_is_that_of_its_chord_however_many_slices() {
    let mut renderer = renderer();
    let volume = stack(&[30]);
    show([&mut *renderer], &volume);
    let middle = volume.extent() * 0.5;
    let window = Window {
        low: 20.0,
        high: 120.0,
    };
    for projection in [
        Projection::Orthographic { height: 12.0 },
        Projection::Perspective {
            fov_y_degrees: 50.0,
        },
    ] {
        let camera = Camera {
            eye: middle - DVec3::Z * 14.0,
            target: middle,
            up: DVec3::Y,
            projection,
        };
        let sizes = [16, 16];
        let frame = camera.ray_frame(&volume, sizes, 1.0).unwrap();
        for count in [SliceCount::PerVoxel, SliceCount::Exactly(106)] {
            let picture = renderer.render(&Settings {
                skip: Skip::Box,
                size: sizes,
                slices: Some(count),
                ..settings(Mode::Grey(window), camera)
            });
            for (i, pixel) in picture.unwrap().picture.rgba.into_iter().enumerate() {
                // A tenth of the window is the opacity per voxel of the way, which is longer aslant.
                let [x, y] = [i % 16, i / 16].map(|c| c as f64 - 7.5);
                let slant = (frame.dir + x * frame.dir_dx + y * frame.dir_dy).length();
                let opacity = 1.0 - 0.9_f64.powf(8.0 * slant);
                for (channel, expected) in pixel.into_iter().zip([0.1, 0.1, 0.1, 1.0]) {
                    let expected = expected * opacity;
                    assert!(
                        (f64::from(channel) - expected).abs() < 1e-4,
                        "{count:?} {i}: {pixel:?}, not {expected}"
                    );
                }
            }
        }
    }
}

#[test]
fn counted_slices_are_those_drawn_at_any_width() {
    let mut renderer = renderer();
    let volume = made("pot");
    show([&mut *renderer], &volume);
    let camera = Orbit::default().camera(volume.extent());
    let mode = Mode::Mip(Window::above_background(&Statistics::of(&volume)));
    // 16 pixels of 16 bytes are what copies align rows to.
    for size in [[48, 20], [45, 20]] {
        let [rays, slices] = rays_and_slices(mode, camera).map(|s| Settings { size, ..s });
        let counted = renderer.count(&slices).unwrap();
        let drawn = renderer.render(&slices).unwrap().picture;
        assert_eq!(counted.picture.difference(&drawn).pixels, 0);
        let of_rays = renderer.count(&rays).unwrap().counters.samples as f64;
        let ratio = counted.counters.samples as f64 / of_rays;
        assert!(
            (0.85..1.1).contains(&ratio),
            "{ratio} samples for each of a ray's"
        );
    }
}

#[test]
fn slices_refuse_what_they_do_not_draw() {
    let mut renderer = renderer();
    let volume = made("sphere");
    show([&mut *renderer], &volume);
    let camera = Orbit::default().camera(volume.extent());
    let [_, slices] = rays_and_slices(Mode::EmissionAbsorption, camera);
    let hull = Settings {
        skip: Skip::Hull,
        ..slices
    };
    let surface = Settings {
        mode: Mode::Normals { iso: 90.0 },
        ..slices
    };
    for (settings, field) in [(hull, "method"), (surface, "mode")] {
        let error = renderer.render(&settings).unwrap_err();
        assert!(
            error.is_bad_input() && error.to_string().starts_with(field),
            "{error}"
        );
    }
    let mut cpu = Renderer::new(BackendChoice::Cpu).unwrap();
    show([&mut cpu], &volume);
    let error = cpu.render(&slices).unwrap_err().to_string();
    assert!(error.starts_with("renderer"), "{error}");
}
