//! The reference against closed-form answers, and skipping against not skipping.

mod closed_form;
mod lossless;

use glam::{DMat3, DVec3, Vec3Swizzles as _};

use crate::camera::{Camera, Projection};
use crate::lattice::RayFrame;
use crate::mode::Mode;
use crate::sample::Classification;
use crate::scene::Scene;
use crate::transfer::{ControlPoint, Domain, Table, TransferFunction};
use crate::volume::{Rescale, Volume, Voxels};

fn volume(dims: [usize; 3], spacing: [f64; 3], voxels: Voxels) -> Volume {
    Volume {
        name: "made by hand".into(),
        dims,
        spacing: spacing.into(),
        origin: DVec3::ZERO,
        direction: DMat3::IDENTITY,
        rescale: Rescale::IDENTITY,
        voxels,
        warnings: Vec::new(),
    }
}

fn point(value: f64, opacity: f64, color: [f64; 3]) -> ControlPoint {
    ControlPoint {
        value,
        opacity,
        color,
    }
}

fn function(points: Vec<ControlPoint>, reference_length_voxels: f64) -> TransferFunction {
    TransferFunction::new(points, reference_length_voxels).expect("points ascend")
}

fn domain(volume: &Volume, entries: usize) -> Domain {
    let range = volume
        .voxels
        .voxel_type()
        .integer_range()
        .expect("tests use integers");
    Domain::new(volume, range, entries).expect("a table size")
}

fn scene<'a>(volume: &'a Volume, table: &'a Table, frame: &'a RayFrame, ert: f32) -> Scene<'a> {
    Scene {
        ert,
        ..Scene::new(volume, table, frame)
    }
}

/// Parallel rays along `axis`, or against it, through the middle of the box; one voxel per pixel.
fn along(volume: &Volume, axis: usize, sign: f64, size: [u32; 2], step: f64) -> RayFrame {
    let target = volume.extent() * 0.5;
    let mut forward = DVec3::ZERO;
    forward[axis] = sign;
    let camera = Camera {
        eye: target - forward * 100.0,
        target,
        up: forward.yzx(),
        projection: Projection::Orthographic {
            height: f64::from(size[1]),
        },
    };
    camera.ray_frame(volume, size, step).expect("a valid view")
}
