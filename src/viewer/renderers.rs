//! Renderers, opened at first use and kept.

use std::any::Any;
use std::sync::Arc;

use crate::error::{Error, Result};
use crate::gpu::Gpu;
use crate::render::{BackendChoice, MethodChoice, Renderer, Settings};
use crate::sample::{Classification, Sampler};
use crate::skip::{HalfCut, Skip};
use crate::transfer::TransferFunction;
use crate::volume::Volume;

use super::look::Way;

/// The settings by the method that they ask for.
pub(super) fn chosen(renderer: &mut Renderer, way: &Way, settings: &Settings) -> Result<Settings> {
    match way.method() {
        MethodChoice::Auto => Ok(renderer.choose(settings)?.in_settings(settings)),
        MethodChoice::Only(_) => Ok(*settings),
    }
}

/// What a panic said, as an error.
pub(super) fn of_panic(panic: &(dyn Any + Send)) -> Error {
    let text = panic.downcast_ref::<String>().cloned();
    let text = text.or_else(|| panic.downcast_ref::<&str>().map(|&s| s.to_owned()));
    Error::Gpu(text.unwrap_or_else(|| "failed".to_owned()))
}

/// Whether the CPU backend can draw by these settings; of `auto`, what is left to choose is box, which it has.
fn is_on_cpu(settings: &Settings) -> bool {
    let cuts_best = settings.skip == Skip::HalfSplit && settings.cuts.half == HalfCut::Best;
    settings.skip.check_backend("cpu").is_ok()
        && !cuts_best
        && settings.slices.is_none()
        && settings.classification == Classification::Post
        && settings.depth_cue == 0.0
        && settings.mode.check_backend("cpu").is_ok()
        && matches!(settings.sampler, None | Some(Sampler::Exact))
}

/// Renderers by what they draw with, opened at first use.
#[derive(Default)]
pub(super) struct Renderers {
    open: Vec<(BackendChoice, Renderer, Option<Arc<Volume>>)>,
    /// Whether there is a hardware GPU, once that is known.
    has_gpu: Option<bool>,
    /// The window's device, where pictures are drawn on it.
    window: Option<Gpu>,
}

impl Renderers {
    /// With the window's device as the GPU.
    pub(super) fn on(window: Option<Gpu>) -> Self {
        Self {
            has_gpu: window.as_ref().map(|_| true),
            window,
            ..Self::default()
        }
    }

    /// The renderer that draws by these settings. `auto` is a hardware GPU, else the CPU, else (for what the CPU backend
    /// does not have) a software GPU. What moves is drawn on the CPU in place of a software GPU too, which takes several
    /// times as long.
    pub(super) fn for_picture(
        &mut self,
        (way, settings, is_moving): (&Way, &Settings, bool),
        volume: &Arc<Volume>,
        transfer: &TransferFunction,
    ) -> Result<&mut Renderer> {
        let choice = match way.backend {
            BackendChoice::Auto | BackendChoice::Gpu if self.has_gpu()? => BackendChoice::Gpu,
            BackendChoice::Auto if is_on_cpu(settings) => BackendChoice::Cpu,
            BackendChoice::Gpu if is_moving && is_on_cpu(settings) => BackendChoice::Cpu,
            BackendChoice::Auto => BackendChoice::Gpu,
            named => named,
        };
        let known = self.open.iter().position(|(c, ..)| *c == choice);
        let place = if let Some(place) = known {
            place
        } else {
            let renderer = match (choice, &self.window) {
                (BackendChoice::Gpu, Some(gpu)) => Renderer::with_device(gpu.clone())?,
                _ => Renderer::new(choice)?,
            };
            self.open.push((choice, renderer, None));
            self.open.len() - 1
        };
        let (_, renderer, held) = &mut self.open[place];
        let is_held = held.as_ref().is_some_and(|held| Arc::ptr_eq(held, volume));
        if !is_held {
            *held = None;
            renderer.set_volume(Arc::clone(volume))?;
            *held = Some(Arc::clone(volume));
        }
        renderer.set_transfer(transfer.clone());
        Ok(renderer)
    }

    fn has_gpu(&mut self) -> Result<bool> {
        if let Some(has_gpu) = self.has_gpu {
            return Ok(has_gpu);
        }
        let renderer = Renderer::new(BackendChoice::Auto)?;
        let has_gpu = renderer.info().backend == "gpu";
        let choice = if has_gpu {
            BackendChoice::Gpu
        } else {
            BackendChoice::Cpu
        };
        self.open.push((choice, renderer, None));
        self.has_gpu = Some(has_gpu);
        Ok(has_gpu)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Orbit;
    use crate::mode::MODES;
    use crate::render::SliceCount;
    use crate::volume::{Statistics, phantom};

    #[test]
    fn what_the_cpu_cannot_draw_is_known_before() {
        let volume = phantom::make("pot", [8; 3]).unwrap();
        let settings = Settings::new(Orbit::default().camera(volume.extent()));
        for row in MODES {
            let mode = (row.suited_to)(&Statistics::of(&volume));
            assert_eq!(
                is_on_cpu(&Settings { mode, ..settings }),
                row.backends.contains(&"cpu")
            );
        }
        let skip = Skip::BeamMasks;
        assert!(is_on_cpu(&Settings { skip, ..settings }));
        let gpu_only = [
            |s: &mut Settings| s.skip = Skip::KCuts,
            |s: &mut Settings| s.sampler = Some(Sampler::Hardware),
            |s: &mut Settings| s.classification = Classification::Pre,
            |s: &mut Settings| s.depth_cue = 0.5,
            |s: &mut Settings| s.slices = Some(SliceCount::PerVoxel),
        ];
        for change in gpu_only {
            let mut changed = settings;
            change(&mut changed);
            assert!(!is_on_cpu(&changed));
        }
    }
}
