//! The tables as Markdown, to be pasted into a document.

use super::model::Model;
use super::tables::{Row, Table, Tables};
use crate::measure::suite::Header;

/// All tables but that of every case, under what they were measured on.
pub(super) fn text(model: &Model, tables: &Tables) -> String {
    let mut parts: Vec<String> = model
        .results
        .iter()
        .map(|r| measured_on(&r.header))
        .collect();
    let all = [&tables.splits, &tables.methods].into_iter().flatten();
    parts.extend(
        all.chain(&tables.modes)
            .chain(&tables.structures)
            .map(table),
    );
    parts.join("\n")
}

fn measured_on(header: &Header) -> String {
    let machine = &header.machine;
    let adapters = header
        .adapters
        .iter()
        .map(|a| format!("{}: {} ({})", a.asked, a.name, a.driver));
    let commit = machine.commit.as_ref().map(|c| format!(", commit {c}"));
    format!(
        "Suite {} ({}), on {}, {} threads; {}; hollowcast {}{}.\n",
        header.suite,
        header.suite_hash,
        machine.cpu,
        machine.cores,
        adapters.collect::<Vec<_>>().join("; "),
        machine.hollowcast,
        commit.unwrap_or_default(),
    )
}

fn table(table: &Table) -> String {
    let mut lines = vec![format!("### {}\n", plain(&table.title)), line(&table.head)];
    let columns = vec!["---".to_owned(); table.head.len()];
    lines.push(line(&columns));
    lines.extend(table.rows.iter().map(row));
    if !table.note.is_empty() {
        lines.push(format!("\n{}", plain(&table.note)));
    }
    lines.join("\n") + "\n"
}

/// What others measured is set apart.
fn row(row: &Row) -> String {
    let emphasised = |cell: &String| format!("*{cell}*");
    if row.is_published {
        line(&row.cells.iter().map(emphasised).collect::<Vec<_>>())
    } else {
        line(&row.cells)
    }
}

fn line(cells: &[String]) -> String {
    let cells: Vec<String> = cells.iter().map(|c| plain(c)).collect();
    format!("| {} |", cells.join(" | "))
}

/// Text that neither ends a cell nor begins a tag.
fn plain(text: &str) -> String {
    text.replace('|', "\\|").replace('<', "&lt;")
}
