//! Results as a page that a browser shows without a network, and as chart files.

mod atlas;
mod charts;
pub mod figure;
mod files;
mod model;
mod number;
mod page;
mod papers;
mod svg;
mod tables;

use std::io::Write as _;
use std::path::Path;

pub use atlas::Atlas;
pub use files::{write_charts, write_pictures};

use self::figure::Figure;
use self::model::Model;
use crate::error::Result;
use crate::measure::suite::Results;
use crate::output::write_atomically;

/// Writes the page of these results and of what hazards showed, and gives its charts.
///
/// # Errors
/// [`crate::Error::Io`].
pub fn write(results: &[Results], atlas: Option<&Atlas>, path: &Path) -> Result<Vec<Figure>> {
    let model = Model::new(results);
    let figures = charts::all(&model);
    let tables = page::Tables {
        splits: tables::splits(&model),
        modes: tables::modes(&model),
        structures: tables::structures(&model),
        everything: tables::everything(&model),
        atlas: atlas.map(atlas::tables),
    };
    let text = page::page(&model, &figures, &tables).into_string();
    write_atomically(path, |file| file.write_all(text.as_bytes()))?;
    Ok(figures)
}
