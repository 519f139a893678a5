//! Least squares with coefficients that are not negative: a cost is never a gain.

/// Rounds of coordinate descent. A handful of unknowns settles in some hundred.
const ROUNDS: usize = 4000;

/// One equation: `y ~ sum of x[j] * coefficient[j]`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row<const N: usize> {
    pub(super) x: [f64; N],
    /// Positive.
    pub(super) y: f64,
    /// What its squared relative error counts.
    pub(super) weight: f64,
}

/// The coefficients, none negative, whose weighted squares of *relative* errors have the least sum: a frame of 2 ms is to
/// be as right as one of 200 ms.
///
/// Cyclic coordinate descent with each step cut off at zero (Franc, Hlavac & Navara 2005): for a convex function of a few
/// unknowns that is all it takes.
pub(super) fn non_negative<const N: usize>(rows: &[Row<N>]) -> [f64; N] {
    // Every equation divided by its y and multiplied by the root of its weight.
    let scaled = |row: &Row<N>| row.x.map(|x| x / row.y * row.weight.sqrt());
    // Columns of one length, so that no unit of measurement decides how fast a coefficient settles.
    let mut length = [0.0; N];
    for row in rows {
        for (length, x) in length.iter_mut().zip(scaled(row)) {
            *length += x * x;
        }
    }
    let length = length.map(f64::sqrt);
    let scale = length.map(|l| if l > 0.0 { 1.0 / l } else { 0.0 });
    // Gram matrix and right-hand side.
    let mut gram = [[0.0; N]; N];
    let mut right = [0.0; N];
    for row in rows {
        let x = scaled(row);
        let x: [f64; N] = std::array::from_fn(|j| x[j] * scale[j]);
        for i in 0..N {
            right[i] += x[i] * row.weight.sqrt();
            for j in 0..N {
                gram[i][j] += x[i] * x[j];
            }
        }
    }
    let mut found = [0.0; N];
    for _ in 0..ROUNDS {
        for j in 0..N {
            if gram[j][j] > 0.0 {
                let slope = (0..N).map(|i| gram[j][i] * found[i]).sum::<f64>() - right[j];
                found[j] = f64::max(found[j] - slope / gram[j][j], 0.0);
            }
        }
    }
    std::array::from_fn(|j| found[j] * scale[j])
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn row<const N: usize>(x: [f64; N], y: f64) -> Row<N> {
        Row { x, y, weight: 1.0 }
    }

    proptest! {
        /// What a line of costs generated is found again.
        #[test]
        fn costs_are_found_again(
            costs in prop::array::uniform3(0.0f64..10.0),
            rows in prop::collection::vec(prop::array::uniform2(0.1f64..1000.0), 8..20),
        ) {
            let rows: Vec<Row<3>> = rows
                .iter()
                .map(|&[a, b]| {
                    let x = [1.0, a, b * b];
                    row(x, 1e-3 + x.iter().zip(costs).map(|(x, c)| x * c).sum::<f64>())
                })
                .collect();
            let found = non_negative(&rows);
            for Row { x, y, .. } in &rows {
                let told: f64 = x.iter().zip(found).map(|(x, c)| x * c).sum();
                prop_assert!((told / y - 1.0).abs() < 0.05, "{told} for {y}");
            }
        }
    }

    #[test]
    fn what_seems_to_pay_costs_nothing() {
        // y falls as the second column grows: its coefficient would be negative.
        let rows: Vec<Row<2>> = (0..10)
            .map(|i| row([1.0, f64::from(i)], 20.0 - f64::from(i)))
            .collect();
        let [fixed, each] = non_negative(&rows);
        assert_eq!(each, 0.0);
        assert!((10.0..20.0).contains(&fixed), "{fixed}");
    }

    #[test]
    fn a_column_of_zeros_costs_nothing() {
        let rows = [row([2.0, 0.0], 6.0), row([4.0, 0.0], 12.0)];
        let [each, unseen] = non_negative(&rows);
        assert!((each - 3.0).abs() < 1e-9);
        assert_eq!(unseen, 0.0);
    }

    #[test]
    fn a_heavy_equation_is_heeded_more() {
        let heavy = |weight| {
            let [cost] = non_negative(&[
                row([1.0], 1.0),
                Row {
                    weight,
                    ..row([1.0], 2.0)
                },
            ]);
            cost
        };
        assert!(heavy(0.01) < heavy(1.0) && heavy(1.0) < heavy(100.0));
        assert!((heavy(1e6) - 2.0).abs() < 1e-3);
    }
}
