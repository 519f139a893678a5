//! At an adapter's first use, every method is compared with box on a small scene; one that differs is withdrawn.
//!
//! The outcome is kept per adapter and driver version, in the user's cache folder. The file is safe to delete, and one
//! that cannot be read is made anew.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;

use super::{Renderer, Settings};
use crate::camera::Orbit;
use crate::error::Result;
use crate::lattice::Clipping;
use crate::mode::Mode;
use crate::sample::Sampler;
use crate::skip::{Cuts, METHODS, Method, Skip};
use crate::transfer::{ControlPoint, TransferFunction};
use crate::volume::phantom;

/// Edge of the check's pictures in pixels.
const SIZE: u32 = 64;

/// Methods that failed, by adapter.
type Outcomes = BTreeMap<String, Vec<String>>;

/// The methods that must not be used on this renderer's adapter: as kept, or found now.
///
/// # Errors
/// As [`Renderer::render`].
pub(super) fn withdrawn(renderer: &mut Renderer, cache: Option<&Path>) -> Result<Vec<Skip>> {
    let info = renderer.info();
    // Another version of the program has other shaders and methods: what was found of those says nothing of these.
    let tried: Vec<&str> = candidates().map(|m| m.name).collect();
    let key = format!(
        "{} | {} | hollowcast {} | {}",
        info.adapter,
        info.driver,
        env!("CARGO_PKG_VERSION"),
        tried.join(" "),
    );
    let mut outcomes = cache.map(read).unwrap_or_default();
    let names = if let Some(names) = outcomes.get(&key) {
        names.clone()
    } else {
        let failed: Vec<String> = check(renderer)?
            .iter()
            .map(|s| s.method().name.to_owned())
            .collect();
        outcomes.insert(key, failed.clone());
        if let Some(path) = cache {
            write(path, &outcomes);
        }
        failed
    };
    Ok(names
        .iter()
        .filter_map(|name| Skip::from_name(name))
        .collect())
}

/// Where outcomes are kept: `$XDG_CACHE_HOME/hollowcast` or `~/.cache/hollowcast`.
pub(super) fn cache_file() -> Option<PathBuf> {
    let set = |name| {
        std::env::var_os(name)
            .filter(|v| !v.is_empty())
            .map(PathBuf::from)
    };
    let folder = set("XDG_CACHE_HOME").or_else(|| Some(set("HOME")?.join(".cache")))?;
    Some(folder.join("hollowcast").join("self-check.json"))
}

fn read(path: &Path) -> Outcomes {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    serde_json::from_str(&text).unwrap_or_default()
}

/// Keeps the outcomes; a cache that cannot be written costs the next start a check, nothing else.
fn write(path: &Path, outcomes: &Outcomes) {
    let save = || -> std::io::Result<()> {
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder)?;
        }
        // Renamed into place, so that a second process never reads half a file.
        let unfinished = path.with_extension(format!("{}.unfinished", std::process::id()));
        std::fs::write(&unfinished, serde_json::to_string_pretty(outcomes)?)?;
        std::fs::rename(&unfinished, path)
    };
    if let Err(error) = save() {
        tracing::debug!("{}: {error}", path.display());
    }
}

/// The methods that are compared with box.
fn candidates() -> impl Iterator<Item = &'static Method> {
    METHODS
        .iter()
        .filter(|m| m.lossless && m.skip != Skip::Box && m.backends.contains(&"gpu"))
}

/// Draws a pot with something in it from outside and inside, and compares each method with box.
fn check(renderer: &mut Renderer) -> Result<Vec<Skip>> {
    let volume = Arc::new(phantom::make("pot", [40, 36, 44])?);
    let point = |value, opacity| ControlPoint {
        value,
        opacity,
        color: [0.9, 0.6, 0.4],
    };
    let transfer = TransferFunction::new(vec![point(40.0, 0.0), point(255.0, 0.3)], 1.0)?;
    renderer.set_volume(Arc::clone(&volume))?;
    renderer.set_transfer(transfer);
    let mut failed = Vec::new();
    for sampler in Sampler::ALL {
        for distance_edges in [1.6, 0.1] {
            let mut settings = Settings {
                skip: Skip::Box,
                cuts: Cuts::default(),
                sampler: Some(*sampler),
                mode: Mode::EmissionAbsorption,
                block: 4,
                step_voxels: 0.4,
                ert: 0.98,
                size: [SIZE; 2],
                camera: Orbit {
                    distance_edges,
                    ..Orbit::default()
                }
                .camera(volume.extent() - DVec3::splat(0.3)),
                clipping: Clipping::NONE,
                table_entries: 256,
            };
            let picture = renderer.render(&settings)?.picture;
            for method in candidates() {
                settings.skip = method.skip;
                let difference = renderer.render(&settings)?.picture.difference(&picture);
                if difference.pixels > 0 && !failed.contains(&method.skip) {
                    tracing::warn!(
                        "{}: {} pixels differ from box on this adapter",
                        method.name,
                        difference.pixels
                    );
                    failed.push(method.skip);
                }
            }
        }
    }
    Ok(failed)
}
