//! Structural similarity: Z. Wang, A. C. Bovik, H. R. Sheikh, E. P. Simoncelli, "Image quality assessment: from error
//! visibility to structural similarity", IEEE Transactions on Image Processing 13(4), 2004, equation 13, with the paper's
//! window (11 x 11, Gaussian of 1.5 pixels) and constants, over windows that lie wholly in the picture.

use super::plane::{Plane, kernel, normalised};

/// Pixels on each side of a window's middle.
const RADIUS: usize = 5;
const DEVIATION: f64 = 1.5;
/// `(K1 L)^2` and `(K2 L)^2` for a full scale L of 1.
const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;

/// The mean similarity of two channels; not a number where no window fits in.
pub(super) fn ssim(a: &Plane, b: &Plane) -> f64 {
    let window = kernel(RADIUS, |x| (-0.5 * (x / DEVIATION).powi(2)).exp());
    let window = normalised(window);
    let blurred = |plane: &Plane| plane.filtered(&window, &window);
    let (mean_a, mean_b) = (blurred(a), blurred(b));
    let squares_a = blurred(&a.with(a, |x, y| x * y));
    let squares_b = blurred(&b.with(b, |x, y| x * y));
    let products = blurred(&a.with(b, |x, y| x * y));
    let [width, height] = a.size;
    let (mut sum, mut count) = (0.0, 0u32);
    for y in RADIUS..height.saturating_sub(RADIUS) {
        for x in RADIUS..width.saturating_sub(RADIUS) {
            let i = y * width + x;
            let (ma, mb) = (mean_a.values[i], mean_b.values[i]);
            let variance_a = squares_a.values[i] - ma * ma;
            let variance_b = squares_b.values[i] - mb * mb;
            let covariance = products.values[i] - ma * mb;
            sum += (2.0 * ma * mb + C1) * (2.0 * covariance + C2)
                / ((ma * ma + mb * mb + C1) * (variance_a + variance_b + C2));
            count += 1;
        }
    }
    sum / f64::from(count)
}

#[cfg(test)]
mod tests {
    use super::super::known::pictures;
    use super::*;

    /// Against scikit-image 0.25: `structural_similarity(a, b, gaussian_weights=True, sigma=1.5,
    /// use_sample_covariance=False, data_range=1.0, channel_axis=-1)`.
    #[test]
    fn it_is_what_another_implementation_has() {
        let [a, b] = pictures();
        let mean = (0..3).map(|c| ssim(&a[c], &b[c])).sum::<f64>() / 3.0;
        assert!((mean - 0.947_414_860_413_736_5).abs() < 1e-9, "{mean}");
        assert!((ssim(&a[0], &a[0]) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_picture_too_small_for_a_window_has_none() {
        let a = Plane::new([10, 30], vec![0.5; 300]);
        assert!(ssim(&a, &a).is_nan());
    }
}
