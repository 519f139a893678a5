//! Lines, marks and words at places of their own, as SVG or PNG.

use std::io::Write;
use std::path::Path;

use kuva::backend::raster::RasterBackend;
use kuva::backend::svg::SvgBackend;
use kuva::render::color::Color;
use kuva::render::render::{PathData, Primitive, Scene, TextAnchor};

use super::chart::{Format, PNG_SCALE, format};
use super::write_atomically;
use crate::error::{Error, Result};

/// Shapes on white, the last above the others.
#[derive(Debug, Clone)]
pub struct Drawing {
    /// Width and height in pixels of the SVG.
    pub size: [f64; 2],
    /// What is drawn.
    pub shapes: Vec<Shape>,
}

/// A shape. Places are in pixels from the upper left; colours are `#rrggbb`.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// Points, joined.
    Line {
        /// In their order.
        points: Vec<[f64; 2]>,
        /// Colour.
        color: String,
        /// In pixels.
        width: f64,
        /// Whether it has gaps.
        is_dashed: bool,
    },
    /// A closed path around a place.
    Mark {
        /// Where its origin lies.
        at: [f64; 2],
        /// In SVG's words, with capital letters.
        path: &'static str,
        /// Of its outline, and of its inside unless that is white.
        color: String,
        /// Whether its inside is white.
        is_hollow: bool,
    },
    /// Words.
    Text {
        /// Where they begin, have their middle or end, and what they stand on.
        at: [f64; 2],
        /// Which of these.
        anchor: Anchor,
        /// Height in pixels.
        size: u32,
        /// The words.
        text: String,
        /// Colour.
        color: String,
    },
}

/// What of words is at their place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// The left end.
    Start,
    /// The middle.
    Middle,
    /// The right end.
    End,
}

impl Drawing {
    /// Writes the drawing; `.svg` or `.png`.
    ///
    /// # Errors
    /// [`Error::File`] for another extension; [`Error::Io`].
    pub fn write(&self, path: &Path) -> Result<()> {
        let scene = self.scene();
        let bytes = match format(path)? {
            Format::Svg => SvgBackend::default().render_scene(&scene).into_bytes(),
            Format::Png => RasterBackend::new()
                .with_scale(PNG_SCALE)
                .render_scene(&scene)
                .map_err(|reason| Error::file(path, "drawing", reason))?,
        };
        write_atomically(path, |file| file.write_all(&bytes))
    }

    fn scene(&self) -> Scene {
        let mut scene = Scene::new(self.size[0], self.size[1]);
        scene.font_family = Some("system-ui, 'DejaVu Sans', sans-serif".to_owned());
        for shape in &self.shapes {
            match shape {
                Shape::Line {
                    points,
                    color,
                    width,
                    is_dashed,
                } => scene.add(Primitive::PolyLine {
                    points: points.iter().map(|[x, y]| (*x, *y)).collect(),
                    stroke: Color::from(color),
                    stroke_width: *width,
                    stroke_dasharray: is_dashed.then(|| "2 4".to_owned()),
                }),
                Shape::Mark {
                    at: [x, y],
                    path,
                    color,
                    is_hollow,
                } => {
                    scene.add(Primitive::GroupStart {
                        transform: Some(format!("translate({x:.1},{y:.1})")),
                        title: None,
                        extra_attrs: None,
                    });
                    let fill = if *is_hollow { "#ffffff" } else { color };
                    scene.add(Primitive::Path(Box::new(PathData {
                        d: (*path).to_owned(),
                        fill: Some(Color::from(fill)),
                        stroke: Color::from(color),
                        stroke_width: if *is_hollow { 2.0 } else { 0.5 },
                        opacity: None,
                        stroke_dasharray: None,
                    })));
                    scene.add(Primitive::GroupEnd);
                }
                Shape::Text {
                    at: [x, y],
                    anchor,
                    size,
                    text,
                    color,
                } => scene.add(Primitive::Text {
                    x: *x,
                    y: *y,
                    content: text.clone(),
                    size: *size,
                    anchor: match anchor {
                        Anchor::Start => TextAnchor::Start,
                        Anchor::Middle => TextAnchor::Middle,
                        Anchor::End => TextAnchor::End,
                    },
                    rotate: None,
                    bold: false,
                    color: Some(Color::from(color)),
                }),
            }
        }
        scene
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drawings_are_svg_or_png_and_escape_their_words() {
        let folder = tempfile::tempdir().unwrap();
        let drawing = Drawing {
            size: [60.0, 40.0],
            shapes: vec![
                Shape::Line {
                    points: vec![[0.0, 0.0], [60.0, 40.0]],
                    color: "#ff0000".to_owned(),
                    width: 3.0,
                    is_dashed: false,
                },
                Shape::Mark {
                    at: [30.0, 10.0],
                    path: "M-4,-4L4,-4L4,4L-4,4Z",
                    color: "#0000ff".to_owned(),
                    is_hollow: true,
                },
                Shape::Text {
                    at: [2.0, 30.0],
                    anchor: Anchor::Start,
                    size: 10,
                    text: "a < b".to_owned(),
                    color: "#000000".to_owned(),
                },
            ],
        };
        let path = folder.path().join("d.svg");
        drawing.write(&path).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(
            text.contains("a &lt; b") && text.contains("#ff0000"),
            "{text}"
        );
        let path = folder.path().join("d.png");
        drawing.write(&path).unwrap();
        let picture = image::open(&path).unwrap().to_rgb8();
        assert_eq!(picture.dimensions(), (120, 80));
        assert_eq!(picture.get_pixel(30, 20).0, [255, 0, 0]);
        assert_eq!(picture.get_pixel(60, 20).0, [255, 255, 255]);
        assert!(drawing.write(&folder.path().join("d.gif")).is_err());
    }
}
