//! What a sample's value looks like: by the baked table, or by the transfer function itself.

use crate::transfer::{Domain, Table, TransferFunction, lookup, opacity_per_step};

/// Colour and opacity of one step.
pub(super) trait Classes: Sync {
    /// What the values are looked up in.
    fn domain(&self) -> &Domain;

    /// Premultiplied red, green, blue and opacity at table coordinate `x`.
    fn rgba(&self, x: f64) -> [f64; 4];
}

/// The baked table, interpolated in f64.
pub(super) struct Baked<'a> {
    table: &'a Table,
    entries: f64,
    snap: f64,
}

impl<'a> Baked<'a> {
    pub(super) fn new(table: &'a Table) -> Self {
        Self {
            table,
            entries: table.domain().entries as f64,
            snap: table.domain().snap(),
        }
    }
}

impl Classes for Baked<'_> {
    fn domain(&self) -> &Domain {
        self.table.domain()
    }

    #[inline]
    fn rgba(&self, x: f64) -> [f64; 4] {
        let (lower, f) = lookup(x, self.entries, self.snap);
        let rgba = self.table.rgba();
        let lower = lower as u32 as usize;
        let (a, b) = (rgba[lower], rgba[(lower + 1).min(rgba.len() - 1)]);
        std::array::from_fn(|c| {
            let (a, b) = (f64::from(a[c]), f64::from(b[c]));
            a + f * (b - a)
        })
    }
}

/// The transfer function, its opacity corrected for the step in f64.
pub(super) struct Unbaked<'a> {
    function: &'a TransferFunction,
    domain: Domain,
    /// Step over reference length.
    ratio: f64,
}

impl<'a> Unbaked<'a> {
    pub(super) fn new(function: &'a TransferFunction, domain: Domain, step_voxels: f64) -> Self {
        Self {
            function,
            domain,
            ratio: step_voxels / function.reference_length_voxels,
        }
    }
}

impl Classes for Unbaked<'_> {
    fn domain(&self) -> &Domain {
        &self.domain
    }

    fn rgba(&self, x: f64) -> [f64; 4] {
        let (color, opacity) = self.function.at(self.domain.value_from_x(x));
        let opacity = opacity_per_step(opacity, self.ratio);
        [
            color[0] * opacity,
            color[1] * opacity,
            color[2] * opacity,
            opacity,
        ]
    }
}
