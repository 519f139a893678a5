//! WHERE samples are taken: one file per method, one row each in [`METHODS`].
//!
//! A method yields for each ray an ascending list of half-open ranges of sample indices. It may leave out only samples
//! whose contribution is exactly zero (unless its row says lossy), so that the picture is bit-identical to [`Skip::Box`].

pub mod beam_masks;
mod bounding_box;
pub mod distance_map;
mod half_split;
mod hull;
pub mod k_cuts;
#[cfg(test)]
mod tests;
mod traversal;

pub use half_split::HalfSplit;
pub use hull::Hull;
pub use k_cuts::{Cuts, HalfCut, KCuts, SlabCount};

#[cfg(test)]
mod support;

use std::ops::Range;

use glam::DVec3;

use crate::error::{Error, Result};
use crate::lattice::{Ray, Real};
use crate::octree::Occupancy;
use distance_map::DistanceMap;
use k_cuts::{BestCuts, DEFAULT_CUT_COST, MAX_SLABS, Planes};
use traversal::Line;

/// The choice of skipping method.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Skip {
    /// The bounding box: the baseline.
    Box,
    /// From the nearest front face to the farthest back face of the active blocks.
    Hull,
    /// The hull of each half of the volume, cut across the view's dominant axis.
    HalfSplit,
    /// The same with several cuts, placed where they pay.
    KCuts,
    /// Runs of active layers along the view axis, one mask per tile of pixels.
    BeamMasks,
    /// Leaps of the distance to the nearest active block.
    DistanceMap,
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
    /// The file in `shaders/skip/` that draws it: methods whose segments are known before the march share one.
    pub shader: &'static str,
    /// The backends that have it.
    pub backends: &'static [&'static str],
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
        shader: "bounds",
        backends: &["gpu", "cpu", "reference"],
        max_segments: 1,
        summary: "every sample inside the bounding box",
        origin: "Krüger & Westermann 2003",
        known_failure: "marches all empty space",
    },
    Method {
        skip: Skip::Hull,
        name: "hull",
        lossless: true,
        shader: "bounds",
        backends: &["gpu", "cpu", "reference"],
        max_segments: 1,
        summary: "from the first to the last active block",
        origin: "Hadwiger, Scharsach et al. 2005-2008",
        known_failure: "marches through cavities",
    },
    Method {
        skip: Skip::HalfSplit,
        name: "half-split",
        lossless: true,
        shader: "bounds",
        backends: &["gpu", "cpu", "reference"],
        max_segments: 2,
        summary: "the hull of each half, cut across the view axis",
        origin: "Yu et al. 2016",
        known_failure: "a cavity off the cut, or a second one, is still marched",
    },
    Method {
        skip: Skip::KCuts,
        name: "k-cuts",
        lossless: true,
        shader: "bounds",
        backends: &["gpu", "reference"],
        max_segments: MAX_SLABS,
        summary: "the hull of each slab between planes placed where they pay",
        origin: "this project",
        known_failure: "every cut costs two raster passes; a cavity of few columns pays for none",
    },
    Method {
        skip: Skip::BeamMasks,
        name: "beam-masks",
        lossless: true,
        shader: "bounds",
        backends: &["gpu", "cpu"],
        max_segments: usize::MAX,
        summary: "runs of active layers along the view axis, one mask per tile of pixels",
        origin: "this project",
        known_failure: "coarse where a tile straddles much",
    },
    Method {
        skip: Skip::DistanceMap,
        name: "distance-map",
        lossless: true,
        shader: "distance_map",
        backends: &["gpu", "cpu"],
        max_segments: usize::MAX,
        summary: "leaps of the Chebyshev distance to the nearest active block",
        origin: "Sramek & Kaufman 2000; Deakin & Knoll 2019",
        known_failure: "fragmented data: the leaps get short; the map is rebuilt with every table",
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

    /// Checks that a backend has this method.
    ///
    /// # Errors
    /// [`Error::Setting`] that names the backends that do.
    pub fn check_backend(self, backend: &str) -> Result<()> {
        let Method { name, backends, .. } = self.method();
        if backends.contains(&backend) {
            return Ok(());
        }
        let reason = format!(
            "the {backend} backend does not have {name}; it is on {}",
            backends.join(", ")
        );
        Err(Error::setting("method", reason))
    }

    /// What its shader reads of every block, if it has one of its own.
    pub fn block_words(self, occupancy: &Occupancy) -> Option<Vec<u32>> {
        match self {
            Self::DistanceMap => Some(DistanceMap::new(occupancy).words()),
            Self::Box | Self::Hull | Self::HalfSplit | Self::KCuts | Self::BeamMasks => None,
        }
    }

    /// The method of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        METHODS.iter().find(|m| m.name == name).map(|m| m.skip)
    }
}

/// A method made ready for one picture: which blocks count as active, where the cut lies.
#[derive(Debug, Clone, Copy)]
pub enum Plan<'a> {
    /// [`Skip::Box`].
    Box,
    /// [`Skip::Hull`].
    Hull(Hull<'a>),
    /// [`Skip::HalfSplit`].
    HalfSplit(HalfSplit<'a>),
    /// [`Skip::KCuts`].
    KCuts(KCuts<'a>),
}

impl<'a> Plan<'a> {
    /// The method `skip` over these blocks for a camera that looks along `forward`; half-split cuts in the middle, k-cuts
    /// as [`DEFAULT_CUT_COST`] has it.
    ///
    /// # Errors
    /// As [`Self::with_planes`].
    pub fn new(skip: Skip, occupancy: &'a Occupancy, forward: DVec3) -> Result<Self> {
        let axis = half_axis(forward);
        let planes = match skip {
            Skip::KCuts => BestCuts::new(occupancy, axis).cheapest(DEFAULT_CUT_COST),
            _ => Planes::new(&[occupancy.half_cut(axis)]),
        };
        Self::with_planes(skip, occupancy, axis, planes)
    }

    /// The method `skip` over these blocks, cut across `axis` at these planes if it cuts (half-split at the first).
    ///
    /// # Errors
    /// [`Error::Setting`] for methods that have no segments of a single ray: only the backends named in it have them.
    pub fn with_planes(
        skip: Skip,
        occupancy: &'a Occupancy,
        axis: usize,
        planes: Planes,
    ) -> Result<Self> {
        match skip {
            Skip::Box => Ok(Self::Box),
            Skip::Hull => Ok(Self::Hull(Hull { occupancy })),
            Skip::HalfSplit => {
                let cut = planes.as_slice().first().copied().unwrap_or(0);
                Ok(Self::HalfSplit(HalfSplit {
                    occupancy,
                    axis,
                    cut,
                }))
            }
            Skip::KCuts => Ok(Self::KCuts(KCuts {
                occupancy,
                axis,
                planes,
            })),
            Skip::BeamMasks | Skip::DistanceMap => Err(Error::setting(
                "method",
                format!("{} has no segments of a single ray", skip.method().name),
            )),
        }
    }

    /// The segments of a ray, whatever numbers it was computed in.
    ///
    /// A sample is left out only where its position, as [`Ray::at`] rounds it, lies less than half a voxel outside an
    /// inactive block: the closed support of that block still holds all voxels that it touches.
    pub fn segments<R: Real + Into<f64>>(&self, ray: &Ray<R>) -> impl Segments + use<R> {
        let Some(line) = Line::new(ray) else {
            return Listed::default();
        };
        match self {
            Self::Box => bounding_box::segments(&line),
            Self::Hull(hull) => hull.segments(&line),
            Self::HalfSplit(half_split) => half_split.segments(&line),
            Self::KCuts(k_cuts) => k_cuts.segments(&line),
        }
    }
}

/// The axis that half-split cuts across for a camera that looks along `forward`: the largest component, the first of
/// equals.
pub fn half_axis(forward: DVec3) -> usize {
    let size = forward.abs();
    (1..3).fold(0, |best, a| if size[a] > size[best] { a } else { best })
}

/// The segments of one ray, asked for one after another.
pub trait Segments {
    /// The next segment at or after sample `k`, not empty; `None` at the end of the ray. `state` is what a mode tells
    /// of its progress (the running maximum, say; NaN where a mode has nothing to tell).
    fn next(&mut self, k: u32, state: f64) -> Option<Range<u32>>;

    /// Segments given so far, and steps taken between samples to find them; what was known before the march is free.
    fn steps(&self) -> u32;
}

/// The most segments of a [`Listed`].
const MAX_LISTED: usize = MAX_SLABS;

/// Segments that are known before the march, ascending and disjoint.
#[derive(Debug, Clone, Default)]
struct Listed {
    ranges: [Range<u32>; MAX_LISTED],
    len: usize,
    given: usize,
}

impl Listed {
    /// Appends the part of `range` that lies after the last one, if there is any.
    fn push(&mut self, range: Range<u32>) {
        let after = self.ranges[..self.len].last().map_or(0, |last| last.end);
        let start = range.start.max(after);
        if start < range.end {
            self.ranges[self.len] = start..range.end;
            self.len += 1;
        }
    }
}

impl Segments for Listed {
    #[inline]
    fn next(&mut self, k: u32, _state: f64) -> Option<Range<u32>> {
        while let Some(range) = self.ranges[..self.len].get(self.given) {
            self.given += 1;
            if k < range.end {
                return Some(range.start.max(k)..range.end);
            }
        }
        None
    }

    fn steps(&self) -> u32 {
        self.given as u32
    }
}
