//! The window's own device, on which pictures are drawn where it is hardware: straight into the texture that is shown, with
//! nothing fetched and sent back.
//!
//! A software adapter takes its submissions one after another, so that the window would stand still while a picture is
//! drawn on its device: there, pictures have a device of their own.

use std::sync::Arc;

use eframe::egui::TextureId;
use eframe::egui_wgpu::{RenderState, WgpuSetup, WgpuSetupCreateNew, wgpu};

use crate::error::Result;
use crate::gpu::{Gpu, device};
use crate::render::{FrameTimes, Renderer, Settings, Targets};

/// A picture that lies in a texture of the window's device, encoded and before its backdrop.
#[derive(Debug)]
pub struct Canvas(wgpu::Texture);

/// What egui reads: encoded bytes. What the renderer writes: the same as linear light.
const READ: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
const WRITTEN: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;

impl Canvas {
    /// Draws a picture into a texture of its own, by a renderer on this device.
    ///
    /// # Errors
    /// As [`Renderer::render_to`].
    pub(super) fn draw(
        gpu: &Gpu,
        renderer: &mut Renderer,
        settings: &Settings,
        backdrop: [f32; 3],
    ) -> Result<(Self, FrameTimes)> {
        let [width, height] = settings.size;
        let texture = gpu.checked(|| {
            gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some("picture"),
                size: wgpu::Extent3d {
                    width,
                    height,
                    depth_or_array_layers: 1,
                },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: READ,
                usage: wgpu::TextureUsages::TEXTURE_BINDING
                    | wgpu::TextureUsages::RENDER_ATTACHMENT,
                view_formats: &[WRITTEN],
            })
        })?;
        let view = texture.create_view(&wgpu::TextureViewDescriptor {
            format: Some(WRITTEN),
            ..Default::default()
        });
        clear(gpu, &view, backdrop);
        let targets = Targets {
            color: &view,
            color_format: WRITTEN,
            depth: None,
        };
        let times = renderer.render_to(settings, &targets)?;
        Ok((Self(texture), times))
    }
}

fn clear(gpu: &Gpu, view: &wgpu::TextureView, [r, g, b]: [f32; 3]) {
    let mut encoder = gpu
        .device
        .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let [r, g, b] = [r, g, b].map(f64::from);
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("backdrop"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a: 1.0 }),
                store: wgpu::StoreOp::Store,
            },
        })],
        ..Default::default()
    });
    gpu.queue.submit([encoder.finish()]);
}

/// The window's device, and egui's textures on it.
#[derive(Clone)]
pub struct WindowGpu {
    /// The device that pictures are drawn on.
    pub gpu: Gpu,
    state: RenderState,
}

impl WindowGpu {
    /// The device of a window.
    pub fn new(state: &RenderState) -> Self {
        let (device, queue) = (state.device.clone(), state.queue.clone());
        Self {
            gpu: Gpu::from_device(device, queue, state.adapter.get_info()),
            state: state.clone(),
        }
    }

    /// What a window asks for, so that pictures can be drawn on its device: the adapter that the command draws on, where it
    /// can show something, with all that is used of it.
    pub fn setup() -> WgpuSetup {
        let pick = |adapters: &[wgpu::Adapter], surface: Option<&wgpu::Surface<'_>>| {
            let shows = |a: &&wgpu::Adapter| surface.is_none_or(|s| a.is_surface_supported(s));
            let able: Vec<wgpu::Adapter> = adapters.iter().filter(shows).cloned().collect();
            let best = device::best(&able).cloned();
            best.ok_or_else(|| "no adapter draws on this display".to_owned())
        };
        WgpuSetup::CreateNew(WgpuSetupCreateNew {
            native_adapter_selector: Some(Arc::new(pick)),
            device_descriptor: Arc::new(device::descriptor),
            ..WgpuSetupCreateNew::without_display_handle()
        })
    }

    /// Shows a picture, in the place of the last one where there is one.
    pub(super) fn show(&self, canvas: &Canvas, is_enlarged: bool, last: &mut Option<TextureId>) {
        let filter = if is_enlarged {
            wgpu::FilterMode::Linear
        } else {
            wgpu::FilterMode::Nearest
        };
        let view = canvas
            .0
            .create_view(&wgpu::TextureViewDescriptor::default());
        let mut textures = self.state.renderer.write();
        let device = &self.state.device;
        match *last {
            Some(id) => textures.update_egui_texture_from_wgpu_texture(device, &view, filter, id),
            None => *last = Some(textures.register_native_texture(device, &view, filter)),
        }
    }
}
