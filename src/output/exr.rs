//! OpenEXR: f32 channels, linear, premultiplied, as that format has it.

use std::io::{self, Seek, Write};

use exr::prelude::{
    Encoding, Image, Layer, LayerAttributes, SpecificChannels, Vec2, WritableImage,
};

use crate::scene::Picture;

/// Writes one layer with the channels R, G, B and A, compressed without loss.
pub(super) fn encode(picture: &Picture, file: &mut (impl Write + Seek)) -> io::Result<()> {
    let size = Vec2(picture.size[0] as usize, picture.size[1] as usize);
    let channels = SpecificChannels::rgba(|position: Vec2<usize>| {
        let [r, g, b, a] = picture.rgba[position.y() * size.x() + position.x()];
        (r, g, b, a)
    });
    let layer = Layer::new(
        size,
        LayerAttributes::default(),
        Encoding::SMALL_FAST_LOSSLESS,
        channels,
    );
    Image::from_layer(layer)
        .write()
        .non_parallel()
        .to_buffered(file)
        .map_err(|e| match e {
            exr::error::Error::Io(e) => e,
            other => io::Error::other(other.to_string()),
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use exr::prelude::{ReadChannels, ReadLayers, read};

    #[test]
    fn every_bit_comes_back() {
        let picture = Picture {
            size: [5, 3],
            rgba: (0..15)
                .map(|i| [i as f32 * 0.1, 1e-30, 3.0, (i as f32).sqrt() / 4.0])
                .collect(),
        };
        let mut bytes = io::Cursor::new(Vec::new());
        encode(&picture, &mut bytes).unwrap();
        let image = read()
            .no_deep_data()
            .largest_resolution_level()
            .rgba_channels(
                |size, _| Picture {
                    size: [size.x() as u32, size.y() as u32],
                    rgba: vec![[0.0; 4]; size.area()],
                },
                |picture, position, (r, g, b, a): (f32, f32, f32, f32)| {
                    let at = position.y() * picture.size[0] as usize + position.x();
                    picture.rgba[at] = [r, g, b, a];
                },
            )
            .first_valid_layer()
            .all_attributes()
            .from_buffered(io::Cursor::new(bytes.into_inner()))
            .unwrap();
        assert_eq!(image.layer_data.channel_data.pixels, picture);
    }
}
