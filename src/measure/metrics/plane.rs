//! Planes of numbers, and filters along their rows and columns.

/// One channel of a picture, row by row.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Plane {
    pub(super) size: [usize; 2],
    pub(super) values: Vec<f64>,
}

impl Plane {
    pub(super) fn new(size: [usize; 2], values: impl IntoIterator<Item = f64>) -> Self {
        let values: Vec<f64> = values.into_iter().collect();
        assert_eq!(
            values.len(),
            size[0] * size[1],
            "a plane has all its values"
        );
        Self { size, values }
    }

    /// The plane whose value at `i` is `f` of the values of both there.
    pub(super) fn with(&self, other: &Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let pairs = self.values.iter().zip(&other.values);
        Self::new(self.size, pairs.map(|(&a, &b)| f(a, b)))
    }

    /// Each value replaced by the sum of those around it in its row, weighted by `row`, and then in its column by `column`;
    /// both have an odd number of weights, the middle one for the value itself. Beyond an edge its values go on.
    pub(super) fn filtered(&self, row: &[f64], column: &[f64]) -> Self {
        let [width, height] = self.size;
        let mut along = self.clone();
        for y in 0..height {
            let values = &self.values[y * width..][..width];
            for x in 0..width {
                along.values[y * width + x] = weighted(row, x, width, |x| values[x]);
            }
        }
        let mut both = along.clone();
        for y in 0..height {
            for x in 0..width {
                both.values[y * width + x] =
                    weighted(column, y, height, |y| along.values[y * width + x]);
            }
        }
        both
    }
}

fn weighted(weights: &[f64], at: usize, count: usize, value: impl Fn(usize) -> f64) -> f64 {
    let radius = weights.len() / 2;
    let terms = weights.iter().enumerate().map(|(i, weight)| {
        let place = (at + i).saturating_sub(radius).min(count - 1);
        weight * value(place)
    });
    terms.sum()
}

/// `f` at the whole numbers from `-radius` to `radius`.
pub(super) fn kernel(radius: usize, f: impl Fn(f64) -> f64) -> Vec<f64> {
    let radius = radius as i32;
    (-radius..=radius).map(|x| f(f64::from(x))).collect()
}

/// The same weights with a sum of 1.
pub(super) fn normalised(mut weights: Vec<f64>) -> Vec<f64> {
    let sum: f64 = weights.iter().sum();
    for weight in &mut weights {
        *weight /= sum;
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn filters_go_along_their_axis_and_edges_go_on() {
        let plane = Plane::new([3, 2], [1.0, 2.0, 4.0, 0.0, 0.0, 8.0]);
        let moved = plane.filtered(&[0.0, 0.0, 1.0], &[1.0]);
        assert_eq!(moved.values, [2.0, 4.0, 4.0, 0.0, 8.0, 8.0]);
        let moved = plane.filtered(&[1.0], &[1.0, 0.0, 0.0]);
        assert_eq!(moved.values, [1.0, 2.0, 4.0, 1.0, 2.0, 4.0]);
        let mean = normalised(kernel(1, |_| 7.0));
        assert_eq!(plane.filtered(&mean, &mean).values.len(), 6);
    }
}
