//! On what results were measured.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use serde::{Deserialize, Serialize};

/// Crates whose versions may change times or pictures.
const CRATES: [&str; 5] = ["wgpu", "naga", "rayon", "glam", "half"];

/// The processor, the system, and what the program was made of.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Machine {
    /// The processor's own name, where the system tells it.
    pub processor: String,
    /// Logical cores.
    pub cores: usize,
    /// Operating system and architecture.
    pub system: String,
    /// This program's version.
    pub version: String,
    /// The commit of the checkout that the program lies in, with `+` where files differ from it.
    pub commit: Option<String>,
    /// Versions of the crates that it was built with.
    pub crates: BTreeMap<String, String>,
}

impl Machine {
    /// This machine and this program.
    pub fn this() -> Self {
        Self {
            processor: processor().unwrap_or_else(|| "unknown processor".to_owned()),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            commit: commit(),
            crates: crates(),
        }
    }
}

fn processor() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

fn commit() -> Option<String> {
    let program = std::env::current_exe().ok()?;
    let folder = program.parent()?;
    let hash = git(folder, &["rev-parse", "--short=12", "HEAD"])?;
    let changes = git(folder, &["status", "--porcelain", "--untracked-files=no"])?;
    Some(if changes.is_empty() { hash } else { hash + "+" })
}

fn git(folder: &Path, words: &[&str]) -> Option<String> {
    let output = Command::new("git")
        .arg("-C")
        .arg(folder)
        .args(words)
        .output()
        .ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}

/// As the lock file names them that the program was built from.
fn crates() -> BTreeMap<String, String> {
    let lock: toml::Table = toml::from_str(include_str!("../../../Cargo.lock"))
        .expect("cargo writes its lock file as TOML");
    let packages = lock.get("package").and_then(toml::Value::as_array);
    let of = |package: &toml::Value, field: &str| {
        package
            .get(field)
            .and_then(toml::Value::as_str)
            .map(str::to_owned)
    };
    packages
        .into_iter()
        .flatten()
        .filter_map(|package| Some((of(package, "name")?, of(package, "version")?)))
        .filter(|(name, _)| CRATES.contains(&name.as_str()))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lock_file_names_the_crates() {
        let crates = Machine::this().crates;
        assert!(
            CRATES.iter().all(|name| crates.contains_key(*name)),
            "{crates:?}"
        );
    }
}
