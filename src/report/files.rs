//! The charts as SVG and PNG files, and the pictures as they are.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use super::charts::file_name;
use super::figure::{Figure, Series};
use crate::error::{Error, Result};
use crate::measure::suite::{PictureRecord, Results, What};
use crate::output::chart::{Chart, Line, Panel};
use crate::output::write_atomically;

/// Writes every chart into a folder, which is made if it is missing; gives the files.
///
/// # Errors
/// [`Error::Io`].
pub fn write_charts(figures: &[Figure], folder: &Path) -> Result<Vec<PathBuf>> {
    std::fs::create_dir_all(folder).map_err(|e| Error::io(folder, e))?;
    let mut paths = Vec::new();
    for figure in figures {
        let chart = chart(figure);
        for ending in ["svg", "png"] {
            let path = folder.join(format!("{}.{ending}", figure.id));
            chart.write(&path)?;
            paths.push(path);
        }
    }
    Ok(paths)
}

/// Writes every picture into a folder that is there; gives the files.
///
/// # Errors
/// [`Error::Io`]; [`Error::File`] where the results hold no picture in its place.
pub fn write_pictures(results: &[Results], folder: &Path) -> Result<Vec<PathBuf>> {
    let mut paths = Vec::new();
    for picture in results.iter().flat_map(|r| &r.pictures) {
        let what = match picture.what {
            What::Picture => "picture",
            What::Difference => "difference",
            What::Samples => "samples",
        };
        let PictureRecord {
            scene,
            backend,
            step,
            method,
            ..
        } = picture;
        let name = format!("{what}-{scene}-{backend}-{step}-{method}");
        let path = folder.join(format!("{}.png", file_name(&name)));
        let bytes = STANDARD.decode(&picture.png);
        let bytes = bytes.map_err(|e| Error::file(&path, "picture", e.to_string()))?;
        write_atomically(&path, |file| file.write_all(&bytes))?;
        paths.push(path);
    }
    Ok(paths)
}

fn chart(figure: &Figure) -> Chart {
    let name = |series: &Series| format!("{} ({})", series.method, series.kind);
    let mut lines: Vec<Line> = figure
        .series
        .iter()
        .map(|series| Line {
            name: name(series),
            points: series.points.iter().map(|p| [p.x, p.y]).collect(),
        })
        .collect();
    if !figure.front.is_empty() {
        lines.push(Line {
            name: "Pareto front".to_owned(),
            points: figure.front.clone(),
        });
    }
    Chart {
        title: figure.title.clone(),
        panels: vec![Panel {
            x_label: figure.x.label.clone(),
            y_label: figure.y.label.clone(),
            log_x: figure.x.log,
            log_y: figure.y.log,
            lines,
        }],
    }
}
