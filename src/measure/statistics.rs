//! Medians of repeated runs. Times on a busy machine have a long tail upwards: a mean would tell of the tail.

/// The middle and the quarters of a set of numbers.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Quartiles {
    /// A quarter of the numbers lies below.
    pub q1: f64,
    /// Half of the numbers lies below.
    pub median: f64,
    /// Three quarters of the numbers lie below.
    pub q3: f64,
}

/// The quartiles, by linear interpolation between the sorted numbers (Hyndman & Fan 1996, definition 7, which is what
/// numpy and R do too).
///
/// # Panics
/// Where there is no number.
pub fn quartiles(numbers: &[f64]) -> Quartiles {
    let mut sorted = numbers.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len() - 1;
    let at = |fraction: f64| {
        let x = fraction * last as f64;
        let lower = x.floor() as usize;
        let upper = (lower + 1).min(last);
        sorted[lower] + (x - lower as f64) * (sorted[upper] - sorted[lower])
    };
    Quartiles {
        q1: at(0.25),
        median: at(0.5),
        q3: at(0.75),
    }
}

/// The median.
///
/// # Panics
/// Where there is no number.
pub fn median(numbers: &[f64]) -> f64 {
    quartiles(numbers).median
}

/// Indices of `contestants` in the order of their runs: A B C, A B C, ... for `rounds` rounds.
///
/// A machine that slows down or is disturbed for a while then slows all contestants, not the one whose turn it was.
pub fn interleaved(contestants: usize, rounds: usize) -> impl Iterator<Item = usize> {
    (0..rounds).flat_map(move |_| 0..contestants)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quartiles_do_not_depend_on_the_order() {
        let expected = Quartiles {
            q1: 2.0,
            median: 3.0,
            q3: 4.0,
        };
        assert_eq!(quartiles(&[1.0, 2.0, 3.0, 4.0, 5.0]), expected);
        assert_eq!(quartiles(&[5.0, 1.0, 4.0, 2.0, 3.0]), expected);
        assert_eq!(median(&[1.0, 2.0]), 1.5);
        assert_eq!(quartiles(&[7.0]).q3, 7.0);
    }

    #[test]
    fn every_contestant_runs_once_per_round() {
        let order: Vec<_> = interleaved(3, 2).collect();
        assert_eq!(order, [0, 1, 2, 0, 1, 2]);
    }
}
