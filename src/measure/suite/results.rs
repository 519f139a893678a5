//! Results files: JSON Lines that grow by whole lines, so that a run which was stopped can go on.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};

use super::record::{CaseRecord, Header, PictureRecord, Record, SceneRecord};
use crate::error::{Error, Result};

/// What a file holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Results {
    /// The first line.
    pub header: Header,
    /// Scenes, each once.
    pub scenes: Vec<SceneRecord>,
    /// Cases that are finished.
    pub cases: Vec<CaseRecord>,
    /// Pictures for the report.
    pub pictures: Vec<PictureRecord>,
}

impl Results {
    fn new(header: Header) -> Self {
        Self {
            header,
            scenes: Vec::new(),
            cases: Vec::new(),
            pictures: Vec::new(),
        }
    }

    /// Reads a file. A last line without an end is left out: whoever wrote it was stopped.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::File`] naming the first line that is no record.
    pub fn read(path: &Path) -> Result<Self> {
        let bytes = crate::text_file::read_bytes(path, crate::text_file::MEASURED_BYTES)?;
        let text = std::str::from_utf8(whole_lines(&bytes))
            .map_err(|_| Error::file(path, "content", "is not valid UTF-8"))?;
        Self::parse(text, path)?
            .ok_or_else(|| Error::file(path, "line 1", "expected the header of a results file"))
    }

    /// The records of whole lines; `None` where there is no line.
    fn parse(text: &str, path: &Path) -> Result<Option<Self>> {
        let mut results: Option<Self> = None;
        for (i, line) in text.lines().enumerate() {
            let bad = |reason: &str| Error::file(path, format!("line {}", i + 1), reason);
            let record = serde_json::from_str(line)
                .map_err(|e| bad(&format!("is no record of results: {e}")))?;
            match (record, &mut results) {
                (Record::Header(header), None) => results = Some(Self::new(header)),
                (Record::Header(_), Some(_)) => return Err(bad("a second header")),
                (_, None) => return Err(bad("expected the header of a results file")),
                (Record::Scene(scene), Some(results)) => results.scenes.push(scene),
                (Record::Case(case), Some(results)) => results.cases.push(*case),
                (Record::Pictures { pictures }, Some(results)) => results.pictures.extend(pictures),
            }
        }
        Ok(results)
    }

    /// Whether a case of this command is finished.
    pub fn has(&self, command: &str) -> bool {
        self.cases.iter().any(|c| c.command == command)
    }

    /// The scene of this name.
    pub fn scene(&self, name: &str) -> Option<&SceneRecord> {
        self.scenes.iter().find(|s| s.name == name)
    }
}

/// Cut before it is decoded: whoever was stopped may have been in the middle of a letter.
fn whole_lines(bytes: &[u8]) -> &[u8] {
    let end = bytes.iter().rposition(|&b| b == b'\n');
    &bytes[..end.map_or(0, |end| end + 1)]
}

/// How a file of results begins.
const HEADER: &[u8] = b"{\"kind\":\"header\"";

/// Appends records to a file.
#[derive(Debug)]
pub struct Writer {
    path: PathBuf,
    file: File,
}

impl Writer {
    /// Begins a file, or goes on with one that the same suite began on the same machine; gives what it holds already.
    ///
    /// # Errors
    /// [`Error::File`] where there is another file of that name, with what is different; [`Error::Io`].
    pub fn open(path: &Path, header: &Header) -> Result<(Self, Results)> {
        let io = |e| Error::io(path, e);
        if path.metadata().is_ok_and(|m| !m.is_file()) {
            return Err(Error::file(path, "file", "is not a regular file"));
        }
        let mut file = OpenOptions::new()
            .read(true)
            .append(true)
            .create(true)
            .open(path)
            .map_err(io)?;
        // Held until the writer is dropped.
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let reason = "another bench writes to it; name another file or wait";
                return Err(Error::file(path, "output", reason));
            }
            Err(TryLockError::Error(error)) => {
                // Some network folders have no locks: lines are appended whole there, too.
                tracing::warn!("{}: cannot be locked: {error}", path.display());
            }
        }
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(io)?;
        let whole = whole_lines(&bytes);
        let is_cut_header = HEADER.starts_with(&bytes[..bytes.len().min(HEADER.len())]);
        // A header that was cut off is one of ours; anything else without a whole line is not.
        if whole.is_empty() && !is_cut_header {
            return Err(not_ours(path));
        }
        let whole = std::str::from_utf8(whole).map_err(|_| not_ours(path))?;
        // Of a header alone nothing is lost: a suite that failed at once can be mended and run again.
        let known = Results::parse(whole, path)?.filter(|r| !r.scenes.is_empty());
        let whole = if known.is_some() { whole } else { "" };
        if let Some(results) = &known {
            check_same(path, &results.header, header)?;
        }
        file.set_len(whole.len() as u64).map_err(io)?;
        let mut writer = Self {
            path: path.to_owned(),
            file,
        };
        let results = if let Some(results) = known {
            results
        } else {
            writer.append(&[Record::Header(header.clone())])?;
            Results::new(header.clone())
        };
        Ok((writer, results))
    }

    /// Appends whole lines at once.
    ///
    /// # Errors
    /// [`Error::Io`].
    ///
    /// # Panics
    /// Never: every record is an object with names for keys.
    pub fn append(&mut self, records: &[Record]) -> Result<()> {
        let mut text = String::new();
        for record in records {
            text += &serde_json::to_string(record).expect("records have no keys but strings");
            text.push('\n');
        }
        self.file
            .write_all(text.as_bytes())
            .and_then(|()| self.file.flush())
            .map_err(|e| Error::io(&self.path, e))
    }
}

impl SceneRecord {
    /// Refuses a scene whose data is not what the results were measured of.
    ///
    /// # Errors
    /// [`Error::Setting`] naming the scene.
    pub fn check_same(&self, voxels_sha256: &str, stand_in: Option<&str>) -> Result<()> {
        let reason = if self.stand_in.as_deref() != stand_in {
            let named = |stand_in: Option<&str>| stand_in.unwrap_or(&self.volume).to_owned();
            let (then, now) = (named(self.stand_in.as_deref()), named(stand_in));
            format!("the results were measured of {then}, now there is {now}")
        } else if self.voxels_sha256 != voxels_sha256 {
            format!("{} is not what the results were measured of", self.volume)
        } else {
            return Ok(());
        };
        Err(Error::setting(
            format!("scene \"{}\"", self.name),
            format!("{reason}; name another file of results or remove this one"),
        ))
    }
}

fn not_ours(path: &Path) -> Error {
    Error::file(path, "line 1", "is no results file; name another")
}

/// Refuses to go on with results of another suite, machine or program.
fn check_same(path: &Path, old: &Header, new: &Header) -> Result<()> {
    let pairs = [
        ("suite", old.suite.clone(), new.suite.clone()),
        (
            "suite's content",
            old.suite_hash.clone(),
            new.suite_hash.clone(),
        ),
        (
            "machine",
            format!("{:?}", old.machine),
            format!("{:?}", new.machine),
        ),
        (
            "adapters",
            format!("{:?}", old.adapters),
            format!("{:?}", new.adapters),
        ),
    ];
    match pairs.into_iter().find(|(_, old, new)| old != new) {
        Some((what, old, new)) => Err(Error::file(
            path,
            what,
            format!(
                "is not that of this run; name another file or remove this one ({old}, now {new})"
            ),
        )),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::super::record::MachineRecord;
    use super::*;

    fn header(suite: &str) -> Header {
        Header {
            suite: suite.to_owned(),
            suite_hash: "0".to_owned(),
            machine: MachineRecord {
                cpu: "p".to_owned(),
                cores: 2,
                os: "s".to_owned(),
                hollowcast: "v".to_owned(),
                wgpu: None,
                commit: None,
            },
            adapters: Vec::new(),
            missing: Vec::new(),
        }
    }

    fn scene(name: &str) -> Record {
        Record::Scene(SceneRecord {
            name: name.to_owned(),
            title: String::new(),
            volume: String::new(),
            stand_in: None,
            voxels_sha256: String::new(),
            dims: [1; 3],
            bytes: 1,
            load_ms: 0.5,
            paper: None,
            family: None,
        })
    }

    #[test]
    fn a_half_written_line_is_dropped_and_written_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.jsonl");
        let (mut writer, empty) = Writer::open(&path, &header("a")).unwrap();
        assert!(empty.scenes.is_empty());
        writer.append(&[scene("one"), scene("two")]).unwrap();
        drop(writer);
        let whole = std::fs::read_to_string(&path).unwrap();
        for cut in [1, 5, 20] {
            std::fs::write(&path, &whole[..whole.len() - cut]).unwrap();
            assert_eq!(Results::read(&path).unwrap().scenes.len(), 1);
            let (mut writer, results) = Writer::open(&path, &header("a")).unwrap();
            assert_eq!(results.scenes.len(), 1);
            writer.append(&[scene("two")]).unwrap();
            assert_eq!(std::fs::read_to_string(&path).unwrap(), whole);
        }
        // Two at once would write into one another's lines.
        let error = {
            let (_first, _) = Writer::open(&path, &header("a")).unwrap();
            Writer::open(&path, &header("a")).unwrap_err()
        };
        assert!(error.is_bad_input() && error.to_string().contains("another bench"));
        // Stopped in the middle of a letter.
        let half = [whole.as_bytes(), &"{\"kind\":\"\u{f6}".as_bytes()[..10]].concat();
        std::fs::write(&path, &half).unwrap();
        assert_eq!(Results::read(&path).unwrap().scenes.len(), 2);
        assert_eq!(Writer::open(&path, &header("a")).unwrap().1.scenes.len(), 2);
        // Stopped within the header.
        std::fs::write(&path, &whole[..30]).unwrap();
        let (_, results) = Writer::open(&path, &header("a")).unwrap();
        assert!(results.scenes.is_empty());
    }

    #[test]
    fn other_data_is_told_from_what_was_measured() {
        let Record::Scene(scene) = scene("one") else {
            unreachable!()
        };
        assert!(scene.check_same("", None).is_ok());
        for (hash, stand_in) in [("0", None), ("", Some("phantom:pot:16"))] {
            let error = scene.check_same(hash, stand_in).unwrap_err();
            assert!(error.is_bad_input() && error.to_string().starts_with("scene \"one\": "));
        }
    }

    #[test]
    fn what_another_run_wrote_is_refused_and_left_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.jsonl");
        let (mut writer, _) = Writer::open(&path, &header("a")).unwrap();
        writer.append(&[scene("one")]).unwrap();
        drop(writer);
        let mut elsewhere = header("a");
        elsewhere.machine.cores = 4;
        let texts = [
            std::fs::read_to_string(&path).unwrap(),
            "notes".to_owned(),
            "x\ny\n".to_owned(),
        ];
        for (text, header, named) in [
            (&texts[0], header("b"), "suite"),
            (&texts[0], elsewhere, "machine"),
            (&texts[1], header("a"), "is no results file"),
            (&texts[2], header("a"), "is no record"),
        ] {
            std::fs::write(&path, text).unwrap();
            let error = Writer::open(&path, &header).unwrap_err();
            assert!(
                error.is_bad_input() && error.to_string().contains(named),
                "{error}"
            );
            assert_eq!(&std::fs::read_to_string(&path).unwrap(), text);
        }
    }
}
