//! WHERE samples are taken: one file per method, one row each in [`METHODS`].
//!
//! A method yields for each ray an ascending list of half-open ranges of sample indices. It may leave out only samples
//! whose contribution is exactly zero (unless its row says lossy), so that the picture is bit-identical to [`Skip::Box`].

pub mod adaptive;
pub mod beam_cells;
pub mod beam_masks;
mod bounding_box;
pub mod distance_map;
mod frame_runs;
mod grid_dda;
mod half_split;
mod hull;
pub mod k_cuts;
mod majorants;
mod octree_encoded;
mod oracle;
mod plan;
pub mod segment_list;
#[cfg(test)]
mod tests;
mod traversal;
mod two_step;

pub use frame_runs::FrameRuns;
pub use grid_dda::GridDda;
pub use half_split::HalfSplit;
pub use hull::Hull;
pub use k_cuts::{Cuts, HalfCut, KCuts, SlabCount};
pub use majorants::{FULL, Majorants};
pub use plan::{Bound, Plan, Segments, Shows};

#[cfg(test)]
mod support;

use glam::DVec3;

use crate::error::{Error, Result};
use crate::octree::Occupancy;
use distance_map::DistanceMap;
use k_cuts::MAX_SLABS;
pub use segment_list::MOST_SEGMENTS;

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
    /// A walk from block to block.
    GridDda,
    /// All entries and exits, listed before the march.
    SegmentList,
    /// Every position, but only samples in active blocks.
    OctreeEncoded,
    /// Probes far apart, samples around those that show something.
    TwoStep,
    /// Strides as data and transfer function vary.
    Adaptive,
    /// Beams of tiles leap by the distance map, rays cut their runs down to cells.
    BeamCells,
    /// The contributing samples alone: no method, but the limit.
    Oracle,
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
    /// Whether it is no method to draw with but the limit that methods are measured against.
    pub is_limit: bool,
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
        is_limit: false,
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
        is_limit: false,
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
        is_limit: false,
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
        is_limit: false,
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
        is_limit: false,
        shader: "bounds",
        backends: &["gpu", "cpu", "reference"],
        max_segments: usize::MAX,
        summary: "runs of active layers along the view axis, one mask per tile of pixels",
        origin: "this project",
        known_failure: "coarse where a tile straddles much",
    },
    Method {
        skip: Skip::DistanceMap,
        name: "distance-map",
        lossless: true,
        is_limit: false,
        shader: "distance_map",
        backends: &["gpu", "cpu", "reference"],
        max_segments: usize::MAX,
        summary: "leaps of the Chebyshev distance to the nearest active block",
        origin: "Sramek & Kaufman 2000; Deakin & Knoll 2019",
        known_failure: "fragmented data: the leaps get short; the map is rebuilt with every table",
    },
    Method {
        skip: Skip::GridDda,
        name: "grid-dda",
        lossless: true,
        is_limit: false,
        shader: "grid_dda",
        backends: &["gpu", "reference"],
        max_segments: usize::MAX,
        summary: "a walk from block to block, sampling the active ones",
        origin: "Amanatides & Woo 1987; macrocells of OpenVKL, OSPRay",
        known_failure: "many small steps through large cavities; neighbouring rays diverge",
    },
    Method {
        skip: Skip::SegmentList,
        name: "segment-list",
        lossless: true,
        is_limit: false,
        shader: "segment_list",
        backends: &["gpu", "reference"],
        max_segments: MOST_SEGMENTS,
        summary: "all entries and exits of each ray, listed before the march",
        origin: "Hadwiger et al. 2018 (SparseLeap)",
        known_failure: "memory for every pixel; past its last slot a list marches to the last exit",
    },
    Method {
        skip: Skip::BeamCells,
        name: "beam-cells",
        lossless: true,
        is_limit: false,
        shader: "beam_cells",
        backends: &["gpu", "reference"],
        max_segments: MOST_SEGMENTS,
        summary: "tiles leap as one beam by the distance map; rays cut what is left down to cells of eight voxels (exact on the gpu: out of packed bricks)",
        origin: "this project; beams after Laine & Karras 2010, bricks after Crassin et al. 2009",
        known_failure: "two bits for every voxel and copies of what shows, made anew with every table; gaps that a beam does not fit through",
    },
    Method {
        skip: Skip::OctreeEncoded,
        name: "octree-encoded",
        lossless: true,
        is_limit: false,
        shader: "octree_encoded",
        backends: &["gpu", "reference"],
        max_segments: usize::MAX,
        summary: "every position of the box, but only samples in active blocks are loaded",
        origin: "Kang et al. 2012, as Yu et al. 2016 describe it",
        known_failure: "does not skip: it saves the accumulation, not the way",
    },
    Method {
        skip: Skip::TwoStep,
        name: "two-step",
        lossless: false,
        is_limit: false,
        shader: "two_step",
        backends: &["gpu", "reference"],
        max_segments: usize::MAX,
        summary: "coarse steps through emptiness, back by one on the first hit (lossy)",
        origin: "Ye et al. 2010, as Yu et al. 2016 describe it",
        known_failure: "walls thinner than a coarse step are lost; large cavities still cost many",
    },
    Method {
        skip: Skip::Adaptive,
        name: "adaptive",
        lossless: false,
        is_limit: false,
        shader: "adaptive",
        backends: &["gpu", "reference"],
        max_segments: usize::MAX,
        summary: "steps by block, as data and transfer function vary (lossy)",
        origin: "Bergner et al. 2006; Suwelack et al. 2010",
        known_failure: "the gradients of all voxels are read first; the picture depends on the rule",
    },
    Method {
        skip: Skip::Oracle,
        name: "oracle",
        lossless: true,
        is_limit: true,
        shader: "oracle",
        backends: &["gpu", "reference"],
        max_segments: usize::MAX,
        summary: "the contributing samples alone, found by a first march that is not timed: the limit",
        origin: "this project",
        known_failure: "no method: it takes a whole picture to find what it marches",
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

    /// Whether it is told which blocks are active.
    pub fn reads_blocks(self) -> bool {
        !matches!(self, Self::Box | Self::TwoStep)
    }

    /// Whether it looks at every block when a ray comes to it, and so can leave out those that are bounded by what the ray
    /// has seen.
    pub fn reads_majorants(self) -> bool {
        matches!(
            self,
            Self::DistanceMap | Self::GridDda | Self::OctreeEncoded
        )
    }

    /// Whether it is told which cells contribute.
    pub fn reads_cells(self) -> bool {
        self == Self::BeamCells
    }

    /// Whether its samples come from bricks, where the sampler and the classification allow it.
    pub fn reads_bricks(self) -> bool {
        matches!(self, Self::BeamCells | Self::Oracle)
    }

    /// What its shader reads of every block, if it has one of its own that reads no more than which are active.
    pub fn block_words(self, occupancy: &Occupancy) -> Option<Vec<u32>> {
        match self {
            Self::DistanceMap | Self::BeamCells => Some(DistanceMap::new(occupancy).words()),
            Self::GridDda | Self::SegmentList | Self::OctreeEncoded => Some(
                occupancy
                    .words()
                    .iter()
                    .flat_map(|&word| [word as u32, (word >> 32) as u32])
                    .collect(),
            ),
            _ => None,
        }
    }

    /// The method of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        METHODS.iter().find(|m| m.name == name).map(|m| m.skip)
    }
}

/// The axis that half-split cuts across for a camera that looks along `forward`: the largest component, the first of
/// equals.
pub fn half_axis(forward: DVec3) -> usize {
    let size = forward.abs();
    (1..3).fold(0, |best, a| if size[a] > size[best] { a } else { best })
}

/// Four bytes to a word, the first in the lowest: what shaders read.
fn words_of_bytes(bytes: &[u8]) -> Vec<u32> {
    let word = |four: &[u8]| {
        four.iter()
            .rev()
            .fold(0, |word, &byte| word << 8 | u32::from(byte))
    };
    bytes.chunks(4).map(word).collect()
}
