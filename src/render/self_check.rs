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
use crate::mode::{MODES, Mode, ModeRow};
use crate::sample::Sampler;
use crate::skip::{METHODS, Method, Skip};
use crate::transfer::{ControlPoint, TransferFunction};
use crate::volume::{Statistics, phantom};

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
    let key = format!("{} | {}", info.adapter, info.driver);
    let read = || -> Outcomes { kept.map(cache::read).unwrap_or_default() };
    let names = if let Some(names) = read().remove(&key) {
        names
    } else {
        let failed: Vec<String> = check(renderer)?
            .iter()
            .map(|s| s.method().name.to_owned())
            .collect();
        if let Some(path) = kept {
            // Read again: another process may have kept its own meanwhile.
            let mut outcomes = read();
            outcomes.insert(key, failed.clone());
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

/// The modes that are checked besides emission-absorption: one of each way to look at samples.
fn other_modes() -> impl Iterator<Item = &'static ModeRow> {
    let names = ["shaded", "mip", "mean", "phong"];
    MODES.iter().filter(move |row| names.contains(&row.name))
}

/// Of the candidates that draw by one shader, the first: modes meet shaders, not methods. The limit draws nobody's pictures.
fn one_of_each_shader() -> impl Iterator<Item = &'static Method> {
    let is_first = |m: &&Method| {
        let same = candidates().find(|other| other.shader == m.shader);
        same.is_some_and(|first| first.skip == m.skip)
    };
    candidates().filter(|m| !m.is_limit).filter(is_first)
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
    let settings = |distance_edges: f64, mode, sampler| {
        let orbit = Orbit {
            distance_edges,
            ..Orbit::default()
        };
        Settings {
            sampler: Some(sampler),
            mode,
            block: 4,
            step_voxels: 0.4,
            size: [SIZE; 2],
            table_entries: 256,
            ..Settings::new(orbit.camera(volume.extent() - DVec3::splat(0.3)))
        }
    };
    let mut failed = Vec::new();
    for sampler in [Sampler::Hardware, Sampler::Exact] {
        for distance_edges in [1.6, 0.1] {
            let settings = settings(distance_edges, Mode::EmissionAbsorption, sampler);
            compare(renderer, &settings, candidates(), &mut failed)?;
        }
    }
    // What tricubic-exact samples, tricubic has sampled, by shaders that compile in a fraction of the time.
    for sampler in [Sampler::Nearest, Sampler::Tricubic] {
        let settings = settings(1.6, Mode::EmissionAbsorption, sampler);
        let hull = candidates().filter(|m| m.skip == Skip::Hull);
        compare(renderer, &settings, hull, &mut failed)?;
    }
    let statistics = Statistics::of(&volume);
    for row in other_modes() {
        let settings = settings(1.6, (row.suited_to)(&statistics), Sampler::Exact);
        compare(renderer, &settings, one_of_each_shader(), &mut failed)?;
    }
    Ok(failed)
}

/// Adds the methods whose picture is not box's to those that failed.
fn compare(
    renderer: &mut Renderer,
    settings: &Settings,
    methods: impl Iterator<Item = &'static Method>,
    failed: &mut Vec<Skip>,
) -> Result<()> {
    let picture = renderer.render(settings)?.picture;
    for method in methods {
        let by_method = Settings {
            skip: method.skip,
            ..*settings
        };
        let difference = renderer.render(&by_method)?.picture.difference(&picture);
        if difference.pixels > 0 && !failed.contains(&method.skip) {
            tracing::warn!(
                "{}: {} pixels differ from box in {} on this adapter",
                method.name,
                difference.pixels,
                settings.mode.name()
            );
            failed.push(method.skip);
        }
    }
    Ok(())
}
