//! Rows, summed up: the table of methods by hazards.

use std::fmt::Write as _;

use super::{GROUPS, Row, Verdict};

/// What came of one group on one backend.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tally {
    /// The group, 1 to 10.
    pub group: u8,
    /// Rows by verdict: ok, slow, wrong.
    pub rows: [usize; 3],
    /// Hazards in which a lossless method is wrong.
    pub lossless_wrong: Vec<String>,
}

/// A tally of every group that has a row.
pub fn tallies(rows: &[Row]) -> Vec<Tally> {
    (1..=GROUPS.len() as u8)
        .filter_map(|group| {
            let rows: Vec<&Row> = rows.iter().filter(|r| r.group == group).collect();
            let count = |verdict| rows.iter().filter(|r| r.verdict == verdict).count();
            let mut lossless_wrong: Vec<String> = rows
                .iter()
                .filter(|r| r.lossless && r.verdict == Verdict::Wrong)
                .map(|r| r.hazard.to_string())
                .collect();
            lossless_wrong.dedup();
            (!rows.is_empty()).then(|| Tally {
                group,
                rows: [Verdict::Ok, Verdict::Slow, Verdict::Wrong].map(count),
                lossless_wrong,
            })
        })
        .collect()
}

/// The verdict with the number that it rests on.
pub fn cell(row: &Row) -> String {
    match row.verdict {
        Verdict::Slow => format!("slow {:.2}x", row.time_vs_box.unwrap_or_default()),
        Verdict::Ok => row
            .time_vs_box
            .map_or_else(|| "ok".to_owned(), |time| format!("ok {time:.2}x")),
        Verdict::Wrong => {
            let off = if row.method == "box" && row.group != 10 {
                row.error_vs_reference.unwrap_or_default()
            } else {
                row.max_abs_diff_vs_box
            };
            format!("wrong {off:.3}")
        }
    }
}

/// The table of one backend, in markdown: a line for each hazard, a column for each method.
///
/// Box's column has its largest distance from the f64 reference, in 255ths.
pub fn markdown(rows: &[Row], backend: &str) -> String {
    let rows: Vec<&Row> = rows.iter().filter(|r| r.backend == backend).collect();
    let mut methods: Vec<&str> = Vec::new();
    let mut hazards: Vec<(&str, u8)> = Vec::new();
    for row in &rows {
        if !methods.contains(&&*row.method) {
            methods.push(&row.method);
        }
        if !hazards.contains(&(&*row.hazard, row.group)) {
            hazards.push((&row.hazard, row.group));
        }
    }
    let mut text = format!("| hazard | {} |\n", methods.join(" | "));
    text.push_str(&"| --- ".repeat(methods.len() + 1));
    text.push_str("|\n");
    for (hazard, group) in hazards {
        let cells: Vec<String> = methods
            .iter()
            .map(|&method| {
                let row = rows
                    .iter()
                    .find(|r| r.method == method && r.hazard == hazard && r.group == group);
                let Some(row) = row else {
                    return "–".to_owned();
                };
                match row.error_vs_reference {
                    Some(error) if method == "box" && row.verdict == Verdict::Ok => {
                        format!("{} {:.3}/255", cell(row), error * 255.0)
                    }
                    _ => cell(row),
                }
            })
            .collect();
        // Writing to a String cannot fail.
        let _ = writeln!(text, "| {group} {hazard} | {} |", cells.join(" | "));
    }
    text
}
