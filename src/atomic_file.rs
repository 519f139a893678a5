//! Files that appear complete or not at all.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

/// Writes a file through a sibling that takes its name only once it is complete. Of a link, the file that it leads to is
/// written; what is no file (a pipe, a device) is written to as it is.
///
/// # Errors
/// [`Error::Io`] about `path`, whatever failed; the sibling is removed and an older file of that name left untouched.
pub fn write_atomically(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<()> {
    let attempt = || {
        let target = match fs::metadata(path) {
            Ok(there) if there.is_file() => fs::canonicalize(path)?,
            Ok(there) if there.is_dir() => return Err(io::ErrorKind::IsADirectory.into()),
            Ok(_) => {
                let mut writer = BufWriter::new(OpenOptions::new().write(true).open(path)?);
                return fill(&mut writer).and_then(|()| writer.flush());
            }
            Err(_) => path.to_owned(),
        };
        let sibling = sibling(&target)?;
        let file = OpenOptions::new()
            .write(true)
            .create_new(true)
            .open(&sibling)?;
        let mut writer = BufWriter::new(file);
        let written = fill(&mut writer)
            .and_then(|()| writer.flush())
            // A rename can outlive its bytes where the power fails.
            .and_then(|()| writer.get_ref().sync_all())
            .and_then(|()| fs::rename(&sibling, &target));
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

    #[cfg(unix)]
    #[test]
    fn links_stay_links_and_what_is_no_file_stays_what_it_is() {
        use std::os::unix::fs::{FileTypeExt, symlink};
        use std::os::unix::net::UnixListener;

        let folder = tempfile::tempdir().unwrap();
        let [file, link] = ["picture.png", "latest.png"].map(|name| folder.path().join(name));
        fs::write(&file, "old").unwrap();
        symlink(&file, &link).unwrap();
        write_atomically(&link, |file| file.write_all(b"new")).unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&file).unwrap(), b"new");

        // Not a pipe: opening one waits for a reader.
        let socket = folder.path().join("socket");
        let _listener = UnixListener::bind(&socket).unwrap();
        assert!(write_atomically(&socket, |file| file.write_all(b"new")).is_err());
        assert!(fs::metadata(&socket).unwrap().file_type().is_socket());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 3);
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
