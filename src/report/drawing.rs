//! Figures as drawings on white, with all that their files must say.

use super::figure::{Figure, Mark, can_draw, kinds};
use super::layout::{Layout, mark_path, methods};
use super::svg::place;
use crate::output::chart::COLORS;
use crate::output::drawing::{Anchor, Drawing, Shape};

/// Width and height to the end of the axis' name, and what surrounds the axes: left, top, right, bottom.
const SIZE: [f64; 2] = [860.0, 600.0];
const MARGIN: [f64; 4] = [70.0, 76.0, 20.0, 60.0];
/// Between rows of the legend.
const ROW: f64 = 22.0;
/// A letter's width on average, over the height of the letters.
const LETTER: f64 = 0.56;

const INK: &str = "#1d2126";
const SOFT: &str = "#5b636d";
const GRID: &str = "#dcdfe3";
const BETWEEN: &str = "#eff1f3";
const FRONT: &str = "#b5d4e1";

pub(super) fn drawing(figure: &Figure) -> Drawing {
    let layout = Layout::new(figure, SIZE, MARGIN);
    let mut shapes = axes(figure, &layout);
    if !figure.front.is_empty() {
        let points = figure.front.iter().map(|p| layout.at(*p)).collect();
        shapes.push(line(points, FRONT, 7.0));
    }
    for series in &figure.series {
        let color = COLORS[place(&series.method)];
        let points = series.points.iter().map(|p| [p.x, p.y]);
        let points: Vec<[f64; 2]> = points
            .filter(|p| can_draw(*p))
            .map(|p| layout.at(p))
            .collect();
        if points.len() > 1 {
            shapes.push(line(points.clone(), color, 0.8));
        }
        shapes.extend(points.into_iter().map(|at| mark(at, series.mark, color)));
    }
    let height = legend(figure, &mut shapes);
    Drawing {
        size: [SIZE[0], height],
        shapes,
    }
}

/// Everything but the points.
fn axes(figure: &Figure, layout: &Layout) -> Vec<Shape> {
    let [left, top, right, bottom] = layout.frame;
    let across = |y: f64| vec![[left, y], [right, y]];
    let upwards = |x: f64| vec![[x, top], [x, bottom]];
    let mut shapes = vec![
        text([left, 28.0], Anchor::Start, 17, &figure.title, INK),
        text([left, top - 12.0], Anchor::Start, 13, &figure.y.label, INK),
        text(
            [f64::midpoint(left, right), SIZE[1] - 14.0],
            Anchor::Middle,
            13,
            &figure.x.label,
            INK,
        ),
    ];
    let (xs, ys) = (&layout.xs, &layout.ys);
    shapes.extend(
        xs.between
            .iter()
            .map(|x| line(upwards(layout.x_at(*x)), BETWEEN, 1.0)),
    );
    shapes.extend(
        ys.between
            .iter()
            .map(|y| line(across(layout.y_at(*y)), BETWEEN, 1.0)),
    );
    for (tick, name) in &xs.ticks {
        let x = layout.x_at(*tick);
        shapes.push(line(upwards(x), GRID, 1.0));
        shapes.push(text([x, bottom + 20.0], Anchor::Middle, 13, name, SOFT));
    }
    for (tick, name) in &ys.ticks {
        let y = layout.y_at(*tick);
        shapes.push(line(across(y), GRID, 1.0));
        shapes.push(text([left - 8.0, y + 4.5], Anchor::End, 13, name, SOFT));
    }
    let corners = [
        [left, top],
        [right, top],
        [right, bottom],
        [left, bottom],
        [left, top],
    ];
    shapes.push(line(corners.to_vec(), SOFT, 1.0));
    for (level, name) in layout.levels(figure) {
        let y = layout.y_at(level);
        shapes.push(Shape::Line {
            points: across(y),
            color: SOFT.to_owned(),
            width: 1.0,
            is_dashed: true,
        });
        if let Some(name) = name {
            shapes.push(text([right - 4.0, y - 4.0], Anchor::End, 11, name, SOFT));
        }
    }
    shapes
}

/// Methods, kinds and the front in rows under the axes; gives the height of the whole.
fn legend(figure: &Figure, shapes: &mut Vec<Shape>) -> f64 {
    let methods = methods(figure).into_iter();
    let methods = methods.map(|m| (Some(Mark::Disc), COLORS[place(m)], m));
    let kinds = kinds(&figure.series).into_iter();
    let kinds = kinds.map(|(mark, kind)| (Some(mark), INK, kind));
    let front = (!figure.front.is_empty()).then_some((None, FRONT, "Pareto front"));
    let [left, _, right, _] = MARGIN;
    let (mut x, mut y) = (left, SIZE[1] + 12.0);
    for (of, color, name) in methods.chain(kinds).chain(front) {
        let width = 22.0 + 13.0 * LETTER * name.chars().count() as f64;
        if x + width > SIZE[0] - right {
            (x, y) = (left, y + ROW);
        }
        shapes.push(match of {
            Some(of) => mark([x + 5.0, y - 4.5], of, color),
            None => line(vec![[x - 1.0, y - 4.5], [x + 9.0, y - 4.5]], color, 7.0),
        });
        shapes.push(text([x + 16.0, y], Anchor::Start, 13, name, INK));
        x += width + 14.0;
    }
    y + 20.0
}

fn line(points: Vec<[f64; 2]>, color: &str, width: f64) -> Shape {
    Shape::Line {
        points,
        color: color.to_owned(),
        width,
        is_dashed: false,
    }
}

fn mark(at: [f64; 2], mark: Mark, color: &str) -> Shape {
    Shape::Mark {
        at,
        path: mark_path(mark),
        color: color.to_owned(),
        is_hollow: mark.is_hollow(),
    }
}

fn text(at: [f64; 2], anchor: Anchor, size: u32, text: &str, color: &str) -> Shape {
    Shape::Text {
        at,
        anchor,
        size,
        text: text.to_owned(),
        color: color.to_owned(),
    }
}
