//! What a volume's values are like: range, histogram, share of empty voxels.

use rayon::prelude::*;

use super::{Rescale, Volume};
use crate::with_voxels;

/// Number of bins of a [`Statistics`] histogram.
pub const BINS: usize = 256;

/// Voxels that one task counts.
const CHUNK: usize = 1 << 16;

/// Range and histogram of a volume's stored numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Statistics {
    /// Smallest and largest stored number.
    pub stored_range: [f64; 2],
    /// Voxels per bin, [`BINS`] of them; bin i counts `first + i * width <= stored < first + (i + 1) * width`. The
    /// last bin of float data counts the largest number too.
    pub histogram: Vec<u64>,
    /// Lower edge of the first bin, a stored number.
    pub first: f64,
    /// Width of a bin in stored units. Integers have whole widths, and 1 where all their numbers fit the bins.
    pub width: f64,
    /// Whether stored numbers are whole.
    pub integers: bool,
    /// What stored numbers mean.
    pub rescale: Rescale,
}

impl Statistics {
    /// Counts a volume: one pass over 8-bit data, two over others.
    pub fn of(volume: &Volume) -> Self {
        let bounds = volume.voxels.voxel_type().integer_range();
        let stored_range = match bounds {
            // The histogram of 8-bit data tells their range.
            Some([low, high]) if high - low < BINS as f64 => [low, high],
            _ => stored_range(volume),
        };
        let [low, high] = stored_range;
        let integers = bounds.is_some();
        let width = if integers {
            ((high - low + 1.0) / BINS as f64).ceil()
        } else if high > low {
            (high - low) / BINS as f64
        } else {
            1.0
        };
        let histogram = histogram(volume, low, width);
        let stored_range = if integers && width == 1.0 {
            let filled = |i: Option<usize>| low + i.unwrap_or(0) as f64;
            [
                filled(histogram.iter().position(|&n| n > 0)),
                filled(histogram.iter().rposition(|&n| n > 0)),
            ]
        } else {
            stored_range
        };
        Self {
            stored_range,
            histogram,
            first: low,
            width,
            integers,
            rescale: volume.rescale,
        }
    }

    /// Smallest and largest data value.
    pub fn value_range(&self) -> [f64; 2] {
        let [a, b] = self
            .stored_range
            .map(|stored| self.rescale.value_from_stored(stored));
        [a.min(b), a.max(b)]
    }

    /// Number of voxels.
    pub fn count(&self) -> u64 {
        self.histogram.iter().sum()
    }
}

/// Smallest and largest stored number.
pub fn stored_range(volume: &Volume) -> [f64; 2] {
    with_voxels!(&volume.voxels, v => {
        let (low, high) = v
            .par_chunks(CHUNK)
            .map(|chunk| {
                chunk.iter().fold((chunk[0], chunk[0]), |(low, high), &s| {
                    (if s < low { s } else { low }, if s > high { s } else { high })
                })
            })
            .reduce(
                || (v[0], v[0]),
                |a, b| (if b.0 < a.0 { b.0 } else { a.0 }, if b.1 > a.1 { b.1 } else { a.1 }),
            );
        [f64::from(low), f64::from(high)]
    })
}

fn histogram(volume: &Volume, first: f64, width: f64) -> Vec<u64> {
    with_voxels!(&volume.voxels, v => {
        v.par_chunks(CHUNK)
            .fold(
                || [0_u64; BINS],
                |mut bins, chunk| {
                    // Four counters in turn: neighbours are often alike, and an increment waits for the one before.
                    let mut turns = [[0_u32; BINS]; 4];
                    for four in chunk.chunks(4) {
                        for (turn, &stored) in turns.iter_mut().zip(four) {
                            let bin = ((f64::from(stored) - first) / width) as usize;
                            turn[bin.min(BINS - 1)] += 1;
                        }
                    }
                    for (i, bin) in bins.iter_mut().enumerate() {
                        *bin += turns.iter().map(|t| u64::from(t[i])).sum::<u64>();
                    }
                    bins
                },
            )
            .reduce(
                || [0; BINS],
                |mut a, b| {
                    a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
                    a
                },
            )
            .to_vec()
    })
}

/// The share of voxels, 0 to 1, whose data value `is_empty`.
pub fn empty_share(volume: &Volume, is_empty: impl Fn(f64) -> bool + Sync) -> f64 {
    let empty: usize = with_voxels!(&volume.voxels, v => v
        .par_chunks(CHUNK)
        .map(|chunk| {
            chunk
                .iter()
                .filter(|&&s| is_empty(volume.rescale.value_from_stored(f64::from(s))))
                .count()
        })
        .sum());
    empty as f64 / volume.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::{Voxels, phantom};

    fn volume(voxels: Voxels, n: usize) -> Volume {
        Volume {
            dims: [n, 1, 1],
            voxels,
            ..phantom::make("empty", [1; 3]).unwrap()
        }
    }

    #[test]
    fn every_voxel_is_counted_in_the_bin_that_holds_it() {
        let i16s: Vec<i16> = (0..2000).map(|i| i * 7 - 5000).collect();
        let f32s: Vec<f32> = (0..1000).map(|i| i as f32 * 0.37 - 20.0).collect();
        let i8s: Vec<i8> = (-100..100).collect();
        for volume in [
            volume(Voxels::I16(i16s.into()), 2000),
            volume(Voxels::F32(f32s.into()), 1000),
            volume(Voxels::I8(i8s.into()), 200),
            volume(Voxels::F32(vec![3.0; 9].into()), 9),
        ] {
            let statistics = Statistics::of(&volume);
            let stored: Vec<f64> =
                with_voxels!(&volume.voxels, v => v.iter().map(|&s| f64::from(s)).collect());
            let low = stored.iter().copied().fold(f64::INFINITY, f64::min);
            let high = stored.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            assert_eq!(statistics.stored_range, [low, high]);
            assert_eq!(statistics.count() as usize, stored.len());
            for (i, &count) in statistics.histogram.iter().enumerate() {
                let from = statistics.first + i as f64 * statistics.width;
                let to = if i == BINS - 1 {
                    f64::INFINITY
                } else {
                    from + statistics.width
                };
                let inside = stored.iter().filter(|s| (from..to).contains(*s)).count() as i64;
                // An edge of float bins is rounded once here and once there.
                let slack = i64::from(!statistics.integers);
                assert!((inside - count as i64).abs() <= slack, "bin {i}");
            }
        }
    }

    #[test]
    fn integers_that_fit_have_a_bin_each() {
        let statistics = Statistics::of(&volume(Voxels::U16(vec![1000, 1255, 1001].into()), 3));
        assert_eq!((statistics.first, statistics.width), (1000.0, 1.0));
        assert_eq!(statistics.histogram[..2], [1, 1]);
        assert_eq!(statistics.histogram[255], 1);
    }

    #[test]
    fn empty_shares_follow_data_values() {
        let mut v = volume(Voxels::U8(vec![0, 1, 2, 3].into()), 4);
        v.rescale = Rescale {
            slope: -2.0,
            intercept: 1.0,
        };
        assert_eq!(empty_share(&v, |value| value < -2.0), 0.5);
        assert_eq!(Statistics::of(&v).value_range(), [-5.0, 1.0]);
    }
}
