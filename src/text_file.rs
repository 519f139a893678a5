//! Files of text: tables, profiles, suites, results.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use crate::error::{Error, Result};

/// Most bytes of what people write by hand: transfer functions, profiles, suites, sessions.
pub(crate) const WRITTEN_BYTES: u64 = 1 << 20;
/// Most bytes of what measurements write: results and rows of hazards.
pub(crate) const MEASURED_BYTES: u64 = 256 << 20;

/// The text of a regular file of at most this many bytes.
///
/// # Errors
/// As [`read_bytes`]; [`Error::Io`] where it is no UTF-8.
pub(crate) fn read(path: &Path, most_bytes: u64) -> Result<String> {
    String::from_utf8(read_bytes(path, most_bytes)?).map_err(|_| {
        let reason = "stream did not contain valid UTF-8";
        Error::io(path, io::Error::new(io::ErrorKind::InvalidData, reason))
    })
}

/// The content of a regular file of at most this many bytes. A pipe may never end and a device never does.
///
/// # Errors
/// [`Error::Io`] where it cannot be read; [`Error::File`] where it is no regular file or too large.
pub(crate) fn read_bytes(path: &Path, most_bytes: u64) -> Result<Vec<u8>> {
    let io = |e| Error::io(path, e);
    let bad = |reason| Err(Error::file(path, "file", reason));
    // Asked of the name: to open a pipe is to wait for whoever writes.
    if !path.metadata().map_err(io)?.is_file() {
        return bad("is not a regular file");
    }
    let mut bytes = Vec::new();
    // One byte more than may be: the file may grow while it is read.
    let mut file = File::open(path).map_err(io)?.take(most_bytes + 1);
    file.read_to_end(&mut bytes).map_err(io)?;
    if bytes.len() as u64 > most_bytes {
        return bad("is too large");
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_too_large_or_no_file_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("text");
        std::fs::write(&path, "four").unwrap();
        assert_eq!(read(&path, 4).unwrap(), "four");
        let refused = |path: &Path| read(path, 3).unwrap_err().to_string();
        assert!(refused(&path).ends_with("file: is too large"));
        assert!(refused(folder.path()).ends_with("file: is not a regular file"));
    }

    #[cfg(unix)]
    #[test]
    fn devices_without_an_end_are_refused() {
        let refused = read(Path::new("/dev/zero"), WRITTEN_BYTES).unwrap_err();
        assert_eq!(
            refused.to_string(),
            "/dev/zero: file: is not a regular file"
        );
    }
}
