//! Editing a transfer function: where its points lie in the editor, and what dragging them does.

use crate::transfer::{ControlPoint, TransferFunction};
use crate::volume::Statistics;

/// What of the values and opacities the editor shows, and how it places them: both as parts of its width and height, the
/// height upwards.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axes {
    /// Data values at the left and right edges.
    pub values: [f64; 2],
    /// Whether small opacities are drawn apart: height is then the opacity's fourth root.
    pub near_zero: bool,
}

impl Axes {
    /// All values of a volume.
    pub fn whole(statistics: &Statistics) -> Self {
        let [low, high] = statistics.value_range();
        let high = if high > low { high } else { low + 1.0 };
        Self {
            values: [low, high],
            near_zero: false,
        }
    }

    /// Where a value lies, as a part of the width; beyond 0 to 1 where it is not shown.
    pub fn x(&self, value: f64) -> f64 {
        (value - self.values[0]) / (self.values[1] - self.values[0])
    }

    /// The value at a part of the width.
    pub fn value(&self, x: f64) -> f64 {
        self.values[0] + x * (self.values[1] - self.values[0])
    }

    /// Where an opacity lies, as a part of the height.
    pub fn y(&self, opacity: f64) -> f64 {
        if self.near_zero {
            opacity.sqrt().sqrt()
        } else {
            opacity
        }
    }

    /// The opacity at a part of the height.
    pub fn opacity(&self, y: f64) -> f64 {
        let y = y.clamp(0.0, 1.0);
        if self.near_zero { y.powi(4) } else { y }
    }

    /// Shows more (factor above 1) or fewer values around the one at `x`, never more than `whole` holds.
    pub fn zoom(&mut self, factor: f64, x: f64, whole: [f64; 2]) {
        let fixed = self.value(x);
        let span = whole[1] - whole[0];
        let shown = (self.values[1] - self.values[0]) * factor;
        let shown = shown.clamp(span * 1e-3, span);
        let low = (fixed - x * shown).clamp(whole[0], whole[1] - shown);
        self.values = [low, low + shown];
    }
}

/// Moves a point; it stays between its neighbours.
pub fn move_point(
    transfer: &TransferFunction,
    i: usize,
    value: f64,
    opacity: f64,
) -> Vec<ControlPoint> {
    let mut points = transfer.points().to_vec();
    let low = if i > 0 {
        points[i - 1].value
    } else {
        f64::NEG_INFINITY
    };
    let high = points.get(i + 1).map_or(f64::INFINITY, |next| next.value);
    points[i].value = value.max(low).min(high);
    points[i].opacity = opacity.clamp(0.0, 1.0);
    points
}

/// Adds a point of the colour that is there already; tells where in the list it is.
pub fn add_point(
    transfer: &TransferFunction,
    value: f64,
    opacity: f64,
) -> (Vec<ControlPoint>, usize) {
    let mut points = transfer.points().to_vec();
    let at = points.partition_point(|p| p.value <= value);
    let point = ControlPoint {
        value,
        opacity: opacity.clamp(0.0, 1.0),
        color: transfer.at(value).0,
    };
    points.insert(at, point);
    (points, at)
}

/// Takes a point away; the last one stays.
pub fn remove_point(transfer: &TransferFunction, i: usize) -> Vec<ControlPoint> {
    let mut points = transfer.points().to_vec();
    if points.len() > 1 {
        points.remove(i);
    }
    points
}

/// The function through other points, with the same reference length; what it was where they are no function.
pub fn with_points(transfer: &TransferFunction, points: Vec<ControlPoint>) -> TransferFunction {
    TransferFunction::new(points, transfer.reference_length_voxels)
        .unwrap_or_else(|_| transfer.clone())
}

/// The histogram's bars: data values at both ends, and the height of each as a part of the highest, logarithmic.
pub fn bars(statistics: &Statistics) -> Vec<([f64; 2], f64)> {
    let most = statistics.histogram.iter().copied().max().unwrap_or(0);
    let scale = 1.0 / (most.max(1) as f64).ln_1p();
    let edge = |i: usize| {
        let stored = statistics.first + i as f64 * statistics.width;
        statistics.rescale.value_from_stored(stored)
    };
    let filled = |(i, &count): (usize, &u64)| {
        (count > 0).then(|| {
            let [a, b] = [edge(i), edge(i + 1)];
            ([a.min(b), a.max(b)], (count as f64).ln_1p() * scale)
        })
    };
    statistics
        .histogram
        .iter()
        .enumerate()
        .filter_map(filled)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::phantom;

    fn ramp() -> TransferFunction {
        let statistics = Statistics::of(&phantom::make("pot", [8; 3]).unwrap());
        TransferFunction::from_spec("ramp:0:100:0.5", &statistics).unwrap()
    }

    #[test]
    fn a_dragged_point_stays_between_its_neighbours() {
        let transfer = ramp();
        for (value, opacity, expected) in [
            (60.0, 0.4, (60.0, 0.4)),
            (-9.0, 2.0, (0.0, 1.0)),
            (500.0, -1.0, (100.0, 0.0)),
        ] {
            let points = move_point(&transfer, 1, value, opacity);
            assert_eq!((points[1].value, points[1].opacity), expected);
            let moved = with_points(&transfer, points);
            assert_eq!(moved.points().len(), 3);
        }
    }

    #[test]
    fn an_added_point_changes_nothing_until_it_moves_and_one_point_stays() {
        let transfer = ramp();
        let (points, at) = add_point(&transfer, 75.0, transfer.at(75.0).1);
        assert_eq!(at, 2);
        let added = with_points(&transfer, points);
        for value in [0.0, 30.0, 75.0, 90.0, 100.0] {
            let ([a, b], [c, d]) = (
                [transfer.at(value).1, added.at(value).1],
                [transfer.at(value).0, added.at(value).0],
            );
            assert!((a - b).abs() < 1e-12 && c.iter().zip(d).all(|(x, y)| (x - y).abs() < 1e-12));
        }
        let mut left = transfer;
        for _ in 0..5 {
            left = with_points(&left, remove_point(&left, 0));
        }
        assert_eq!(left.points().len(), 1);
    }

    #[test]
    fn places_and_values_agree_and_zooming_stays_inside() {
        let mut axes = Axes {
            values: [-10.0, 30.0],
            near_zero: true,
        };
        for opacity in [0.0, 1e-4, 0.3, 1.0] {
            assert!((axes.opacity(axes.y(opacity)) - opacity).abs() < 1e-12);
        }
        assert!(axes.y(1e-4) > 0.09);
        let fixed = axes.value(0.25);
        axes.zoom(0.5, 0.25, [-10.0, 30.0]);
        assert!((axes.value(0.25) - fixed).abs() < 1e-12);
        assert!((axes.x(fixed) - 0.25).abs() < 1e-12);
        axes.zoom(100.0, 0.9, [-10.0, 30.0]);
        assert_eq!(axes.values, [-10.0, 30.0]);
    }

    #[test]
    fn bars_cover_the_values_that_there_are() {
        let statistics = Statistics::of(&phantom::make("pot", [16; 3]).unwrap());
        let bars = bars(&statistics);
        assert!(bars.iter().any(|(_, height)| (*height - 1.0).abs() < 1e-12));
        let [low, high] = statistics.value_range();
        assert!(bars[0].0[0] <= low && bars[bars.len() - 1].0[1] >= high);
    }
}
