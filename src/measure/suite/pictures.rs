//! Pictures for the report: what methods draw, how far that is from the truth, and what it takes.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use super::record::{PictureRecord, What};
use crate::error::Result;
use crate::measure::truth::Truth;
use crate::output::{self, PngEncoding, heat};
use crate::render::{Renderer, Settings};
use crate::scene::Picture;

/// Behind the pictures, linear.
const BACKGROUND: [f32; 3] = [0.01, 0.011, 0.013];

/// A method whose pictures are shown.
#[derive(Debug, Clone)]
pub struct Shown {
    /// The command that draws it again.
    pub command: String,
    /// The method's name.
    pub method: String,
    /// What it is drawn with.
    pub settings: Settings,
}

/// The truth, then for each method what it draws, the difference from the truth, amplified as it needs, and the samples, all
/// on one scale.
/// Of `about`, scene, backend, step and the truth's command are taken.
///
/// # Errors
/// Whatever the renderer reports.
pub fn pictures(
    renderer: &mut Renderer,
    shown: &[Shown],
    truth: &Truth,
    about: &PictureRecord,
) -> Result<Vec<PictureRecord>> {
    let mut records = vec![PictureRecord {
        method: "truth".to_owned(),
        what: What::Picture,
        scale: 1.0,
        size: truth.picture.size,
        png: png(&output::over(&truth.picture, BACKGROUND)),
        ..about.clone()
    }];
    let counted = shown
        .iter()
        .map(|s| renderer.count(&s.settings))
        .collect::<Result<Vec<_>>>()?;
    let most = counted
        .iter()
        .flat_map(|c| &c.samples)
        .copied()
        .max()
        .unwrap_or(0);
    for (shown, counted) in shown.iter().zip(&counted) {
        let size = counted.picture.size;
        let difference = difference(&counted.picture, truth);
        let amplification =
            amplification(f64::from(difference.iter().copied().fold(0.0, f32::max)));
        let difference = amplified(&difference, size, amplification as f32);
        for (what, scale, picture) in [
            (
                What::Picture,
                1.0,
                output::over(&counted.picture, BACKGROUND),
            ),
            (What::Difference, amplification, difference),
            (
                What::Samples,
                f64::from(most),
                heat::map(&counted.samples, size, most),
            ),
        ] {
            records.push(PictureRecord {
                command: shown.command.clone(),
                method: shown.method.clone(),
                what,
                scale,
                size,
                png: png(&picture),
                ..about.clone()
            });
        }
    }
    Ok(records)
}

/// The power of ten, at least 1, that brings the largest difference to between a tenth and all of full scale.
fn amplification(largest: f64) -> f64 {
    if largest > 0.0 {
        10.0f64.powf((1.0 / largest).log10().floor()).max(1.0)
    } else {
        1.0
    }
}

/// The largest absolute difference of each pixel's channels; 0 where the truth is masked, as in every other measure.
fn difference(picture: &Picture, truth: &Truth) -> Vec<f32> {
    let pixels = picture.rgba.iter().zip(&truth.picture.rgba);
    let pixel = |((a, b), masked): ((&[f32; 4], &[f32; 4]), &bool)| {
        let channels = a.iter().zip(b).map(|(x, y)| (x - y).abs());
        if *masked {
            0.0
        } else {
            channels.fold(0.0, f32::max)
        }
    };
    pixels.zip(&truth.masked).map(pixel).collect()
}
/// The same as grey, amplified.
fn amplified(difference: &[f32], size: [u32; 2], amplification: f32) -> Picture {
    let pixel = |d: &f32| {
        let grey = (d * amplification).min(1.0);
        [grey, grey, grey, 1.0]
    };
    Picture {
        size,
        rgba: difference.iter().map(pixel).collect(),
    }
}

fn png(picture: &Picture) -> String {
    STANDARD.encode(output::png_bytes(picture, PngEncoding::default()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_amplified_by_powers_of_ten_to_full_scale_at_most() {
        for (largest, expected) in [
            (0.3, 1.0),
            (0.03, 10.0),
            (0.1, 10.0),
            (7e-5, 1e4),
            (0.0, 1.0),
            (2.0, 1.0),
        ] {
            assert_eq!(amplification(largest), expected, "{largest}");
        }
    }
}
