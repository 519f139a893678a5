//! Methods made ready for one picture, and the segments that they give its rays, on the processor.

use std::ops::Range;

use super::adaptive::Strides;
use super::beam_cells::{BeamCells, Near};
use super::distance_map::DistanceMap;
use super::frame_runs::FrameRuns;
use super::grid_dda::GridDda;
use super::k_cuts::{BestCuts, DEFAULT_CUT_COST, Planes};
use super::octree_encoded::Positions;
use super::oracle::Contributing;
use super::traversal::Line;
use super::two_step::CoarseSteps;
use super::{HalfSplit, Hull, KCuts, Majorants, Skip, bounding_box, half_axis, segment_list};
use crate::error::{Error, Result};
use crate::lattice::{Ray, RayFrame, Real};
use crate::octree::Occupancy;

/// A method made ready for one picture: which blocks count as active, where the cut lies.
#[derive(Debug)]
pub enum Plan<'a> {
    /// [`Skip::Box`].
    Box,
    /// [`Skip::Hull`].
    Hull(Hull<'a>),
    /// [`Skip::HalfSplit`].
    HalfSplit(HalfSplit<'a>),
    /// [`Skip::KCuts`].
    KCuts(KCuts<'a>),
    /// [`Skip::BeamMasks`].
    BeamMasks(FrameRuns),
    /// [`Skip::DistanceMap`].
    DistanceMap(DistanceMap, Bound<'a>),
    /// [`Skip::GridDda`].
    GridDda(GridDda<'a>),
    /// [`Skip::SegmentList`].
    SegmentList(&'a Occupancy),
    /// [`Skip::BeamCells`].
    BeamCells(Box<BeamCells<'a>>),
    /// [`Skip::OctreeEncoded`].
    OctreeEncoded(&'a Occupancy, Bound<'a>),
    /// [`Skip::TwoStep`].
    TwoStep,
    /// [`Skip::Adaptive`].
    Adaptive(Strides),
    /// [`Skip::Oracle`].
    Oracle,
}

impl<'a> Plan<'a> {
    /// The method `skip` over these blocks for the rays of `frame`; half-split cuts in the middle, k-cuts as
    /// [`DEFAULT_CUT_COST`] has it.
    ///
    /// # Errors
    /// As [`Self::with_planes`].
    pub fn new(skip: Skip, occupancy: &'a Occupancy, frame: &RayFrame) -> Result<Self> {
        let axis = half_axis(frame.dir);
        let planes = match skip {
            Skip::KCuts => BestCuts::new(occupancy, axis).cheapest(DEFAULT_CUT_COST),
            _ => Planes::new(&[occupancy.half_cut(axis)]),
        };
        Self::with_planes(skip, occupancy, frame, axis, planes)
    }

    /// The method `skip` over these blocks, cut across `axis` at these planes if it cuts (half-split at the first).
    ///
    /// # Errors
    /// [`Error::Setting`] for [`Skip::Adaptive`], which wants more than blocks: see [`Strides`].
    pub fn with_planes(
        skip: Skip,
        occupancy: &'a Occupancy,
        frame: &RayFrame,
        axis: usize,
        planes: Planes,
    ) -> Result<Self> {
        Ok(match skip {
            Skip::Box => Self::Box,
            Skip::Hull => Self::Hull(Hull { occupancy }),
            Skip::HalfSplit => Self::HalfSplit(HalfSplit {
                occupancy,
                axis,
                cut: planes.as_slice().first().copied().unwrap_or(0),
            }),
            Skip::KCuts => Self::KCuts(KCuts {
                occupancy,
                axis,
                planes,
            }),
            Skip::BeamMasks => Self::BeamMasks(FrameRuns::new(occupancy, frame)),
            Skip::DistanceMap => Self::DistanceMap(DistanceMap::new(occupancy), Bound::NONE),
            Skip::GridDda => Self::GridDda(GridDda {
                occupancy,
                bound: Bound::NONE,
            }),
            Skip::SegmentList => Self::SegmentList(occupancy),
            Skip::BeamCells => {
                let beams = BeamCells::new(occupancy, frame, Near::Unknown);
                Self::BeamCells(Box::new(beams))
            }
            Skip::OctreeEncoded => Self::OctreeEncoded(occupancy, Bound::NONE),
            Skip::TwoStep => Self::TwoStep,
            Skip::Oracle => Self::Oracle,
            Skip::Adaptive => {
                let reason = "adaptive is made from strides, not from blocks alone";
                return Err(Error::setting("method", reason));
            }
        })
    }

    /// The same, where blocks are left out that lie no higher than what a ray has seen. Of methods that do not look at
    /// blocks on their way ([`Skip::reads_majorants`]) nothing changes.
    #[must_use]
    pub fn bounded(mut self, majorants: &'a Majorants) -> Self {
        if let Self::DistanceMap(_, bound)
        | Self::GridDda(GridDda { bound, .. })
        | Self::OctreeEncoded(_, bound) = &mut self
        {
            *bound = Bound::by(Some(majorants));
        }
        self
    }

    /// The same, where rays know this of cells. Of methods that do not ask ([`Skip::reads_cells`]) nothing changes.
    #[must_use]
    pub fn cut_down(self, near: Near<'a>) -> Self {
        match self {
            Self::BeamCells(beams) => Self::BeamCells(Box::new(beams.with_cells(near))),
            other => other,
        }
    }

    /// The segments of a pixel's ray, whatever numbers it was computed in. `shows` tells whether a sample of the ray
    /// contributes; only methods that look at the data on their way ask.
    ///
    /// A lossless method leaves a sample out only where its position, as [`Ray::at`] rounds it, lies less than half a voxel
    /// outside an inactive block: the closed support of that block still holds all voxels that it touches.
    pub fn segments<'r, R: Real + Into<f64>>(
        &'r self,
        ray: &Ray<R>,
        pixel: [u32; 2],
        shows: Shows<'r>,
    ) -> Box<dyn Segments + 'r> {
        let Some(line) = Line::new(ray) else {
            return Box::new(Listed::default());
        };
        let range = line.range();
        let ray = Ray {
            entry: ray.entry.map(Into::into),
            delta: ray.delta.map(Into::into),
            k_near: ray.k_near.into(),
            k_end: ray.k_end.into(),
            t_box: ray.t_box.into(),
            drawn: ray.drawn.map(Into::into),
            reach: ray.reach.into(),
        };
        match self {
            Self::Box => Box::new(bounding_box::segments(&line)),
            Self::Hull(hull) => Box::new(hull.segments(&line)),
            Self::HalfSplit(half_split) => Box::new(half_split.segments(&line)),
            Self::KCuts(k_cuts) => Box::new(k_cuts.segments(&line)),
            Self::BeamMasks(runs) => Box::new(runs.segments(&ray, pixel)),
            Self::DistanceMap(map, bound) => Box::new(map.segments(ray, *bound)),
            Self::GridDda(grid_dda) => Box::new(grid_dda.segments(line)),
            Self::SegmentList(occupancy) => Box::new(segment_list::segments(occupancy, line)),
            Self::BeamCells(beams) => Box::new(beams.segments(ray, pixel, beams.runs(pixel))),
            Self::OctreeEncoded(occupancy, bound) => Box::new(Positions {
                occupancy,
                bound: *bound,
                ray,
                steps: 0,
            }),
            Self::TwoStep => Box::new(CoarseSteps {
                range,
                shows,
                hit: None,
                probes: 0,
            }),
            Self::Adaptive(strides) => Box::new(strides.segments(ray)),
            Self::Oracle => Box::new(Contributing {
                range,
                shows,
                given: 0,
            }),
        }
    }
}

/// What is left out besides inactive blocks: those that lie no higher than what a ray has seen, where anything is known of
/// that.
#[derive(Debug, Clone, Copy)]
pub struct Bound<'a>(Option<&'a Majorants>);

impl<'a> Bound<'a> {
    /// Nothing is.
    pub const NONE: Self = Self(None);

    /// Those that these tell of.
    pub fn by(majorants: Option<&'a Majorants>) -> Self {
        Self(majorants)
    }

    /// Whether it leaves out anything.
    pub(super) fn is_some(self) -> bool {
        self.0.is_some()
    }

    /// Whether a block can add anything to a ray that has seen `highest` ([`Segments::next`]).
    pub(super) fn may_add(self, block: [usize; 3], highest: f64) -> bool {
        self.0.is_none_or(|m| m.may_add(block, highest))
    }
}

/// Whether a sample of a ray contributes.
pub type Shows<'r> = &'r dyn Fn(u32) -> bool;

/// The segments of one ray, asked for one after another.
pub trait Segments {
    /// The next segment at or after sample `k`, not empty; `None` at the end of the ray. `highest` is the highest place in
    /// the window that the ray has seen before `k`; NaN in modes that do not keep it.
    fn next(&mut self, k: u32, highest: f64) -> Option<Range<u32>>;

    /// Lattice points that one sample of the segment given last stands for; it lies in their middle, and the segment holds
    /// a whole number of them.
    fn stride(&self) -> u32 {
        1
    }

    /// Segments given so far, and steps taken between samples to find them; what was known before the march is free.
    fn steps(&self) -> u32;

    /// Samples that were looked at on the way to segments, besides those in them.
    fn probes(&self) -> u32 {
        0
    }
}

/// Segments that are known before the march, ascending and disjoint.
#[derive(Debug, Clone, Default)]
pub(super) struct Listed {
    ranges: Vec<Range<u32>>,
    given: usize,
}

impl Listed {
    /// Appends the part of `range` that lies after the last one, if there is any.
    pub(super) fn push(&mut self, range: Range<u32>) {
        let after = self.ranges.last().map_or(0, |last| last.end);
        let start = range.start.max(after);
        if start < range.end {
            self.ranges.push(start..range.end);
        }
    }
}

impl FromIterator<Range<u32>> for Listed {
    fn from_iter<I: IntoIterator<Item = Range<u32>>>(ranges: I) -> Self {
        let mut listed = Self::default();
        for range in ranges {
            listed.push(range);
        }
        listed
    }
}

impl Segments for Listed {
    #[inline]
    fn next(&mut self, k: u32, _highest: f64) -> Option<Range<u32>> {
        while let Some(range) = self.ranges.get(self.given) {
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
