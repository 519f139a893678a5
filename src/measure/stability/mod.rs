//! Where methods fail: named hazards, each with a generator of its own, and what every method makes of them.
//!
//! A hazard is one or more frames of a small volume. `run` draws them with every [`Contestant`], holds each picture
//! against box's on the same backend and box's against the f64 reference's of the same scene (exact interpolation, the
//! same step and mode), so that arithmetic and skipping are judged and not the step; and says [`Verdict`]. What the step
//! costs is told beside it, as the error of the first frame against its ground truth.

mod cameras;
mod claims;
mod contestant;
mod data;
mod eye_rays;
mod grids;
mod rays;
mod run;
mod scenery;
mod sequences;
mod settings;
mod summary;
mod tables;
mod truths;
mod volumes;

use std::borrow::Cow;
use std::fmt;

use serde::{Deserialize, Serialize};

use crate::error::Result;

pub use claims::{CLAIMS, Claim, Finding, LEFT_BEHIND, findings};
pub use contestant::Contestant;
pub use run::{Atlas, Found, Worst};
pub use scenery::{Frame, Judged, Scenery};
pub use summary::{Tally, cell, markdown, tallies};

/// Largest distance of a channel of an exact picture from the f64 reference's.
pub const REFERENCE_MAX_ABS: f64 = 2.0 / 255.0;
/// Smallest PSNR of an exact picture against the f64 reference's.
pub const REFERENCE_PSNR_DB: f64 = 60.0;
/// Largest distance of a channel of a lossy picture from box's.
pub const LOSSY_MAX_ABS: f64 = 1.0 / 255.0;
/// Frames that take this many times as long as box's are slow.
pub const SLOW: f64 = 1.1;

/// Titles of the groups of hazards, from group 1 on.
pub const GROUPS: [&str; 10] = [
    "where the camera stands",
    "rays along axes, planes, edges and corners",
    "orbits through the change of the dominant axis",
    "movements too small to see",
    "thin walls and hostile tables",
    "checkerboards, noise, shells and cavities",
    "odd grids, spacings and numbers",
    "steps, thresholds and sizes at their limits",
    "changes between frames",
    "two backends, one scene",
];

/// A scene that some method may fail on.
#[derive(Debug)]
pub struct Hazard {
    /// The name used by flags and reports.
    pub name: &'static str,
    /// Number of its group: an index into [`GROUPS`], from 1 on.
    pub group: u8,
    /// What is hard about it, in one line.
    pub about: &'static str,
    /// Makes its volume and frames.
    pub make: fn() -> Result<Scenery>,
}

/// All hazards, by group.
pub fn hazards() -> impl Iterator<Item = &'static Hazard> {
    [
        cameras::HAZARDS,
        rays::HAZARDS,
        sequences::ORBITS,
        sequences::MOVEMENTS,
        tables::HAZARDS,
        data::HAZARDS,
        grids::HAZARDS,
        settings::HAZARDS,
        sequences::CHANGES,
    ]
    .into_iter()
    .flatten()
}

/// What came of a contestant in a hazard.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Right, and as fast as box where time was asked for.
    Ok,
    /// Right, and slower than box by more than [`SLOW`].
    Slow,
    /// Another picture than it should be.
    Wrong,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.pad(match self {
            Self::Ok => "ok",
            Self::Slow => "slow",
            Self::Wrong => "wrong",
        })
    }
}

/// One contestant in one hazard on one backend.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// The hazard's name.
    pub hazard: Cow<'static, str>,
    /// Its group, 1 to 10.
    pub group: u8,
    /// The method's name, or that of another contestant.
    pub method: Cow<'static, str>,
    /// `gpu` or `cpu`; both, where they are held against each other.
    pub backend: String,
    /// Whether its pictures must be bit-identical to box's.
    pub lossless: bool,
    /// What came of it.
    pub verdict: Verdict,
    /// Pixels of all frames with any bit different from box's.
    pub differing_pixels_vs_box: u64,
    /// Largest difference of any channel from box's.
    pub max_abs_diff_vs_box: f64,
    /// Largest difference of any channel from the f64 reference of the same scene; `None` where two backends are held
    /// against each other.
    pub error_vs_reference: Option<f64>,
    /// Largest difference of any channel of the first frame from the picture that all tend to as the step goes to 0
    /// ([`crate::measure::truth`]), pixels at discontinuities left out: what the step, the interpolation and an early end of
    /// rays cost, besides all else. It is that of one channel of one pixel, the worst, and may be 1 in a picture that is
    /// right in all others. `None` where it was not asked for, or the picture is too large.
    pub error_vs_truth: Option<f64>,
    /// Time of a frame over box's: medians of interleaved runs. `None` where the hazard is not one of time.
    pub time_vs_box: Option<f64>,
    /// Largest change of a channel from one frame to the next, where the frames are a sequence: between the two frames
    /// where it is the most over what is expected.
    pub change: Option<f64>,
    /// Largest change of a channel there of box; of box itself, of the f64 reference.
    pub change_expected: Option<f64>,
}
