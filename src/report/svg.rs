//! Figures as SVG inside the page: coloured by its style sheet, so that they suit light and dark.

use std::fmt::Write as _;

use maud::{Markup, html};

use super::figure::{Figure, Mark, Scale, Series};
use crate::skip::METHODS;

/// Width and height of the drawing, and of what surrounds its axes: left, top, right, bottom.
const SIZE: [f64; 2] = [720.0, 420.0];
const MARGIN: [f64; 4] = [68.0, 14.0, 18.0, 50.0];

/// The figure with its legend and its note.
pub(super) fn figure(figure: &Figure) -> Markup {
    html! {
        figure id=(figure.id) {
            figcaption { (figure.title) }
            div class="scroll" { (drawing(figure)) }
            div class="legend" {
                @for method in methods(figure) {
                    span class=(color(method)) { (swatch(Mark::Disc)) (method) }
                }
                @for (mark, kind) in kinds(figure) {
                    span { (swatch(mark)) (kind) }
                }
                @if !figure.front.is_empty() {
                    span { svg viewBox="0 0 20 12" width="20" height="12" aria-hidden="true" { path class="front" d="M0 6H20" {} } "Pareto front" }
                }
            }
            p class="told" hidden { }
            @if !figure.note.is_empty() { p class="note" { (figure.note) } }
            details class="commands" {
                summary { "Points and the commands that measure them" }
                div class="scroll" {
                    table {
                        thead { tr { th { "point" } th { (figure.x.label) } th { (figure.y.label) } th { "command" } } }
                        tbody {
                            @for series in &figure.series { @for point in &series.points {
                                tr {
                                    td { (point.label) }
                                    td class="n" { (super::number::short(point.x)) }
                                    td class="n" { (super::number::short(point.y)) }
                                    td { code { (point.command) } }
                                }
                            } }
                        }
                    }
                }
            }
        }
    }
}

fn swatch(mark: Mark) -> Markup {
    html! {
        svg viewBox="-6 -6 12 12" width="12" height="12" aria-hidden="true" {
            path class=(mark_class(mark)) d=(path(mark)) {}
        }
    }
}

/// The methods of a figure, each once.
fn methods(figure: &Figure) -> Vec<&str> {
    let mut methods: Vec<&str> = Vec::new();
    for series in &figure.series {
        if !methods.contains(&series.method.as_str()) {
            methods.push(&series.method);
        }
    }
    methods
}

/// The kinds of a figure's points, each once.
fn kinds(figure: &Figure) -> Vec<(Mark, &str)> {
    let mut kinds: Vec<(Mark, &str)> = Vec::new();
    for series in &figure.series {
        if !kinds.iter().any(|(_, kind)| *kind == series.kind) {
            kinds.push((series.mark, &series.kind));
        }
    }
    kinds
}

/// The class of a method's colour.
pub(super) fn color(method: &str) -> String {
    let place = METHODS.iter().position(|m| m.name == method);
    format!("c{}", place.unwrap_or(METHODS.len()))
}

fn drawing(figure: &Figure) -> Markup {
    let levels = || figure.levels.iter().map(|(level, _)| *level);
    let xs = Scale::of(&figure.x, figure.points().map(|p| p[0]));
    let ys = Scale::of(&figure.y, figure.points().map(|p| p[1]).chain(levels()));
    let [left, top, right, bottom] = [
        MARGIN[0],
        MARGIN[1],
        SIZE[0] - MARGIN[2],
        SIZE[1] - MARGIN[3],
    ];
    let x_at = |x: f64| left + xs.at(x) * (right - left);
    let y_at = |y: f64| bottom - ys.at(y) * (bottom - top);
    let place = |[x, y]: [f64; 2]| [x_at(x), y_at(y)];
    html! {
        svg class="chart" viewBox=(format!("0 0 {} {}", SIZE[0], SIZE[1])) role="img" aria-label=(figure.title) {
            @for (tick, text) in &xs.ticks {
                line class="grid" x1=(px(x_at(*tick))) x2=(px(x_at(*tick))) y1=(px(top)) y2=(px(bottom)) {}
                text x=(px(x_at(*tick))) y=(px(bottom + 18.0)) text-anchor="middle" { (text) }
            }
            @for (tick, text) in &ys.ticks {
                line class="grid" x1=(px(left)) x2=(px(right)) y1=(px(y_at(*tick))) y2=(px(y_at(*tick))) {}
                text x=(px(left - 8.0)) y=(px(y_at(*tick) + 4.0)) text-anchor="end" { (text) }
            }
            rect class="frame" x=(px(left)) y=(px(top)) width=(px(right - left)) height=(px(bottom - top)) {}
            text class="label" x=(px(f64::midpoint(left, right))) y=(px(SIZE[1] - 10.0)) text-anchor="middle" { (figure.x.label) }
            text class="label" transform=(format!("translate(14 {}) rotate(-90)", px(f64::midpoint(top, bottom)))) text-anchor="middle" { (figure.y.label) }
            @for (level, meaning) in &figure.levels {
                line class="level" x1=(px(left)) x2=(px(right)) y1=(px(y_at(*level))) y2=(px(y_at(*level))) {}
                text class="level" x=(px(right - 4.0)) y=(px(y_at(*level) - 4.0)) text-anchor="end" { (meaning) }
            }
            @if !figure.front.is_empty() {
                polyline class="front" points=(polyline(figure.front.iter().map(|p| place(*p)))) {}
            }
            @for series in &figure.series { (drawn(figure, series, &place)) }
        }
    }
}

fn drawn(figure: &Figure, series: &Series, place: &impl Fn([f64; 2]) -> [f64; 2]) -> Markup {
    let points = || {
        let all = series.points.iter().map(|p| ([p.x, p.y], p));
        all.filter(|(at, _)| figure.can_draw(*at))
    };
    html! {
        g class=(color(&series.method)) {
            @if points().count() > 1 {
                polyline class="join" points=(polyline(points().map(|(at, _)| place(at)))) {}
            }
            @for (at, point) in points() {
                path class={ "p " (mark_class(series.mark)) } d=(path(series.mark)) transform=(translate(place(at))) {
                    title { (point.label) "\n" (point.command) }
                }
            }
        }
    }
}

fn mark_class(mark: Mark) -> &'static str {
    if mark == Mark::Ring { "ring" } else { "full" }
}

/// A mark around the origin.
fn path(mark: Mark) -> &'static str {
    match mark {
        Mark::Disc | Mark::Ring => "M-4 0a4 4 0 1 0 8 0a4 4 0 1 0 -8 0z",
        Mark::Square => "M-3.6 -3.6h7.2v7.2h-7.2z",
        Mark::Diamond => "M0 -5l5 5l-5 5l-5 -5z",
        Mark::Triangle => "M0 -5l4.6 8.4h-9.2z",
    }
}

fn translate([x, y]: [f64; 2]) -> String {
    format!("translate({} {})", px(x), px(y))
}

fn polyline(points: impl Iterator<Item = [f64; 2]>) -> String {
    let mut text = String::new();
    for [x, y] in points {
        // Writing to a String cannot fail.
        let _ = write!(text, "{},{} ", px(x), px(y));
    }
    text.trim_end().to_owned()
}

/// Tenths of a pixel are as fine as anyone sees.
fn px(x: f64) -> String {
    format!("{x:.1}")
}
