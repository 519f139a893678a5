//! What is found out once, per adapter or scene, and kept in the user's cache folder; what adapters cost as JSON. Every file there is safe to delete,
//! and one that cannot be read is made anew.

use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// A hash of the crate's sources. What was found out by other sources, of other shaders and methods, says nothing of these.
const BUILD: &str = env!("HOLLOWCAST_BUILD");

/// A value with the build that found it out.
#[derive(Serialize, Deserialize)]
struct Kept<T> {
    build: String,
    found: T,
}

/// The file of this name in `$XDG_CACHE_HOME/hollowcast` or `~/.cache/hollowcast`.
pub(crate) fn file(name: &str) -> Option<PathBuf> {
    let set = |name| {
        std::env::var_os(name)
            .map(PathBuf::from)
            // A relative path is to be ignored (XDG Base Directory Specification).
            .filter(|path| path.is_absolute())
    };
    let folder = set("XDG_CACHE_HOME").or_else(|| Some(set("HOME")?.join(".cache")))?;
    Some(folder.join("hollowcast").join(name))
}

/// What a file holds; nothing where it is missing, broken, another build's or someone else's.
pub(super) fn read<T: DeserializeOwned + Default>(path: &Path) -> T {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    let kept: Option<Kept<T>> = serde_json::from_str(&text).ok();
    kept.filter(|kept| kept.build == BUILD)
        .map(|kept| kept.found)
        .unwrap_or_default()
}

/// Keeps a value; a cache that cannot be written costs the next start some work, nothing else.
pub(super) fn write(path: &Path, value: &impl Serialize) {
    let save = || -> std::io::Result<()> {
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder)?;
        }
        // Renamed into place, so that a second process never reads half a file.
        let unfinished = path.with_extension(format!("{}.unfinished", std::process::id()));
        let kept = Kept {
            build: BUILD.to_owned(),
            found: value,
        };
        std::fs::write(&unfinished, serde_json::to_string_pretty(&kept)?)?;
        std::fs::rename(&unfinished, path).inspect_err(|_| {
            // The first error is the one to tell.
            let _ = std::fs::remove_file(&unfinished);
        })
    };
    if let Err(error) = save() {
        tracing::debug!("{}: {error}", path.display());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_another_build_found_out_is_not_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("found.json");
        write(&path, &vec![3u32]);
        assert_eq!(read::<Vec<u32>>(&path), [3]);
        let text = std::fs::read_to_string(&path).unwrap();
        let other = text.replace(BUILD, "0123456789abcdef");
        assert_ne!(text, other);
        std::fs::write(&path, other).unwrap();
        assert!(read::<Vec<u32>>(&path).is_empty());
    }
}
