//! Pictures as files: PNG for looking at, `.npy` and `.exr` for computing with.
//!
//! A [`Picture`] is linear and premultiplied by opacity. `.npy` and `.exr` keep it so, in f32, bit for bit; PNG holds
//! straight (not premultiplied) colour as its specification asks, sRGB-encoded or linear, in 8 or 16 bits. A background
//! is composited before anything is encoded, in linear light.

pub mod chart;
pub mod drawing;
mod exr;
mod font;
pub mod heat;
mod npy;
mod png;

use std::path::Path;

pub use crate::atomic_file::write_atomically;
pub use png::{Curve, Depth, linear_from_srgb, srgb_from_linear};

use crate::error::{Error, Result};
use crate::scene::Picture;

/// A file format of pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Portable Network Graphics, RGBA, straight alpha.
    Png,
    /// NumPy array of shape (height, width, 4), little-endian f32, linear, premultiplied.
    Npy,
    /// OpenEXR with f32 channels R, G, B, A, linear, premultiplied.
    Exr,
}

impl Format {
    /// All formats.
    pub const ALL: &[Self] = &[Self::Png, Self::Npy, Self::Exr];

    /// The file name extension, without the dot.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Npy => "npy",
            Self::Exr => "exr",
        }
    }

    /// The format that a file name asks for by its extension, in any case of letters.
    ///
    /// # Errors
    /// [`Error::File`] that lists the known extensions.
    pub fn from_path(path: &Path) -> Result<Self> {
        let extension = path.extension().unwrap_or_default().to_string_lossy();
        Self::ALL
            .iter()
            .copied()
            .find(|f| extension.eq_ignore_ascii_case(f.extension()))
            .ok_or_else(|| {
                let known: Vec<_> = Self::ALL
                    .iter()
                    .map(|f| format!(".{}", f.extension()))
                    .collect();
                Error::file(
                    path,
                    "extension",
                    format!(
                        "no picture format of that name; known are {}",
                        known.join(", ")
                    ),
                )
            })
    }
}

/// How a PNG stores colours. The other formats have one way only.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PngEncoding {
    /// Bits per channel.
    pub depth: Depth,
    /// Curve of red, green and blue; opacity is always linear.
    pub curve: Curve,
}

impl Default for PngEncoding {
    fn default() -> Self {
        Self {
            depth: Depth::Eight,
            curve: Curve::Srgb,
        }
    }
}

/// Writes a picture, in the format of the path's extension, complete or not at all.
///
/// # Errors
/// [`Error::File`] for an unknown extension, [`Error::Io`] where the file cannot be written; an older file of that name
/// is then still what it was.
pub fn write(picture: &Picture, path: &Path, encoding: PngEncoding) -> Result<()> {
    let format = Format::from_path(path)?;
    write_atomically(path, |file| match format {
        Format::Png => png::encode(picture, encoding, file),
        Format::Npy => npy::encode(picture, file),
        Format::Exr => exr::encode(picture, file),
    })
}

/// A picture as the bytes of a PNG.
///
/// # Panics
/// Never: memory takes all that is written.
pub fn png_bytes(picture: &Picture, encoding: PngEncoding) -> Vec<u8> {
    let mut bytes = Vec::new();
    png::encode(picture, encoding, &mut bytes).expect("memory takes all that is written");
    bytes
}

/// The picture in front of an opaque background (linear red, green, blue).
pub fn over(picture: &Picture, background: [f32; 3]) -> Picture {
    let pixel = |p: &[f32; 4]| {
        let behind = 1.0 - p[3];
        [
            p[0] + behind * background[0],
            p[1] + behind * background[1],
            p[2] + behind * background[2],
            1.0,
        ]
    };
    Picture {
        size: picture.size,
        rgba: picture.rgba.iter().map(pixel).collect(),
    }
}

/// Pictures of one height next to each other, with `gap` pixels of nothing between them.
///
/// # Panics
/// Where heights differ or there is no picture.
pub fn side_by_side(pictures: &[Picture], gap: u32) -> Picture {
    let height = pictures[0].size[1];
    assert!(
        pictures.iter().all(|p| p.size[1] == height),
        "pictures of one height stand side by side"
    );
    let mut rgba = Vec::new();
    for y in 0..height as usize {
        for (i, p) in pictures.iter().enumerate() {
            if i > 0 {
                rgba.extend(std::iter::repeat_n([0.0; 4], gap as usize));
            }
            let width = p.size[0] as usize;
            rgba.extend_from_slice(&p.rgba[y * width..(y + 1) * width]);
        }
    }
    let width = pictures.iter().map(|p| p.size[0]).sum::<u32>() + gap * (pictures.len() as u32 - 1);
    Picture {
        size: [width, height],
        rgba,
    }
}

/// Makes a folder for files where it is missing.
///
/// # Errors
/// [`Error::File`] where there is something else of that name, [`Error::Io`].
pub fn make_folder(folder: &Path) -> Result<()> {
    if folder.exists() && !folder.is_dir() {
        return Err(Error::file(folder, "output", "is no folder"));
    }
    std::fs::create_dir_all(folder).map_err(|e| Error::io(folder, e))
}

/// A picture whose pixels are squares of so many that its longer edge is no shorter than `edge`.
pub fn enlarged(picture: &Picture, edge: u32) -> Picture {
    let [width, height] = picture.size;
    let times = edge.div_ceil(width.max(height).max(1)).max(1);
    let rows = (0..height * times).flat_map(|y| {
        let row = (y / times * width) as usize;
        (0..width * times).map(move |x| picture.rgba[row + (x / times) as usize])
    });
    Picture {
        size: [width * times, height * times],
        rgba: rows.collect(),
    }
}

/// Pictures of one width below each other.
///
/// # Panics
/// Where widths differ or there is no picture.
pub fn stacked(pictures: &[Picture]) -> Picture {
    let width = pictures[0].size[0];
    assert!(
        pictures.iter().all(|p| p.size[0] == width),
        "pictures of one width are stacked"
    );
    Picture {
        size: [width, pictures.iter().map(|p| p.size[1]).sum()],
        rgba: pictures
            .iter()
            .flat_map(|p| p.rgba.iter().copied())
            .collect(),
    }
}

/// A strip with a line of text in white on black, `width` pixels wide.
pub fn caption(text: &str, width: u32) -> Picture {
    let mut strip = Picture {
        size: [width, font::HEIGHT],
        rgba: vec![[0.0, 0.0, 0.0, 1.0]; (width * font::HEIGHT) as usize],
    };
    let left = width.saturating_sub(font::width(text)) / 2;
    font::draw(&mut strip, text, left);
    strip
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_background_shows_where_and_as_far_as_the_picture_is_transparent() {
        let picture = Picture {
            size: [3, 1],
            rgba: vec![[0.0; 4], [0.25, 0.0, 0.0, 0.5], [0.2, 0.3, 0.4, 1.0]],
        };
        assert_eq!(
            over(&picture, [0.5, 1.0, 0.0]).rgba,
            [
                [0.5, 1.0, 0.0, 1.0],
                [0.5, 0.5, 0.0, 1.0],
                [0.2, 0.3, 0.4, 1.0]
            ]
        );
    }

    #[test]
    fn an_unknown_extension_is_answered_with_the_known_ones() {
        for name in ["picture.jpg", "picture"] {
            let message = Format::from_path(Path::new(name)).unwrap_err().to_string();
            assert!(
                message.starts_with(name)
                    && [".png", ".npy", ".exr"].iter().all(|e| message.contains(e)),
                "{message}"
            );
        }
        assert_eq!(Format::from_path(Path::new("A.PNG")).unwrap(), Format::Png);
    }

    #[test]
    fn an_enlarged_picture_has_each_pixel_as_a_square() {
        let [dark, light] = [[0.0; 4], [1.0; 4]];
        let pair = Picture {
            size: [2, 1],
            rgba: vec![dark, light],
        };
        let large = enlarged(&pair, 3);
        assert_eq!(large.size, [4, 2]);
        let row = [dark, dark, light, light];
        assert_eq!(large.rgba, [row, row].concat());
        assert_eq!(enlarged(&large, 1), large);
    }

    #[test]
    fn pictures_keep_their_pixels_when_joined() {
        let of = |size: [u32; 2], v: f32| Picture {
            size,
            rgba: vec![[v; 4]; (size[0] * size[1]) as usize],
        };
        let row = side_by_side(&[of([2, 2], 1.0), of([1, 2], 2.0)], 1);
        assert_eq!(row.size, [4, 2]);
        let first: Vec<f32> = row.rgba.iter().map(|p| p[0]).collect();
        assert_eq!(first, [1.0, 1.0, 0.0, 2.0, 1.0, 1.0, 0.0, 2.0]);
        let column = stacked(&[of([1, 2], 1.0), of([1, 1], 2.0)]);
        assert_eq!(column.size, [1, 3]);
        assert_eq!(column.rgba[2], [2.0; 4]);
    }
}
