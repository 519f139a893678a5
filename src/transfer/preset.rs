//! Transfer functions that work on unknown data: by name, from the histogram.

use super::{ControlPoint, TransferFunction};
use crate::error::Result;
use crate::volume::Statistics;

/// A preset's row in the table that every part of the program reads.
#[derive(Debug)]
pub struct Preset {
    /// The name used by flags and files.
    pub name: &'static str,
    /// One line for help texts.
    pub summary: &'static str,
    points: fn(threshold: f64, high: f64, bin: f64) -> Vec<ControlPoint>,
}

/// All presets, the default first.
pub const PRESETS: &[Preset] = &[
    Preset {
        name: "translucent",
        summary: "background invisible, then rising to 0.3 per voxel, in warm colours",
        points: |threshold, high, _| warm_ramp(threshold, high, 0.3).to_vec(),
    },
    Preset {
        name: "opaque",
        summary: "background invisible, then rising to 0.9 per voxel, in warm colours",
        points: |threshold, high, _| warm_ramp(threshold, high, 0.9).to_vec(),
    },
    Preset {
        name: "surface",
        summary: "everything above the background alike and nearly opaque",
        points: |threshold, high, bin| {
            let full = (threshold + bin.max((high - threshold) * 0.02)).min(high);
            let point = |value, opacity| ControlPoint {
                value,
                opacity,
                color: WARM[1],
            };
            vec![point(threshold, 0.0), point(full, 0.9)]
        },
    },
    Preset {
        name: "grey",
        summary: "background invisible, then rising to 0.3 per voxel, from black to white",
        points: |threshold, high, _| {
            let point = |value, opacity, grey| ControlPoint {
                value,
                opacity,
                color: [grey; 3],
            };
            vec![point(threshold, 0.0, 0.0), point(high, 0.3, 1.0)]
        },
    },
];

/// Colours from the first visible value over the middle to the highest.
const WARM: [[f64; 3]; 3] = [[0.55, 0.22, 0.12], [0.9, 0.6, 0.4], [1.0, 0.95, 0.85]];

/// Nothing up to `low`, then opacity rising evenly to `opacity` at `high`, in warm colours.
pub(super) fn warm_ramp(low: f64, high: f64, opacity: f64) -> [ControlPoint; 3] {
    [0.0, 0.5, 1.0].map(|f| ControlPoint {
        value: low + f * (high - low),
        opacity: f * opacity,
        color: WARM[(f * 2.0) as usize],
    })
}

impl Preset {
    /// The preset for data of these statistics.
    ///
    /// # Errors
    /// None that finite statistics can cause.
    pub fn transfer_function(&self, statistics: &Statistics) -> Result<TransferFunction> {
        let [low, high] = statistics.value_range();
        let threshold = threshold(statistics);
        let bin = statistics.width * statistics.rescale.slope.abs();
        let points = if threshold < high {
            (self.points)(threshold, high, bin)
        } else {
            // Nothing but background: nothing to see.
            warm_ramp(low, high, 0.0).to_vec()
        };
        TransferFunction::new(points, 1.0)
    }
}

/// The data value up to which a volume is background: what a preset leaves transparent.
///
/// Two criteria of thresholding err to opposite sides where a small object lies in a large background: Otsu's (1979),
/// which assumes alike spreads, cuts into the object; Li and Lee's minimum cross entropy (1993) into the noise. Their
/// geometric mean is taken, and raised to the foot of the last large peak of the background (air, fat or packing
/// around the object), which is where the histogram lies farthest below the line from that peak down to its end.
///
/// A volume of one value is background if the value is not above 0.
pub fn threshold(statistics: &Statistics) -> f64 {
    let [low, high] = statistics.value_range();
    if low == high {
        return low.min(0.0);
    }
    // Bins in the order of data values, and trimmed to those that are used.
    let mut counts: Vec<u64> = statistics.histogram.clone();
    let falling = statistics.rescale.slope < 0.0;
    if falling {
        counts.reverse();
    }
    let first = counts.iter().position(|&n| n > 0).unwrap_or(0);
    let last = counts.iter().rposition(|&n| n > 0).unwrap_or(0);
    let counts = &counts[first..=last];

    let otsu = otsu(counts);
    let both = (otsu * li(counts, otsu)).sqrt();
    let bin = match background_peak(counts, otsu) {
        Some(peak) => both.max(foot(counts, peak) as f64),
        None => both,
    };
    // In whole bins: integers stay integers.
    let bin = (first as f64 + bin.round()).min((counts.len() + first - 1) as f64);
    let stored_bin = if falling {
        statistics.histogram.len() as f64 - 1.0 - bin
    } else {
        bin
    };
    let stored = statistics.first + stored_bin * statistics.width;
    statistics
        .rescale
        .value_from_stored(stored)
        .clamp(low, high)
}

/// The bin where two classes of bins differ most between and least within; the middle one of several alike.
fn otsu(counts: &[u64]) -> f64 {
    let total: f64 = counts.iter().map(|&n| n as f64).sum();
    let moment: f64 = (0..)
        .zip(counts)
        .map(|(i, &n)| f64::from(i) * n as f64)
        .sum();
    let (mut below, mut moment_below) = (0.0, 0.0);
    let mut best = (0.0, 1, 1);
    for (i, &n) in counts[..counts.len() - 1].iter().enumerate() {
        below += n as f64;
        moment_below += i as f64 * n as f64;
        let above = total - below;
        let apart = moment_below / below - (moment - moment_below) / above;
        let between = apart * apart * below * above;
        if between > best.0 {
            best = (between, i + 1, i + 1);
        } else if between == best.0 {
            best.2 = i + 1;
        }
    }
    f64::from(best.1 as u32 + best.2 as u32) * 0.5
}

/// The same of all bins but the lowest.
fn otsu_of_rest(counts: &[u64]) -> f64 {
    1.0 + otsu(&counts[1..])
}

/// Li and Lee's threshold by their fixed-point iteration (Li and Tam 1998), from `start`; bins count from 1.
fn li(counts: &[u64], start: f64) -> f64 {
    let mean = |bins: std::ops::Range<usize>| {
        let (n, moment) = bins.fold((0.0, 0.0), |(n, moment), i| {
            let count = counts[i] as f64;
            (n + count, moment + (i as f64 + 1.0) * count)
        });
        moment / n
    };
    let mut threshold = start;
    for _ in 0..100 {
        let cut = (threshold as usize + 1).clamp(1, counts.len() - 1);
        let (below, above) = (mean(0..cut), mean(cut..counts.len()));
        if above <= below {
            break;
        }
        let next = (above - below) / (above / below).ln() - 1.0;
        if (next - threshold).abs() < 0.05 {
            break;
        }
        threshold = next;
    }
    threshold.max(0.0)
}

/// The last peak of the background but for its lowest bin: one that holds, over the bins around it from half its height to
/// all of it, a tenth of what lies
/// above the lowest bin, and lies below Otsu's threshold. Where the lowest bin is a spike (air cut off to one number),
/// that threshold parts the spike from the noise; then a peak of the dimmer half counts that lies below Otsu's
/// threshold of the rest and outweighs all that is brighter two to one.
fn background_peak(counts: &[u64], otsu: f64) -> Option<usize> {
    let above_lowest: u64 = counts[1..].iter().sum();
    if counts.len() < 3 {
        return None;
    }
    // Otsu's threshold cuts a peak anywhere: one bin of slack, for data of few values.
    let end = |threshold: f64| (threshold as usize + 2).min(counts.len());
    let (sure, end) = (end(otsu), end(otsu_of_rest(counts).max(otsu)));
    // Combs, as rescaled integers make them, are smoothed away.
    let reach = counts.len() / 64;
    let smooth: Vec<f64> = (0..counts.len())
        .map(|i| {
            let around =
                i.saturating_sub(reach).max(usize::from(i > 0))..(i + reach + 1).min(counts.len());
            let n = around.len() as f64;
            counts[around].iter().map(|&c| c as f64).sum::<f64>() / n
        })
        .collect();
    (1..end).rev().find(|&i| {
        let higher = |j: Option<&f64>| j.is_some_and(|&j| j > smooth[i]);
        if higher(smooth.get(i - 1)) || higher(smooth.get(i + 1)) {
            return false;
        }
        let part = |&j: &usize| (smooth[i] * 0.5..=smooth[i]).contains(&smooth[j]);
        let from = (1..i).rev().take_while(part).count();
        let to = (i..counts.len()).take_while(part).count();
        // A valley before it makes a peak; ripples on the lowest bin's long tail do not.
        let valley = smooth[i - from..=i]
            .iter()
            .copied()
            .fold(f64::INFINITY, f64::min);
        let rises = valley < 0.9 * smooth[i];
        let mass: u64 = counts[i - from..i + to].iter().sum();
        let brighter: u64 = counts[i + to..].iter().sum();
        let background = i < sure || (i * 2 < counts.len() && mass > 2 * brighter);
        rises && background && mass * 10 >= above_lowest
    })
}

/// The bin after `peak` that lies farthest below the straight line from the peak to 0 at the end (after Zack et al.
/// 1977, whose line ends on the last bin: where values were cut off to it, that is a spike).
fn foot(counts: &[u64], peak: usize) -> usize {
    let last = counts.len() - 1;
    let top = counts[peak] as f64;
    let below = |i: usize| top * (last - i) as f64 / (last - peak).max(1) as f64 - counts[i] as f64;
    (peak..=last)
        .max_by(|&a, &b| below(a).total_cmp(&below(b)))
        .unwrap_or(peak)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::{Rescale, Volume, Voxels, phantom};

    fn volume(voxels: Vec<u8>) -> Volume {
        Volume {
            dims: [voxels.len(), 1, 1],
            voxels: Voxels::U8(voxels.into()),
            ..phantom::make("empty", [1; 3]).unwrap()
        }
    }

    /// A background that is 0, noise about `noise`, and an object about `object`.
    fn scan(noise: u8, object: u8) -> Volume {
        let bell = |centre: u8, n: usize| {
            (0..n).map(move |i| {
                let spread: i32 = (0..4)
                    .map(|k| ((i * 7919 + i / 13 * (k + 1)) >> (3 * k)) as i32 % 7 - 3)
                    .sum();
                (i32::from(centre) + spread) as u8
            })
        };
        volume(
            std::iter::repeat_n(0, 50_000)
                .chain(bell(noise, 20_000))
                .chain(bell(object, 3_000))
                .collect(),
        )
    }

    #[test]
    fn the_threshold_parts_noise_from_object() {
        for (noise, object) in [(20, 100), (20, 200), (40, 120), (60, 240)] {
            let at = threshold(&Statistics::of(&scan(noise, object)));
            assert!(
                at >= f64::from(noise) + 12.0 && at <= f64::from(object) - 12.0,
                "{noise} {object}: {at}"
            );
        }
    }

    #[test]
    fn the_threshold_goes_with_the_data_values() {
        let mut scan = scan(20, 200);
        let stored = threshold(&Statistics::of(&scan));
        scan.rescale = Rescale {
            slope: 2.0,
            intercept: -100.0,
        };
        assert_eq!(threshold(&Statistics::of(&scan)), 2.0 * stored - 100.0);
        // Turned round, the object is the many zeros: what was highest is background.
        scan.rescale = Rescale {
            slope: -1.0,
            intercept: 0.0,
        };
        let at = threshold(&Statistics::of(&scan));
        assert!((-188.0..=-1.0).contains(&at), "{at}");
    }

    #[test]
    fn presets_hide_the_background_and_show_the_object() {
        for preset in PRESETS {
            let tf = preset
                .transfer_function(&Statistics::of(&scan(20, 200)))
                .unwrap();
            assert_eq!(tf.at(0.0).1, 0.0, "{}", preset.name);
            assert_eq!(tf.at(32.0).1, 0.0, "{}", preset.name);
            assert!(tf.at(200.0).1 > 0.2, "{}", preset.name);
        }
    }

    #[test]
    fn a_volume_of_one_value_is_visible_if_the_value_is_above_zero() {
        for (value, visible) in [(0, false), (200, true)] {
            for preset in PRESETS {
                let tf = preset
                    .transfer_function(&Statistics::of(&volume(vec![value; 10])))
                    .unwrap();
                assert_eq!(tf.at(f64::from(value)).1 > 0.0, visible, "{}", preset.name);
            }
        }
    }

    #[test]
    fn no_material_of_a_phantom_is_taken_for_background() {
        for (name, least) in [
            ("sphere", 200.0),
            ("shells", 160.0),
            ("pot", 200.0),
            ("slab", 100.0),
        ] {
            let statistics = Statistics::of(&phantom::make(name, [48; 3]).unwrap());
            let at = threshold(&statistics);
            assert!(at < least, "{name}: {at}");
        }
    }

    #[test]
    fn two_values_are_parted_between_them() {
        let menger = phantom::make("menger", [27; 3]).unwrap();
        let at = threshold(&Statistics::of(&menger));
        assert!((1.0..200.0).contains(&at), "{at}");
    }
}
