//! Line charts as SVG or PNG: beside `drawing.rs` the one place that knows the charting crate.

use std::io::Write;
use std::path::Path;

use kuva::backend::raster::RasterBackend;
use kuva::backend::svg::SvgBackend;
use kuva::plot::{LinePlot, ScatterPlot};
use kuva::render::figure::{Figure, FigureLegendPosition};
use kuva::render::layout::{Layout, TickFormat};
use kuva::render::plots::Plot;

use super::write_atomically;
use crate::error::{Error, Result};

/// Panels side by side that share their lines' names and colours.
#[derive(Debug, Clone)]
pub struct Chart {
    /// Over the whole.
    pub title: String,
    /// From left to right, two in a row.
    pub panels: Vec<Panel>,
}

/// One pair of axes.
#[derive(Debug, Clone)]
pub struct Panel {
    /// What is across, with its unit.
    pub x_label: String,
    /// What is upwards, with its unit.
    pub y_label: String,
    /// Whether equal lengths across are equal ratios. Numbers that are not positive are then left out.
    pub log_x: bool,
    /// The same upwards.
    pub log_y: bool,
    /// The lines; one of a name has one colour in all panels.
    pub lines: Vec<Line>,
}

/// Numbers over numbers.
#[derive(Debug, Clone)]
pub struct Line {
    /// In the legend. Lines whose names differ in what stands in parentheses alone have one colour, in different strokes.
    pub name: String,
    /// `[x, y]`, joined in this order.
    pub points: Vec<[f64; 2]>,
}

/// Colours on white that are told apart with any kind of sight (after Okabe & Ito 2008), then others: as many as there are
/// methods with auto.
pub const COLORS: [&str; 13] = [
    "#1d2126", "#c77c02", "#2d8fc9", "#00875f", "#c8501a", "#b0578c", "#1559a8", "#8a7f00",
    "#7d7d7d", "#6d3fb0", "#7a4a2a", "#2f7d32", "#d0246e",
];

/// The most points of a line that are marked.
const MARKED: usize = 16;

/// A name before its parentheses.
fn stem(name: &str) -> &str {
    name.split(" (").next().unwrap_or(name)
}

/// What stands in a name's parentheses.
fn kind(name: &str) -> &str {
    name.split_once(" (").map_or("", |(_, kind)| kind)
}

/// Width and height of a panel in pixels of the SVG.
const PANEL: [f64; 2] = [520.0, 340.0];

/// Pixels of a PNG per pixel of the SVG.
pub(super) const PNG_SCALE: f32 = 2.0;

/// Checks that a chart's file has a name that says its format.
///
/// # Errors
/// [`Error::File`] where it ends on neither `.svg` nor `.png`.
pub fn check_path(path: &Path) -> Result<()> {
    format(path).map(|_| ())
}

pub(super) enum Format {
    Svg,
    Png,
}

pub(super) fn format(path: &Path) -> Result<Format> {
    match path.extension().and_then(|e| e.to_str()) {
        Some("svg") => Ok(Format::Svg),
        Some("png") => Ok(Format::Png),
        _ => Err(Error::file(path, "extension", "expected .svg or .png")),
    }
}

impl Chart {
    /// Writes the chart; `.svg` or `.png`.
    ///
    /// # Errors
    /// [`Error::File`] for another extension; [`Error::Io`].
    pub fn write(&self, path: &Path) -> Result<()> {
        let bytes = match format(path)? {
            Format::Svg => SvgBackend::default()
                .render_scene(&self.figure().render())
                .into_bytes(),
            Format::Png => RasterBackend::new()
                .with_scale(PNG_SCALE)
                .render_scene(&self.figure().render())
                .map_err(|reason| Error::file(path, "chart", reason))?,
        };
        write_atomically(path, |file| file.write_all(&bytes))
    }

    /// What the names of all lines say before their parentheses, or in them, each once.
    fn parts(&self, part: fn(&str) -> &str) -> Vec<&str> {
        let mut parts: Vec<&str> = Vec::new();
        for line in self.panels.iter().flat_map(|p| &p.lines) {
            if !parts.contains(&part(&line.name)) {
                parts.push(part(&line.name));
            }
        }
        parts
    }

    fn figure(&self) -> Figure {
        let (stems, kinds) = (self.parts(stem), self.parts(kind));
        let place = |parts: &[&str], part: &str| parts.iter().position(|p| *p == part).unwrap_or(0);
        let color = |name: &str| COLORS[place(&stems, stem(name)) % COLORS.len()];
        let mut plots = Vec::new();
        let mut layouts = Vec::new();
        for panel in &self.panels {
            let mut lines: Vec<Plot> = Vec::new();
            for line in &panel.lines {
                let is_shown =
                    |p: &&[f64; 2]| (!panel.log_x || p[0] > 0.0) && (!panel.log_y || p[1] > 0.0);
                let points = line.points.iter().filter(is_shown).map(|p| (p[0], p[1]));
                let plot = LinePlot::new()
                    .with_data(points.clone())
                    .with_color(color(&line.name))
                    .with_stroke_width(2.0)
                    .with_legend(&line.name);
                lines.push(Plot::Line(match place(&kinds, kind(&line.name)) % 4 {
                    0 => plot,
                    1 => plot.with_dashed(),
                    2 => plot.with_dotted(),
                    _ => plot.with_dashdot(),
                }));
                // Few points are marked: one alone makes no line.
                if line.points.len() <= MARKED {
                    let marks = ScatterPlot::new().with_data(points).with_size(3.0);
                    lines.push(Plot::Scatter(marks.with_color(color(&line.name))));
                }
            }
            let mut layout = Layout::auto_from_plots(&lines)
                .with_x_label(&panel.x_label)
                .with_y_label(&panel.y_label);
            if panel.log_x {
                layout = layout.with_log_x();
            }
            if panel.log_y {
                layout = layout.with_log_y();
            }
            plots.push(lines);
            layouts.push(layout.with_tick_format(TickFormat::Auto));
        }
        let columns = self.panels.len().clamp(1, 2);
        let rows = self.panels.len().div_ceil(columns);
        Figure::new(rows, columns)
            .with_title(&self.title)
            .with_plots(plots)
            .with_layouts(layouts)
            .with_cell_size(PANEL[0], PANEL[1])
            .with_shared_legend_position(FigureLegendPosition::Bottom)
    }
}
