//! How far two pictures are apart.
//!
//! All metrics are taken on the channels as they are rendered: linear red, green and blue premultiplied by opacity, and
//! opacity, before any background, curve or quantisation. A channel's full scale is 1.

use crate::scene::Picture;

/// Distances between two pictures, over all four channels of all pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Metrics {
    /// Largest absolute difference of any channel.
    pub max_abs: f64,
    /// Mean absolute difference.
    pub mean_abs: f64,
    /// Root of the mean squared difference.
    pub rms: f64,
}

impl Metrics {
    /// Peak signal-to-noise ratio in decibels, `-20 log10(rms)` for a peak of 1; infinite where nothing differs.
    pub fn psnr_db(&self) -> f64 {
        -20.0 * self.rms.log10()
    }
}

/// The distances between pairs of pictures, as if each side were one large picture.
///
/// # Panics
/// Where a pair's sizes differ or there is no pixel.
pub fn metrics<'a>(pairs: impl IntoIterator<Item = (&'a Picture, &'a Picture)>) -> Metrics {
    let (mut max_abs, mut sum, mut squares, mut count) = (0.0f64, 0.0, 0.0, 0usize);
    for (a, b) in pairs {
        assert_eq!(a.size, b.size, "pictures of one size are compared");
        for (x, y) in a.rgba.as_flattened().iter().zip(b.rgba.as_flattened()) {
            let difference = (f64::from(*x) - f64::from(*y)).abs();
            max_abs = max_abs.max(difference);
            sum += difference;
            squares += difference * difference;
        }
        count += a.rgba.len() * 4;
    }
    assert!(count > 0, "there is something to compare");
    Metrics {
        max_abs,
        mean_abs: sum / count as f64,
        rms: (squares / count as f64).sqrt(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flat(value: f32, pixels: u32) -> Picture {
        Picture {
            size: [pixels, 1],
            rgba: vec![[value; 4]; pixels as usize],
        }
    }

    #[test]
    fn a_constant_difference_is_every_metric() {
        let (a, b) = (flat(0.5, 3), flat(0.25, 3));
        let m = metrics([(&a, &b)]);
        assert_eq!((m.max_abs, m.mean_abs, m.rms), (0.25, 0.25, 0.25));
        assert!((m.psnr_db() - 12.041_199_826_559_248).abs() < 1e-12);
    }

    #[test]
    fn equal_pictures_are_infinitely_alike() {
        let a = flat(0.3, 2);
        assert_eq!(metrics([(&a, &a)]).psnr_db(), f64::INFINITY);
    }

    #[test]
    fn pairs_weigh_by_their_pixels() {
        let (a, b) = (flat(0.0, 3), flat(1.0, 1));
        let m = metrics([(&a, &a), (&b, &flat(0.0, 1))]);
        assert_eq!((m.max_abs, m.mean_abs, m.rms), (1.0, 0.25, 0.5));
    }
}
