//! Renderers, opened at first use and kept.

use std::sync::Arc;

use crate::error::Result;
use crate::mode::Mode;
use crate::render::{BackendChoice, MethodChoice, Renderer, Settings};
use crate::transfer::TransferFunction;
use crate::volume::Volume;

use super::look::Way;

/// The settings by the method that they ask for.
pub(super) fn chosen(renderer: &mut Renderer, way: &Way, settings: &Settings) -> Result<Settings> {
    match way.method {
        MethodChoice::Auto => Ok(renderer.choose(settings)?.in_settings(settings)),
        MethodChoice::Only(_) => Ok(*settings),
    }
}

/// Renderers by what they draw with, opened at first use.
#[derive(Default)]
pub(super) struct Renderers {
    open: Vec<(BackendChoice, Renderer, Option<Arc<Volume>>)>,
    /// Whether there is a hardware GPU, once that is known.
    has_gpu: Option<bool>,
}

impl Renderers {
    /// The renderer that draws this way. `auto` is a hardware GPU, else the CPU, else (for what the CPU backend does not
    /// have) a software GPU.
    pub(super) fn for_picture(
        &mut self,
        way: &Way,
        mode: &Mode,
        volume: &Arc<Volume>,
        transfer: &TransferFunction,
    ) -> Result<&mut Renderer> {
        let choice = match way.backend {
            BackendChoice::Auto if self.has_gpu()? => BackendChoice::Gpu,
            BackendChoice::Auto if way.is_on_cpu(mode) => BackendChoice::Cpu,
            BackendChoice::Auto => BackendChoice::Gpu,
            named => named,
        };
        let known = self.open.iter().position(|(c, ..)| *c == choice);
        let place = if let Some(place) = known {
            place
        } else {
            self.open.push((choice, Renderer::new(choice)?, None));
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
