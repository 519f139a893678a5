//! What the literature's methods are said to fail at, each in the hazard that was made for it, held against what was measured.

use serde::Serialize;

use super::{Row, SLOW, Verdict};

/// A method that takes this many times as long as the fastest lossless one fails to skip what can be skipped.
pub const LEFT_BEHIND: f64 = 1.5;

/// A failure that is expected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Claim {
    /// The method's name, or that of another contestant.
    pub method: &'static str,
    /// The hazard's name.
    pub hazard: &'static str,
    /// What fails, in one line.
    pub about: &'static str,
}

/// All of them.
pub const CLAIMS: [Claim; 9] = [
    Claim {
        method: "half-split",
        hazard: "time-cavity-in-one-half",
        about: "marches a cavity that its cut does not go through",
    },
    Claim {
        method: "two-step",
        hazard: "wall-of-a-voxel",
        about: "steps over thin walls",
    },
    Claim {
        method: "adaptive",
        hazard: "faint-spike",
        about: "steps over a spike whose slope is gentle only beside the steepest",
    },
    Claim {
        method: "octree-encoded",
        hazard: "time-scattered",
        about: "visits every position of the emptiness",
    },
    Claim {
        method: "distance-map",
        hazard: "time-fragmented",
        about: "leaps no farther than a block where every block is active",
    },
    Claim {
        method: "segment-list",
        hazard: "time-many-sheets",
        about: "lists more segments than it has slots for",
    },
    Claim {
        method: "pre-classified",
        hazard: "thin-layer-between-two-materials",
        about: "interpolates colours across a layer that no voxel lies in",
    },
    Claim {
        method: "hardware-filter",
        hazard: "magnified-smooth-data",
        about: "interpolates in 256 steps",
    },
    Claim {
        method: "f32-from-eye",
        hazard: "eye-far",
        about: "measures lengths from an eye that is too far for f32",
    },
];

/// A claim and what was measured on one backend.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// The claim.
    #[serde(flatten)]
    pub claim: Claim,
    /// Where it was measured.
    pub backend: String,
    /// What came of the method.
    pub verdict: Verdict,
    /// Largest difference of any channel from box's.
    pub max_abs_diff_vs_box: f64,
    /// Time of a frame over box's, where the hazard is one of time.
    pub time_vs_box: Option<f64>,
    /// The fastest lossless method there, with its time over box's.
    pub fastest: Option<(String, f64)>,
    /// Whether the failure was seen: another picture, or more time than box or [`LEFT_BEHIND`] times that of the fastest.
    pub is_shown: bool,
}

/// What the rows say of every claim, on every backend that has the method and the hazard.
pub fn findings(rows: &[Row]) -> Vec<Finding> {
    let of_claim = |claim: &'static Claim| {
        let is_its = |row: &&Row| row.method == claim.method && row.hazard == claim.hazard;
        rows.iter()
            .filter(|row| row.group != 10)
            .filter(is_its)
            .map(|row| finding(*claim, row, rows))
    };
    CLAIMS.iter().flat_map(of_claim).collect()
}

fn finding(claim: Claim, row: &Row, rows: &[Row]) -> Finding {
    let fastest = rows
        .iter()
        .filter(|r| r.lossless && r.hazard == row.hazard && r.backend == row.backend)
        .filter_map(|r| Some((&r.method, r.time_vs_box?)))
        .min_by(|a, b| a.1.total_cmp(&b.1));
    let takes_long = row
        .time_vs_box
        .zip(fastest)
        .is_some_and(|(time, (_, least))| time > SLOW || time > LEFT_BEHIND * least);
    Finding {
        claim,
        backend: row.backend.clone(),
        verdict: row.verdict,
        max_abs_diff_vs_box: row.max_abs_diff_vs_box,
        time_vs_box: row.time_vs_box,
        fastest: fastest.map(|(method, time)| (method.to_string(), time)),
        is_shown: row.verdict != Verdict::Ok || takes_long,
    }
}

impl Finding {
    /// What was measured, in words.
    pub fn words(&self) -> String {
        match (self.verdict, self.time_vs_box, &self.fastest) {
            (Verdict::Wrong, ..) => format!("wrong by {:.3}", self.max_abs_diff_vs_box),
            (_, Some(time), Some((fastest, least))) => {
                format!("{time:.2} of box's time; {fastest} {least:.2}")
            }
            _ => format!("off by {:.4}", self.max_abs_diff_vs_box),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::borrow::Cow;

    use super::*;
    use crate::measure::stability::{Contestant, hazards};

    #[test]
    fn claims_are_of_contestants_and_hazards_that_there_are() {
        for claim in CLAIMS {
            assert!(Contestant::all().any(|c| c.name() == claim.method));
            assert!(hazards().any(|h| h.name == claim.hazard), "{claim:?}");
        }
    }

    #[test]
    fn a_method_that_is_left_behind_is_shown_and_one_that_is_as_fast_is_not() {
        let row = |method, time| Row {
            hazard: "time-scattered".into(),
            group: 6,
            method: Cow::Borrowed(method),
            backend: "gpu".to_owned(),
            lossless: true,
            verdict: Verdict::Ok,
            differing_pixels_vs_box: 0,
            max_abs_diff_vs_box: 0.0,
            error_vs_reference: None,
            error_vs_truth: None,
            time_vs_box: Some(time),
            change: None,
            change_expected: None,
        };
        for (time, is_shown) in [(0.5, true), (0.14, false), (0.1, false)] {
            let rows = [
                row("box", 1.0),
                row("octree-encoded", time),
                row("hull", 0.12),
            ];
            let found = findings(&rows);
            assert_eq!(found.len(), 1);
            assert_eq!(found[0].is_shown, is_shown, "{}", found[0].words());
        }
    }
}
