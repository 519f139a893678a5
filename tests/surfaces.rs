//! First surfaces: their normals against a closed form, and what becomes of those that are not there. These tests fail, not
//! skip, where there is no adapter.

mod support;

use std::sync::Arc;

use glam::DVec3;
use hollowcast::camera::{Camera, Orbit, Projection};
use hollowcast::mode::Mode;
use hollowcast::render::{BackendChoice, Renderer, Settings};
use hollowcast::skip::Skip;
use hollowcast::volume::{Volume, Voxels, phantom};
use support::{made, renderer, settings, show};

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
