//! The cases of all results, as the report's charts and tables ask for them.

use std::collections::{BTreeMap, BTreeSet};

use super::figure::Point;
use super::number::short;
use crate::measure::suite::{CaseRecord, Paper, Results, SceneRecord};
use crate::mode::MODES;

/// A case with where it was measured.
#[derive(Debug, Clone, Copy)]
pub(super) struct Case<'a> {
    /// The results' place, where there are several.
    pub(super) run: Option<usize>,
    /// What was drawn.
    pub(super) scene: &'a SceneRecord,
    /// What was measured.
    pub(super) record: &'a CaseRecord,
}

/// All cases.
#[derive(Debug)]
pub(super) struct Model<'a> {
    /// As they were given.
    pub(super) results: &'a [Results],
    /// In the order of the files.
    pub(super) cases: Vec<Case<'a>>,
}

impl<'a> Model<'a> {
    pub(super) fn new(results: &'a [Results]) -> Self {
        let mut cases = Vec::new();
        for (i, one) in results.iter().enumerate() {
            for record in &one.cases {
                if let Some(scene) = one.scene(&record.scene) {
                    let run = (results.len() > 1).then_some(i + 1);
                    cases.push(Case { run, scene, record });
                }
            }
        }
        Self { results, cases }
    }

    /// The scenes by name, each once.
    pub(super) fn scenes(&self) -> Vec<&'a SceneRecord> {
        let mut scenes: Vec<&SceneRecord> = Vec::new();
        for scene in self.results.iter().flat_map(|r| &r.scenes) {
            if !scenes.iter().any(|s| s.name == scene.name) {
                scenes.push(scene);
            }
        }
        scenes
    }

    /// Cases in emission and absorption, of which most charts are.
    pub(super) fn usual(&self) -> impl Iterator<Item = Case<'a>> + '_ {
        let is_usual = |c: &Case| c.record.mode == MODES[0].name;
        self.cases.iter().copied().filter(is_usual)
    }

    /// The same of one scene.
    pub(super) fn of_scene<'s>(&'s self, scene: &'s str) -> impl Iterator<Item = Case<'a>> + 's {
        self.usual().filter(move |c| c.scene.name == scene)
    }

    /// The scene that stands beside a data set of the main paper.
    pub(super) fn beside(&self, paper: Paper) -> Option<&'a SceneRecord> {
        self.scenes().into_iter().find(|s| s.paper == Some(paper))
    }
}

/// The different errors of lossless cases, bit for bit, by all that decides them: one, unless a method is not what it says.
pub(super) fn error_lines(cases: &[Case]) -> BTreeMap<String, BTreeSet<[u64; 2]>> {
    let mut lines: BTreeMap<String, BTreeSet<[u64; 2]>> = BTreeMap::new();
    for case in cases.iter().filter(|c| c.record.lossless) {
        let record = case.record;
        let Some(error) = &record.error else { continue };
        let line = format!(
            "{}, {}, {}, step {}, ERT {}, {:?}",
            record.scene,
            case.kind(),
            record.mode,
            record.step,
            record.ert,
            error.size
        );
        let bits = [error.rms, error.max_abs].map(f64::to_bits);
        lines.entry(line).or_default().insert(bits);
    }
    lines
}

impl Case<'_> {
    /// Where and how samples are taken: cases of one kind are drawn with one mark.
    pub(super) fn kind(&self) -> String {
        let CaseRecord {
            backend,
            sampler,
            classification,
            ..
        } = self.record;
        let mut kind = format!("{backend}, {sampler}");
        if let Some(classification) = classification {
            kind = format!("{kind}, {classification}");
        }
        match self.run {
            Some(run) => format!("{kind} (results {run})"),
            None => kind,
        }
    }

    /// In words: all that tells it from its neighbours.
    pub(super) fn label(&self) -> String {
        let CaseRecord {
            method,
            step,
            block,
            frame_ms,
            error,
            ert,
            ..
        } = self.record;
        let blocks = if method == "box" || method == "auto" {
            String::new()
        } else {
            format!(", blocks of {block}")
        };
        let error = error.as_ref().map_or(String::new(), |error| {
            format!(", RMS error {}", short(error.rms))
        });
        format!(
            "{}: {method}, step {step}{blocks}, {}, ERT {ert}: {} ms{error}",
            self.scene.title,
            self.kind(),
            short(frame_ms.median)
        )
    }

    /// As a point of a chart.
    pub(super) fn point(&self, x: f64, y: f64) -> Point {
        Point {
            x,
            y,
            label: self.label(),
            command: self.record.command.clone(),
        }
    }

    /// Median frame time in ms.
    pub(super) fn ms(&self) -> f64 {
        self.record.frame_ms.median
    }
}
