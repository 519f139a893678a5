//! What `hollowcast stability` found, as a table of methods by hazards.

use std::path::Path;

use maud::{Markup, PreEscaped, html};
use serde::Deserialize;

use crate::error::{Error, Result};
use crate::measure::stability::{Finding, GROUPS, Row, Verdict, cell, findings};

/// The content of a `rows.json`, or of what `--json` printed.
#[derive(Debug, Clone, Deserialize)]
pub struct Atlas {
    adapters: Vec<Adapter>,
    rows: Vec<Row>,
}

/// What the pictures were made on.
#[derive(Debug, Clone, Deserialize)]
struct Adapter {
    backend: String,
    name: String,
    driver: String,
}

impl Atlas {
    /// Reads a file.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::File`] naming what is no such report.
    pub fn read(path: &Path) -> Result<Self> {
        let text = crate::text_file::read(path, crate::text_file::MEASURED_BYTES)?;
        serde_json::from_str(&text).map_err(|e| {
            let reason = format!("is not what `hollowcast stability --json` prints: {e}");
            Error::file(path, format!("line {}", e.line()), reason)
        })
    }
}

/// The tables of every backend, and what became of the literature's methods.
pub(super) fn tables(atlas: &Atlas) -> Markup {
    let found = findings(&atlas.rows);
    html! {
        style { (PreEscaped(include_str!("atlas.css"))) }
        p { "A hazard is a small scene that some method may fail on. A lossless method is wrong where one pixel differs from box's \
             in any bit, a lossy one where a channel is off by more than 1/255; the number is the largest difference of a channel. \
             Slow is over 1.1 times box's frame; the number is the frame's time over box's." }
        @for adapter in &atlas.adapters {
            (backend(atlas, adapter))
        }
        @if !found.is_empty() { (claims(&found)) }
    }
}

fn backend(atlas: &Atlas, adapter: &Adapter) -> Markup {
    let rows: Vec<&Row> = atlas
        .rows
        .iter()
        .filter(|r| r.backend == adapter.backend)
        .collect();
    let methods = in_order(rows.iter().map(|r| &*r.method));
    html! {
        div class="table" id=(format!("atlas-{}", adapter.backend)) {
            h3 { (adapter.backend) ": " (adapter.name) " " (adapter.driver) }
            div class="scroll" {
                table class="atlas" {
                    thead { tr { th { "hazard" } @for method in &methods { th { (method) } } } }
                    @for group in 1..=GROUPS.len() as u8 {
                        (hazards(&rows, &methods, group))
                    }
                }
            }
            p class="note" { "Made by hollowcast stability -o FOLDER; one cell again by hollowcast stability --hazard NAME --method NAME." }
        }
    }
}

/// The rows of one group.
fn hazards(rows: &[&Row], methods: &[&str], group: u8) -> Markup {
    let of_group = || rows.iter().filter(move |r| r.group == group);
    let names = in_order(of_group().map(|r| &*r.hazard));
    html! {
        @if !names.is_empty() {
            tbody {
                tr { th colspan=(methods.len() + 1) { (group) ". " (GROUPS[usize::from(group) - 1]) } }
                @for name in names {
                    tr {
                        td { (name) }
                        @for method in methods {
                            @match of_group().find(|r| r.hazard == name && r.method == *method) {
                                Some(row) => { td class=(class(row.verdict)) { (cell(row)) } }
                                None => { td { "\u{2013}" } }
                            }
                        }
                    }
                }
            }
        }
    }
}

fn class(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Ok => "ok",
        Verdict::Slow => "slow",
        Verdict::Wrong => "wrong",
    }
}

fn claims(found: &[Finding]) -> Markup {
    html! {
        div class="table" id="claims" {
            h3 { "Where the literature's methods fail" }
            div class="scroll" {
                table class="atlas" {
                    thead { tr { @for name in ["method", "fails where it", "hazard", "backend", "measured", "shown"] { th { (name) } } } }
                    tbody {
                        @for finding in found {
                            tr {
                                td { (finding.claim.method) }
                                td { (finding.claim.about) }
                                td { (finding.claim.hazard) }
                                td { (finding.backend) }
                                td { (finding.words()) }
                                @if finding.is_shown { td class="wrong" { "yes" } } @else { td class="ok" { "no" } }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Names once each, in the order of their first mention.
fn in_order<'a>(all: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut names = Vec::new();
    for name in all {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}
