//! Rays along an axis, their chord a whole number of steps, through volumes whose integral has a closed form.

use super::*;
use crate::reference::{render, render_exact, render_f64};
use crate::scene::Progress;
use crate::skip::Plan;

/// Steps that halve: the slope of error over step is fitted to these.
const STEPS: [f64; 6] = [0.5, 0.25, 0.125, 0.0625, 0.03125, 0.015_625];

/// The least-squares slope of log(error) over log(step).
fn slope(errors: &[f64]) -> f64 {
    let points: Vec<[f64; 2]> = STEPS
        .iter()
        .zip(errors)
        .map(|(step, error)| [step.log2(), error.log2()])
        .collect();
    let mean = |i: usize| points.iter().map(|p| p[i]).sum::<f64>() / points.len() as f64;
    let (mx, my) = (mean(0), mean(1));
    let covariance: f64 = points.iter().map(|p| (p[0] - mx) * (p[1] - my)).sum();
    covariance / points.iter().map(|p| (p[0] - mx).powi(2)).sum::<f64>()
}

fn exact_pixel(volume: &Volume, function: &TransferFunction, frame: &RayFrame) -> [f64; 4] {
    let table = function.bake(&domain(volume, 65536), frame.step);
    let scene = scene(volume, &table, frame, 1.0);
    render_exact(&scene, function, &Plan::Box, &Progress::default()).expect("not cancelled")[0]
}

#[test]
fn a_homogeneous_slab_has_its_opacity_per_length_at_any_step() {
    // Anisotropic: the second axis is 1.5 local units per voxel.
    let volume = volume(
        [7, 4, 9],
        [2.0, 3.0, 2.0],
        Voxels::U8(vec![100; 7 * 4 * 9].into()),
    );
    let color = [0.9, 0.5, 0.1];
    for reference_length in [1.0, 2.5] {
        let function = function(vec![point(100.0, 0.3, color)], reference_length);
        for (axis, length) in [(0, 7.0f64), (1, 6.0), (2, 9.0)] {
            let opacity = 1.0 - 0.7f64.powf(length / reference_length);
            let expected = [0.9 * opacity, 0.5 * opacity, 0.1 * opacity, opacity];
            for step in [1.0].iter().chain(&STEPS) {
                for sign in [1.0, -1.0] {
                    let frame = along(&volume, axis, sign, [1, 1], *step);
                    let pixel = exact_pixel(&volume, &function, &frame);
                    for c in 0..4 {
                        assert!(
                            (pixel[c] - expected[c]).abs() < 1e-12,
                            "axis {axis}, step {step}: {pixel:?}, not {expected:?}"
                        );
                    }
                    // The table's entries are f32: each sample errs by half an ulp of its opacity at most.
                    let table = function.bake(&domain(&volume, 256), *step);
                    let scene = scene(&volume, &table, &frame, 1.0);
                    let baked = render_f64(&scene, &Plan::Box, &Progress::default())
                        .expect("not cancelled")[0];
                    for c in 0..4 {
                        assert!((baked[c] - expected[c]).abs() < 1e-6);
                    }
                }
            }
        }
    }
}

/// A ramp along x, 1000 per voxel.
fn ramp(nx: usize) -> Volume {
    let voxels: Vec<u16> = (0..9)
        .flat_map(|_| (0..nx).map(|x| 1000 * x as u16))
        .collect();
    volume([nx, 3, 3], [1.0; 3], Voxels::U16(voxels.into()))
}

#[test]
fn linear_color_converges_with_the_square_of_the_step() {
    // Colours linear in the value, which is linear between the outermost voxel centres and constant beyond them.
    let nx = 8;
    let volume = ramp(nx);
    let top = 1000.0 * (nx - 1) as f64;
    let function = function(
        vec![
            point(0.0, 0.2, [0.0, 1.0, 0.25]),
            point(top, 0.2, [1.0, 0.0, 0.75]),
        ],
        1.0,
    );
    let kappa = -f64::ln_1p(-0.2);
    // Integral of (p + q x) kappa exp(-kappa x) over [a, b].
    let piece = |p: f64, q: f64, a: f64, b: f64| {
        let antiderivative = |x: f64| -(p + q * x + q / kappa) * (-kappa * x).exp();
        antiderivative(b) - antiderivative(a)
    };
    let n = nx as f64;
    let expected = [[0.0, 1.0], [1.0, 0.0], [0.25, 0.75]].map(|[first, last]| {
        let q = (last - first) / (n - 1.0);
        piece(first, 0.0, 0.0, 0.5)
            + piece(first - 0.5 * q, q, 0.5, n - 0.5)
            + piece(last, 0.0, n - 0.5, n)
    });
    let pixels =
        STEPS.map(|step| exact_pixel(&volume, &function, &along(&volume, 0, 1.0, [1, 1], step)));
    for c in 0..3 {
        let errors = pixels.map(|pixel| (pixel[c] - expected[c]).abs());
        let slope = slope(&errors);
        assert!(
            (slope - 2.0).abs() < 0.15,
            "channel {c}: slope {slope}, errors {errors:?}"
        );
    }
    let opacity = 1.0 - (-kappa * n).exp();
    assert!(pixels.iter().all(|p| (p[3] - opacity).abs() < 1e-12));
}

#[test]
fn one_steep_table_interval_converges_with_the_step() {
    // 9,000 entries per voxel: the one interval in which opacity rises is 1/9000 voxel wide, below every step.
    let (nx, per_voxel) = (8, 9000);
    let voxels: Vec<u16> = (0..9)
        .flat_map(|_| (0..nx).map(|x| per_voxel * x as u16))
        .collect();
    let volume = volume([nx, 3, 3], [1.0; 3], Voxels::U16(voxels.into()));
    // A third of a voxel past a voxel's face: a third or two thirds of a step past a lattice point, at any halving.
    let entry = f64::from(per_voxel) * (3.0 + 1.0 / 3.0 - 0.5) - 0.5;
    assert_eq!(entry.fract(), 0.5, "the jump lies between two entries");
    let lower = entry.floor();
    let function = function(
        vec![
            point(lower, 0.0, [1.0, 0.5, 0.0]),
            point(lower + 1.0, 0.4, [1.0, 0.5, 0.0]),
        ],
        1.0,
    );
    let kappa = -f64::ln_1p(-0.4);
    // As the step goes to 0 interpolated opacities of a step become interpolated extinctions: half the rise counts.
    let rise = (lower + 0.5) / f64::from(per_voxel) + 0.5;
    let opacity = 1.0 - (-kappa * (nx as f64 - rise)).exp();
    let errors = STEPS.map(|step| {
        let frame = along(&volume, 0, 1.0, [1, 1], step);
        let table = function.bake(&domain(&volume, 65536), step);
        let scene = scene(&volume, &table, &frame, 1.0);
        let pixel = render_f64(&scene, &Plan::Box, &Progress::default()).expect("not cancelled")[0];
        (pixel[3] - opacity).abs()
    });
    let slope = slope(&errors);
    assert!(
        (slope - 1.0).abs() < 0.15,
        "slope {slope}, errors {errors:?}"
    );
}

#[test]
fn the_first_hit_is_the_first_sample_that_shows() {
    // Visible from value 3500 on: past x = 4 in voxels. The camera's rays start outside the box.
    let volume = ramp(8);
    let function = function(
        vec![point(3500.0, 0.0, [1.0; 3]), point(3500.0, 0.5, [1.0; 3])],
        1.0,
    );
    let step = 0.25;
    let frame = along(&volume, 0, 1.0, [1, 1], step);
    let table = function.bake(&domain(&volume, 65536), step);
    let counted = render(
        &scene(&volume, &table, &frame, 1.0),
        &Plan::Box,
        &Progress::default(),
    )
    .expect("not cancelled");
    let ray = frame.basis::<f64>().ray(0.0, 0.0);
    // The sample at x = 4.125 is the first behind the jump.
    assert!((f64::from(counted.first_hit[0]) - (ray.t_box + 4.125)).abs() < 1e-6);
    assert_eq!(
        (counted.samples[0], counted.counters.contributing),
        (32, 16)
    );

    let against = along(&volume, 0, -1.0, [1, 1], step);
    let table = function.bake(&domain(&volume, 65536), step);
    let counted = render(
        &scene(&volume, &table, &against, 0.5),
        &Plan::Box,
        &Progress::default(),
    )
    .expect("not cancelled");
    // 0.5 per voxel: opacity 0.5 is reached with the fourth sample, and the ray ends there.
    assert_eq!((counted.samples[0], counted.counters.contributing), (4, 4));
}

#[test]
fn rays_that_miss_find_nothing() {
    let volume = ramp(4);
    let function = function(vec![point(0.0, 1.0, [1.0; 3])], 1.0);
    let frame = along(&volume, 0, 1.0, [5, 5], 0.5);
    let table = function.bake(&domain(&volume, 65536), 0.5);
    let counted = render(
        &scene(&volume, &table, &frame, 1.0),
        &Plan::Box,
        &Progress::default(),
    )
    .expect("not cancelled");
    let hit: Vec<bool> = (0..25).map(|i| i % 5 % 4 != 0 && i / 5 % 4 != 0).collect();
    assert_eq!(
        counted
            .first_hit
            .iter()
            .map(|t| t.is_finite())
            .collect::<Vec<_>>(),
        hit
    );
    assert_eq!(
        counted.samples.iter().map(|&n| n > 0).collect::<Vec<_>>(),
        hit
    );
}

/// Values that rise with x times y, looked at along the diagonal: as far as voxel centres go, interpolation gives back just
/// that, and values on the way rise with the square of it.
fn curved() -> Volume {
    let n = 8;
    let voxels: Vec<u16> = (0..n * n * 3)
        .map(|i| 1300 * (i % n * (i / n % n)) as u16)
        .collect();
    volume([n, n, 3], [1.0; 3], Voxels::U16(voxels.into()))
}

/// Halvings of a sixteenth of the diagonal, which is a chord of whole steps.
const CURVED_STEPS: [f64; 6] = [1.0, 0.5, 0.25, 0.125, 0.0625, 0.03125];

/// Errors at those steps across one steep interval of the table, in red and in opacity. It lies two thirds of the coarsest
/// step past an interval's end, so a third or two thirds past one at any halving.
fn errors_across_a_steep_interval(classification: Classification) -> [[f64; 2]; 6] {
    let volume = curved();
    let length = 8.0 * std::f64::consts::SQRT_2;
    let coarsest = length / 16.0;
    let at = coarsest * (9.0 + 2.0 / 3.0);
    // On the diagonal x = y = s / sqrt(2), and values are 1300 (x - 1/2)^2.
    let lower = (1300.0 * (at / std::f64::consts::SQRT_2 - 0.5).powi(2)).floor();
    let at = ((lower + 0.5) / 1300.0).sqrt() + 0.5;
    let at = at * std::f64::consts::SQRT_2;
    let (thin, dense) = (0.05, 0.25);
    let function = function(
        vec![
            point(lower, thin, [1.0, 0.0, 0.0]),
            point(lower + 1.0, dense, [0.25, 0.0, 0.0]),
        ],
        1.0,
    );
    let [thin, dense] = [thin, dense].map(|a| -f64::ln_1p(-a));
    let before = -f64::exp_m1(-thin * at);
    let behind = -f64::exp_m1(-dense * (length - at)) * (1.0 - before);
    let truth = [before + 0.25 * behind, before + behind];
    let camera = Camera {
        eye: DVec3::new(-40.0, -40.0, 1.5),
        target: DVec3::new(4.0, 4.0, 1.5),
        up: DVec3::Z,
        projection: Projection::Orthographic { height: 1.0 },
    };
    CURVED_STEPS.map(|halving| {
        let step = coarsest * halving;
        let frame = RayFrame {
            reach: classification.reach(),
            ..camera
                .ray_frame(&volume, [1, 1], step)
                .expect("a valid view")
        };
        let table = function.bake(&domain(&volume, 65536), step);
        let scene = Scene {
            classification,
            ..scene(&volume, &table, &frame, 1.0)
        };
        let pixel = render_f64(&scene, &Plan::Box, &Progress::default()).expect("not cancelled")[0];
        [(pixel[0] - truth[0]).abs(), (pixel[3] - truth[1]).abs()]
    })
}

#[test]
fn pre_integration_converges_with_the_square_of_the_step_across_one_steep_table_interval() {
    let fitted = |classification, channel: usize| {
        let errors = errors_across_a_steep_interval(classification).map(|e| e[channel]);
        (slope(&errors), errors)
    };
    for channel in [0, 1] {
        let (slope, errors) = fitted(Classification::PreIntegrated, channel);
        println!("pre-integrated: slope {slope:.3}, errors {errors:?}");
        assert!(
            (slope - 2.0).abs() < 0.15,
            "slope {slope}, errors {errors:?}"
        );
        let (slope, errors) = fitted(Classification::Post, channel);
        println!("post: slope {slope:.3}, errors {errors:?}");
        assert!(
            (slope - 1.0).abs() < 0.15,
            "slope {slope}, errors {errors:?}"
        );
    }
}
