//! The suite file.

use std::path::Path;

use serde::Deserialize;

use crate::error::Result;
use crate::measure::toml_text;

/// A suite as its file describes it.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Suite {
    /// In results and reports.
    pub name: String,
    /// Timed runs of each case in each view, where a sweep does not say.
    #[serde(default = "three")]
    pub repeat: u32,
    /// What is drawn.
    #[serde(rename = "scene")]
    pub scenes: Vec<SceneRow>,
    /// How it is drawn.
    #[serde(rename = "sweep")]
    pub sweeps: Vec<Sweep>,
    /// What the report shows.
    #[serde(default, rename = "picture")]
    pub pictures: Vec<PictureRow>,
    /// The file's content, by which results know their suite.
    #[serde(skip)]
    pub hash: String,
}

/// A volume, its table and its views.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneRow {
    /// By which sweeps name it.
    pub name: String,
    /// By which the report does.
    pub title: Option<String>,
    /// A phantom, or the name of a file in the folder of data.
    pub volume: String,
    /// The phantom that is drawn where that file is missing.
    pub stand_in: Option<String>,
    /// The transfer function, as `--tf` takes it.
    #[serde(default = "translucent")]
    pub tf: String,
    /// The first view, as `--camera` takes it.
    pub camera: Option<String>,
    /// Views around the box.
    #[serde(default = "one")]
    pub views: u32,
    /// More flags of `hollowcast compare`.
    #[serde(default)]
    pub flags: Vec<String>,
    /// Which of the main paper's data it stands beside.
    pub paper: Option<Paper>,
    /// Scenes of one family differ in their size alone.
    pub family: Option<String>,
}

/// The data of Yu et al. 2016.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Deserialize, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Paper {
    /// Hollow.
    Teapot,
    /// Solid. Not available; another solid scan takes its place.
    Foot,
}

/// Every combination of these lists, less what a backend does not have.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sweep {
    /// Scenes by name.
    pub scenes: Vec<String>,
    /// `gpu`, `cpu`, `reference` or `auto`.
    pub backends: Vec<String>,
    /// Methods, or `auto`; box runs along in any case.
    pub methods: Vec<String>,
    /// Block edges in voxels; methods without blocks take none.
    #[serde(default = "eight")]
    pub blocks: Vec<usize>,
    /// As `--steps` takes them.
    pub steps: Vec<String>,
    /// As `--sampler` takes them. Backends other than gpu take part in `exact`.
    #[serde(default = "exact")]
    pub samplers: Vec<String>,
    /// As `--classification` takes them; none: as is usual.
    #[serde(default)]
    pub classifications: Vec<String>,
    /// As `--mode` takes them.
    #[serde(default = "emission_absorption")]
    pub modes: Vec<String>,
    /// As `--ert` takes them.
    #[serde(default = "usual_ert")]
    pub ert: Vec<String>,
    /// As `--size` takes them.
    #[serde(default = "usual_size")]
    pub sizes: Vec<String>,
    /// Timed runs of each case in each view.
    pub repeat: Option<u32>,
    /// Width and height of the first view's picture that is held against the truth; 0: none is.
    #[serde(default)]
    pub truth: u32,
}

/// Pictures of the first view, their differences from the truth and their samples, for the report.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PictureRow {
    /// The scene by name.
    pub scene: String,
    /// The backend.
    pub backend: String,
    /// The methods, next to one another.
    pub methods: Vec<String>,
    /// Block edge in voxels.
    #[serde(default = "eight_voxels")]
    pub block: usize,
    /// As `--step` takes it.
    pub step: String,
    /// As `--mode` takes it.
    #[serde(default = "first_mode")]
    pub mode: String,
    /// Width and height in pixels.
    pub size: u32,
}

fn three() -> u32 {
    3
}
fn one() -> u32 {
    1
}
fn translucent() -> String {
    "translucent".to_owned()
}
fn eight() -> Vec<usize> {
    vec![8]
}
fn eight_voxels() -> usize {
    8
}
fn exact() -> Vec<String> {
    vec!["exact".to_owned()]
}
fn first_mode() -> String {
    "emission-absorption".to_owned()
}
fn emission_absorption() -> Vec<String> {
    vec![first_mode()]
}
fn usual_ert() -> Vec<String> {
    vec!["0.98".to_owned()]
}
fn usual_size() -> Vec<String> {
    vec!["512x512".to_owned()]
}

impl Suite {
    /// Reads a suite.
    ///
    /// # Errors
    /// [`crate::Error::Io`], or [`crate::Error::File`] naming the line or field that is wrong.
    pub fn read(path: &Path) -> Result<Self> {
        let text = crate::text_file::read(path, crate::text_file::WRITTEN_BYTES)?;
        Self::from_toml(&text).map_err(|e| e.in_file(path))
    }

    /// Parses a suite's text. Values that `hollowcast compare` would take as flags are left to it to check.
    ///
    /// # Errors
    /// [`crate::Error::Setting`] naming the line or field that is wrong.
    pub fn from_toml(text: &str) -> Result<Self> {
        let mut suite: Self = toml_text::parse(text)?;
        suite.check()?;
        suite.hash = format!("{:016x}", fnv1a(text.as_bytes()));
        Ok(suite)
    }

    /// The scene of this name.
    pub fn scene(&self, name: &str) -> Option<usize> {
        self.scenes.iter().position(|s| s.name == name)
    }
}

/// Fowler, Noll & Vo's hash, variant 1a, of 64 bits: names a content, and withstands no malice.
fn fnv1a(bytes: &[u8]) -> u64 {
    let step = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, step)
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = r#"
name = "small"
[[scene]]
name = "ball"
volume = "phantom:sphere:16"
[[sweep]]
scenes = ["ball"]
backends = ["cpu"]
methods = ["box", "hull"]
steps = ["0.5"]
"#;

    #[test]
    fn what_is_not_said_is_usual() {
        let suite = Suite::from_toml(GOOD).unwrap();
        assert_eq!((suite.repeat, suite.scenes[0].views), (3, 1));
        assert_eq!(suite.sweeps[0].samplers, ["exact"]);
        assert_eq!(suite.sweeps[0].blocks, [8]);
        assert_eq!(fnv1a(b"a"), 0xaf63_dc4c_8601_ec8c);
    }

    #[test]
    fn what_is_wrong_is_named_in_one_line() {
        for (from, to, named) in [
            ("name = \"small\"", "name = 3", "line 2: "),
            ("steps", "step", "line 10: unknown field `step`"),
            (
                "\"cpu\"",
                "\"tpu\"",
                "sweep 1: backends: there is no \"tpu\"",
            ),
            (
                "\"hull\"",
                "\"hulk\"",
                "sweep 1: methods: there is no \"hulk\"",
            ),
            (
                "[\"ball\"]",
                "[\"cube\"]",
                "sweep 1: scenes: there is no \"cube\"",
            ),
            ("[\"0.5\"]", "[]", "sweep 1: steps: must be at least one"),
            (
                "[\"0.5\"]",
                &format!("[{}]", "\"0.5\", ".repeat(5_001)),
                "sweep: 10002 cases; at most 10000",
            ),
            (
                "phantom:sphere:16",
                "/data/x.nrrd",
                "scene \"ball\": volume: expected",
            ),
            (
                "volume =",
                "views = 0\nvolume =",
                "scene \"ball\": views: must be",
            ),
        ] {
            assert!(GOOD.contains(from));
            let error = Suite::from_toml(&GOOD.replace(from, to)).unwrap_err();
            let line = error.to_string();
            assert!(error.is_bad_input() && !line.contains('\n'), "{line}");
            assert!(line.starts_with(named), "{named:?} does not begin {line}");
        }
    }
}
