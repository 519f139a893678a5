//! Pre-integration (Engel, Kraus & Ertl 2001): the colour and opacity of an interval whose values go evenly from one to
//! another, for all pairs of values.
//!
//! Extinction is linear between the entries of the table that it is made from, and so is what is emitted. Sums over the
//! entries give the integral of both over any range in constant time, so that a table follows an edit at once (`cargo bench
//! --bench octree` tells what it takes). What the
//! front of an interval absorbs of the light from its back is accounted for twice over: exactly where the colour does not
//! change, and by cutting the range into pieces where it does. Both errors are of third order in an interval
//! whose colour is smooth and of second order in the one that a steep entry falls into: of second order in all.

use std::sync::Arc;

use rayon::prelude::*;

use crate::transfer::{Table, lookup};

/// Values for which all pairs are kept: at 16 bytes a pair 4 MiB, which processors' caches hold.
///
/// A table of which data use more entries is reduced to as many, each the mean of what lies around it: then a peak
/// narrower than that counts with its area, as it does in every interval that spans it.
pub const MOST_NODES: usize = 512;

/// Pieces of equal range that every interval is cut into: as many for a short one as for a long one, so that errors fall
/// evenly with the step.
const PIECES: usize = 8;

/// Optical depth of a step through what is opaque at any length: a hundredth of it still is, to f32's last bit but ten.
const OPAQUE: f64 = 1024.0;

/// Colour and opacity of every pair of values.
#[derive(Debug)]
pub struct PreIntegrated {
    nodes: Arc<Table>,
    pairs: Vec<[f32; 4]>,
}

impl PreIntegrated {
    /// The pairs over `stored_range` (smallest and largest stored number of the volume) of a table, which says what a step
    /// is. Computed in parallel.
    pub fn new(table: &Table, stored_range: [f64; 2]) -> Self {
        let nodes = reduced(table, stored_range);
        let integrals = Integrals::new(&nodes);
        let running = integrals.running();
        let n = nodes.rgba().len();
        // Both ways at once: what a pair costs is the exponentials of its pieces. Short rows come last.
        let half: Vec<Vec<[[f32; 4]; 2]>> = (0..n)
            .into_par_iter()
            .with_max_len(8)
            .map(|low| {
                let node = attenuated(integrals.densities[low]);
                let others = (low + 1..n).map(|high| between(&running, low, high));
                let pairs = std::iter::once([node; 2]).chain(others);
                pairs
                    .map(|ways| ways.map(|way| way.map(|c| c as f32)))
                    .collect()
            })
            .collect();
        let mut pairs = vec![[0.0; 4]; n * n];
        for (low, row) in half.iter().enumerate() {
            for (high, [up, down]) in (low..).zip(row) {
                pairs[low * n + high] = *up;
                pairs[high * n + low] = *down;
            }
        }
        Self {
            nodes: Arc::new(nodes),
            pairs,
        }
    }

    /// The values for which all pairs are kept, as a table: a block is empty where it shows nothing over the block's range.
    ///
    /// Of two blocks that touch, closed supports overlap, and so do ranges. Hence what is between two values of an interval
    /// that meets empty blocks alone is in the range of one of them, and adds nothing.
    pub fn nodes(&self) -> &Arc<Table> {
        &self.nodes
    }

    /// Premultiplied colour and opacity of a step from value `front` to value `back`, at `front * n + back`, where `n` is
    /// the number of nodes.
    pub fn pairs(&self) -> &[[f32; 4]] {
        &self.pairs
    }
}

/// The part of a table that data in this range use, with at most [`MOST_NODES`] entries.
fn reduced(table: &Table, stored_range: [f64; 2]) -> Table {
    let domain = table.domain();
    let last = (domain.entries - 1) as f64;
    let [a, b] = stored_range.map(|stored| domain.x_from_stored(stored).clamp(0.0, last));
    let (first, end) = (a.min(b).floor(), a.max(b).ceil());
    let used = (end - first) as usize + 1;
    if used <= MOST_NODES {
        let part = table.rgba()[first as usize..=end as usize].to_vec();
        return Table::new(part, domain.part(first, 1.0, used));
    }
    let spacing = (end - first) / (MOST_NODES - 1) as f64;
    let entries = (0..MOST_NODES).map(|node| {
        let x = first + node as f64 * spacing;
        let [low, high] = [x - spacing, x + spacing];
        let around = (low.ceil().max(first) as usize)..=(high.floor().min(end) as usize);
        let (mut mean, mut weights) = ([0.0; 4], 0.0);
        for i in around {
            let weight = (1.0 - (i as f64 - x).abs() / spacing).max(0.0);
            let density = density(table.rgba()[i]);
            mean = std::array::from_fn(|c| mean[c] + weight * density[c]);
            weights += weight;
        }
        attenuated(mean.map(|c| c / weights)).map(|c| c as f32)
    });
    Table::new(entries.collect(), domain.part(first, spacing, MOST_NODES))
}

/// Emission (red, green, blue) and extinction over one step, of a premultiplied colour and opacity of one step.
fn density(rgba: [f32; 4]) -> [f64; 4] {
    let [r, g, b, opacity] = rgba.map(f64::from);
    if opacity <= 0.0 {
        return [0.0; 4];
    }
    let depth = if opacity >= 1.0 {
        OPAQUE
    } else {
        -f64::ln_1p(-opacity)
    };
    let per_opacity = depth / opacity;
    [r * per_opacity, g * per_opacity, b * per_opacity, depth]
}

/// The reverse of [`density`]: what of so much emission comes out through so much extinction that goes with it.
fn attenuated([r, g, b, depth]: [f64; 4]) -> [f64; 4] {
    if depth <= 0.0 {
        return [0.0; 4];
    }
    let opacity = -f64::exp_m1(-depth);
    let share = opacity / depth;
    [r * share, g * share, b * share, opacity]
}

/// Emission and extinction of a table, and their sums: what intervals are made of.
#[derive(Debug)]
pub struct Integrals {
    densities: Vec<[f64; 4]>,
    /// Integrals from the first entry to each.
    sums: Vec<[f64; 4]>,
    snap: f64,
}

impl Integrals {
    /// Those of a table.
    pub fn new(table: &Table) -> Self {
        let densities: Vec<[f64; 4]> = table.rgba().iter().map(|&rgba| density(rgba)).collect();
        let mut sums = Vec::with_capacity(densities.len());
        let mut sum = [0.0; 4];
        sums.push(sum);
        for pair in densities.windows(2) {
            sum = std::array::from_fn(|c| sum[c] + 0.5 * (pair[0][c] + pair[1][c]));
            sums.push(sum);
        }
        Self {
            densities,
            sums,
            snap: table.domain().snap(),
        }
    }

    /// Premultiplied colour and opacity of a step whose values go evenly from `front` to `back` (table coordinates, snapped
    /// to entries as [`lookup`] does).
    pub fn interval(&self, front: f64, back: f64) -> [f64; 4] {
        let entries = self.densities.len() as f64;
        let [front, back] = [front, back].map(|x| {
            let (lower, fraction) = lookup(x, entries, self.snap);
            lower + fraction
        });
        let [up, down] = self.both_ways(front.min(back), front.max(back));
        if front <= back { up } else { down }
    }

    /// The same from `low` to `high`, and from `high` to `low`.
    fn both_ways(&self, low: f64, high: f64) -> [[f64; 4]; 2] {
        let range = high - low;
        if range <= 0.0 {
            return [attenuated(self.at(low)); 2];
        }
        let whole = self.integral(low, high);
        // What is not there is exactly nothing.
        if whole[3] == 0.0 {
            return [[0.0; 4]; 2];
        }
        let end = |i: usize| low + range * (i as f64 / PIECES as f64);
        of_pieces(range, |i| self.integral(end(i), end(i + 1)))
    }

    /// Integrals from the first entry to every [`PIECES`]th part of the way from entry to entry: ends of the pieces of all
    /// intervals between entries are among them.
    fn running(&self) -> Vec<[f64; 4]> {
        let parts = (self.densities.len() - 1) * PIECES;
        let running = |part: usize| {
            let entry = part / PIECES;
            let way = (part % PIECES) as f64 / PIECES as f64;
            let next = (entry + 1).min(self.densities.len() - 1);
            let rise = combined(self.densities[entry], self.densities[next], |a, b| {
                way * (a + 0.5 * way * (b - a))
            });
            combined(self.sums[entry], rise, |sum, rise| sum + rise)
        };
        (0..=parts).map(running).collect()
    }

    fn at(&self, x: f64) -> [f64; 4] {
        let lower = x as usize;
        let upper = (lower + 1).min(self.densities.len() - 1);
        let (a, b) = (self.densities[lower], self.densities[upper]);
        std::array::from_fn(|c| a[c] + (x - lower as f64) * (b[c] - a[c]))
    }

    /// The integral over table coordinates. Whole cells by their sums, the rest on its own: differences of sums alone would
    /// leave nothing of a narrow range.
    fn integral(&self, low: f64, high: f64) -> [f64; 4] {
        let (first, last) = (low.ceil(), high.floor());
        let trapezoid = |from: f64, to: f64| {
            let (a, b) = (self.at(from), self.at(to));
            combined(a, b, |a, b| 0.5 * (to - from) * (a + b))
        };
        if last < first {
            return trapezoid(low, high);
        }
        let cells = combined(
            self.sums[last as usize],
            self.sums[first as usize],
            |b, a| b - a,
        );
        let [before, after] = [trapezoid(low, first), trapezoid(last, high)];
        std::array::from_fn(|c| before[c] + cells[c] + after[c])
    }
}

/// Colour and opacity of a step from entry `low` to entry `high` above it, and of one from `high` to `low`, by
/// [`Integrals::running`].
fn between(running: &[[f64; 4]], low: usize, high: usize) -> [[f64; 4]; 2] {
    let (first, cells) = (low * PIECES, high - low);
    if running[first][3] == running[high * PIECES][3] {
        return [[0.0; 4]; 2];
    }
    of_pieces(cells as f64, |i| {
        let [from, to] = [i, i + 1].map(|end| running[first + cells * end]);
        combined(from, to, |from, to| to - from)
    })
}

/// Colour and opacity of a step over a range of table coordinates, in the order of its pieces and in the other one.
/// `integral` is that of a piece.
fn of_pieces(range: f64, integral: impl Fn(usize) -> [f64; 4]) -> [[f64; 4]; 2] {
    let (mut up, mut down) = ([0.0; 4], [0.0; 4]);
    let per_range = 1.0 / range;
    for i in 0..PIECES {
        let piece = attenuated(integral(i).map(|c| c * per_range));
        up = over(up, piece);
        down = over(piece, down);
    }
    [up, down]
}

fn combined(a: [f64; 4], b: [f64; 4], f: impl Fn(f64, f64) -> f64) -> [f64; 4] {
    std::array::from_fn(|c| f(a[c], b[c]))
}

/// A premultiplied colour before another.
fn over(front: [f64; 4], back: [f64; 4]) -> [f64; 4] {
    std::array::from_fn(|c| front[c] + (1.0 - front[3]) * back[c])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transfer::{ControlPoint, Domain, TransferFunction};
    use crate::volume::{Volume, Voxels, phantom};

    /// A table over 16-bit data with a jump, a thin peak and colours that change.
    fn table(entries: usize, step: f64) -> Table {
        let volume = Volume {
            voxels: Voxels::U16(vec![0; 8].into()),
            ..phantom::make("empty", [2; 3]).unwrap()
        };
        let at = |share: f64, opacity, color| ControlPoint {
            value: 65535.0 * share,
            opacity,
            color,
        };
        let function = TransferFunction::new(
            vec![
                at(0.2, 0.0, [1.0, 0.0, 0.0]),
                at(0.2, 0.3, [1.0, 0.0, 0.0]),
                at(0.5, 0.1, [0.0, 1.0, 0.0]),
                at(0.6, 0.0, [0.0, 0.0, 1.0]),
                at(0.8, 0.0, [0.0, 0.0, 1.0]),
                at(0.801, 0.9, [0.0, 0.0, 1.0]),
                at(0.802, 0.0, [0.0, 0.0, 1.0]),
            ],
            1.0,
        )
        .unwrap();
        function.bake(
            &Domain::new(&volume, [0.0, 65535.0], entries).unwrap(),
            step,
        )
    }

    /// The same in many thin slices.
    fn brute_force(table: &Table, front: f64, back: f64) -> [f64; 4] {
        let slices = 20_000;
        let mut sum = [0.0; 4];
        for i in 0..slices {
            let x = front + (back - front) * (f64::from(i) + 0.5) / f64::from(slices);
            let lower = x as usize;
            let upper = (lower + 1).min(table.rgba().len() - 1);
            let (a, b) = (density(table.rgba()[lower]), density(table.rgba()[upper]));
            let slice = std::array::from_fn(|c| {
                (a[c] + (x - lower as f64) * (b[c] - a[c])) / f64::from(slices)
            });
            sum = over(sum, attenuated(slice));
        }
        sum
    }

    #[test]
    fn intervals_are_what_thin_slices_add_up_to() {
        let table = table(256, 1.5);
        let integrals = Integrals::new(&table);
        let ends = [0.0, 40.3, 51.0, 90.5, 91.0, 130.0, 203.7, 204.2, 255.0];
        let mut worst: f64 = 0.0;
        for front in ends {
            for back in ends {
                let ours = integrals.interval(front, back);
                let truth = brute_force(&table, front, back);
                for (c, (ours, truth)) in ours.iter().zip(truth).enumerate() {
                    let off = (ours - truth).abs();
                    // Opacity is exact; colours that change within a piece are mixed in it.
                    assert!(c < 3 || off < 1e-6, "{front} {back}: {ours} {truth}");
                    worst = worst.max(off);
                }
            }
        }
        assert!(worst < 2e-3, "colours are off by up to {worst}");
    }

    #[test]
    fn pairs_of_equal_values_are_the_table_s_entries() {
        let table = table(256, 0.5);
        let made = PreIntegrated::new(&table, [0.0, 65535.0]);
        assert_eq!(made.nodes().as_ref(), &table);
        for (i, entry) in table.rgba().iter().enumerate() {
            for (a, b) in made.pairs()[i * 256 + i].iter().zip(entry) {
                assert!((a - b).abs() < 1e-6);
            }
        }
    }

    /// What is kept of all pairs is what intervals between any two values are.
    #[test]
    fn pairs_are_the_intervals_between_their_values() {
        let table = table(256, 1.5);
        let integrals = Integrals::new(&table);
        let made = PreIntegrated::new(&table, [0.0, 65535.0]);
        for (i, pair) in made.pairs().iter().enumerate() {
            let interval = integrals.interval((i / 256) as f64, (i % 256) as f64);
            for (ours, exact) in pair.iter().zip(interval) {
                assert!((f64::from(*ours) - exact).abs() < 1e-6, "{i}: {pair:?}");
            }
        }
    }

    #[test]
    fn what_no_entry_between_shows_is_exactly_nothing() {
        for entries in [256, 4096] {
            let made = PreIntegrated::new(&table(entries, 0.5), [0.0, 65535.0]);
            let n = made.nodes().rgba().len();
            for front in 0..n {
                for back in 0..n {
                    let range = front.min(back) as f64..=front.max(back) as f64;
                    let is_visible = made.nodes().is_visible(range);
                    assert_eq!(made.pairs()[front * n + back] != [0.0; 4], is_visible);
                }
            }
        }
    }

    /// A reduced table keeps the area of a peak that is narrower than its nodes.
    #[test]
    fn a_thin_peak_keeps_its_area_in_fewer_nodes() {
        let table = table(65536, 0.5);
        let made = PreIntegrated::new(&table, [0.0, 65535.0]);
        let n = made.nodes().rgba().len();
        assert_eq!(n, MOST_NODES);
        let (front, back) = (n * 7 / 10, n * 9 / 10);
        let x = |node: usize| node as f64 * 65535.0 / (n - 1) as f64;
        let whole = Integrals::new(&table).interval(x(front), x(back))[3];
        let ours = f64::from(made.pairs()[front * n + back][3]);
        assert!(
            whole > 0.0 && (ours / whole - 1.0).abs() < 0.01,
            "{ours} {whole}"
        );
    }
}
