//! Charts before they are drawn: as SVG in the page, or as files by [`crate::output::drawing`].

use super::number;

/// A chart.
#[derive(Debug, Clone, Default, PartialEq)]
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

/// An axis, on which equal lengths are equal ratios.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Axis {
    /// What it counts, with its unit.
    pub label: String,
    /// Whether its ticks are the numbers that were measured at, where these are few, in place of round ones.
    pub at_points: bool,
}

impl Axis {
    /// An axis with round ticks.
    pub(super) fn new(label: &str) -> Self {
        Self {
            label: label.to_owned(),
            at_points: false,
        }
    }

    /// An axis of a few numbers that someone chose.
    pub(super) fn chosen(label: &str) -> Self {
        Self {
            at_points: true,
            ..Self::new(label)
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
    /// Hollow.
    Ring,
    /// Filled.
    Square,
    /// Hollow.
    Frame,
    /// Filled.
    Diamond,
    /// Hollow.
    Rhomb,
    /// Filled.
    Triangle,
    /// Hollow.
    Wedge,
}

impl Mark {
    /// All, in the order in which kinds take them; more kinds begin again.
    const ALL: [Self; 8] = [
        Self::Disc,
        Self::Ring,
        Self::Square,
        Self::Triangle,
        Self::Diamond,
        Self::Frame,
        Self::Wedge,
        Self::Rhomb,
    ];

    /// Whether its inside is empty.
    pub(super) fn is_hollow(self) -> bool {
        matches!(self, Self::Ring | Self::Frame | Self::Rhomb | Self::Wedge)
    }
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

/// Adds a point to the series of its method and kind, which is begun where it is the first.
pub(super) fn add(all: &mut Vec<Series>, method: &str, kind: &str, point: Point) {
    let is_its = |s: &&mut Series| s.method == method && s.kind == kind;
    if let Some(series) = all.iter_mut().find(is_its) {
        series.points.push(point);
        return;
    }
    let kinds = kinds(all);
    let known = kinds.iter().find(|(_, other)| *other == kind);
    let next = Mark::ALL[kinds.len() % Mark::ALL.len()];
    all.push(Series {
        method: method.to_owned(),
        kind: kind.to_owned(),
        mark: known.map_or(next, |(mark, _)| *mark),
        points: vec![point],
    });
}

/// The kinds of some series with their marks, each once.
pub(super) fn kinds(all: &[Series]) -> Vec<(Mark, &str)> {
    let mut kinds: Vec<(Mark, &str)> = Vec::new();
    for series in all {
        if !kinds.iter().any(|(_, kind)| *kind == series.kind) {
            kinds.push((series.mark, &series.kind));
        }
    }
    kinds
}

impl Figure {
    /// All points that can be drawn, as `[x, y]`.
    pub(super) fn points(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        let points = self.series.iter().flat_map(|s| &s.points);
        points.map(|p| [p.x, p.y]).filter(|p| can_draw(*p))
    }

    /// Draws the Pareto front of the points of these series.
    pub(super) fn with_front_of(mut self, is_meant: impl Fn(&Series) -> bool) -> Self {
        let meant = self.series.iter().filter(|s| is_meant(s));
        let points = meant.flat_map(|s| &s.points).map(|p| [p.x, p.y]);
        self.front = front(&points.filter(|p| can_draw(*p)).collect::<Vec<_>>());
        self
    }
}

/// Whether logarithmic axes have a place for this point.
pub(super) fn can_draw(point: [f64; 2]) -> bool {
    point.iter().all(|v| v.is_finite() && *v > 0.0)
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
    /// Logarithms to the base of 10.
    low: f64,
    high: f64,
    /// Where ticks are, and what stands at them.
    pub(super) ticks: Vec<(f64, String)>,
    /// Lines without a number between them.
    pub(super) between: Vec<f64>,
}

impl Scale {
    /// For these positive numbers, with a little room around them.
    pub(super) fn of(axis: &Axis, numbers: impl Iterator<Item = f64>) -> Self {
        let mut logs: Vec<f64> = numbers.map(f64::log10).collect();
        logs.sort_by(f64::total_cmp);
        let (low, high) = match (logs.first(), logs.last()) {
            (Some(&low), Some(&high)) => (low, high),
            _ => (0.0, 1.0),
        };
        let room = if high > low { 0.06 * (high - low) } else { 0.3 };
        let (low, high) = (low - room, high + room);
        logs.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
        let least = 0.04 * (high - low);
        let are_apart = logs.windows(2).all(|pair| pair[1] - pair[0] > least);
        let ticks = if axis.at_points && are_apart && (2..=8).contains(&logs.len()) {
            logs.iter().map(|log| 10.0_f64.powf(*log)).collect()
        } else {
            round_ticks(low, high)
        };
        let is_free = |number: &f64| !ticks.iter().any(|t: &f64| (t / number - 1.0).abs() < 1e-6);
        let between = if axis.at_points || high - low > 3.5 {
            Vec::new()
        } else {
            let all = in_decades(low, high, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]);
            all.into_iter().filter(is_free).collect()
        };
        let named = |tick: f64| (tick, number::short(tick));
        Self {
            low,
            high,
            ticks: ticks.into_iter().map(named).collect(),
            between,
        }
    }

    /// Where a number lies, 0 to 1.
    pub(super) fn at(&self, number: f64) -> f64 {
        (number.log10() - self.low) / (self.high - self.low)
    }
}

/// About five round numbers between two logarithms.
fn round_ticks(low: f64, high: f64) -> Vec<f64> {
    match high - low {
        span if span < 0.6 => linear_ticks(10.0_f64.powf(low), 10.0_f64.powf(high)),
        span if span > 3.5 => in_decades(low, high, &[1.0]),
        span if span > 1.8 => in_decades(low, high, &[1.0, 3.0]),
        _ => in_decades(low, high, &[1.0, 2.0, 5.0]),
    }
}

/// These factors of the powers of ten between two logarithms.
fn in_decades(low: f64, high: f64, factors: &[f64]) -> Vec<f64> {
    (low.floor() as i32..=high.ceil() as i32)
        .flat_map(|decade| factors.iter().map(move |f| f * 10.0_f64.powi(decade)))
        .filter(|tick| (low..=high).contains(&tick.log10()))
        .collect()
}

fn linear_ticks(low: f64, high: f64) -> Vec<f64> {
    let rough = (high - low) / 5.0;
    let decade = 10.0_f64.powf(rough.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|f| f * decade);
    let step = steps.into_iter().find(|s| *s >= rough).unwrap_or(steps[3]);
    let first = (low / step).ceil() as i64;
    let last = (high / step).floor() as i64;
    (first..=last).map(|i| i as f64 * step).collect()
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
        for (at_points, numbers) in [
            (false, vec![0.5, 800.0]),
            (false, vec![3.0, 3.1]),
            (false, vec![7.0]),
            (false, vec![1e-6, 2.0]),
            (false, vec![]),
            (true, vec![32.0, 64.0, 128.0, 64.0]),
            (true, vec![1.0, 1.001, 9.0]),
        ] {
            let axis = Axis {
                label: String::new(),
                at_points,
            };
            let scale = Scale::of(&axis, numbers.iter().copied());
            assert!(numbers.iter().all(|n| (0.0..=1.0).contains(&scale.at(*n))));
            let places = || scale.ticks.iter().map(|(tick, _)| scale.at(*tick));
            assert!(
                places().all(|p| (-1e-9..=1.0 + 1e-9).contains(&p)),
                "{scale:?}"
            );
            assert!((1..=10).contains(&scale.ticks.len()), "{scale:?}");
        }
        let blocks = Scale::of(&Axis::chosen("block"), [2.0, 4.0, 8.0].into_iter());
        let named: Vec<&str> = blocks.ticks.iter().map(|(_, name)| name.as_str()).collect();
        assert_eq!(named, ["2", "4", "8"]);
    }

    #[test]
    fn points_of_a_method_and_kind_are_one_series_and_kinds_have_marks_of_their_own() {
        let mut all = Vec::new();
        let point = |x| Point {
            x,
            y: 1.0,
            label: String::new(),
            command: String::new(),
        };
        for (method, kind) in [("a", "cpu"), ("a", "gpu"), ("b", "gpu"), ("a", "cpu")] {
            add(&mut all, method, kind, point(1.0));
        }
        assert_eq!(all.len(), 3);
        assert_eq!(all[0].points.len(), 2);
        assert_eq!(all[1].mark, all[2].mark);
        assert_ne!(all[0].mark, all[1].mark);
        assert_eq!(kinds(&all).len(), 2);
    }
}
