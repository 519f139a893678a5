//! The page: one file, escaped by its template, that asks nothing of any network.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::figure::Figure;
use super::model::{Model, error_lines};
use super::number::short;
use super::svg;
use super::tables::{NONE, Row, Table, Tables};
use crate::measure::suite::{PictureRecord, Results, What};
use crate::mode::MODES;

const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = include_str!("script.js");

/// Nothing but what the page holds itself.
const POLICY: &str = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'; base-uri 'none'; form-action 'none'";

pub(super) fn page(
    model: &Model,
    figures: &[Figure],
    tables: &Tables,
    atlas: Option<&Markup>,
) -> Markup {
    let of = |prefix: &str| -> Vec<&Figure> {
        figures
            .iter()
            .filter(|f| f.id.starts_with(prefix))
            .collect()
    };
    let growth: Vec<&Figure> = [of("volume-size"), of("image-size")].concat();
    let title = model
        .results
        .first()
        .map_or("hollowcast", |r| r.header.suite.as_str());
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                link rel="icon" href="data:,";
                title { "hollowcast: " (title) }
                style { (PreEscaped(svg::colors())) (PreEscaped(STYLE)) }
            }
            body {
                header {
                    h1 { "Speed against accuracy: " (title) }
                    p { "Measured by hollowcast. Under every chart and table are the commands that measure its numbers again; \
                         a point of a chart tells its own when it is pointed at or tapped." }
                    @if model.cases.iter().any(|c| c.record.command.contains("$HOLLOWCAST_DATA")) {
                        p { "Where they name " code { "$HOLLOWCAST_DATA" } ", that is the folder of scans that do not ship with the program: "
                            code { "export HOLLOWCAST_DATA=FOLDER" } " before." }
                    }
                }
                main {
                    (section("on", "What it was measured on", html! { @for (i, one) in model.results.iter().enumerate() { (header(one, i, model.results.len())) } (lossless(model)) }))
                    (charts("error", "Error over time", &of("pareto")))
                    @if !tables.splits.is_empty() {
                        (section("paper", "The half-splitting paper's tables", html! {
                            p { "Yu et al. 2016 measured 256x256x256 voxels on a GeForce GT 635M. Another machine's milliseconds cannot \
                                 be compared; ratios can." }
                            @for one in &tables.splits { (table(one)) }
                        }))
                    }
                    @if let Some(modes) = &tables.modes { (section("by-mode", "Modes", table(modes))) }
                    @if !tables.methods.is_empty() {
                        (section("by-method", "Methods by scenes", html! { @for one in &tables.methods { (table(one)) } }))
                    }
                    (charts("growth", "Growth", &growth))
                    (charts("block-size", "Blocks", &of("by-block")))
                    (charts("samples", "Work", &of("work")))
                    @if let Some(structures) = &tables.structures { (section("by-structure", "Structures", table(structures))) }
                    (pictures(model))
                    @if let Some(atlas) = atlas { (section("stability", "Where methods fail", atlas)) }
                    (section("cases", "Every case", html! { details { summary { (tables.everything.rows.len()) " cases" } (table(&tables.everything)) } }))
                }
                script { (PreEscaped(SCRIPT)) }
            }
        }
    }
}

fn section(id: &str, title: &str, content: impl maud::Render) -> Markup {
    html! { section id=(id) { h2 { (title) } (content) } }
}

fn charts(id: &str, title: &str, figures: &[&Figure]) -> Markup {
    html! {
        @if !figures.is_empty() {
            (section(id, title, html! {
                @if id == "error" { p { "Errors are those of the first view, times the means of all views." } }
                div class=[(id != "error").then_some("wide")] { @for figure in figures { (svg::figure(figure)) } }
            }))
        }
    }
}

/// Machine, adapters, versions, and what was missing.
fn header(results: &Results, place: usize, of: usize) -> Markup {
    let header = &results.header;
    let machine = &header.machine;
    html! {
        dl {
            @if of > 1 { dt { "results" } dd { (place + 1) } }
            dt { "suite" } dd { (header.suite) " (" (header.suite_hash) "), " (results.cases.len()) " cases" }
            dt { "machine" } dd { (machine.cpu) ", " (machine.cores) " threads, " (machine.os) }
            @for adapter in &header.adapters {
                dt { (adapter.asked) }
                dd { (adapter.name) " " (adapter.driver) @if adapter.is_software { " (software)" } }
            }
            @for (name, reason) in &header.missing { dt { (name) } dd class="warn" { "left out: " (reason) } }
            dt { "program" }
            dd { "hollowcast " (machine.hollowcast) @if let Some(commit) = &machine.commit { ", commit " (commit) } @if let Some(wgpu) = &machine.wgpu { ", wgpu " (wgpu) } }
            @for scene in &results.scenes {
                dt { (scene.name) }
                dd {
                    (scene.title) ": " (scene.stand_in.as_ref().unwrap_or(&scene.volume)) ", "
                    (scene.dims[0]) " x " (scene.dims[1]) " x " (scene.dims[2])
                    @if let Some(phantom) = &scene.stand_in {
                        span class="warn" { " \u{2014} " (scene.volume) " was missing: " (phantom) " stands in for it" }
                    }
                }
            }
        }
    }
}

/// What was found of the promise that lossless methods keep.
fn lossless(model: &Model) -> Markup {
    let lossless = || model.cases.iter().filter(|c| c.record.lossless);
    let differing: u64 = lossless().map(|c| c.record.differing_pixels_vs_box).sum();
    let lines = error_lines(&model.cases);
    let bent = lines.values().filter(|errors| errors.len() > 1).count();
    html! {
        p class=(if differing == 0 { "good" } else { "warn" }) {
            "Of " (lossless().count()) " cases of lossless methods, "
            @if differing == 0 { "no pixel differs from box's in any bit." }
            @else { (differing) " pixels differ from box's." }
        }
        @if !lines.is_empty() {
            p class=(if bent == 0 { "good" } else { "warn" }) {
                "Their errors against the truth lie on " (lines.len()) " levels, one for each scene, backend, sampler, step and threshold: "
                @if bent == 0 { "on each all are equal to the last digit." }
                @else { "on " (bent) " of them they are not all equal." }
            }
        }
    }
}

/// A table, and the commands of its rows.
fn table(table: &Table) -> Markup {
    html! {
        div class="table" id=(table.id) {
            h3 { (table.title) }
            div class="scroll" {
                table {
                    thead { tr { @for (i, name) in table.head.iter().enumerate() { th class=[has_numbers(table, i).then_some("n")] { (name) } } } }
                    tbody { @for row in &table.rows { (table_row(row)) } }
                }
            }
            @if !table.note.is_empty() { p class="note" { (table.note) } }
            details class="commands" {
                summary { "Commands" }
                @for row in table.rows.iter().filter(|r| !r.commands.is_empty()) {
                    p { (row.cells.iter().take(3).cloned().collect::<Vec<_>>().join(", ")) }
                    @for command in &row.commands { pre { (command) } }
                }
            }
        }
    }
}

fn table_row(row: &Row) -> Markup {
    html! {
        tr class=[row.is_published.then_some("published")] {
            @for cell in &row.cells {
                td class=[is_number(cell).then_some("n")] { (cell) }
            }
        }
    }
}

fn is_number(cell: &str) -> bool {
    let unsigned = cell.strip_prefix(['-', '\u{2212}']).unwrap_or(cell);
    cell == NONE || unsigned.starts_with(|c: char| c.is_ascii_digit())
}

/// Whether the cells under a heading are numbers, so that it stands over them.
fn has_numbers(table: &Table, column: usize) -> bool {
    let mut cells = table.rows.iter().filter_map(|row| row.cells.get(column));
    cells.clone().next().is_some() && cells.all(|cell| is_number(cell))
}

/// What methods draw, row by row.
fn pictures<'a>(model: &Model<'a>) -> Markup {
    let mut sets: Vec<Vec<(&'a Results, &'a PictureRecord)>> = Vec::new();
    for results in model.results {
        for picture in &results.pictures {
            let key =
                |p: &'a PictureRecord| (&p.scene, &p.backend, &p.step, &p.mode, p.block, p.size);
            let is_same = |other: &'a PictureRecord| key(other) == key(picture);
            match sets
                .iter_mut()
                .find(|s| std::ptr::eq(s[0].0, results) && is_same(s[0].1))
            {
                Some(set) => set.push((results, picture)),
                None => sets.push(vec![(results, picture)]),
            }
        }
    }
    html! {
        @if !sets.is_empty() {
            (section("pictures", "Pictures", html! { @for set in &sets { (picture_set(set)) } }))
        }
    }
}

fn picture_set(set: &[(&Results, &PictureRecord)]) -> Markup {
    let (results, first) = set[0];
    let title = results
        .scene(&first.scene)
        .map_or(first.scene.as_str(), |s| s.title.as_str());
    let of = |what: What| set.iter().map(|(_, p)| *p).filter(move |p| p.what == what);
    let most = of(What::Samples).next().map_or(1.0, |p| p.scale);
    html! {
        h3 { (title) ", step " (first.step) ", " (first.backend) @if first.mode != MODES[0].name { ", " (first.mode) } ", blocks of " (first.block) }
        (row(of(What::Picture), "Pictures", "What is drawn; the first is the truth, the converged picture."))
        (row(of(What::Difference), "Differences from the truth",
            "Largest absolute difference of a pixel's channels, amplified as stands under it: at \u{d7} 100 white is a difference of 0.01 and more."))
        (row(of(What::Samples), "Samples per pixel", &format!("Black is none, the brightest {}.", short(most))))
    }
}

fn row<'a>(pictures: impl Iterator<Item = &'a PictureRecord>, title: &str, note: &str) -> Markup {
    let pictures: Vec<&PictureRecord> = pictures.collect();
    html! {
        @if !pictures.is_empty() {
            h4 { (title) }
            div class="pictures" {
                @for picture in &pictures {
                    figure {
                        img src=(format!("data:image/png;base64,{}", picture.png)) alt=(format!("{title}: {}", picture.method)) title=(picture.command) width=(picture.size[0]) height=(picture.size[1]);
                        figcaption { (picture.method) @if picture.what == What::Difference { ", \u{d7} " (picture.scale) } }
                    }
                }
            }
            p class="note" { (note) }
            details class="commands" {
                summary { "Commands" }
                @if pictures.iter().any(|p| p.what != What::Picture) { p { "What these are different by, or take samples for; the pictures here are made by the suite." } }
                @for picture in &pictures { pre { (picture.command) } }
            }
        }
    }
}
