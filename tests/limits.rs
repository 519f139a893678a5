//! What an adapter can do to a renderer: take away its device, or take no volume as large as this. These tests fail, not
//! skip, where there is no adapter.

use std::sync::Arc;

use hollowcast::Error;
use hollowcast::camera::Orbit;
use hollowcast::gpu::Gpu;
use hollowcast::render::{Renderer, Settings};
use hollowcast::transfer::{ControlPoint, TransferFunction};
use hollowcast::volume::phantom;

/// A device of the best adapter there is, that takes 3D textures of at most `edge` voxels.
fn device(edge: u32) -> (wgpu::Device, wgpu::Queue, wgpu::AdapterInfo) {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter =
        pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))
            .expect("these tests need an adapter: mesa-vulkan-drivers");
    let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        required_limits: wgpu::Limits {
            max_texture_dimension_3d: edge,
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

fn transfer() -> TransferFunction {
    let point = ControlPoint {
        value: 0.0,
        opacity: 0.1,
        color: [1.0; 3],
    };
    TransferFunction::new(vec![point], 1.0).unwrap()
}

#[test]
fn a_device_that_is_gone_is_an_error_and_no_panic() {
    let (device, queue, info) = device(256);
    let mut renderer =
        Renderer::with_device(Gpu::from_device(device.clone(), queue, info)).unwrap();
    let volume = Arc::new(phantom::make("shells", [16; 3]).unwrap());
    renderer.set_volume(Arc::clone(&volume)).unwrap();
    renderer.set_transfer(transfer());
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
    let (device, queue, info) = device(256);
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
    renderer.set_transfer(transfer());
    let picture = renderer.render(&settings(volume.extent())).unwrap().picture;
    assert!(picture.rgba.iter().any(|p| p[3] > 0.0));
}
