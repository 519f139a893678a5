//! The published tables beside what was measured, and tables of what the charts leave out.

mod everything;
mod methods;
mod modes;
mod splits;
mod structures;

use super::model::{Case, Model};
use super::number::short;
use crate::measure::statistics::median;

/// Nothing was measured.
pub(super) const NONE: &str = "\u{2013}";

/// A table.
#[derive(Debug)]
pub(super) struct Table {
    pub(super) id: String,
    pub(super) title: String,
    pub(super) note: String,
    pub(super) head: Vec<String>,
    pub(super) rows: Vec<Row>,
}

/// A row: its first cell names it.
#[derive(Debug)]
pub(super) struct Row {
    pub(super) cells: Vec<String>,
    /// Whether someone else measured it.
    pub(super) is_published: bool,
    /// What measures its numbers again.
    pub(super) commands: Vec<String>,
}

/// All tables for which something was measured.
#[derive(Debug)]
pub(super) struct Tables {
    /// Of the main paper.
    pub(super) splits: Vec<Table>,
    /// Of the ray caster in CUDA.
    pub(super) modes: Option<Table>,
    /// Methods by scenes.
    pub(super) methods: Vec<Table>,
    pub(super) structures: Option<Table>,
    pub(super) everything: Table,
}

impl Tables {
    pub(super) fn new(model: &Model) -> Self {
        Self {
            splits: splits::tables(model),
            modes: modes::table(model),
            methods: methods::tables(model),
            structures: structures::table(model),
            everything: everything::table(model),
        }
    }
}

fn head(names: &[&str]) -> Vec<String> {
    names.iter().map(|&n| n.to_owned()).collect()
}

fn published(cells: Vec<String>) -> Row {
    Row {
        cells,
        is_published: true,
        commands: Vec::new(),
    }
}

/// What measures these cases again.
fn commands<'a>(cases: impl IntoIterator<Item = &'a Case<'a>>) -> Vec<String> {
    let all = cases.into_iter().map(|c| c.record.command.clone());
    all.collect()
}

/// A number, or what stands where there is none.
fn or_none(number: Option<f64>) -> String {
    number.map_or(NONE.to_owned(), short)
}
