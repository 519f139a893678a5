//! WHERE samples are taken: one file per method, one row each in [`METHODS`].
//!
//! A method yields for each ray an ascending list of half-open ranges of sample indices. It may leave out only samples
//! whose contribution is exactly zero (unless its row says lossy), so that the picture is bit-identical to [`Skip::Box`].

use std::ops::Range;

use glam::DVec3;

/// The choice of skipping method.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Skip {
    /// The bounding box: the baseline.
    Box,
    /// From the nearest front face to the farthest back face of the active blocks.
    Hull,
    /// The hull of each half of the volume, cut across the view's dominant axis.
    HalfSplit,
}

/// A method's row in the table that every part of the program reads.
#[derive(Debug)]
pub struct Method {
    /// The method.
    pub skip: Skip,
    /// The name used by flags, files and reports.
    pub name: &'static str,
    /// Whether pictures are bit-identical to those of [`Skip::Box`].
    pub lossless: bool,
    /// The most segments a ray can have where they are known before the march.
    pub max_segments: usize,
    /// One line for help texts.
    pub summary: &'static str,
    /// Where it comes from.
    pub origin: &'static str,
    /// What it is known not to skip.
    pub known_failure: &'static str,
}

/// All methods, the baseline first.
pub const METHODS: &[Method] = &[
    Method {
        skip: Skip::Box,
        name: "box",
        lossless: true,
        max_segments: 1,
        summary: "every sample inside the bounding box",
        origin: "Krüger & Westermann 2003",
        known_failure: "marches all empty space",
    },
    Method {
        skip: Skip::Hull,
        name: "hull",
        lossless: true,
        max_segments: 1,
        summary: "from the first to the last active block",
        origin: "Hadwiger, Scharsach et al. 2005-2008",
        known_failure: "marches through cavities",
    },
    Method {
        skip: Skip::HalfSplit,
        name: "half-split",
        lossless: true,
        max_segments: 2,
        summary: "the hull of each half, cut across the view axis",
        origin: "Yu et al. 2016",
        known_failure: "a cavity off the cut, or a second one, is still marched",
    },
];

impl Skip {
    /// This method's row.
    ///
    /// # Panics
    /// Never: every method has a row.
    pub fn method(self) -> &'static Method {
        METHODS
            .iter()
            .find(|m| m.skip == self)
            .expect("every method has a row")
    }

    /// The method of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        METHODS.iter().find(|m| m.name == name).map(|m| m.skip)
    }
}

/// The segments of one ray, asked for one after another.
pub trait Segments {
    /// The next segment at or after sample `k`, not empty; `None` at the end of the ray. `state` is what a mode tells
    /// of its progress (the running maximum, say; NaN where a mode has nothing to tell).
    fn next(&mut self, k: u32, state: f64) -> Option<Range<u32>>;
}

/// The axis that halves are cut across: the largest component of the view's direction.
pub fn half_axis(forward: DVec3) -> usize {
    let a = forward.abs();
    if a.x >= a.y && a.x >= a.z {
        0
    } else if a.y >= a.z {
        1
    } else {
        2
    }
}
