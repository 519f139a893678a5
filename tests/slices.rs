//! Slices against rays: the same picture, as near as samples on planes and samples on rays are. These tests fail, not skip,
//! where there is no adapter.

mod support;

use glam::DVec3;
use hollowcast::camera::{Camera, Orbit, Projection};
use hollowcast::lattice::Clipping;
use hollowcast::measure::metrics::metrics;
use hollowcast::measure::verify::View;
use hollowcast::mode::{Mode, Window};
use hollowcast::render::{BackendChoice, Renderer, Settings, SliceCount};
use hollowcast::skip::Skip;
use hollowcast::volume::Statistics;
use support::{made, modes, renderer, settings, show, stack};

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
