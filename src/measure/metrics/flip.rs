//! LDR-FLIP: P. Andersson, J. Nilsson, T. Akenine-Möller, M. Oskarsson, K. Åström, M. D. Fairchild, "FLIP: A Difference
//! Evaluator for Alternating Images", Proceedings of the ACM in Computer Graphics and Interactive Techniques 3(2), 2020,
//! doi:10.1145/3406183. Written from the paper: the crates that have it bind C++.
//!
//! The eye is taken to be 0.7 m from a display 0.7 m wide with 3,840 pixels, the paper's.

use std::f64::consts::PI;

use super::plane::{Plane, kernel, normalised};

/// Pixels per degree of the visual angle: distance times pixels per metre times the length of a degree at distance 1.
const PIXELS_PER_DEGREE: f64 = 3840.0 * PI / 180.0;
/// Contrast sensitivity of each opponent channel as two Gaussians, `[a1, b1, a2, b2]`: achromatic, red-green, blue-yellow.
const SENSITIVITY: [[f64; 4]; 3] = [
    [1.0, 0.0047, 0.0, 1e-5],
    [1.0, 0.0053, 0.0, 1e-5],
    [34.1, 0.04, 13.5, 0.025],
];
/// Width of features that the eye is keen on, in degrees.
const FEATURE_WIDTH: f64 = 0.082;
/// Exponents of colour and feature differences.
const Q_COLOR: f64 = 0.7;
const Q_FEATURE: f64 = 0.5;
/// Colour differences up to this part of the largest are spread over this part of the scale; the rest is compressed.
const KNEE: [f64; 2] = [0.4, 0.95];

/// CIE XYZ from linear sRGB, and back (primaries and white point D65 of IEC 61966-2-1).
const XYZ_FROM_RGB: [[f64; 3]; 3] = [
    [0.412_390_799_266, 0.357_584_339_384, 0.180_480_788_402],
    [0.212_639_005_872, 0.715_168_678_768, 0.072_192_315_361],
    [0.019_330_818_716, 0.119_194_779_795, 0.950_532_152_250],
];
const RGB_FROM_XYZ: [[f64; 3]; 3] = [
    [3.240_969_941_905, -1.537_383_177_570, -0.498_610_760_293],
    [-0.969_243_636_281, 1.875_967_501_508, 0.041_555_057_407],
    [0.055_630_079_697, -0.203_976_958_889, 1.056_971_514_243],
];

/// The mean error of two pictures: 0 where they are equal, at most 1. Channels are linear sRGB; what is beyond 0 to 1 is cut
/// off. Which is the reference makes no difference.
pub(super) fn flip(a: &[Plane; 3], b: &[Plane; 3]) -> f64 {
    let errors = map(a, b);
    errors.values.iter().sum::<f64>() / errors.values.len() as f64
}

/// The error of every pixel.
fn map(a: &[Plane; 3], b: &[Plane; 3]) -> Plane {
    let [a, b] = [a, b].map(opponent);
    let color = color_difference(&a, &b);
    let feature = feature_difference(&a[0], &b[0]);
    color.with(&feature, |color, feature| color.powf(1.0 - feature))
}

/// Three planes, pixel by pixel.
fn each(planes: &[Plane; 3], f: impl Fn([f64; 3]) -> [f64; 3]) -> [Plane; 3] {
    let size = planes[0].size;
    let pixels = (0..planes[0].values.len()).map(|i| [0, 1, 2].map(|c: usize| planes[c].values[i]));
    let pixels: Vec<[f64; 3]> = pixels.map(f).collect();
    [0, 1, 2].map(|c| Plane::new(size, pixels.iter().map(|p| p[c])))
}

fn times(matrix: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|row: usize| (0..3).map(|c| matrix[row][c] * v[c]).sum())
}

/// What white is in XYZ.
fn white() -> [f64; 3] {
    times(&XYZ_FROM_RGB, [1.0; 3])
}

/// XYZ in parts of white's.
fn relative_xyz(rgb: [f64; 3]) -> [f64; 3] {
    let (xyz, white) = (times(&XYZ_FROM_RGB, rgb), white());
    [0, 1, 2].map(|c: usize| xyz[c] / white[c])
}

/// The opponent space `YCxCz`, linear in light: filters may be applied there.
fn opponent(rgb: &[Plane; 3]) -> [Plane; 3] {
    each(rgb, |rgb| {
        let [x, y, z] = relative_xyz(rgb.map(|c| c.clamp(0.0, 1.0)));
        [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
    })
}

fn rgb_from_opponent([yy, cx, cz]: [f64; 3]) -> [f64; 3] {
    let y = (yy + 16.0) / 116.0;
    let white = white();
    let xyz = [y + cx / 500.0, y, y - cz / 200.0];
    times(&RGB_FROM_XYZ, [0, 1, 2].map(|c: usize| xyz[c] * white[c]))
}

/// CIE L*a*b* with chroma scaled by lightness (the Hunt effect): dark colours look alike.
fn hunt_lab(rgb: [f64; 3]) -> [f64; 3] {
    let delta = 6.0_f64 / 29.0;
    let [x, y, z] = relative_xyz(rgb).map(|t| {
        if t > delta.powi(3) {
            t.cbrt()
        } else {
            t / (3.0 * delta * delta) + 4.0 / 29.0
        }
    });
    let lightness = 116.0 * y - 16.0;
    let hunt = 0.01 * lightness;
    [lightness, 500.0 * (x - y) * hunt, 200.0 * (y - z) * hunt]
}

/// The distance `HyAB`, for colours far apart, compressed.
fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let hyab = (a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2]);
    hyab.powf(Q_COLOR)
}

/// What the eye makes of an opponent channel from afar: blurred by its contrast sensitivity.
fn blurred(plane: &Plane, [a1, b1, a2, b2]: [f64; 4]) -> Plane {
    let widest = SENSITIVITY
        .iter()
        .flat_map(|s| [s[1], s[3]])
        .fold(0.0, f64::max);
    let radius = (3.0 * (widest / (2.0 * PI * PI)).sqrt() * PIXELS_PER_DEGREE).ceil() as usize;
    let gaussian = |b: f64| {
        kernel(radius, |x| {
            (-(PI * x / PIXELS_PER_DEGREE).powi(2) / b).exp()
        })
    };
    // Each Gaussian is a product of one along rows and one along columns; of their sum all weights add up to 1.
    let parts = [[a1, b1], [a2, b2]].map(|[a, b]| {
        let weights = gaussian(b);
        let sum = weights.iter().sum::<f64>().powi(2);
        let scale = a * (PI / b).sqrt();
        (
            plane.filtered(&normalised(weights.clone()), &normalised(weights)),
            scale * sum,
        )
    });
    let all = parts[0].1 + parts[1].1;
    let [(first, first_weight), (second, second_weight)] = parts;
    first.with(&second, |x, y| (x * first_weight + y * second_weight) / all)
}

fn color_difference(a: &[Plane; 3], b: &[Plane; 3]) -> Plane {
    let [a, b] = [a, b].map(|planes| {
        let seen = [0, 1, 2].map(|c: usize| blurred(&planes[c], SENSITIVITY[c]));
        each(&seen, |pixel| {
            hunt_lab(rgb_from_opponent(pixel).map(|c| c.clamp(0.0, 1.0)))
        })
    });
    let largest = distance(hunt_lab([0.0, 1.0, 0.0]), hunt_lab([0.0, 0.0, 1.0]));
    let [knee, scale] = KNEE;
    let knee = knee * largest;
    let differences = (0..a[0].values.len()).map(|i| {
        let at = |planes: &[Plane; 3]| [0, 1, 2].map(|c: usize| planes[c].values[i]);
        let difference = distance(at(&a), at(&b));
        if difference < knee {
            difference * scale / knee
        } else {
            scale + (difference - knee) / (largest - knee) * (1.0 - scale)
        }
    });
    Plane::new(a[0].size, differences)
}

/// Differences of edges and points of the achromatic channel.
fn feature_difference(a: &Plane, b: &Plane) -> Plane {
    let deviation = 0.5 * FEATURE_WIDTH * PIXELS_PER_DEGREE;
    let radius = (3.0 * deviation).ceil() as usize;
    let gaussian = |x: f64| (-0.5 * (x / deviation).powi(2)).exp();
    let across = normalised(kernel(radius, gaussian));
    let edges = one_of_each_sign(kernel(radius, |x| -x * gaussian(x)));
    let points = one_of_each_sign(kernel(radius, |x| {
        ((x / deviation).powi(2) - 1.0) * gaussian(x)
    }));
    let strength = |plane: &Plane, along: &[f64]| {
        let grey = plane.with(plane, |y, _| (y + 16.0) / 116.0);
        let x = grey.filtered(along, &across);
        x.with(&grey.filtered(&across, along), f64::hypot)
    };
    let difference =
        |along: &[f64]| strength(a, along).with(&strength(b, along), |x, y| (x - y).abs());
    difference(&edges).with(&difference(&points), |edge, point| {
        (edge.max(point) / 2.0_f64.sqrt()).powf(Q_FEATURE)
    })
}

/// Positive weights with a sum of 1, negative ones with -1.
fn one_of_each_sign(mut weights: Vec<f64>) -> Vec<f64> {
    let sum = |sign: f64| weights.iter().map(|w| (w * sign).max(0.0)).sum::<f64>();
    let [positive, negative] = [sum(1.0), sum(-1.0)];
    for weight in &mut weights {
        *weight /= if *weight > 0.0 { positive } else { negative };
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::super::known::pictures;
    use super::*;

    /// Against `flip-evaluator` 1.7, the authors' own (`evaluate(a, b, "LDR")`), which computes in f32.
    #[test]
    fn it_is_what_the_authors_implementation_has() {
        let [a, b] = pictures();
        let errors = map(&a, &b);
        assert!(
            (flip(&a, &b) - 0.175_044_8).abs() < 2e-4,
            "{}",
            flip(&a, &b)
        );
        assert!((errors.values[10 * 32 + 12] - 0.191_433_3).abs() < 5e-4);
        assert!((errors.values[0] - 0.172_508_5).abs() < 5e-4);
        let black = each(&a, |_| [0.0; 3]);
        assert!((flip(&a, &black) - 0.967_248_9).abs() < 2e-4);
        let [half, quarter] = [0.5, 0.25].map(|grey| each(&a, |_| [grey; 3]));
        assert!((flip(&half, &quarter) - 0.451_9).abs() < 2e-4);
    }

    #[test]
    fn equal_pictures_have_no_error_and_order_makes_no_difference() {
        let [a, b] = pictures();
        assert_eq!(flip(&a, &a), 0.0);
        assert_eq!(flip(&a, &b), flip(&b, &a));
    }
}
