//! Medians of repeated runs, and how far they can be trusted. Times on a busy machine have a long tail upwards: a mean would tell of the tail.

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

/// How far a median of so many noisy numbers can be trusted: its standard error over itself, from the distance of the
/// quartiles (which a long tail does not move), as if noise were normal: `1.253 (q3 - q1) / 1.349 / sqrt(n) / median`. `None`
/// for fewer than three numbers, which tell nothing of their noise.
pub fn noise(numbers: &[f64]) -> Option<f64> {
    if numbers.len() < 3 {
        return None;
    }
    let Quartiles { q1, median, q3 } = quartiles(numbers);
    let deviation = (q3 - q1) / 1.349;
    let noise = 1.253 * deviation / (numbers.len() as f64).sqrt() / median;
    noise.is_finite().then_some(noise)
}

/// Indices of `contestants` in the order of their runs: A B C, A B C, ... for `rounds` rounds.
///
/// A machine that slows down or is disturbed for a while then slows all contestants, not the one whose turn it was.
pub fn interleaved(contestants: usize, rounds: usize) -> impl Iterator<Item = usize> {
    (0..rounds).flat_map(move |_| 0..contestants)
}

/// Resamples of a bootstrap.
const RESAMPLES: usize = 2000;

/// The ratio of two contestants' times, and bounds within which it lies.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Ratio {
    /// Median of the pairs' ratios.
    pub median: f64,
    /// It is at least this, with 95 % confidence.
    pub lower: f64,
    /// It is at most this, with 95 % confidence.
    pub upper: f64,
}

/// The ratio of paired times, first over second, with one-sided 95 % bounds by the percentile bootstrap (Efron 1979): the
/// pairs are drawn anew 2,000 times, with replacement, and of the medians of their ratios one in twenty lies below
/// `lower`, and one in twenty above `upper`. Seeded: the same pairs give the same bounds.
///
/// # Panics
/// Where there is no pair.
pub fn paired_ratio(pairs: &[[f64; 2]]) -> Ratio {
    let ratios: Vec<f64> = pairs.iter().map(|[a, b]| a / b).collect();
    let mut random = SplitMix(0x9E37_79B9_7F4A_7C15);
    let mut drawn = vec![0.0; ratios.len()];
    let mut medians: Vec<f64> = (0..RESAMPLES)
        .map(|_| {
            drawn.fill_with(|| ratios[random.below(ratios.len())]);
            median(&drawn)
        })
        .collect();
    medians.sort_by(f64::total_cmp);
    Ratio {
        median: median(&ratios),
        lower: medians[RESAMPLES / 20],
        upper: medians[RESAMPLES - 1 - RESAMPLES / 20],
    }
}

/// `SplitMix64` (Steele, Lea & Flood 2014).
struct SplitMix(u64);

impl SplitMix {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A number below `n`, all alike to within 2^-32.
    fn below(&mut self, n: usize) -> usize {
        (((self.next() >> 32) * n as u64) >> 32) as usize
    }
}

/// The line nearest to `[x, y]` in the least squares' sense: its height at 0 and its slope.
pub fn line_through(points: &[[f64; 2]]) -> [f64; 2] {
    let n = points.len() as f64;
    let mean = [0, 1].map(|i| points.iter().map(|p| p[i]).sum::<f64>() / n);
    let sum = |f: fn([f64; 2]) -> f64| -> f64 {
        let centred = points.iter().map(|p| f([p[0] - mean[0], p[1] - mean[1]]));
        centred.sum()
    };
    let slope = sum(|[x, y]| x * y) / sum(|[x, _]| x * x);
    [mean[1] - slope * mean[0], slope]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Times around `ratio` and 1, of pairs that a busy machine slows together, each with some noise of its own.
    fn noisy_pairs(ratio: f64, count: usize, seed: u64) -> Vec<[f64; 2]> {
        let mut random = SplitMix(seed);
        let mut unit = || random.below(1 << 20) as f64 / f64::from(1 << 20);
        (0..count)
            .map(|_| {
                let busy = 1.0 + 3.0 * unit().powi(4);
                [ratio, 1.0].map(|time| time * busy * (0.97 + 0.06 * unit()))
            })
            .collect()
    }

    #[test]
    fn bounds_hold_the_ratio_about_as_often_as_they_say() {
        for ratio in [0.4, 1.0, 1.3] {
            let found: Vec<Ratio> = (0..200)
                .map(|seed| paired_ratio(&noisy_pairs(ratio, 15, seed)))
                .collect();
            let share = |holds: &dyn Fn(&Ratio) -> bool| {
                found.iter().filter(|r| holds(r)).count() as f64 / found.len() as f64
            };
            assert!(share(&|r| r.lower <= ratio) > 0.88);
            assert!(share(&|r| r.upper >= ratio) > 0.88);
            // Three per cent of noise leave the median of fifteen pairs within three.
            assert!(share(&|r| r.upper - r.lower < 0.06 * ratio) > 0.9);
            assert!(
                found
                    .iter()
                    .all(|r| r.lower <= r.median && r.median <= r.upper)
            );
        }
    }

    #[test]
    fn bounds_are_the_same_again_and_those_of_equal_pairs_are_the_ratio() {
        let pairs = noisy_pairs(0.8, 21, 7);
        assert_eq!(paired_ratio(&pairs), paired_ratio(&pairs));
        let equal = paired_ratio(&[[3.0, 2.0]; 15]);
        assert_eq!((equal.lower, equal.median, equal.upper), (1.5, 1.5, 1.5));
    }

    #[test]
    fn one_disturbed_pair_moves_no_bound() {
        let mut pairs = vec![[1.0, 1.0]; 15];
        pairs[4] = [50.0, 1.0];
        let ratio = paired_ratio(&pairs);
        assert_eq!((ratio.lower, ratio.upper), (1.0, 1.0));
    }

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
    fn noise_is_of_the_numbers_middle_and_falls_with_their_number() {
        assert_eq!(noise(&[1.0, 9.0]), None);
        assert_eq!(noise(&[2.0; 5]), Some(0.0));
        let mut few = vec![9.0, 10.0, 11.0, 10.0, 9.5];
        let of_few = noise(&few).unwrap();
        assert!(of_few > 0.02 && of_few < 0.1, "{of_few}");
        few.extend(few.clone());
        few.extend(few.clone());
        assert!(noise(&few).unwrap() < 0.6 * of_few);
        // One run that was disturbed moves neither quartile far.
        few[2] = 1000.0;
        assert!(noise(&few).unwrap() < of_few);
    }

    #[test]
    fn every_contestant_runs_once_per_round() {
        let order: Vec<_> = interleaved(3, 2).collect();
        assert_eq!(order, [0, 1, 2, 0, 1, 2]);
    }

    #[test]
    fn a_line_goes_through_its_own_points() {
        let points = [1.0, 2.0, 5.0].map(|x| [x, 3.0 - 0.5 * x]);
        let [height, slope] = line_through(&points);
        assert!((height - 3.0).abs() < 1e-12 && (slope + 0.5).abs() < 1e-12);
    }
}
