//! Heat maps: a number per pixel as a colour, with a bar that says which colour is how much.

use super::font;
use crate::scene::Picture;

/// Colours from nothing (black) to the most (white), in linear light; brightness rises throughout, so that the map reads
/// in grey too.
const STOPS: [[f32; 3]; 5] = [
    [0.0, 0.0, 0.0],
    [0.09, 0.01, 0.22],
    [0.55, 0.04, 0.10],
    [0.95, 0.42, 0.02],
    [1.0, 1.0, 0.85],
];

/// The colour of `fraction` (0 to 1; clamped), opaque.
pub fn color(fraction: f32) -> [f32; 4] {
    let x = fraction.clamp(0.0, 1.0) * (STOPS.len() - 1) as f32;
    let lower = (x.floor() as usize).min(STOPS.len() - 2);
    let f = x - lower as f32;
    let (a, b) = (STOPS[lower], STOPS[lower + 1]);
    let mix = |c: usize| a[c] + f * (b[c] - a[c]);
    [mix(0), mix(1), mix(2), 1.0]
}

/// A map of counts, row by row; `most` and above take the last colour.
///
/// # Panics
/// Where there are not `size[0] * size[1]` counts.
pub fn map(counts: &[u32], size: [u32; 2], most: u32) -> Picture {
    assert_eq!(counts.len(), (size[0] * size[1]) as usize);
    let scale = 1.0 / most.max(1) as f32;
    Picture {
        size,
        rgba: counts.iter().map(|&n| color(n as f32 * scale)).collect(),
    }
}

/// The bar of colours from 0 to `most`, with both numbers and what they count, `width` pixels wide.
pub fn legend(most: u32, what: &str, width: u32) -> Picture {
    let height = 3 * font::HEIGHT;
    let mut legend = Picture {
        size: [width, height],
        rgba: vec![[0.0, 0.0, 0.0, 1.0]; (width * height) as usize],
    };
    let last = most.to_string();
    font::draw(&mut legend, "0", 0);
    font::draw(
        &mut legend,
        what,
        width.saturating_sub(font::width(what)) / 2,
    );
    font::draw(&mut legend, &last, width.saturating_sub(font::width(&last)));
    for y in font::HEIGHT..height {
        for x in 0..width {
            let at = (y * width + x) as usize;
            legend.rgba[at] = color(x as f32 / (width - 1).max(1) as f32);
        }
    }
    legend
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_is_brighter() {
        let luminance = |p: [f32; 4]| 0.2126 * p[0] + 0.7152 * p[1] + 0.0722 * p[2];
        let bar: Vec<f32> = (0..=100)
            .map(|i| luminance(color(i as f32 / 100.0)))
            .collect();
        assert!(bar.windows(2).all(|w| w[0] < w[1]));
    }

    #[test]
    fn the_map_and_its_legend_agree() {
        let map = map(&[0, 50, 100, 200], [4, 1], 100);
        let legend = legend(100, "samples", 101);
        let last_row = &legend.rgba[legend.rgba.len() - 101..];
        assert_eq!(map.rgba[..3], [last_row[0], last_row[50], last_row[100]]);
        assert_eq!(map.rgba[3], map.rgba[2]);
    }
}
