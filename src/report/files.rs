//! The charts as SVG and PNG files, and the pictures as they are.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use super::charts::file_name;
use super::drawing::drawing;
use super::figure::Figure;
use crate::error::{Error, Result};
use crate::measure::suite::{PictureRecord, Results, What};
use crate::output::{make_folder, write_atomically};

/// Writes every chart into a folder, which is made if it is missing; gives the files.
///
/// # Errors
/// [`Error::Io`].
pub fn write_charts(figures: &[Figure], folder: &Path) -> Result<Vec<PathBuf>> {
    make_folder(folder)?;
    let mut paths = Vec::new();
    for figure in figures {
        let drawing = drawing(figure);
        for ending in ["svg", "png"] {
            let path = folder.join(format!("{}.{ending}", figure.id));
            drawing.write(&path)?;
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
    let mut paths: Vec<PathBuf> = Vec::new();
    let all = results.iter().enumerate();
    let all = all.flat_map(|(i, r)| r.pictures.iter().map(move |p| (i, p)));
    for (i, picture) in all {
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
            mode,
            block,
            size: [width, _],
            ..
        } = picture;
        let run = if results.len() > 1 {
            format!("{}-", i + 1)
        } else {
            String::new()
        };
        let name = format!("{what}-{run}{scene}-{backend}-{step}-{mode}-{block}-{width}-{method}");
        let path = folder.join(format!("{}.png", file_name(&name)));
        let bytes = STANDARD.decode(&picture.png);
        let bytes = bytes.map_err(|e| Error::file(&path, "picture", e.to_string()))?;
        write_atomically(&path, |file| file.write_all(&bytes))?;
        paths.push(path);
    }
    Ok(paths)
}
