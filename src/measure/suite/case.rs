//! Cases: what a suite's sweeps come to, one command each.

use super::file::{SceneRow, Suite, Sweep};
use crate::measure::compare::Against;
use crate::mode::MODES;
use crate::render::{BackendChoice, DEFAULT_BLOCK, MethodChoice};
use crate::sample::{Classification, Sampler};
use crate::skip::Skip;

/// One method on one backend with all that it is drawn with, in the words of the command.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Case {
    /// Where.
    pub backend: String,
    /// Which.
    pub method: String,
    /// Block edge in voxels.
    pub block: usize,
}

/// Cases that differ in method, block and backend alone, and are run in turns.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Group {
    /// The scene's place in the suite.
    pub scene: usize,
    /// The step.
    pub step: String,
    /// The sampler.
    pub sampler: String,
    /// The classification, if it is not the usual one.
    pub classification: Option<String>,
    /// The mode.
    pub mode: String,
    /// Opacity at which rays stop.
    pub ert: String,
    /// Size of the pictures.
    pub size: String,
    /// Timed runs of each case in each view.
    pub repeat: u32,
    /// Edge in pixels of the picture that is held against the truth; 0: none is.
    pub truth: u32,
    /// Who takes part.
    pub cases: Vec<Case>,
}

impl Group {
    /// The words of `hollowcast compare` that measure a case of this group again, the volume being `volume`.
    pub fn words(&self, case: &Case, suite: &Suite, volume: &str) -> Vec<String> {
        let scene = &suite.scenes[self.scene];
        let mut words = scene.words(volume);
        let mut flag = |name: &str, value: &str| words.extend([name.to_owned(), value.to_owned()]);
        flag("--size", &self.size);
        if self.mode != MODES[0].name {
            flag("--mode", &self.mode);
        }
        flag("--sampler", &self.sampler);
        if let Some(classification) = &self.classification {
            flag("--classification", classification);
        }
        flag("--ert", &self.ert);
        flag("--views", &scene.views.to_string());
        flag("--steps", &self.step);
        flag("--backends", &case.backend);
        flag("--methods", &case.method);
        flag("--blocks", &case.block.to_string());
        flag("--repeat", &self.repeat.to_string());
        if self.truth == 0 {
            flag("--reference-views", "0");
        } else {
            flag("--against", Against::Truth.name());
            flag("--reference-size", &self.truth.to_string());
        }
        words
    }

    /// The work of this group in no unit, for estimates of what is left.
    pub fn weight(&self, suite: &Suite) -> f64 {
        let edges = self
            .size
            .split(['x', 'X'])
            .map(|n| n.parse().map_or(512.0, |n: u32| f64::from(n)));
        let pixels: f64 = edges.clone().product();
        let pixels = if edges.count() == 1 {
            pixels * pixels
        } else {
            pixels
        };
        let frames = f64::from(suite.scenes[self.scene].views) * (2.0 + f64::from(self.repeat));
        pixels * frames * self.cases.len() as f64
    }

    fn is_drawn_like(&self, other: &Self) -> bool {
        let alone = |group: &Self| Self {
            cases: Vec::new(),
            truth: 0,
            ..group.clone()
        };
        alone(self) == alone(other)
    }
}

impl SceneRow {
    /// The words that every command about this scene begins with, the volume being `volume`.
    pub fn words(&self, volume: &str) -> Vec<String> {
        let mut words = vec![volume.to_owned(), "--tf".to_owned(), self.tf.clone()];
        words.extend(self.flags.iter().cloned());
        if let Some(camera) = &self.camera {
            words.extend(["--camera".to_owned(), camera.clone()]);
        }
        words
    }
}

impl Suite {
    /// All cases, in the order of scenes and then of the file. What a backend does not have is left out.
    ///
    /// # Panics
    /// Never: names were checked when the suite was read.
    pub fn groups(&self) -> Vec<Group> {
        let mut groups: Vec<Group> = Vec::new();
        for sweep in &self.sweeps {
            for name in &sweep.scenes {
                let scene = self.scene(name).expect("checked when it was read");
                for group in of_sweep(self, sweep, scene) {
                    match groups.iter_mut().find(|g| g.is_drawn_like(&group)) {
                        Some(known) => {
                            known.truth = known.truth.max(group.truth);
                            for case in group.cases {
                                if !known.cases.contains(&case) {
                                    known.cases.push(case);
                                }
                            }
                        }
                        None => groups.push(group),
                    }
                }
            }
        }
        groups.retain(|g| !g.cases.is_empty());
        groups.sort_by_key(|g| g.scene);
        groups
    }
}

fn of_sweep(suite: &Suite, sweep: &Sweep, scene: usize) -> Vec<Group> {
    let classifications: Vec<Option<&String>> = if sweep.classifications.is_empty() {
        vec![None]
    } else {
        sweep.classifications.iter().map(Some).collect()
    };
    let mut groups = Vec::new();
    for mode in &sweep.modes {
        for size in &sweep.sizes {
            for ert in &sweep.ert {
                for sampler in &sweep.samplers {
                    for classification in &classifications {
                        for step in &sweep.steps {
                            groups.push(Group {
                                scene,
                                step: step.clone(),
                                sampler: sampler.clone(),
                                classification: classification.cloned(),
                                mode: mode.clone(),
                                ert: ert.clone(),
                                size: size.clone(),
                                repeat: sweep.repeat.unwrap_or(suite.repeat),
                                truth: sweep.truth,
                                cases: cases(sweep, mode, sampler, *classification),
                            });
                        }
                    }
                }
            }
        }
    }
    groups
}

/// The methods that have the mode, the sampler and the classification, each in every block size if it has blocks at all.
fn cases(sweep: &Sweep, mode: &str, sampler: &str, classification: Option<&String>) -> Vec<Case> {
    let mut cases = Vec::new();
    // A name that is none is left in, for the command to refuse.
    let class = classification
        .and_then(|name| Classification::ALL.iter().find(|c| c.name() == name))
        .copied()
        .unwrap_or_default();
    let is_post = class == Classification::Post;
    for backend in &sweep.backends {
        // Other backends interpolate in one way only, and what auto will be is not known yet.
        let has_sampler = backend == BackendChoice::Gpu.name()
            || backend == BackendChoice::Auto.name()
            || sampler == Sampler::Exact.name();
        let has = |backends: &[&str]| {
            backend == BackendChoice::Auto.name() || backends.contains(&backend.as_str())
        };
        let has_class =
            backend == BackendChoice::Auto.name() || class.check_backend(backend).is_ok();
        let row = MODES.iter().find(|row| row.name == mode);
        // Modes that do not read the table make no use of another classification.
        let has_mode = row.is_none_or(|row| has(row.backends) && (is_post || row.takes_table));
        if !has_sampler || !has_class || !has_mode {
            continue;
        }
        for method in &sweep.methods {
            let choice = MethodChoice::from_name(method).expect("checked when it was read");
            let has_blocks = match choice {
                MethodChoice::Auto => false,
                MethodChoice::Only(skip) => {
                    // Adaptive follows the table, value by value, of which the other modes make no use.
                    let is_possible = skip != Skip::Adaptive
                        || (is_post && row.is_some_and(|row| row.takes_table));
                    if !has(skip.method().backends) || !is_possible {
                        continue;
                    }
                    skip.reads_blocks()
                }
            };
            let blocks = if has_blocks {
                &sweep.blocks[..]
            } else {
                &[DEFAULT_BLOCK]
            };
            cases.extend(blocks.iter().map(|&block| Case {
                backend: backend.clone(),
                method: method.clone(),
                block,
            }));
        }
    }
    cases
}

#[cfg(test)]
mod tests {
    use super::*;

    const SUITE: &str = r#"
name = "small"
[[scene]]
name = "ball"
volume = "phantom:sphere:16"
[[sweep]]
scenes = ["ball"]
backends = ["cpu", "gpu"]
methods = ["box", "hull", "k-cuts", "adaptive"]
blocks = [4, 8]
steps = ["0.5", "0.01u"]
samplers = ["exact", "hardware"]
modes = ["emission-absorption", "phong"]
[[sweep]]
scenes = ["ball"]
backends = ["cpu"]
methods = ["box", "half-split"]
steps = ["0.5"]
"#;

    #[test]
    fn a_backend_runs_what_it_has_and_each_case_once() {
        let suite = Suite::from_toml(SUITE).unwrap();
        let groups = suite.groups();
        assert_eq!(groups.len(), 8);
        let names = |group: &Group, backend: &str| -> Vec<String> {
            let own = group.cases.iter().filter(|c| c.backend == backend);
            own.map(|c| format!("{} {}", c.method, c.block)).collect()
        };
        // The second sweep joins the group that draws alike, of which box, which has no blocks, is already one.
        let first = &groups[0];
        let of_cpu = names(first, "cpu");
        assert_eq!(of_cpu, ["box 8", "hull 4", "hull 8", "half-split 8"]);
        assert_eq!(names(first, "gpu").len(), 7);
        let hardware = groups.iter().filter(|g| g.sampler == "hardware");
        assert!(hardware.clone().all(|g| names(g, "cpu").is_empty()));
        assert!(hardware.count() == 4);
        let phong = groups.iter().find(|g| g.mode == "phong").unwrap();
        assert!(
            names(phong, "gpu")
                .iter()
                .all(|n| !n.starts_with("adaptive"))
        );
    }

    #[test]
    fn a_classification_is_drawn_by_what_has_it() {
        let text = SUITE
            .replace(
                "modes = [\"emission-absorption\", \"phong\"]",
                "classifications = [\"post\", \"pre\"]\nmodes = [\"emission-absorption\", \"mip\"]",
            )
            .replace("[\"cpu\", \"gpu\"]", "[\"cpu\", \"gpu\", \"reference\"]");
        let suite = Suite::from_toml(&text).unwrap();
        let groups = suite.groups();
        let pre = || {
            let is_pre = |g: &&Group| g.classification.as_deref() == Some("pre");
            groups.iter().filter(is_pre)
        };
        assert!(pre().count() > 0 && pre().all(|g| g.mode == "emission-absorption"));
        let cases = || pre().flat_map(|g| &g.cases);
        assert!(cases().any(|c| c.backend == "reference"));
        assert!(cases().all(|c| c.backend != "cpu" && c.method != "adaptive"));
        let post = groups
            .iter()
            .filter(|g| g.classification.as_deref() == Some("post"));
        assert!(post.flat_map(|g| &g.cases).any(|c| c.backend == "cpu"));
    }

    #[test]
    fn words_say_all_that_a_case_is_drawn_with() {
        let suite = Suite::from_toml(SUITE).unwrap();
        let group = &suite.groups()[0];
        let words = group
            .words(&group.cases[1], &suite, "phantom:sphere:16")
            .join(" ");
        assert_eq!(
            words,
            "phantom:sphere:16 --tf translucent --size 512x512 --sampler exact --ert 0.98 --views 1 --steps 0.5 \
             --backends cpu --methods hull --blocks 4 --repeat 3 --reference-views 0"
        );
    }
}
