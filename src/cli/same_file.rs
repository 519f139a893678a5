//! Whether two paths, however they are spelled, are one file.

use std::path::{Path, PathBuf};

/// Whether what is written to one path would be lost, or lose something, at the other: links and detours are followed, and
/// neither file has to exist. What is no file (a pipe, a device) keeps nothing that could be lost.
pub(super) fn is_same_file(a: &Path, b: &Path) -> bool {
    let is_special = |path: &Path| path.metadata().is_ok_and(|m| !m.is_file());
    match [a, b].map(resolved) {
        [Some(a), Some(b)] => a == b && !is_special(&a),
        _ => a == b,
    }
}

/// The path without links and detours; of a file that is yet to be, its folder's.
fn resolved(path: &Path) -> Option<PathBuf> {
    if let Ok(path) = path.canonicalize() {
        return Some(path);
    }
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty());
    let folder = folder.unwrap_or(Path::new(".")).canonicalize().ok()?;
    Some(folder.join(path.file_name()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spellings_and_links_of_one_file_are_one() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("there"), "").unwrap();
        std::fs::create_dir(at("sub")).unwrap();
        assert!(is_same_file(&at("there"), &at("./sub/../there")));
        assert!(is_same_file(&at("yet-to-be"), &at("sub/../yet-to-be")));
        assert!(!is_same_file(&at("there"), &at("sub/there")));
        assert!(!is_same_file(&at("gone/a"), &at("gone/b")));
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_devices_hold_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("there"), "").unwrap();
        std::os::unix::fs::symlink(at("there"), at("link")).unwrap();
        assert!(is_same_file(&at("there"), &at("link")));
        assert!(!is_same_file(
            Path::new("/dev/null"),
            Path::new("/dev/null")
        ));
    }
}
