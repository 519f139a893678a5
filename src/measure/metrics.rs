//! How far a picture is from another, or from the truth: the one place where measures of error are defined.
//!
//! All are taken on the channels as they are rendered: linear red, green and blue premultiplied by opacity, and opacity,
//! before any background, curve or quantisation. A channel's full scale is 1.
//!
//! | measure | of | unit |
//! | --- | --- | --- |
//! | [`Metrics::max_abs`] | the channel that is off most | full scale |
//! | [`Metrics::mean_abs`] | all channels | full scale |
//! | [`Metrics::rms`] | all channels | full scale |
//! | [`Metrics::psnr_db`] | the same, against a peak of full scale | decibels |
//! | [`Metrics::off_share`] | pixels with a channel off by more than 1/255 | share, 0 to 1 |
//! | [`Perceived::ssim`] | structural similarity, mean of the four channels | 1 where equal |
//! | [`Perceived::flip`] | LDR-FLIP over black or white, whichever shows more | 0 (equal) to 1 |
//!
//! Pixels that are masked count for nothing in the first five, and as equal in the last two, which look at neighbourhoods.

mod flip;
#[cfg(test)]
mod known;
mod plane;
mod ssim;

use plane::Plane;

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
    /// Mean structural similarity (Wang et al. 2004) of the four channels, at most 1: equal. Not a number (in JSON: null)
    /// where a picture is smaller than a window of 11 x 11 pixels.
    pub ssim: f64,
    /// Mean LDR-FLIP error (Andersson et al. 2020), 0 (equal) to 1: of the pictures over black and over white the larger.
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
    let Pair {
        picture,
        truth,
        masked,
    } = pair.into();
    assert_eq!(
        picture.size, truth.size,
        "pictures of one size are compared"
    );
    let shown = |i: usize| match masked {
        Some(masked) if masked[i] => truth.rgba[i],
        _ => picture.rgba[i],
    };
    let shown: Vec<[f32; 4]> = (0..picture.rgba.len()).map(shown).collect();
    let size = picture.size.map(|n| n as usize);
    let channels = [0, 1, 2, 3].map(|c: usize| {
        let [a, b] = [&shown, &truth.rgba]
            .map(|rgba| Plane::new(size, rgba.iter().map(|p| f64::from(p[c]))));
        ssim::ssim(&a, &b)
    });
    let over = |background: f64| {
        let [a, b] = [&shown, &truth.rgba].map(|rgba| {
            [0, 1, 2].map(|c: usize| {
                let behind = |p: &[f32; 4]| (1.0 - f64::from(p[3])) * background;
                Plane::new(size, rgba.iter().map(|p| f64::from(p[c]) + behind(p)))
            })
        });
        flip::flip(&a, &b)
    };
    Perceived {
        ssim: channels.iter().sum::<f64>() / 4.0,
        flip: over(0.0).max(over(1.0)),
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
    fn what_looks_alike_is_alike_and_masked_pixels_look_equal() {
        let size = [16, 16];
        let rgba = (0..256).map(|i| [i as f32 / 255.0 * 0.5; 4]).collect();
        let a = Picture { size, rgba };
        let mut b = a.clone();
        let same = perceived((&a, &b));
        assert!(
            (same.ssim - 1.0).abs() < 1e-12 && same.flip == 0.0,
            "{same:?}"
        );
        b.rgba[100] = [1.0; 4];
        let off = perceived((&b, &a));
        assert!(off.ssim < 0.99 && off.flip > 0.001, "{off:?}");
        let masked: Vec<bool> = (0..256).map(|i| i == 100).collect();
        let pair = Pair {
            masked: Some(&masked),
            ..Pair::from((&b, &a))
        };
        assert_eq!(perceived(pair), same);
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
