//! Least squares with coefficients that are not negative: a cost is never a gain.

/// Rounds of coordinate descent. A handful of unknowns settles in some hundred.
const ROUNDS: usize = 4000;

/// The coefficients, none negative, of `y ~ sum of x[j] * coefficient[j]` whose *relative* errors have the least sum of
/// squares: a frame of 2 ms is to be as right as one of 200 ms. Numbers in `y` are positive.
///
/// Cyclic coordinate descent with each step cut off at zero (Franc, Hlavac & Navara 2005): for a convex function of a few
/// unknowns that is all it takes.
pub(super) fn non_negative<const N: usize>(rows: &[([f64; N], f64)]) -> [f64; N] {
    // Columns of one length, so that no unit of measurement decides how fast a coefficient settles.
    let mut length = [0.0; N];
    for (x, y) in rows {
        for j in 0..N {
            length[j] += (x[j] / y).powi(2);
        }
    }
    let length = length.map(f64::sqrt);
    let scale = length.map(|l| if l > 0.0 { 1.0 / l } else { 0.0 });
    // Gram matrix and right-hand side, every equation divided by its y.
    let mut gram = [[0.0; N]; N];
    let mut right = [0.0; N];
    for (x, y) in rows {
        let x: [f64; N] = std::array::from_fn(|j| x[j] / y * scale[j]);
        for i in 0..N {
            right[i] += x[i];
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

    proptest! {
        /// What a line of costs generated is found again.
        #[test]
        fn costs_are_found_again(
            costs in prop::array::uniform3(0.0f64..10.0),
            rows in prop::collection::vec(prop::array::uniform2(0.1f64..1000.0), 8..20),
        ) {
            let rows: Vec<([f64; 3], f64)> = rows
                .iter()
                .map(|&[a, b]| {
                    let x = [1.0, a, b * b];
                    (x, 1e-3 + x.iter().zip(costs).map(|(x, c)| x * c).sum::<f64>())
                })
                .collect();
            let found = non_negative(&rows);
            for (x, y) in &rows {
                let told: f64 = x.iter().zip(found).map(|(x, c)| x * c).sum();
                prop_assert!((told / y - 1.0).abs() < 0.05, "{told} for {y}");
            }
        }
    }

    #[test]
    fn what_seems_to_pay_costs_nothing() {
        // y falls as the second column grows: its coefficient would be negative.
        let rows: Vec<([f64; 2], f64)> = (0..10)
            .map(|i| ([1.0, f64::from(i)], 20.0 - f64::from(i)))
            .collect();
        let [fixed, each] = non_negative(&rows);
        assert_eq!(each, 0.0);
        assert!((10.0..20.0).contains(&fixed), "{fixed}");
    }

    #[test]
    fn a_column_of_zeros_costs_nothing() {
        let rows = [([2.0, 0.0], 6.0), ([4.0, 0.0], 12.0)];
        let [each, unseen] = non_negative(&rows);
        assert!((each - 3.0).abs() < 1e-9);
        assert_eq!(unseen, 0.0);
    }
}
