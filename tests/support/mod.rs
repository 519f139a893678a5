//! What the tests of modes share: renderers, volumes and settings.

// Each test binary takes what it needs.
#![allow(dead_code)]

use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use glam::{DVec3, Vec3Swizzles as _};
use hollowcast::camera::{Camera, Orbit, Projection};
use hollowcast::measure::metrics::metrics;
use hollowcast::measure::verify::{Case, Verifier, View};
use hollowcast::mode::{Light, MODES, Mode};
use hollowcast::render::{BackendChoice, Renderer, Settings};
use hollowcast::sample::Sampler;
use hollowcast::scene::Picture;
use hollowcast::skip::Skip;
use hollowcast::transfer::{ControlPoint, TransferFunction};
use hollowcast::volume::{self, Rescale, Statistics, Volume, Voxels, phantom};

/// One renderer for all tests: devices are dear on a software driver.
pub(crate) fn renderer() -> MutexGuard<'static, Renderer> {
    static RENDERER: Mutex<Option<&'static Mutex<Renderer>>> = Mutex::new(None);
    let mut slot = RENDERER.lock().unwrap_or_else(PoisonError::into_inner);
    let renderer = slot.get_or_insert_with(|| {
        let renderer = Renderer::new(BackendChoice::Gpu)
            .expect("these tests need an adapter: mesa-vulkan-drivers");
        Box::leak(Box::new(Mutex::new(renderer)))
    });
    renderer.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Gives renderers a volume, and the transfer function that suits it.
pub(crate) fn show<'a>(
    renderers: impl IntoIterator<Item = &'a mut Renderer>,
    volume: &Arc<Volume>,
) -> TransferFunction {
    let transfer = TransferFunction::from_spec("translucent", &Statistics::of(volume)).unwrap();
    for renderer in renderers {
        renderer.set_volume(Arc::clone(volume)).unwrap();
        renderer.set_transfer(transfer.clone());
    }
    transfer
}

/// Holds a verifier's methods to box's bits from a place.
pub(crate) fn check_bits(mut verifier: Verifier, view: View, sampler: Sampler, told: &str) {
    let case = Case {
        view,
        is_parallel: view == View::Outside,
        block: 4,
        step_edges: 0.03,
        ert: 0.98,
        sampler,
    };
    for outcome in verifier.run(&case).unwrap() {
        assert_eq!(outcome.differing_pixels, 0, "{told} {view:?}: {outcome:?}");
    }
}

pub(crate) fn settings(mode: Mode, camera: Camera) -> Settings {
    Settings {
        skip: Skip::HalfSplit,
        sampler: Some(Sampler::Exact),
        mode,
        block: 4,
        step_voxels: 0.7,
        ert: 1.0,
        size: [80, 72],
        ..Settings::new(camera)
    }
}

pub(crate) fn shipped(name: &str) -> Arc<Volume> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("data")
        .join(name);
    Arc::new(volume::open(&path, None).unwrap())
}

/// A scan of the folder in `HOLLOWCAST_DATA`.
pub(crate) fn of_data_folder(name: &str) -> Arc<Volume> {
    let folder = std::env::var_os("HOLLOWCAST_DATA");
    let path = Path::new(&folder.expect("HOLLOWCAST_DATA names the folder of scans")).join(name);
    Arc::new(volume::open(&path, None).unwrap())
}

pub(crate) fn made(name: &str) -> Arc<Volume> {
    Arc::new(phantom::make(name, [44, 48, 40]).unwrap())
}

/// The same numbers, of which data values are the negatives.
pub(crate) fn turned_round(volume: &Volume) -> Arc<Volume> {
    let Voxels::U8(voxels) = &volume.voxels else {
        panic!("phantoms are bytes")
    };
    Arc::new(Volume {
        voxels: Voxels::U8(voxels.iter().map(|v| 255 - v).collect::<Vec<_>>().into()),
        rescale: Rescale {
            slope: -1.0,
            intercept: 255.0,
        },
        ..phantom::make("empty", volume.dims).unwrap()
    })
}

/// All modes as they suit a volume, with light that does not come from the eye where one is lit.
pub(crate) fn modes(volume: &Volume) -> Vec<Mode> {
    let statistics = Statistics::of(volume);
    let aside = Light::From([1.0, -2.0, 1.5]);
    let mut modes: Vec<Mode> = MODES
        .iter()
        .map(|row| (row.suited_to)(&statistics))
        .collect();
    for mode in &mut modes {
        if let Mode::Shaded(lighting) | Mode::TwoSurfaces { lighting, .. } = mode {
            lighting.light = aside;
        }
    }
    modes
}

/// Parallel rays along an axis through the middle of a volume, in pictures `height` local units high.
pub(crate) fn along(volume: &Volume, axis: DVec3, height: f64) -> Camera {
    let target = volume.extent() * 0.5;
    Camera {
        eye: target - axis * 100.0,
        target,
        up: axis.abs().yzx(),
        projection: Projection::Orthographic { height },
    }
}

/// Stacks of material along z that every ray of an upright parallel view passes.
pub(crate) fn stack(values: &[u8]) -> Arc<Volume> {
    let (n, layer) = (24, 8);
    let voxels: Vec<u8> = (0..n * n * layer * values.len())
        .map(|i| values[i / (n * n * layer)])
        .collect();
    Arc::new(Volume {
        dims: [n, n, layer * values.len()],
        voxels: Voxels::U8(voxels.into()),
        ..phantom::make("empty", [1; 3]).unwrap()
    })
}

/// Transparent up to `low`, rising to `opacity` a voxel at `high`.
pub(crate) fn ramp(low: f64, high: f64, opacity: f64) -> TransferFunction {
    let point = |value, opacity, color| ControlPoint {
        value,
        opacity,
        color,
    };
    TransferFunction::new(
        vec![
            point(low, 0.0, [0.9, 0.6, 0.4]),
            point(high, opacity, [1.0, 0.9, 0.8]),
        ],
        1.0,
    )
    .unwrap()
}

/// Pictures of a whole volume by a method, through the smallest table.
pub(crate) fn outside(volume: &Volume, skip: Skip, sampler: Sampler) -> Settings {
    Settings {
        skip,
        sampler: Some(sampler),
        ert: 1.0,
        size: [96, 96],
        table_entries: 256,
        ..Settings::new(Orbit::default().camera(volume.extent()))
    }
}

/// How near two pictures are: in dB, and the largest difference of a channel.
pub(crate) fn nearness(a: &Picture, b: &Picture) -> (f64, f64) {
    let error = metrics([(a, b)]);
    (error.psnr_db(), error.max_abs)
}
