//! Profiles: what a tuning found best, as a small TOML file that `render --profile` reads.

use std::fmt::Write as _;
use std::path::Path;

use serde::Deserialize;

use super::errors::Accuracy;
use super::toml_text;
use crate::error::{Error, Result};
use crate::render::{BackendChoice, Choice};
use crate::sample::{Classification, Sampler};
use crate::skip::{Cuts, HalfCut, METHODS, Skip, SlabCount};

/// A choice, and the backend that it is for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Profile {
    /// Where the pictures are made.
    pub backend: BackendChoice,
    /// Method, block size and cuts.
    pub choice: Choice,
    /// Sampler, classification, step and early termination, where it was tuned for a budget.
    pub accuracy: Option<Accuracy>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    backend: String,
    method: String,
    block: usize,
    cut: Option<String>,
    cuts: Option<String>,
    sampler: Option<String>,
    classification: Option<String>,
    step: Option<f64>,
    ert: Option<f32>,
}

impl Profile {
    /// Reads a profile.
    ///
    /// # Errors
    /// [`Error::Io`], or [`Error::File`] naming the line or field that is wrong.
    pub fn read(path: &Path) -> Result<Self> {
        let text = crate::text_file::read(path, crate::text_file::WRITTEN_BYTES)?;
        Self::from_toml(&text).map_err(|e| e.in_file(path))
    }

    /// Parses a profile's text.
    ///
    /// # Errors
    /// [`Error::Setting`] naming the line or field that is wrong.
    pub fn from_toml(text: &str) -> Result<Self> {
        let file: File = toml_text::parse(text)?;
        let unknown = |field: &str, given: &str, names: &[&str]| {
            let given = given.escape_debug();
            Error::setting(
                field,
                format!("\"{given}\" is none of {}", names.join(", ")),
            )
        };
        let backends: Vec<&str> = BackendChoice::ALL.iter().map(|b| b.name()).collect();
        let backend = BackendChoice::ALL.iter().find(|b| b.name() == file.backend);
        let backend = *backend.ok_or_else(|| unknown("backend", &file.backend, &backends))?;
        let skip = Skip::from_name(&file.method).ok_or_else(|| {
            let names: Vec<&str> = METHODS.iter().map(|m| m.name).collect();
            unknown("method", &file.method, &names)
        })?;
        if !(file.block.is_power_of_two() && (2..=64).contains(&file.block)) {
            let reason = format!("{} is none of 2, 4, 8, 16, 32, 64", file.block);
            return Err(Error::setting("block", reason));
        }
        let mut cuts = Cuts::default();
        if let Some(cut) = &file.cut {
            let names: Vec<&str> = HalfCut::ALL.iter().map(|c| c.name()).collect();
            let found = HalfCut::ALL.iter().find(|c| c.name() == cut);
            cuts.half = *found.ok_or_else(|| unknown("cut", cut, &names))?;
        }
        if let Some(slabs) = &file.cuts {
            cuts.slabs = slabs
                .parse::<SlabCount>()
                .map_err(|reason| Error::setting("cuts", reason))?;
        }
        let accuracy = match (&file.sampler, file.step, file.ert) {
            (Some(sampler), Some(step_voxels), Some(ert)) => {
                let names: Vec<&str> = Sampler::ALL.iter().map(|s| s.name()).collect();
                let found = Sampler::ALL.iter().find(|s| s.name() == sampler);
                if !(step_voxels > 0.0 && step_voxels.is_finite()) {
                    return Err(Error::setting(
                        "step",
                        "must be a positive number of voxels",
                    ));
                }
                if !(ert > 0.0 && ert <= 1.0) {
                    return Err(Error::setting("ert", "must lie above 0 and be at most 1"));
                }
                let name = file.classification.as_deref();
                let name = name.unwrap_or(Classification::Post.name());
                let classification = Classification::ALL.iter().find(|c| c.name() == name);
                let all: Vec<&str> = Classification::ALL.iter().map(|c| c.name()).collect();
                Some(Accuracy {
                    sampler: *found.ok_or_else(|| unknown("sampler", sampler, &names))?,
                    classification: *classification
                        .ok_or_else(|| unknown("classification", name, &all))?,
                    step_voxels,
                    ert,
                })
            }
            (None, None, None) if file.classification.is_none() => None,
            _ => {
                let reason = "belong together: all of them or none";
                return Err(Error::setting("sampler, step, ert", reason));
            }
        };
        Ok(Self {
            backend,
            choice: Choice {
                skip,
                block: file.block,
                cuts,
            },
            accuracy,
        })
    }

    /// The text that [`Self::from_toml`] reads the same profile from, under `comment`, of one or more lines.
    pub fn to_toml(&self, comment: &str) -> String {
        let mut text = String::new();
        // Writing to a String cannot fail.
        for line in comment.lines() {
            let _ = writeln!(text, "# {line}");
        }
        let Choice { skip, block, cuts } = &self.choice;
        let _ = writeln!(text, "backend = \"{}\"", self.backend.name());
        let _ = writeln!(text, "method = \"{}\"", skip.method().name);
        let _ = writeln!(text, "block = {block}");
        let _ = writeln!(text, "cut = \"{}\"", cuts.half.name());
        let _ = writeln!(text, "cuts = \"{}\"", cuts.slabs);
        if let Some(accuracy) = &self.accuracy {
            let _ = writeln!(text, "sampler = \"{}\"", accuracy.sampler.name());
            let classification = accuracy.classification.name();
            let _ = writeln!(text, "classification = \"{classification}\"");
            let _ = writeln!(text, "step = {:?}", accuracy.step_voxels);
            let _ = writeln!(text, "ert = {:?}", accuracy.ert);
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_reads_back_the_same() {
        for &backend in BackendChoice::ALL {
            for method in METHODS {
                for (half, slabs) in [
                    (HalfCut::Middle, SlabCount::Auto),
                    (HalfCut::Best, SlabCount::Middle),
                    (HalfCut::Best, SlabCount::AtMost(5)),
                ] {
                    let profile = Profile {
                        backend,
                        choice: Choice {
                            skip: method.skip,
                            block: 16,
                            cuts: Cuts { half, slabs },
                        },
                        accuracy: (half == HalfCut::Best).then_some(Accuracy {
                            sampler: Sampler::Hardware,
                            classification: Classification::PreIntegrated,
                            step_voxels: 2.0_f64.sqrt(),
                            ert: 0.98,
                        }),
                    };
                    let text = profile.to_toml("made for\nsomething # odd");
                    assert_eq!(Profile::from_toml(&text).unwrap(), profile, "{text}");
                }
            }
        }
    }

    #[test]
    fn what_is_wrong_is_named_with_its_file_in_one_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bad.profile.toml");
        let good = "backend = \"cpu\"\nmethod = \"hull\"\nblock = 8\n";
        assert!(Profile::from_toml(good).is_ok());
        for (text, named) in [
            (good.replace("cpu", "tpu"), "backend: \"tpu\" is none of"),
            (good.replace("hull", "hulk"), "method: \"hulk\" is none of"),
            (good.replace('8', "9"), "block: 9 is none of"),
            (good.replace('8', "-8"), "line 3: "),
            (good.replace('8', "\"8\""), "line 3: "),
            (good.replace("block = 8", ""), "missing field `block`"),
            (
                good.replace("block", "blocks"),
                "line 3: unknown field `blocks`",
            ),
            (
                format!("{good}cut = \"third\"\n"),
                "cut: \"third\" is none of",
            ),
            (format!("{good}cuts = \"99\"\n"), "cuts: expected"),
            (format!("{good}step = 0.5\n"), "sampler, step, ert: belong"),
            (
                format!("{good}classification = \"pre\"\n"),
                "sampler, step, ert: belong",
            ),
            (
                format!(
                    "{good}step = 0.5\nert = 0.9\nsampler = \"exact\"\nclassification = \"late\"\n"
                ),
                "classification: \"late\" is none of",
            ),
            (
                format!("{good}step = 0.5\nert = 0.9\nsampler = \"soft\"\n"),
                "sampler: \"soft\" is none of",
            ),
            (
                format!("{good}step = -1.0\nert = 0.9\nsampler = \"exact\"\n"),
                "step: must be",
            ),
            (
                format!("{good}colour = 3\n"),
                "line 4: unknown field `colour`",
            ),
            ("backend = ".to_owned(), "line 1: "),
            ("\u{0}".to_owned(), "line 1: "),
        ] {
            std::fs::write(&path, text).unwrap();
            let error = Profile::read(&path).unwrap_err();
            let line = error.to_string();
            assert!(error.is_bad_input() && !line.contains('\n'), "{line}");
            assert!(line.starts_with(path.to_str().unwrap()), "{line}");
            assert!(line.contains(named), "{named:?} is not in {line}");
        }
        assert!(
            Profile::read(&folder.path().join("none"))
                .unwrap_err()
                .is_bad_input()
        );
    }
}
