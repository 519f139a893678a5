//! Results as a page that a browser shows without a network, as chart files, and their tables as Markdown.

mod atlas;
mod charts;
mod drawing;
pub mod figure;
mod files;
mod layout;
mod markdown;
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
use self::tables::Tables;
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
    let atlas = atlas.map(atlas::tables);
    let text = page::page(&model, &figures, &Tables::new(&model), atlas.as_ref()).into_string();
    write_atomically(path, |file| file.write_all(text.as_bytes()))?;
    Ok(figures)
}

/// Writes the tables of these results as Markdown.
///
/// # Errors
/// [`crate::Error::Io`].
pub fn write_tables(results: &[Results], path: &Path) -> Result<()> {
    let model = Model::new(results);
    let text = markdown::text(&model, &Tables::new(&model));
    write_atomically(path, |file| file.write_all(text.as_bytes()))
}
