//! Files that appear complete or not at all.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

/// Writes a file through a sibling that takes its name only once it is complete.
///
/// # Errors
/// [`Error::Io`] about `path`, whatever failed; the sibling is removed and an older file of that name left untouched.
pub fn write_atomically(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<()> {
    let attempt = || {
        let sibling = sibling(path)?;
        let file = OpenOptions::new()
            .write(true)
            .create_new(true)
            .open(&sibling)?;
        let mut writer = BufWriter::new(file);
        let written = fill(&mut writer)
            .and_then(|()| writer.flush())
            .and_then(|()| fs::rename(&sibling, path));
        if written.is_err() {
            // The first error is the one to report.
            let _ = fs::remove_file(&sibling);
        }
        written
    };
    attempt().map_err(|e| Error::io(path, e))
}

/// A hidden name in the same folder (a rename must not leave the file system), of this process alone.
fn sibling(path: &Path) -> io::Result<PathBuf> {
    let name = path.file_name().ok_or(io::ErrorKind::IsADirectory)?;
    let mut hidden = std::ffi::OsString::from(".");
    hidden.push(name);
    hidden.push(format!(".{}.part", std::process::id()));
    Ok(path.with_file_name(hidden))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.png");
        fs::write(&path, "old").unwrap();
        let failed = write_atomically(&path, |file| {
            file.write_all(b"half of it")?;
            Err(io::Error::other("out of paper"))
        });
        assert!(failed.unwrap_err().to_string().contains("out of paper"));
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);

        write_atomically(&path, |file| file.write_all(b"new")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn the_error_names_the_file_that_was_asked_for() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("no such folder").join("picture.png");
        let error = write_atomically(&path, |_| Ok(())).unwrap_err();
        assert!(error.to_string().starts_with(&path.display().to_string()));
        assert!(error.is_bad_input());
    }
}
