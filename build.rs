//! Notes of which commit, and with which wgpu, the crate is built, for reports of measurements; and what its sources hash
//! to, by which caches know what another build left there.
//!
//! Run again only when what is compiled changes, which builds the crate anyway; a commit alone rebuilds nothing.

use std::fs;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io;
use std::path::Path;
use std::process::Command;

fn main() {
    for path in ["build.rs", "src", "shaders", "Cargo.toml", "Cargo.lock"] {
        println!("cargo::rerun-if-changed={path}");
    }
    let root = std::env::var("CARGO_MANIFEST_DIR").unwrap_or_default();
    let root = Path::new(&root);
    let mut hasher = DefaultHasher::new();
    for folder in ["src", "shaders"] {
        hash_folder(&root.join(folder), &mut hasher).expect("the crate's own sources are there");
    }
    println!("cargo::rustc-env=HOLLOWCAST_BUILD={:016x}", hasher.finish());
    let commit = from_git(root).or_else(|| from_package(root));
    if let Some(commit) = commit {
        println!("cargo::rustc-env=HOLLOWCAST_COMMIT={commit}");
    }
    if let Some(version) = locked_version(root, "wgpu") {
        println!("cargo::rustc-env=HOLLOWCAST_WGPU={version}");
    }
}

/// Names and contents of all files below, in the order of their names.
fn hash_folder(folder: &Path, hasher: &mut DefaultHasher) -> io::Result<()> {
    let mut entries = fs::read_dir(folder)?.collect::<Result<Vec<_>, _>>()?;
    entries.sort_by_key(fs::DirEntry::file_name);
    for entry in entries {
        entry.file_name().hash(hasher);
        if entry.file_type()?.is_dir() {
            hash_folder(&entry.path(), hasher)?;
        } else {
            fs::read(entry.path())?.hash(hasher);
        }
    }
    Ok(())
}

/// The commit that is checked out, with `-dirty` where files differ from it.
fn from_git(root: &Path) -> Option<String> {
    // Unpacked inside another repository, the crate is not of that one's commit.
    if !root.join(".git").exists() {
        return None;
    }
    let described = Command::new("git")
        .arg("-C")
        .arg(root)
        .args([
            "describe",
            "--always",
            "--dirty",
            "--exclude=*",
            "--abbrev=12",
        ])
        .output()
        .ok()?;
    let text = String::from_utf8(described.stdout).ok()?;
    let text = text.trim();
    (described.status.success() && !text.is_empty()).then(|| text.to_owned())
}

/// The commit that `cargo package` noted.
fn from_package(root: &Path) -> Option<String> {
    let noted = std::fs::read_to_string(root.join(".cargo_vcs_info.json")).ok()?;
    let (_, after) = noted.split_once("\"sha1\"")?;
    let commit = after.split('"').nth(1)?;
    Some(commit.chars().take(12).collect())
}

/// The version of a crate in Cargo.lock, which is not there where this crate is built for another.
fn locked_version(root: &Path, name: &str) -> Option<String> {
    let lock = std::fs::read_to_string(root.join("Cargo.lock")).ok()?;
    let mut lines = lock
        .lines()
        .skip_while(|line| *line != format!("name = \"{name}\""));
    let version = lines.nth(1)?.strip_prefix("version = \"")?;
    Some(version.trim_end_matches('"').to_owned())
}
