//! hollowcast inside another program: the caller's wgpu device, the caller's colour target, and the depth of the first
//! visible sample as a second output, with which meshes and other volumes can be combined.
//!
//! ```sh
//! cargo run --example embed -- embedded.png
//! ```
//!
//! Draws a pot over a blue background that the program has drawn before, and prints the depth in the middle.

use std::sync::Arc;

use anyhow::{Context, Result};
use hollowcast::camera::Orbit;
use hollowcast::gpu::{Gpu, buffer::read_back};
use hollowcast::render::{Renderer, Settings, Targets};
use hollowcast::skip::Skip;
use hollowcast::transfer::{ControlPoint, TransferFunction};
use hollowcast::volume::phantom;

const SIZE: u32 = 256;

fn main() -> Result<()> {
    let path = std::env::args()
        .nth(1)
        .unwrap_or_else(|| "embedded.png".to_owned());

    // The program's own device. The three features are optional: see `Gpu::from_device`.
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter =
        pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))
            .context("no adapter; install a driver (Debian: mesa-vulkan-drivers)")?;
    let wanted = wgpu::Features::TEXTURE_FORMAT_16BIT_NORM
        | wgpu::Features::FLOAT32_FILTERABLE
        | wgpu::Features::TIMESTAMP_QUERY;
    let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        required_features: wanted & adapter.features(),
        required_limits: adapter.limits(),
        ..Default::default()
    }))?;

    // Its targets, and what it has drawn into them already: a plain background.
    let target = |format| {
        device.create_texture(&wgpu::TextureDescriptor {
            label: Some("target"),
            size: wgpu::Extent3d {
                width: SIZE,
                height: SIZE,
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        })
    };
    let color = target(wgpu::TextureFormat::Rgba8UnormSrgb);
    let depth = target(wgpu::TextureFormat::R32Float);
    let [color_view, depth_view] =
        [&color, &depth].map(|t| t.create_view(&wgpu::TextureViewDescriptor::default()));
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: &color_view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color {
                    r: 0.02,
                    g: 0.05,
                    b: 0.2,
                    a: 1.0,
                }),
                store: wgpu::StoreOp::Store,
            },
        })],
        ..Default::default()
    });
    queue.submit([encoder.finish()]);

    // hollowcast on that device.
    let gpu = Gpu::from_device(device, queue, adapter.get_info());
    let mut renderer = Renderer::with_device(gpu.clone())?;
    let volume = Arc::new(phantom::make("pot", [96; 3])?);
    renderer.set_volume(Arc::clone(&volume))?;
    renderer.set_transfer(TransferFunction::new(
        vec![
            ControlPoint {
                value: 40.0,
                opacity: 0.0,
                color: [0.9, 0.6, 0.4],
            },
            ControlPoint {
                value: 255.0,
                opacity: 0.3,
                color: [1.0, 0.9, 0.8],
            },
        ],
        1.0,
    )?);
    let settings = Settings {
        skip: Skip::HalfSplit,
        size: [SIZE; 2],
        ..Settings::new(Orbit::default().camera(volume.extent()))
    };
    let targets = Targets {
        color: &color_view,
        color_format: wgpu::TextureFormat::Rgba8UnormSrgb,
        depth: Some(&depth_view),
    };
    let times = renderer.render_to(&settings, &targets)?;

    let pixels: Vec<[u8; 4]> = read_texture(&gpu, &color)?;
    let depths: Vec<f32> = read_texture(&gpu, &depth)?;
    image::save_buffer(
        &path,
        pixels.as_flattened(),
        SIZE,
        SIZE,
        image::ExtendedColorType::Rgba8,
    )
    .with_context(|| path.clone())?;
    let middle = depths[(SIZE / 2 * SIZE + SIZE / 2) as usize];
    let seen = depths.iter().filter(|&&d| d < f32::MAX).count();
    println!(
        "{path}: {:.1} ms on {}; depth in the middle {middle:.1} voxels; {seen} pixels see the pot",
        times.frame_ms,
        renderer.info().adapter,
    );
    Ok(())
}

/// Reads a target of this program back: 4 bytes a pixel in rows that need no padding at this size.
fn read_texture<T: bytemuck::Pod>(gpu: &Gpu, texture: &wgpu::Texture) -> Result<Vec<T>> {
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("read back"),
        size: u64::from(SIZE * SIZE * 4),
        usage: wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = gpu
        .device
        .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(SIZE * 4),
                rows_per_image: None,
            },
        },
        texture.size(),
    );
    gpu.queue.submit([encoder.finish()]);
    Ok(read_back(gpu, &buffer, (SIZE * SIZE) as usize)?)
}
