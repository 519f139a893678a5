//! At an adapter's first use, every method is compared with box on a small scene; one that differs is withdrawn.
//!
//! The outcome is kept per adapter and driver version, in the user's cache folder.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use glam::DVec3;

use super::{Renderer, Settings, cache};
use crate::camera::Orbit;
use crate::error::Result;
use crate::sample::Sampler;
use crate::skip::{METHODS, Method, Skip};
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
pub(super) fn withdrawn(renderer: &mut Renderer, kept: Option<&Path>) -> Result<Vec<Skip>> {
    let info = renderer.info();
    // Another version of the program has other shaders, methods and samplers: what was found of those says nothing of these.
    let samplers = Sampler::ALL.iter().map(|s| s.name());
    let tried: Vec<&str> = candidates().map(|m| m.name).chain(samplers).collect();
    let key = format!(
        "{} | {} | hollowcast {} | {}",
        info.adapter,
        info.driver,
        env!("CARGO_PKG_VERSION"),
        tried.join(" "),
    );
    let mut outcomes: Outcomes = kept.map(cache::read).unwrap_or_default();
    let names = if let Some(names) = outcomes.get(&key) {
        names.clone()
    } else {
        let failed: Vec<String> = check(renderer)?
            .iter()
            .map(|s| s.method().name.to_owned())
            .collect();
        outcomes.insert(key, failed.clone());
        if let Some(path) = kept {
            cache::write(path, &outcomes);
        }
        failed
    };
    Ok(names
        .iter()
        .filter_map(|name| Skip::from_name(name))
        .collect())
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
    // What tricubic-exact samples, tricubic has sampled, by shaders that compile in a fraction of the time.
    let samplers = Sampler::ALL.iter();
    for sampler in samplers.filter(|s| **s != Sampler::TricubicExact) {
        for distance_edges in [1.6, 0.1] {
            let mut settings = Settings {
                sampler: Some(*sampler),
                block: 4,
                step_voxels: 0.4,
                size: [SIZE; 2],
                table_entries: 256,
                ..Settings::new(
                    Orbit {
                        distance_edges,
                        ..Orbit::default()
                    }
                    .camera(volume.extent() - DVec3::splat(0.3)),
                )
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
