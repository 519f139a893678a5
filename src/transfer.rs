//! Transfer functions: from data values to colour and opacity, and the tables baked from them.

mod parse;
mod preset;

pub use preset::{PRESETS, Preset, threshold};

use std::ops::RangeInclusive;

use crate::error::{Error, Result};
use crate::lattice::Real;
use crate::volume::{Rescale, Volume};

/// One control point of a [`TransferFunction`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ControlPoint {
    /// Data value (after the volume's [`Rescale`]).
    pub value: f64,
    /// Opacity per reference length, 0 to 1.
    pub opacity: f64,
    /// Linear red, green, blue, 0 to 1; not multiplied by opacity.
    pub color: [f64; 3],
}

/// Colour and opacity over data values: linear between control points, constant beyond the first and last.
#[derive(Debug, Clone, PartialEq)]
pub struct TransferFunction {
    /// Sorted by value; at least one. Two points may share a value: a jump.
    points: Vec<ControlPoint>,
    /// The length that opacities refer to, in voxels of the smallest spacing.
    pub reference_length_voxels: f64,
}

impl TransferFunction {
    /// A function through these points.
    ///
    /// # Errors
    /// [`Error::Setting`] where there is no point, values do not ascend or a number is out of range.
    pub fn new(points: Vec<ControlPoint>, reference_length_voxels: f64) -> Result<Self> {
        if points.is_empty() {
            return Err(Error::setting(
                "points",
                "the transfer function has none; it needs at least one",
            ));
        }
        if !(reference_length_voxels > 0.0 && reference_length_voxels.is_finite()) {
            return Err(Error::setting(
                "reference_length_voxels",
                "must be a positive number",
            ));
        }
        for (i, p) in points.iter().enumerate() {
            let bad = |field: &str, reason: &str| {
                Err(Error::setting(format!("points[{i}].{field}"), reason))
            };
            if !p.value.is_finite() {
                return bad("value", "must be a finite number");
            }
            if !(0.0..=1.0).contains(&p.opacity) {
                return bad("opacity", "must lie between 0 and 1");
            }
            if !p.color.iter().all(|c| (0.0..=1.0).contains(c)) {
                return bad("color", "red, green and blue must lie between 0 and 1");
            }
            if i > 0 && p.value < points[i - 1].value {
                return bad("value", "lies below the one before; points must ascend");
            }
        }
        Ok(Self {
            points,
            reference_length_voxels,
        })
    }

    /// The control points, ascending.
    pub fn points(&self) -> &[ControlPoint] {
        &self.points
    }

    /// Whether any data value in [low, high] has opacity.
    pub fn shows_any_of(&self, [low, high]: [f64; 2]) -> bool {
        let is_shown = |value: f64| self.at(value).1 > 0.0;
        let mut within = self
            .points
            .iter()
            .filter(|p| low <= p.value && p.value <= high);
        // Opacity is linear between points: where it is none at all of these, it is none between them.
        is_shown(low) || is_shown(high) || within.any(|p| p.opacity > 0.0)
    }

    /// Colour (not premultiplied) and opacity per reference length at a data value. At a jump: the upper side.
    pub fn at(&self, value: f64) -> ([f64; 3], f64) {
        let after = self.points.partition_point(|p| p.value <= value);
        if after == 0 || after == self.points.len() {
            let p = &self.points[after.min(self.points.len() - 1)];
            return (p.color, p.opacity);
        }
        let (a, b) = (&self.points[after - 1], &self.points[after]);
        let f = (value - a.value) / (b.value - a.value);
        let mix = |x: f64, y: f64| x + f * (y - x);
        (
            std::array::from_fn(|c| mix(a.color[c], b.color[c])),
            mix(a.opacity, b.opacity),
        )
    }

    /// Bakes the table for samples `step_voxels` apart.
    pub fn bake(&self, domain: &Domain, step_voxels: f64) -> Table {
        let ratio = step_voxels / self.reference_length_voxels;
        let rgba: Vec<[f32; 4]> = (0..domain.entries)
            .map(|i| {
                let (color, opacity) = self.at(domain.value_from_x(i as f64));
                let corrected = opacity_per_step(opacity, ratio);
                [
                    color[0] * corrected,
                    color[1] * corrected,
                    color[2] * corrected,
                    corrected,
                ]
                .map(|c| c as f32)
            })
            .collect();
        Table::new(rgba, *domain)
    }
}

/// Opacity of one step from opacity per reference length: `1 - (1 - a)^ratio`, exact for small `a` too.
pub fn opacity_per_step(opacity: f64, ratio: f64) -> f64 {
    if opacity >= 1.0 {
        1.0
    } else if opacity <= 0.0 {
        // Also where a reference length is so small that the ratio is infinite.
        0.0
    } else {
        -f64::exp_m1(ratio * f64::ln_1p(-opacity))
    }
}

/// How data values map to a table: entry i lies at `x = i`, `x = (stored - origin) * scale`.
///
/// The origin is subtracted first: f32 data far from zero keep what precision they have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Domain {
    /// Number of entries N: 256, 4,096 or 65,536; of a part of such a table, any.
    pub entries: usize,
    /// Table coordinate per stored unit.
    pub scale: f64,
    /// Stored number at table coordinate 0.
    pub origin: f64,
    /// Table coordinates that the voxel type's whole range spans, or the table's own where that is more: what rounding
    /// is relative to.
    span: f64,
    rescale: Rescale,
}

/// The table sizes there are.
pub const TABLE_SIZES: [usize; 3] = [256, 4096, 65536];

impl Domain {
    /// The domain of a volume's values in a table of `entries`.
    ///
    /// Integer types that have no more values than the table has entries use one entry per value; others spread
    /// `stored_range` (the volume's smallest and largest stored number) over the table.
    ///
    /// # Errors
    /// [`Error::Setting`] where `entries` is not one of [`TABLE_SIZES`].
    pub fn new(volume: &Volume, stored_range: [f64; 2], entries: usize) -> Result<Self> {
        if !TABLE_SIZES.contains(&entries) {
            return Err(Error::setting(
                "table size",
                format!("{entries} is none of 256, 4096, 65536"),
            ));
        }
        let last = (entries - 1) as f64;
        let integers = volume.voxels.voxel_type().integer_range();
        let one_to_one = integers.filter(|r| r[1] - r[0] <= last);
        let (scale, origin) = match (one_to_one, integers) {
            (Some(range), _) => (1.0, range[0]),
            // Integer data whose range fits the table keep one entry per value too.
            (None, Some(_)) if stored_range[1] - stored_range[0] <= last => (1.0, stored_range[0]),
            _ if stored_range[1] > stored_range[0] => {
                (last / (stored_range[1] - stored_range[0]), stored_range[0])
            }
            _ => (1.0, stored_range[0]),
        };
        Ok(Self {
            entries,
            scale,
            origin,
            span: integers
                .map_or(0.0, |r| (r[1] - r[0] + 1.0) * scale)
                .max(entries as f64),
            rescale: volume.rescale,
        })
    }

    /// The domain of a table of `entries` whose entry i lies at `first + i * spacing` in this one.
    #[must_use]
    pub fn part(&self, first: f64, spacing: f64, entries: usize) -> Self {
        Self {
            entries,
            scale: self.scale / spacing,
            origin: self.origin + first / self.scale,
            span: (self.span / spacing).max(entries as f64),
            rescale: self.rescale,
        }
    }

    /// Table coordinate of a stored number (not clamped).
    pub fn x_from_stored(&self, stored: f64) -> f64 {
        (stored - self.origin) * self.scale
    }

    /// Data value at a table coordinate.
    pub fn value_from_x(&self, x: f64) -> f64 {
        self.rescale.value_from_stored(x / self.scale + self.origin)
    }

    /// Table coordinate of a data value (not clamped).
    pub fn x_from_value(&self, value: f64) -> f64 {
        self.x_from_stored(self.rescale.stored_from_value(value))
    }

    /// 1 where data values rise with table coordinates, -1 where they fall.
    pub fn direction(&self) -> f64 {
        self.rescale.slope.signum()
    }

    /// How near to an entry a table coordinate counts as on it, in shaders and in [`lookup`]: 2^-22 of what the table,
    /// or the voxel type if that is more, spans.
    ///
    /// Unorm conversion and interpolation round; a background exactly at the threshold must not touch the next entry.
    pub fn snap(&self) -> f64 {
        self.span / f64::from(1 << 22)
    }
}

/// A baked table: premultiplied colour and opacity of one step, per entry.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    rgba: Vec<[f32; 4]>,
    /// `visible_before[i]` = number of entries below i that are not all zero; one longer than `rgba`.
    visible_before: Vec<u32>,
    domain: Domain,
}

impl Table {
    /// A table of these entries, as many as the domain says.
    pub fn new(rgba: Vec<[f32; 4]>, domain: Domain) -> Self {
        let mut visible_before = Vec::with_capacity(rgba.len() + 1);
        let mut count = 0;
        visible_before.push(count);
        for entry in &rgba {
            count += u32::from(entry.iter().any(|&c| c != 0.0));
            visible_before.push(count);
        }
        Self {
            rgba,
            visible_before,
            domain,
        }
    }

    /// The entries.
    pub fn rgba(&self) -> &[[f32; 4]] {
        &self.rgba
    }

    /// The mapping of data values to entries.
    pub fn domain(&self) -> &Domain {
        &self.domain
    }

    /// Whether the interpolated table is non-zero anywhere over table coordinates in `range`, in O(1).
    pub fn is_visible(&self, range: RangeInclusive<f64>) -> bool {
        let n = self.rgba.len();
        let last = (n - 1) as f64;
        // Half the shaders' tolerance: what they snap to an entry, this does not push beyond it, and the other way round
        // it only ever counts one entry too many.
        let half_snap = self.domain.snap() * 0.5;
        // Culling asks this of every block. Conversion truncates, which is floor from 0 on, and costs no call as
        // `f64::floor` does where the target's baseline has no instruction for it.
        let entries = |x: f64| {
            let x = x.clamp(0.0, last);
            let lower = x as usize;
            let above = x - lower as f64;
            if above <= half_snap {
                (lower, lower)
            } else if 1.0 - above <= half_snap {
                (lower + 1, lower + 1)
            } else {
                (lower, lower + 1)
            }
        };
        let first = entries(*range.start()).0;
        let end = entries(*range.end()).1 + 1;
        self.visible_before[end] != self.visible_before[first]
    }

    /// Whether entries that show something lie between ones that do not: what two samples on either side step over.
    pub fn has_peaks(&self) -> bool {
        let is_hidden = |entry: &[f32; 4]| entry.iter().all(|&c| c == 0.0);
        let first = self.rgba.iter().position(is_hidden);
        let last = self.rgba.iter().rposition(is_hidden);
        first
            .zip(last)
            .is_some_and(|(first, last)| self.visible_before[last] != self.visible_before[first])
    }

    /// Whether the same entries are visible as in `other`: then what was culled for one holds for both.
    pub fn shows_the_same_as(&self, other: &Self) -> bool {
        self.domain == other.domain && self.visible_before == other.visible_before
    }

    /// Largest opacity of one step.
    pub fn max_opacity(&self) -> f32 {
        self.rgba.iter().fold(0.0, |m, e| m.max(e[3]))
    }
}

/// The index of the lower table entry and the fraction towards the next, for a table of `entries` at coordinate `x`.
///
/// `x` is clamped to the table and snapped to an entry within [`Domain::snap`]. The upper entry is the lower plus one,
/// or the last; the caller fetches both and interpolates `a + f * (b - a)`.
#[inline(always)]
pub fn lookup<R: Real>(x: R, entries: R, snap: R) -> (R, R) {
    let last = entries - R::splat(1.0);
    let clamped = x.max(R::splat(0.0)).min(last);
    let nearest = (clamped + R::splat(0.5)).floor();
    let x = R::select((clamped - nearest).abs().lt(snap), nearest, clamped);
    let lower = x.floor();
    (lower, x - lower)
}
