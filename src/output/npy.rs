//! NumPy's array file, version 1.0 (format: numpy.lib.format), for `numpy.load`.

use std::io::{self, Write};

use crate::scene::Picture;

/// Writes shape (height, width, 4), little-endian f32, C order.
pub(super) fn encode(picture: &Picture, file: &mut impl Write) -> io::Result<()> {
    let [width, height] = picture.size;
    let mut header =
        format!("{{'descr': '<f4', 'fortran_order': False, 'shape': ({height}, {width}, 4), }}");
    // Magic (6), version (2), length (2) and header together fill multiples of 64 bytes; the header ends in a newline.
    let padding = (64 - (10 + header.len() + 1) % 64) % 64;
    header.push_str(&" ".repeat(padding));
    header.push('\n');
    file.write_all(b"\x93NUMPY\x01\x00")?;
    file.write_all(&(header.len() as u16).to_le_bytes())?;
    file.write_all(header.as_bytes())?;
    for channel in picture.rgba.as_flattened() {
        file.write_all(&channel.to_le_bytes())?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_data_start_aligned_and_are_the_pictures_bits() {
        for size in [[1, 1], [3, 2], [1000, 1]] {
            let pixels = (size[0] * size[1]) as usize;
            let picture = Picture {
                size,
                rgba: (0..pixels)
                    .map(|i| [i as f32 * 0.1, -0.0, f32::MIN_POSITIVE, 1e30])
                    .collect(),
            };
            let mut bytes = Vec::new();
            encode(&picture, &mut bytes).unwrap();
            let start = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
            assert_eq!(start % 64, 0);
            assert_eq!(bytes[start - 1], b'\n');
            let header = String::from_utf8(bytes[10..start].to_vec()).unwrap();
            assert!(header.contains(&format!("'shape': ({}, {}, 4)", size[1], size[0])));
            let data: Vec<u32> = bytes[start..]
                .chunks_exact(4)
                .map(|c| u32::from_le_bytes([c[0], c[1], c[2], c[3]]))
                .collect();
            let expected: Vec<u32> = picture.rgba.iter().flatten().map(|c| c.to_bits()).collect();
            assert_eq!(data, expected);
        }
    }
}
