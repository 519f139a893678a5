//! PNG: straight colour and opacity, 8 or 16 bits, sRGB-encoded or linear, and marked as such.

use std::io::{self, Write};

use png::{BitDepth, ColorType, Encoder, ScaledFloat, SrgbRenderingIntent};

use super::PngEncoding;
use crate::scene::Picture;

/// Bits per channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Depth {
    /// 8 bits.
    Eight,
    /// 16 bits.
    Sixteen,
}

/// What the numbers of red, green and blue mean. Opacity is linear with either.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Curve {
    /// IEC 61966-2-1; marked by an sRGB chunk.
    Srgb,
    /// Linear light; marked by a gAMA chunk of 1.
    Linear,
}

impl Curve {
    fn encode(self, linear: f64) -> f64 {
        match self {
            Self::Srgb => srgb_from_linear(linear),
            Self::Linear => linear,
        }
    }
}

/// The sRGB curve (IEC 61966-2-1) of a linear value in 0 to 1.
pub fn srgb_from_linear(linear: f64) -> f64 {
    if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    }
}

/// The linear value of an sRGB-encoded one in 0 to 1 (IEC 61966-2-1).
pub fn linear_from_srgb(encoded: f64) -> f64 {
    if encoded <= 0.040_45 {
        encoded / 12.92
    } else {
        ((encoded + 0.055) / 1.055).powf(2.4)
    }
}

/// Straight, encoded channels in 0 to 1 of a linear, premultiplied pixel. What is brighter than 1 becomes 1.
fn straight(pixel: [f32; 4], curve: Curve) -> [f64; 4] {
    let alpha = f64::from(pixel[3]).clamp(0.0, 1.0);
    let color = |c: f32| {
        if alpha > 0.0 {
            curve.encode((f64::from(c) / alpha).clamp(0.0, 1.0))
        } else {
            0.0
        }
    };
    [color(pixel[0]), color(pixel[1]), color(pixel[2]), alpha]
}

/// Writes an RGBA picture, each channel rounded to the nearest step.
pub(super) fn encode(
    picture: &Picture,
    encoding: PngEncoding,
    file: &mut impl Write,
) -> io::Result<()> {
    let mut encoder = Encoder::new(file, picture.size[0], picture.size[1]);
    encoder.set_color(ColorType::Rgba);
    let meaning = match encoding.curve {
        Curve::Srgb => {
            encoder.set_source_srgb(SrgbRenderingIntent::RelativeColorimetric);
            "sRGB colour, straight alpha"
        }
        Curve::Linear => {
            encoder.set_source_gamma(ScaledFloat::new(1.0));
            "linear colour, straight alpha"
        }
    };
    encoder.add_text_chunk("Comment".to_owned(), meaning.to_owned())?;
    let software = concat!("hollowcast ", env!("CARGO_PKG_VERSION"));
    encoder.add_text_chunk("Software".to_owned(), software.to_owned())?;

    let channels = picture
        .rgba
        .iter()
        .flat_map(|&pixel| straight(pixel, encoding.curve));
    let bytes: Vec<u8> = match encoding.depth {
        Depth::Eight => {
            encoder.set_depth(BitDepth::Eight);
            channels.map(|c| (c * 255.0).round() as u8).collect()
        }
        Depth::Sixteen => {
            encoder.set_depth(BitDepth::Sixteen);
            channels
                .flat_map(|c| ((c * 65535.0).round() as u16).to_be_bytes())
                .collect()
        }
    };
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&bytes)?;
    writer.finish()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a decoder that is not ours makes of the picture: header and bytes.
    fn decoded(picture: &Picture, depth: Depth, curve: Curve) -> (png::Info<'static>, Vec<u8>) {
        let mut bytes = Vec::new();
        encode(picture, PngEncoding { depth, curve }, &mut bytes).unwrap();
        let mut reader = png::Decoder::new(io::Cursor::new(bytes))
            .read_info()
            .unwrap();
        let mut data = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut data).unwrap();
        (reader.info().clone(), data)
    }

    #[test]
    fn known_linear_values_become_known_bytes() {
        // Linear 0.21404 is sRGB 0.5 (IEC 61966-2-1); 0.5 linear is sRGB 0.73536.
        let picture = Picture {
            size: [4, 1],
            rgba: vec![
                [0.214_041_14, 0.5, 1.0, 1.0],
                // Half opaque: the same colours, premultiplied.
                [0.107_020_57, 0.25, 0.5, 0.5],
                [0.0; 4],
                // More light than the file holds.
                [2.0, 0.0, 0.001, 1.0],
            ],
        };
        let (_, bytes) = decoded(&picture, Depth::Eight, Curve::Srgb);
        assert_eq!(bytes[..4], [128, 188, 255, 255]);
        assert_eq!(bytes[4..8], [128, 188, 255, 128]);
        assert_eq!(bytes[8..12], [0; 4]);
        assert_eq!(bytes[12..], [255, 0, 3, 255]);
        let (_, bytes) = decoded(&picture, Depth::Eight, Curve::Linear);
        assert_eq!(bytes[..8], [55, 128, 255, 255, 55, 128, 255, 128]);
        let (_, bytes) = decoded(&picture, Depth::Sixteen, Curve::Linear);
        let wide: Vec<u16> = bytes
            .chunks_exact(2)
            .map(|b| u16::from_be_bytes([b[0], b[1]]))
            .collect();
        assert_eq!(wide[..4], [14027, 32768, 65535, 65535]);
    }

    #[test]
    fn the_file_says_what_its_numbers_mean() {
        let picture = Picture {
            size: [1, 1],
            rgba: vec![[0.5; 4]],
        };
        let comment = |info: &png::Info| {
            info.uncompressed_latin1_text
                .iter()
                .find(|t| t.keyword == "Comment")
                .unwrap()
                .text
                .clone()
        };
        let (info, _) = decoded(&picture, Depth::Eight, Curve::Srgb);
        assert!(info.srgb.is_some());
        assert_eq!(comment(&info), "sRGB colour, straight alpha");
        let (info, _) = decoded(&picture, Depth::Sixteen, Curve::Linear);
        assert!(info.srgb.is_none());
        assert_eq!(info.gama_chunk.unwrap().into_scaled(), 100_000);
        assert_eq!(comment(&info), "linear colour, straight alpha");
    }

    #[test]
    fn the_curve_is_monotonic_keeps_its_ends_and_has_an_inverse() {
        let values: Vec<f64> = (0..=1000)
            .map(|i| srgb_from_linear(f64::from(i) / 1000.0))
            .collect();
        assert!(values.windows(2).all(|w| w[0] < w[1]));
        assert_eq!(values[0], 0.0);
        assert!((values[1000] - 1.0).abs() < 1e-12);
        for (i, encoded) in values.into_iter().enumerate() {
            // The two pieces of the standard's curve meet to 1e-7 only.
            assert!((linear_from_srgb(encoded) - i as f64 / 1000.0).abs() < 1e-7);
        }
    }
}
