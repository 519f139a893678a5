//! The transfer function as packets read it.

use std::ops::RangeInclusive;

use super::packet::Voxel;
use crate::transfer::Table;

/// The entries of a table, each with the difference to the next: `a` and `b - a` of the interpolation `a + f * (b - a)`
/// in one row of 32 bytes. The difference is the same single-precision number whenever it is computed.
pub(super) fn rows(table: &Table) -> Vec<[f32; 8]> {
    let entries = table.rgba();
    (0..entries.len())
        .map(|i| {
            let (a, b) = (entries[i], entries[(i + 1).min(entries.len() - 1)]);
            std::array::from_fn(|c| if c < 4 { a[c] } else { b[c - 4] - a[c - 4] })
        })
        .collect()
}

/// The run of all-zero table entries that the background lies in: samples between its ends contribute nothing.
///
/// There may be other such runs; they are looked up like any visible value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Background {
    /// First and last entry of the run.
    entries: [usize; 2],
    /// Number of entries of the table.
    table: usize,
}

impl Background {
    /// The run that holds most of some voxels spread over the volume; `None` where no run holds any.
    pub(super) fn find<V: Voxel>(table: &Table, voxels: &[V]) -> Option<Self> {
        let mut runs: Vec<([usize; 2], usize)> = Vec::new();
        let mut of_entry = vec![None; table.rgba().len()];
        for (i, entry) in table.rgba().iter().enumerate() {
            if entry.iter().all(|&c| c == 0.0) {
                match runs.last_mut() {
                    Some((run, _)) if run[1] + 1 == i => run[1] = i,
                    _ => runs.push(([i, i], 0)),
                }
                of_entry[i] = Some(runs.len() - 1);
            }
        }
        // A prime number of samples, so that they do not fall on one column of a power of two.
        let stride = (voxels.len() / 4099).max(1);
        let last = (of_entry.len() - 1) as f64;
        for voxel in voxels.iter().step_by(stride) {
            let x = table.domain().x_from_stored(f64::from(voxel.to_f32()));
            if let Some(run) = of_entry[x.clamp(0.0, last) as usize] {
                runs[run].1 += 1;
            }
        }
        let (entries, count) = runs.into_iter().max_by_key(|run| run.1)?;
        (count > 0).then_some(Self {
            entries,
            table: of_entry.len(),
        })
    }

    /// The table coordinates of the run, unbounded where it reaches an end of the table, beyond which all is clamped.
    pub(super) fn x(&self) -> [f64; 2] {
        let [first, last] = self.entries;
        [
            if first == 0 {
                f64::NEG_INFINITY
            } else {
                first as f64
            },
            if last + 1 == self.table {
                f64::INFINITY
            } else {
                last as f64
            },
        ]
    }

    /// The smallest and largest voxel of the run; `None` where no voxel can be.
    pub(super) fn voxels<V: Voxel>(&self, table: &Table) -> Option<[V; 2]> {
        let domain = table.domain();
        let [low, high] = self.x().map(|x| x / domain.scale + domain.origin);
        V::interval(low, high)
    }

    /// Whether the run is all zero in this table too.
    pub(super) fn fits(&self, table: &Table) -> bool {
        let [first, last] = self.entries;
        let range: RangeInclusive<f64> = first as f64..=last as f64;
        table.rgba().len() == self.table && !table.is_visible(range)
    }
}
