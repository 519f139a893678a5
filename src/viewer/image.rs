//! Pictures as the window shows them: encoded for a screen, before a backdrop.

use std::sync::LazyLock;

use eframe::egui::{Color32, ColorImage};
use rayon::prelude::*;

use crate::output::{heat, linear_from_srgb};
use crate::scene::Picture;

/// Steps of the table from linear light to sRGB: fine enough that dark tones are within one of 255.
const STEPS: usize = 1 << 14;

static SRGB: LazyLock<Vec<u8>> = LazyLock::new(|| {
    // Inverts the one curve that there is: the first byte whose linear value, half a step up, is not reached.
    let mut byte = 0u8;
    let middle = |byte: u8| linear_from_srgb((f64::from(byte) + 0.5) / 255.0);
    (0..=STEPS)
        .map(|i| {
            let linear = i as f64 / STEPS as f64;
            while byte < 255 && linear > middle(byte) {
                byte += 1;
            }
            byte
        })
        .collect()
});

fn encoded(linear: f32) -> u8 {
    SRGB[(linear.clamp(0.0, 1.0) * STEPS as f32 + 0.5) as usize]
}

/// A picture before a backdrop (linear), as bytes for the screen.
pub fn shown(picture: &Picture, backdrop: [f32; 3]) -> ColorImage {
    let table = &*SRGB;
    debug_assert_eq!(table.len(), STEPS + 1);
    let pixel = |p: &[f32; 4]| {
        let behind = 1.0 - p[3];
        let [r, g, b] = std::array::from_fn(|c| encoded(p[c] + behind * backdrop[c]));
        Color32::from_rgb(r, g, b)
    };
    let pixels = picture.rgba.par_iter().with_min_len(1 << 14).map(pixel);
    ColorImage::new(picture.size.map(|n| n as usize), pixels.collect())
}

/// Where two pictures of one size differ, and how much: the largest difference of a channel as heat, `gain` times.
///
/// # Panics
/// Where sizes differ.
pub fn difference(a: &Picture, b: &Picture, gain: f32) -> ColorImage {
    assert_eq!(a.size, b.size, "pictures of one size are compared");
    let apart = |(a, b): (&[f32; 4], &[f32; 4])| {
        let most = (0..4).fold(0.0f32, |m, c| m.max((a[c] - b[c]).abs()));
        heat::color(most * gain)
    };
    let picture = Picture {
        size: a.size,
        rgba: a.rgba.iter().zip(&b.rgba).map(apart).collect(),
    };
    shown(&picture, [0.0; 3])
}

/// Samples per pixel as heat.
pub fn heat(counts: &[u32], size: [u32; 2], most: u32) -> ColorImage {
    shown(&heat::map(counts, size, most), [0.0; 3])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_is_encoded_from_its_own_linear_value() {
        for byte in 0..=255u8 {
            let linear = linear_from_srgb(f64::from(byte) / 255.0) as f32;
            assert!(encoded(linear).abs_diff(byte) <= 1, "{byte}");
        }
        assert_eq!([encoded(0.0), encoded(1.0), encoded(7.0)], [0, 255, 255]);
    }

    #[test]
    fn what_is_transparent_shows_the_backdrop() {
        let picture = Picture {
            size: [2, 1],
            rgba: vec![[0.0; 4], [1.0, 0.0, 0.0, 1.0]],
        };
        let image = shown(&picture, [0.0, 1.0, 0.0]);
        assert_eq!(
            image.pixels,
            [Color32::from_rgb(0, 255, 0), Color32::from_rgb(255, 0, 0)]
        );
        let same = difference(&picture, &picture, 1000.0);
        assert!(same.pixels.iter().all(|p| *p == Color32::BLACK));
    }
}
