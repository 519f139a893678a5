//! Figures as SVG inside the page: coloured by its style sheet, so that they suit light and dark.

use std::fmt::Write as _;

use maud::{Markup, html};

use super::figure::{Figure, Mark, Series, can_draw, kinds};
use super::layout::{Layout, mark_path, methods};
use crate::output::chart::COLORS;
use crate::skip::METHODS;

/// The colours of the methods and auto on black.
const DARK: [&str; COLORS.len()] = [
    "#f2f2f2", "#f0b040", "#6cc4f5", "#35c79a", "#f5834a", "#e08fc0", "#6f9df5", "#d8cd3a",
    "#a8a8a8", "#b892f5", "#c98f68", "#74c778", "#ff6fa8",
];

/// Width and height of the drawing, and of what surrounds its axes: left, top, right, bottom. Phones show it at half its size
/// and its text, by the style sheet, nearly at full size: the room is for that.
const SIZE: [f64; 2] = [720.0, 520.0];
const MARGIN: [f64; 4] = [74.0, 34.0, 16.0, 66.0];

/// The rules that colour methods.
pub(super) fn colors() -> String {
    let rules = |colors: &[&str]| {
        let each = colors.iter().enumerate();
        let rules = each.map(|(i, color)| format!(".c{i} {{ color: {color}; }}"));
        rules.collect::<Vec<_>>().join(" ")
    };
    format!(
        "{}\n@media (prefers-color-scheme: dark) {{ {} }}\n",
        rules(&COLORS),
        rules(&DARK)
    )
}

/// The class of a method's colour.
fn color(method: &str) -> String {
    format!("c{}", place(method))
}

/// A method's place among the colours.
pub(super) fn place(method: &str) -> usize {
    let place = METHODS.iter().position(|m| m.name == method);
    place.unwrap_or(METHODS.len()).min(COLORS.len() - 1)
}

/// The figure with its legend and its note.
pub(super) fn figure(figure: &Figure) -> Markup {
    html! {
        figure id=(figure.id) {
            figcaption { (figure.title) }
            (drawing(figure))
            div class="legend" {
                @for method in methods(figure) {
                    span class=(color(method)) { (swatch(Mark::Disc)) (method) }
                }
                @for (mark, kind) in kinds(&figure.series) {
                    span { (swatch(mark)) (kind) }
                }
                @if !figure.front.is_empty() {
                    span { svg viewBox="0 0 20 12" width="20" height="12" aria-hidden="true" { path class="front" d="M0 6H20" {} } "Pareto front" }
                }
            }
            p class="told" hidden { }
            @if !figure.series.iter().flat_map(|s| &s.points).any(|p| can_draw([p.x, p.y])) {
                p class="note" { "No point can be drawn: axes are logarithmic, and no number is above 0." }
            }
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
            path class=(mark_class(mark)) d=(mark_path(mark)) {}
        }
    }
}

fn drawing(figure: &Figure) -> Markup {
    let layout = Layout::new(figure, SIZE, MARGIN);
    let (xs, ys) = (&layout.xs, &layout.ys);
    let [left, top, right, bottom] = layout.frame;
    let (x_at, y_at) = (|x: f64| layout.x_at(x), |y: f64| layout.y_at(y));
    let place = |point: [f64; 2]| layout.at(point);
    html! {
            svg class="chart" viewBox=(format!("0 0 {} {}", SIZE[0], SIZE[1])) role="img" aria-label=(figure.title) {
                @for x in &xs.between {
                    line class="between" x1=(px(x_at(*x))) x2=(px(x_at(*x))) y1=(px(top)) y2=(px(bottom)) {}
                }
                @for y in &ys.between {
                    line class="between" x1=(px(left)) x2=(px(right)) y1=(px(y_at(*y))) y2=(px(y_at(*y))) {}
                }
                @for (tick, text) in &xs.ticks {
                    line class="grid" x1=(px(x_at(*tick))) x2=(px(x_at(*tick))) y1=(px(top)) y2=(px(bottom)) {}
                    text x=(px(x_at(*tick))) y=(px(bottom + 22.0)) text-anchor="middle" { (text) }
                }
                @for (tick, text) in &ys.ticks {
                    line class="grid" x1=(px(left)) x2=(px(right)) y1=(px(y_at(*tick))) y2=(px(y_at(*tick))) {}
                    text x=(px(left - 8.0)) y=(px(y_at(*tick))) text-anchor="end" dominant-baseline="central" { (text) }
                }
                rect class="frame" x=(px(left)) y=(px(top)) width=(px(right - left)) height=(px(bottom - top)) {}
                text class="label" x=(px(f64::midpoint(left, right))) y=(px(SIZE[1] - 10.0)) text-anchor="middle" { (figure.x.label) }
    text class="label" x=(px(left)) y=(px(top - 12.0)) { (figure.y.label) }
                @for (level, meaning) in layout.levels(figure) {
                    line class="level" x1=(px(left)) x2=(px(right)) y1=(px(y_at(level))) y2=(px(y_at(level))) {}
                    @if let Some(meaning) = meaning {
                        text class="level" x=(px(right - 4.0)) y=(px(y_at(level) - 4.0)) text-anchor="end" { (meaning) }
                    }
                }
                @if !figure.front.is_empty() {
                    polyline class="front" points=(polyline(figure.front.iter().map(|p| place(*p)))) {}
                }
                @for series in &figure.series { (drawn(series, &place)) }
            }
        }
}

fn drawn(series: &Series, place: &impl Fn([f64; 2]) -> [f64; 2]) -> Markup {
    let points = || {
        let all = series.points.iter().map(|p| ([p.x, p.y], p));
        all.filter(|(at, _)| can_draw(*at))
    };
    html! {
        g class=(color(&series.method)) {
            @if points().count() > 1 {
                polyline class="join" points=(polyline(points().map(|(at, _)| place(at)))) {}
            }
            // The mark is scaled by the style sheet, within the group that moves it.
            @for (at, point) in points() {
                g transform=(translate(place(at))) tabindex="0" {
                    path class={ "p " (mark_class(series.mark)) } d=(mark_path(series.mark)) {
                        title { (point.label) "\n" (point.command) }
                    }
                }
            }
        }
    }
}

fn mark_class(mark: Mark) -> &'static str {
    if mark.is_hollow() { "hollow" } else { "full" }
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
