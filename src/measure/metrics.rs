//! How far a picture is from another, or from the truth: the one place where measures of error are defined.
//!
//! All are taken on the channels as they are rendered: linear red, green and blue premultiplied by opacity, and opacity,
//! before any background, curve or quantisation. A channel's full scale is 1.

use super::truth::Truth;
use crate::scene::Picture;

/// What counts as visible in 8 bits.
pub const VISIBLE: f64 = 1.0 / 255.0;

/// Distances between two pictures, over all four channels of all pixels that are compared.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Metrics {
    /// Largest absolute difference of any channel; full scale is 1, as of the next two.
    pub max_abs: f64,
    /// Mean absolute difference.
    pub mean_abs: f64,
    /// Root of the mean squared difference.
    pub rms: f64,
    /// Pixels with a channel off by more than [`VISIBLE`] over all pixels that are compared.
    pub off_share: f64,
}

impl Metrics {
    /// Peak signal-to-noise ratio in decibels, `-20 log10(rms)` for a peak of 1; infinite where nothing differs.
    pub fn psnr_db(&self) -> f64 {
        -20.0 * self.rms.log10()
    }
}

/// How alike two pictures look.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Perceived {
    /// Mean structural similarity, at most 1: equal.
    pub ssim: f64,
    /// Mean LDR-FLIP error, 0 (equal) to 1.
    pub flip: f64,
}

/// Two pictures of one size, and which of their pixels are not compared.
#[derive(Debug, Clone, Copy)]
pub struct Pair<'a> {
    /// What is measured.
    pub picture: &'a Picture,
    /// What it should be.
    pub truth: &'a Picture,
    /// Pixels that are left out, in the pictures' order.
    pub masked: Option<&'a [bool]>,
}

impl<'a> From<(&'a Picture, &'a Picture)> for Pair<'a> {
    fn from((picture, truth): (&'a Picture, &'a Picture)) -> Self {
        Self {
            picture,
            truth,
            masked: None,
        }
    }
}

impl<'a> From<(&'a Picture, &'a Truth)> for Pair<'a> {
    fn from((picture, truth): (&'a Picture, &'a Truth)) -> Self {
        Self {
            picture,
            truth: &truth.picture,
            masked: Some(&truth.masked),
        }
    }
}

/// The distances between pairs of pictures, as if each side were one large picture. Where all pixels are masked, nothing
/// differs.
///
/// # Panics
/// Where a pair's sizes differ.
pub fn metrics<'a>(pairs: impl IntoIterator<Item = impl Into<Pair<'a>>>) -> Metrics {
    let (mut max_abs, mut sum, mut squares) = (0.0f64, 0.0, 0.0);
    let (mut off, mut pixels) = (0usize, 0usize);
    for pair in pairs {
        let Pair {
            picture,
            truth,
            masked,
        } = pair.into();
        assert_eq!(
            picture.size, truth.size,
            "pictures of one size are compared"
        );
        for (i, (a, b)) in picture.rgba.iter().zip(&truth.rgba).enumerate() {
            if masked.is_some_and(|m| m[i]) {
                continue;
            }
            let mut worst = 0.0f64;
            for (x, y) in a.iter().zip(b) {
                let difference = (f64::from(*x) - f64::from(*y)).abs();
                worst = worst.max(difference);
                sum += difference;
                squares += difference * difference;
            }
            max_abs = max_abs.max(worst);
            off += usize::from(worst > VISIBLE);
            pixels += 1;
        }
    }
    let pixels = pixels.max(1) as f64;
    Metrics {
        max_abs,
        mean_abs: sum / (4.0 * pixels),
        rms: (squares / (4.0 * pixels)).sqrt(),
        off_share: off as f64 / pixels,
    }
}

/// How alike the pictures of a pair look.
///
/// # Panics
/// Where the sizes differ.
pub fn perceived<'a>(pair: impl Into<Pair<'a>>) -> Perceived {
    let pair = pair.into();
    assert_eq!(
        pair.picture.size, pair.truth.size,
        "pictures of one size are compared"
    );
    Perceived {
        ssim: f64::NAN,
        flip: f64::NAN,
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
        assert_eq!(m.off_share, 1.0);
        assert!((m.psnr_db() - 12.041_199_826_559_248).abs() < 1e-12);
    }

    #[test]
    fn equal_pictures_are_infinitely_alike() {
        let a = flat(0.3, 2);
        let m = metrics([(&a, &a)]);
        assert_eq!((m.psnr_db(), m.off_share), (f64::INFINITY, 0.0));
    }

    #[test]
    fn pairs_weigh_by_their_pixels() {
        let (a, b) = (flat(0.0, 3), flat(1.0, 1));
        let m = metrics([(&a, &a), (&b, &flat(0.0, 1))]);
        assert_eq!((m.max_abs, m.mean_abs, m.rms), (1.0, 0.25, 0.5));
        assert_eq!(m.off_share, 0.25);
    }

    #[test]
    fn masked_pixels_count_for_nothing() {
        let (a, mut b) = (flat(0.0, 4), flat(0.0, 4));
        b.rgba[1] = [1.0; 4];
        b.rgba[2] = [0.5; 4];
        let masked = [false, true, false, false];
        let pair = Pair {
            masked: Some(&masked),
            ..Pair::from((&a, &b))
        };
        let m = metrics([pair]);
        assert_eq!(m.max_abs, 0.5);
        assert!((m.off_share - 1.0 / 3.0).abs() < 1e-12);
        let all = [true; 4];
        let pair = Pair {
            masked: Some(&all),
            ..pair
        };
        assert_eq!(metrics([pair]).max_abs, 0.0);
    }
}
