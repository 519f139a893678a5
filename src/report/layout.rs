//! Where the parts of a chart lie, whatever draws it.

use super::figure::{Figure, Mark, Scale};

/// Of the height of the axes, how far two levels must lie apart for both to be named.
const LEVEL_ROOM: f64 = 0.04;

/// The axes of a figure.
pub(super) struct Layout {
    pub(super) xs: Scale,
    pub(super) ys: Scale,
    /// Left, top, right and bottom.
    pub(super) frame: [f64; 4],
}

impl Layout {
    /// Axes within a picture of this width and height, so far from its left, top, right and bottom.
    pub(super) fn new(figure: &Figure, size: [f64; 2], margin: [f64; 4]) -> Self {
        let levels = figure.levels.iter().map(|(level, _)| *level);
        let [left, top, right, bottom] = margin;
        Self {
            xs: Scale::of(&figure.x, figure.points().map(|p| p[0])),
            ys: Scale::of(&figure.y, figure.points().map(|p| p[1]).chain(levels)),
            frame: [left, top, size[0] - right, size[1] - bottom],
        }
    }

    pub(super) fn x_at(&self, x: f64) -> f64 {
        let [left, _, right, _] = self.frame;
        left + self.xs.at(x) * (right - left)
    }

    pub(super) fn y_at(&self, y: f64) -> f64 {
        let [_, top, _, bottom] = self.frame;
        bottom - self.ys.at(y) * (bottom - top)
    }

    pub(super) fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.x_at(x), self.y_at(y)]
    }

    /// The levels of a figure, with their names where there is room for them.
    pub(super) fn levels<'a>(&self, figure: &'a Figure) -> Vec<(f64, Option<&'a str>)> {
        let mut levels: Vec<&(f64, String)> = figure.levels.iter().collect();
        levels.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut named = f64::NEG_INFINITY;
        let with_name = |(level, name): &'a (f64, String)| {
            let has_room = self.ys.at(*level) - named > LEVEL_ROOM;
            if has_room {
                named = self.ys.at(*level);
            }
            (*level, has_room.then_some(name.as_str()))
        };
        levels.into_iter().map(with_name).collect()
    }
}

/// The methods of a figure, each once.
pub(super) fn methods(figure: &Figure) -> Vec<&str> {
    let mut methods: Vec<&str> = Vec::new();
    for series in &figure.series {
        if !methods.contains(&series.method.as_str()) {
            methods.push(&series.method);
        }
    }
    methods
}

/// A mark around the origin, as SVG has paths.
pub(super) fn mark_path(mark: Mark) -> &'static str {
    match mark {
        Mark::Disc | Mark::Ring => "M-4.2,0A4.2,4.2 0 1 0 4.2,0A4.2,4.2 0 1 0 -4.2,0Z",
        Mark::Square | Mark::Frame => "M-3.8,-3.8L3.8,-3.8L3.8,3.8L-3.8,3.8Z",
        Mark::Diamond | Mark::Rhomb => "M0,-5.4L5.4,0L0,5.4L-5.4,0Z",
        Mark::Triangle | Mark::Wedge => "M0,-5.2L5,3.4L-5,3.4Z",
    }
}
