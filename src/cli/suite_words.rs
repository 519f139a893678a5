//! A suite's cases as commands: in words for the parser, and as a line that can be copied into a shell.

use std::path::Path;

use clap::Parser;
use hollowcast::measure::suite::SceneRow;
use hollowcast::{Error, Result};

use super::compare;

/// Where the scans lie that ship with the project, seen from its folder.
const SHIPPED: &str = "data";
/// The variable that names the folder of those that do not.
pub(super) const DATA: &str = "HOLLOWCAST_DATA";

/// A scene's volume, found.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Place {
    /// What is opened.
    pub(super) path: String,
    /// The same as a shell's word that holds on other machines.
    pub(super) word: String,
    /// The phantom that stands in for what is missing.
    pub(super) stand_in: Option<String>,
}

impl Place {
    /// Looks for a scene's volume: among the scans that ship, seen from here and from the folder of the suite's file, then in
    /// `folder`, then for a stand-in.
    pub(super) fn of(scene: &SceneRow, suite: &Path, folder: Option<&Path>) -> Result<Self> {
        let name = &scene.volume;
        let found = |path: String, word: String| Self {
            path,
            word,
            stand_in: None,
        };
        if name.starts_with("phantom:") {
            return Ok(found(name.clone(), quoted(name)));
        }
        let shipped = format!("{SHIPPED}/{name}");
        if Path::new(&shipped).is_file() {
            return Ok(found(shipped.clone(), quoted(&shipped)));
        }
        // Of a suite in this folder the parent is "", and ".." leads on from any.
        let beside = suite.parent().map(|own| own.join("..").join(&shipped));
        if let Some(path) = beside.filter(|p| p.is_file()) {
            // Commands are those that hold in the project's folder.
            let path = path.to_string_lossy().into_owned();
            return Ok(found(path, quoted(&shipped)));
        }
        if let Some(path) = folder.map(|f| f.join(name)).filter(|p| p.is_file()) {
            // The variable alone is live: in the name nothing is.
            let word = format!("\"${DATA}\"/{}", quoted(name));
            return Ok(found(path.to_string_lossy().into_owned(), word));
        }
        match &scene.stand_in {
            Some(phantom) => Ok(Self {
                stand_in: Some(phantom.clone()),
                ..found(phantom.clone(), quoted(phantom))
            }),
            None => Err(Error::setting(
                format!("scene \"{}\": volume", scene.name),
                format!(
                    "{name} is neither in {SHIPPED}/ nor in the folder that --data or {DATA} names"
                ),
            )),
        }
    }
}

/// `hollowcast compare` without its name.
#[derive(Debug, Parser)]
#[command(name = "hollowcast compare", no_binary_name = true)]
struct Compare {
    #[command(flatten)]
    args: compare::Args,
}

/// What `hollowcast compare` makes of these words.
pub(super) fn parsed(words: &[String]) -> Result<compare::Args, String> {
    Compare::try_parse_from(words).map(|c| c.args).map_err(|e| {
        let text = super::message(&e);
        text.strip_prefix("error: ").unwrap_or(&text).to_owned()
    })
}

/// A command as it is typed; the first of its words is the volume, for which `volume` stands.
pub(super) fn line(command: &str, volume: &str, words: &[String]) -> String {
    let rest = words.iter().skip(1).map(|word| quoted(word));
    let all: Vec<String> = [format!("hollowcast {command}"), volume.to_owned()]
        .into_iter()
        .chain(rest)
        .collect();
    all.join(" ")
}

/// A word that a POSIX shell takes as it is.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./:=,+@%".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_quoted_where_a_shell_would_take_them_apart() {
        assert_eq!(quoted("ramp:40:255:0.3"), "ramp:40:255:0.3");
        assert_eq!(quoted("eye=1,2,3;up=0,0,1"), "'eye=1,2,3;up=0,0,1'");
        assert_eq!(quoted("it's"), r"'it'\''s'");
        assert_eq!(quoted(""), "''");
    }

    #[test]
    fn what_is_missing_is_stood_in_for_or_named() {
        let scene = |more: &str| -> SceneRow {
            toml::from_str(&format!("name = \"s\"\nvolume = \"none.nrrd\"\n{more}")).unwrap()
        };
        let suite = Path::new("suites/s.toml");
        let place = Place::of(&scene("stand_in = \"phantom:pot:16\""), suite, None).unwrap();
        assert_eq!(
            (place.path.as_str(), place.stand_in.is_some()),
            ("phantom:pot:16", true)
        );
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("none.nrrd"), "").unwrap();
        let place = Place::of(&scene(""), suite, Some(folder.path())).unwrap();
        assert_eq!(place.word, "\"$HOLLOWCAST_DATA\"/none.nrrd");
        let error = Place::of(&scene(""), suite, None).unwrap_err();
        assert!(error.is_bad_input() && error.to_string().contains("none.nrrd"));
        // From another folder, the scans that ship lie beside the suite's.
        let data = folder.path().join("data");
        std::fs::create_dir(&data).unwrap();
        std::fs::write(data.join("none.nrrd"), "").unwrap();
        let suite = folder.path().join("benches/s.toml");
        std::fs::create_dir(folder.path().join("benches")).unwrap();
        let place = Place::of(&scene(""), &suite, None).unwrap();
        assert_eq!(place.word, "data/none.nrrd");
        assert!(Path::new(&place.path).is_file());
        // A name stays a name in a command that is copied into a shell.
        std::fs::write(folder.path().join("a$(b)"), "").unwrap();
        let live = SceneRow {
            volume: "a$(b)".to_owned(),
            ..scene("")
        };
        let place = Place::of(&live, &suite, Some(folder.path())).unwrap();
        assert_eq!(place.word, "\"$HOLLOWCAST_DATA\"/'a$(b)'");
    }
}
