//! What is found out once, per adapter or scene, and kept in the user's cache folder; what adapters cost as JSON. Every file there is safe to delete,
//! and one that cannot be read is made anew.

use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;

/// The file of this name in `$XDG_CACHE_HOME/hollowcast` or `~/.cache/hollowcast`.
pub(crate) fn file(name: &str) -> Option<PathBuf> {
    let set = |name| {
        std::env::var_os(name)
            .filter(|v| !v.is_empty())
            .map(PathBuf::from)
    };
    let folder = set("XDG_CACHE_HOME").or_else(|| Some(set("HOME")?.join(".cache")))?;
    Some(folder.join("hollowcast").join(name))
}

/// What a file holds; nothing where it is missing, broken or someone else's.
pub(super) fn read<T: DeserializeOwned + Default>(path: &Path) -> T {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    serde_json::from_str(&text).unwrap_or_default()
}

/// Keeps a value; a cache that cannot be written costs the next start some work, nothing else.
pub(super) fn write(path: &Path, value: &impl Serialize) {
    let save = || -> std::io::Result<()> {
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder)?;
        }
        // Renamed into place, so that a second process never reads half a file.
        let unfinished = path.with_extension(format!("{}.unfinished", std::process::id()));
        std::fs::write(&unfinished, serde_json::to_string_pretty(value)?)?;
        std::fs::rename(&unfinished, path)
    };
    if let Err(error) = save() {
        tracing::debug!("{}: {error}", path.display());
    }
}
