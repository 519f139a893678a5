//! The charts as SVG and PNG files.

use std::path::{Path, PathBuf};

use super::figure::{Figure, Series};
use crate::error::{Error, Result};
use crate::output::chart::{Chart, Line, Panel};

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
