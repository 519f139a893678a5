//! Charts before they are drawn: as SVG in the page, or as files by [`crate::output::chart`].

use super::number;

/// A chart.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Names it in the page and its file.
    pub id: String,
    /// Over it.
    pub title: String,
    /// Under it: what is seen, and how far it can be trusted.
    pub note: String,
    /// Across.
    pub x: Axis,
    /// Upwards.
    pub y: Axis,
    /// What is drawn.
    pub series: Vec<Series>,
    /// The points that none is better than in both: joined by a line of their own; empty: none is drawn.
    pub front: Vec<[f64; 2]>,
    /// Horizontal lines with what they mean.
    pub levels: Vec<(f64, String)>,
}

/// An axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// What it counts, with its unit.
    pub label: String,
    /// Whether equal lengths are equal ratios.
    pub log: bool,
}

impl Axis {
    /// A logarithmic axis.
    pub(super) fn log(label: &str) -> Self {
        Self {
            label: label.to_owned(),
            log: true,
        }
    }
}

/// Points of one name.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// The method, by which it is coloured.
    pub method: String,
    /// What else the points share.
    pub kind: String,
    /// How points of this kind look.
    pub mark: Mark,
    /// In the order in which they are joined.
    pub points: Vec<Point>,
}

/// The shape of points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// Filled.
    Disc,
    /// A circle.
    Ring,
    /// Filled.
    Square,
    /// A diamond.
    Diamond,
    /// A triangle.
    Triangle,
}

/// A measured point.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Across.
    pub x: f64,
    /// Upwards.
    pub y: f64,
    /// What it is.
    pub label: String,
    /// What measures it again.
    pub command: String,
}

impl Figure {
    /// All points that can be drawn, as `[x, y]`.
    pub(super) fn points(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        let points = self.series.iter().flat_map(|s| &s.points);
        points.map(|p| [p.x, p.y]).filter(|p| self.can_draw(*p))
    }

    /// Whether the axes have a place for this point.
    pub(super) fn can_draw(&self, [x, y]: [f64; 2]) -> bool {
        let has = |axis: &Axis, v: f64| v.is_finite() && (!axis.log || v > 0.0);
        has(&self.x, x) && has(&self.y, y)
    }

    /// Draws the Pareto front of all points.
    pub(super) fn with_front(mut self) -> Self {
        self.front = front(&self.points().collect::<Vec<_>>());
        self
    }
}

/// The points that no other is at most as far as in both coordinates, from left to right.
pub fn front(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let mut front: Vec<[f64; 2]> = Vec::new();
    for point in sorted {
        if front.last().is_none_or(|last| point[1] < last[1]) {
            front.push(point);
        }
    }
    front
}

/// From the least to the most of an axis, with its ticks.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Scale {
    low: f64,
    high: f64,
    log: bool,
    /// Where ticks are, and what stands at them.
    pub(super) ticks: Vec<(f64, String)>,
}

impl Scale {
    /// For these numbers, with a little room around them.
    pub(super) fn of(axis: &Axis, numbers: impl Iterator<Item = f64>) -> Self {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for number in numbers {
            let x = if axis.log { number.log10() } else { number };
            (low, high) = (low.min(x), high.max(x));
        }
        if !(low.is_finite() && high.is_finite()) {
            (low, high) = (0.0, 1.0);
        }
        if !axis.log {
            low = low.min(0.0);
        }
        let room = if high > low { 0.06 * (high - low) } else { 0.3 };
        high += room;
        if axis.log || low < 0.0 {
            low -= room;
        }
        let ticks = if axis.log {
            log_ticks(low, high)
        } else {
            linear_ticks(low, high)
        };
        Self {
            low,
            high,
            log: axis.log,
            ticks,
        }
    }

    /// Where a number lies, 0 to 1.
    pub(super) fn at(&self, number: f64) -> f64 {
        let x = if self.log { number.log10() } else { number };
        (x - self.low) / (self.high - self.low)
    }
}

fn log_ticks(low: f64, high: f64) -> Vec<(f64, String)> {
    if high - low < 0.7 {
        let [low, high] = [low, high].map(|x| 10.0f64.powf(x));
        return linear_ticks(low, high);
    }
    let factors: &[f64] = match high - low {
        span if span > 3.5 => &[1.0],
        span if span > 1.2 => &[1.0, 3.0],
        _ => &[1.0, 1.5, 2.0, 3.0, 5.0, 7.0],
    };
    let decades = low.floor() as i32..=high.ceil() as i32;
    decades
        .flat_map(|decade| factors.iter().map(move |f| f * 10.0f64.powi(decade)))
        .filter(|tick| (low..=high).contains(&tick.log10()))
        .map(|tick| (tick, number::short(tick)))
        .collect()
}

fn linear_ticks(low: f64, high: f64) -> Vec<(f64, String)> {
    let rough = (high - low) / 5.0;
    let decade = 10.0f64.powf(rough.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|f| f * decade);
    let step = steps.into_iter().find(|s| *s >= rough).unwrap_or(steps[3]);
    let first = (low / step).ceil() as i64;
    let last = (high / step).floor() as i64;
    (first..=last)
        .map(|i| i as f64 * step)
        .map(|tick| (tick, number::short(tick)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn on_the_front_nothing_is_better_in_both() {
        let points = [
            [1.0, 5.0],
            [2.0, 5.0],
            [2.0, 3.0],
            [3.0, 4.0],
            [4.0, 1.0],
            [4.0, 2.0],
        ];
        assert_eq!(front(&points), [[1.0, 5.0], [2.0, 3.0], [4.0, 1.0]]);
        assert!(front(&[]).is_empty());
    }

    #[test]
    fn scales_hold_their_numbers_and_some_ticks() {
        for (log, numbers) in [
            (true, vec![0.5, 800.0]),
            (true, vec![3.0, 3.1]),
            (true, vec![7.0]),
            (false, vec![0.0, 12.5]),
            (false, vec![-3.0, 12.5]),
            (false, vec![]),
        ] {
            let axis = Axis {
                label: String::new(),
                log,
            };
            let scale = Scale::of(&axis, numbers.iter().copied());
            assert!(numbers.iter().all(|n| (0.0..=1.0).contains(&scale.at(*n))));
            let places = || scale.ticks.iter().map(|(tick, _)| scale.at(*tick));
            assert!(
                places().all(|p| (-1e-9..=1.0 + 1e-9).contains(&p)),
                "{scale:?}"
            );
            assert!((1..=14).contains(&scale.ticks.len()), "{scale:?}");
        }
    }
}
