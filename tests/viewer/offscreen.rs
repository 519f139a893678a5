//! Draws the window into a picture, on whatever adapter there is.

use eframe::egui::{Context, FullOutput, TexturesDelta};
use eframe::egui_wgpu::{RenderState, RendererOptions, ScreenDescriptor, WgpuConfiguration, wgpu};
use egui_kittest::TestRenderer;
use hollowcast::viewer::WindowGpu;
use image::RgbaImage;

/// egui's own renderer without a window.
pub(crate) struct Offscreen(RenderState);

impl Offscreen {
    /// Opens a device.
    pub(crate) fn new() -> Self {
        let setup = WindowGpu::setup();
        let instance = pollster::block_on(setup.new_instance());
        let configuration = WgpuConfiguration {
            wgpu_setup: setup,
            ..WgpuConfiguration::default()
        };
        let options = RendererOptions::PREDICTABLE;
        let state = RenderState::create(&configuration, &instance, None, options);
        Self(pollster::block_on(state).expect("an adapter draws the window"))
    }

    /// The device, as a window's.
    pub(crate) fn window(&self) -> WindowGpu {
        WindowGpu::new(&self.0)
    }

    fn read(&self, texture: &wgpu::Texture) -> RgbaImage {
        let (width, height) = (texture.width(), texture.height());
        let stride = (width * 4).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = self.0.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: u64::from(stride * height),
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = self
            .0
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(stride),
            rows_per_image: None,
        };
        let into = wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout,
        };
        encoder.copy_texture_to_buffer(texture.as_image_copy(), into, texture.size());
        self.0.queue.submit([encoder.finish()]);
        buffer
            .slice(..)
            .map_async(wgpu::MapMode::Read, |mapped| mapped.expect("mapped"));
        let done = self.0.device.poll(wgpu::PollType::wait_indefinitely());
        done.expect("the device answers");
        let bytes = buffer
            .slice(..)
            .get_mapped_range()
            .expect("mapped just above");
        let rows = bytes.chunks_exact(stride as usize);
        let pixels = rows.flat_map(|row| row[..width as usize * 4].to_vec());
        RgbaImage::from_raw(width, height, pixels.collect()).expect("as many bytes as pixels")
    }
}

impl TestRenderer for Offscreen {
    fn handle_delta(&mut self, delta: &mut TexturesDelta) {
        let mut renderer = self.0.renderer.write();
        for (id, images) in delta.set.drain() {
            for image in images {
                renderer.update_texture(&self.0.device, &self.0.queue, id, &image);
            }
        }
        for id in delta.free.drain() {
            renderer.free_texture(&id);
        }
    }

    fn render(&mut self, context: &Context, output: &FullOutput) -> Result<RgbaImage, String> {
        let (device, queue) = (&self.0.device, &self.0.queue);
        let scale = context.pixels_per_point();
        let size = context.content_rect().size() * scale;
        let screen = ScreenDescriptor {
            pixels_per_point: scale,
            size_in_pixels: [size.x, size.y].map(|n| n.round() as u32),
        };
        let jobs = context.tessellate(output.shapes.clone(), scale);
        let mut renderer = self.0.renderer.write();
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let before = renderer.update_buffers(device, queue, &mut encoder, &jobs, &screen);
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d {
                width: screen.size_in_pixels[0],
                height: screen.size_in_pixels[1],
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: self.0.target_format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let attachment = wgpu::RenderPassColorAttachment {
            view: &view,
            resolve_target: None,
            ops: wgpu::Operations::default(),
            depth_slice: None,
        };
        let mut pass = encoder
            .begin_render_pass(&wgpu::RenderPassDescriptor {
                color_attachments: &[Some(attachment)],
                ..wgpu::RenderPassDescriptor::default()
            })
            .forget_lifetime();
        renderer.render(&mut pass, &jobs, &screen);
        drop(pass);
        queue.submit(before.into_iter().chain([encoder.finish()]));
        drop(renderer);
        Ok(self.read(&texture))
    }
}
