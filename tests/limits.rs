//! What an adapter can do to a renderer: take away its device, take no volume or table as large as this, or still be at work
//! on a frame when the next one is asked for. These tests fail, not skip, where there is no adapter.

use std::sync::Arc;

use glam::DVec3;
use hollowcast::Error;
use hollowcast::camera::{Camera, Orbit, Projection};
use hollowcast::gpu::Gpu;
use hollowcast::gpu::buffer::read_back;
use hollowcast::render::{Renderer, Settings, Targets};
use hollowcast::skip::{METHODS, Skip};
use hollowcast::transfer::{ControlPoint, TransferFunction};
use hollowcast::volume::{Volume, Voxels, phantom};

/// A device of the best adapter there is, that takes 3D textures of at most `edge` voxels, and of buffers binds at most
/// `binding` bytes.
fn device(edge: u32, binding: Option<u32>) -> (wgpu::Device, wgpu::Queue, wgpu::AdapterInfo) {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter =
        pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))
            .expect("these tests need an adapter: mesa-vulkan-drivers");
    let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        required_limits: wgpu::Limits {
            max_texture_dimension_3d: edge,
            max_storage_buffer_binding_size:
                binding.map_or(adapter.limits().max_storage_buffer_binding_size, Into::into),
            ..adapter.limits()
        },
        ..Default::default()
    }))
    .unwrap();
    (device, queue, adapter.get_info())
}

fn settings(extent: glam::DVec3) -> Settings {
    Settings {
        size: [16, 16],
        ..Settings::new(Orbit::default().camera(extent))
    }
}

/// Edge of the pictures that are drawn into targets: their rows are whole units of a copy.
const EDGE: u32 = 64;

fn transfer(opacity: f64) -> TransferFunction {
    let point = ControlPoint {
        value: 0.0,
        opacity,
        color: [1.0; 3],
    };
    TransferFunction::new(vec![point], 1.0).unwrap()
}

#[test]
fn a_device_that_is_gone_is_an_error_and_no_panic() {
    let (device, queue, info) = device(256, None);
    let mut renderer =
        Renderer::with_device(Gpu::from_device(device.clone(), queue, info)).unwrap();
    let volume = Arc::new(phantom::make("shells", [16; 3]).unwrap());
    renderer.set_volume(Arc::clone(&volume)).unwrap();
    renderer.set_transfer(transfer(0.1));
    let settings = settings(volume.extent());
    renderer.render(&settings).unwrap();
    device.destroy();
    for _ in 0..2 {
        let error = renderer.render(&settings).unwrap_err();
        assert!(matches!(error, Error::Gpu(_)), "{error}");
        assert_eq!(error.to_string().lines().count(), 1, "{error}");
    }
    assert!(renderer.set_volume(volume).is_err());
}

#[test]
fn a_volume_over_the_limit_is_refused_by_the_limits_name() {
    let (device, queue, info) = device(256, None);
    let mut renderer = Renderer::with_device(Gpu::from_device(device, queue, info)).unwrap();
    let long = Arc::new(phantom::make("full", [257, 2, 2]).unwrap());
    let error = renderer.set_volume(long).unwrap_err();
    assert!(error.is_bad_input());
    assert!(
        error.to_string().contains("max_texture_dimension_3d"),
        "{error}"
    );
    // And the next that fits is drawn.
    let volume = Arc::new(phantom::make("full", [8; 3]).unwrap());
    renderer.set_volume(Arc::clone(&volume)).unwrap();
    renderer.set_transfer(transfer(0.1));
    let picture = renderer.render(&settings(volume.extent())).unwrap().picture;
    assert!(picture.rgba.iter().any(|p| p[3] > 0.0));
}

#[test]
fn a_picture_over_the_limit_of_a_binding_is_drawn_in_pieces() {
    let picture = |binding: Option<u32>| {
        let (device, queue, info) = device(256, binding);
        let mut renderer = Renderer::with_device(Gpu::from_device(device, queue, info)).unwrap();
        let volume = Arc::new(phantom::make("shells", [16; 3]).unwrap());
        renderer.set_volume(Arc::clone(&volume)).unwrap();
        renderer.set_transfer(transfer(0.1));
        let settings = Settings {
            size: [100, 75],
            table_entries: 256,
            ..settings(volume.extent())
        };
        renderer.render(&settings).unwrap().picture
    };
    // Its pixels take 120,000 bytes.
    assert_eq!(picture(Some(1 << 16)).difference(&picture(None)).pixels, 0);
}

/// Runs of more layers than are bound at once become one for each tile; blocks that are too many are refused by the limit's
/// name.
#[test]
fn runs_and_blocks_over_the_limit_of_a_binding_are_joined_and_refused() {
    const LONG: usize = 1600;
    let sheets: Vec<u8> = (0..64 * LONG)
        .map(|i| if i / 64 % 8 == 0 { 200 } else { 0 })
        .collect();
    let sheets = Arc::new(Volume {
        voxels: Voxels::U8(sheets.into()),
        ..phantom::make("empty", [8, 8, LONG]).unwrap()
    });
    let point = |value, opacity| ControlPoint {
        value,
        opacity,
        color: [1.0; 3],
    };
    let ramp = TransferFunction::new(vec![point(40.0, 0.0), point(255.0, 0.01)], 1.0).unwrap();
    let along = Camera {
        eye: DVec3::new(4.3, 4.2, -100.0),
        target: DVec3::new(4.0, 4.0, 0.0),
        up: DVec3::Y,
        projection: Projection::Orthographic { height: 14.0 },
    };
    let settings = |skip| Settings {
        skip,
        block: 2,
        table_entries: 256,
        size: [48; 2],
        ..Settings::new(along)
    };
    let mut pictures = Vec::new();
    // Runs of the four tiles of a piece take more than 6,000 bytes, a byte for each block 12,800.
    for binding in [None, Some(4096)] {
        let (device, queue, info) = device(2048, binding);
        let mut renderer = Renderer::with_device(Gpu::from_device(device, queue, info)).unwrap();
        renderer.set_volume(Arc::clone(&sheets)).unwrap();
        renderer.set_transfer(ramp.clone());
        let drawn = renderer.count(&settings(Skip::BeamMasks)).unwrap();
        pictures.push((drawn.picture, drawn.counters.samples));
        let blocks = renderer.render(&settings(Skip::DistanceMap));
        if binding.is_none() {
            blocks.unwrap();
            continue;
        }
        let error = blocks.unwrap_err();
        assert!(error.is_bad_input(), "{error}");
        let words = error.to_string();
        assert!(words.contains("max_storage_buffer_binding_size"), "{words}");
    }
    let [(whole, few), (joined, more)] = &pictures[..] else {
        unreachable!("there are two");
    };
    assert_eq!(whole.difference(joined).pixels, 0);
    assert!(more > few, "{more} {few}");
}

/// A texture to draw into, and its bytes.
fn target(gpu: &Gpu) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("target"),
        size: wgpu::Extent3d {
            width: EDGE,
            height: EDGE,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

fn bytes_of(gpu: &Gpu, texture: &wgpu::Texture) -> Vec<u8> {
    let len = EDGE * EDGE * 4;
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("target's bytes"),
        size: u64::from(len),
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
                bytes_per_row: Some(EDGE * 4),
                rows_per_image: None,
            },
        },
        texture.size(),
    );
    gpu.queue.submit([encoder.finish()]);
    read_back(gpu, &buffer, len as usize).unwrap()
}

#[test]
fn what_changes_while_a_frame_is_in_flight_is_of_the_next_frame_alone() {
    let (device, queue, info) = device(256, None);
    let gpu = Gpu::from_device(device, queue, info);
    let volume = Arc::new(phantom::make("shells", [24; 3]).unwrap());
    let frames: Vec<(f64, Settings)> = (0..6)
        .map(|i| {
            let orbit = Orbit {
                azimuth_degrees: 50.0 * f64::from(i),
                ..Orbit::default()
            };
            let settings = Settings {
                skip: METHODS[i as usize % 3].skip,
                block: [4, 8][i as usize % 2],
                size: [EDGE; 2],
                ..Settings::new(orbit.camera(volume.extent()))
            };
            (0.05 + 0.1 * f64::from(i), settings)
        })
        .collect();
    let draw =
        |renderer: &mut Renderer, (opacity, settings): &(f64, Settings), on: &wgpu::Texture| {
            renderer.set_transfer(transfer(*opacity));
            let targets = Targets {
                color: &on.create_view(&wgpu::TextureViewDescriptor::default()),
                color_format: on.format(),
                depth: None,
            };
            renderer.render_to(settings, &targets).unwrap();
        };
    let renderer = || {
        let mut renderer = Renderer::with_device(gpu.clone()).unwrap();
        renderer.set_volume(Arc::clone(&volume)).unwrap();
        renderer
    };
    // One after another on one renderer: nothing waits for the last pass of any, and all are read at the end.
    let mut busy = renderer();
    let drawn: Vec<wgpu::Texture> = frames.iter().map(|_| target(&gpu)).collect();
    for (frame, texture) in frames.iter().zip(&drawn) {
        draw(&mut busy, frame, texture);
    }
    let drawn: Vec<Vec<u8>> = drawn
        .iter()
        .map(|texture| bytes_of(&gpu, texture))
        .collect();
    for (i, frame) in frames.iter().enumerate() {
        let alone = target(&gpu);
        draw(&mut renderer(), frame, &alone);
        let alone = bytes_of(&gpu, &alone);
        assert!(alone.iter().any(|&b| b > 0));
        assert!(alone == drawn[i], "frame {i}");
    }
}
