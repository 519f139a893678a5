//! What a hazard is made of.

use std::sync::Arc;

use crate::camera::{Camera, Orbit, Projection};
use crate::render::Settings;
use crate::sample::Sampler;
use crate::transfer::{ControlPoint, TABLE_SIZES, TransferFunction};
use crate::volume::Volume;
use glam::DVec3;

/// Edge of a picture in pixels, unless a hazard needs another: odd, so that a ray goes through its middle, and no
/// multiple of the marcher's tiles.
const SIZE: u32 = 45;
/// Voxels along a block's edge, unless a hazard needs another.
pub(super) const BLOCK: usize = 4;
/// Edge of the pictures of timed hazards.
const TIMED_SIZE: u32 = 192;

/// A volume and the pictures that are taken of it.
#[derive(Debug)]
pub struct Scenery {
    /// The voxels.
    pub volume: Arc<Volume>,
    /// The pictures, in the order in which each contestant draws them.
    pub frames: Vec<Frame>,
    /// What is looked at.
    pub judged: Judged,
}

/// One picture.
#[derive(Debug, Clone)]
pub struct Frame {
    /// All but the method.
    pub settings: Settings,
    /// Colour and opacity.
    pub transfer: TransferFunction,
}

/// What is looked at besides every picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Judged {
    /// Nothing.
    Alone,
    /// How much each picture changes from the one before.
    InSequence,
    /// What it takes to draw.
    Timed,
}

impl Scenery {
    /// One frame from each camera, by a ramp from [`super::volumes`]' emptiness to its matter.
    pub(super) fn new(volume: Volume, cameras: impl IntoIterator<Item = Camera>) -> Self {
        let transfer = ramp(40.0, 255.0, 0.3);
        let frames = cameras.into_iter().map(|camera| Frame {
            settings: Settings {
                sampler: Some(Sampler::Exact),
                block: BLOCK,
                ert: 1.0,
                size: [SIZE; 2],
                table_entries: TABLE_SIZES[0],
                ..Settings::new(camera)
            },
            transfer: transfer.clone(),
        });
        Self {
            frames: frames.collect(),
            volume: Arc::new(volume),
            judged: Judged::Alone,
        }
    }

    /// From two places outside, near and oblique.
    pub(super) fn from_outside(volume: Volume) -> Self {
        let extent = volume.extent();
        let cameras = [(35.0, 25.0), (200.0, -60.0)].map(|(azimuth, elevation)| {
            Orbit {
                azimuth_degrees: azimuth,
                elevation_degrees: elevation,
                distance_edges: 1.6,
                ..Orbit::default()
            }
            .camera(extent)
        });
        Self::new(volume, cameras)
    }

    /// From straight before the z axis, large and timed.
    pub(super) fn timed(volume: Volume) -> Self {
        let camera = Orbit {
            azimuth_degrees: 10.0,
            elevation_degrees: 80.0,
            distance_edges: 1.7,
            ..Orbit::default()
        }
        .camera(volume.extent());
        let mut scenery = Self::new(volume, [camera]).with(|s| {
            s.size = [TIMED_SIZE; 2];
            s.ert = 0.98;
        });
        scenery.judged = Judged::Timed;
        scenery
    }

    /// With another transfer function.
    pub(super) fn through(mut self, transfer: &TransferFunction) -> Self {
        for frame in &mut self.frames {
            frame.transfer = transfer.clone();
        }
        self
    }

    /// With the settings of every frame changed.
    pub(super) fn with(mut self, change: impl Fn(&mut Settings)) -> Self {
        for frame in &mut self.frames {
            change(&mut frame.settings);
        }
        self
    }

    /// Every frame once for each of these values.
    pub(super) fn for_each<T>(
        mut self,
        values: impl IntoIterator<Item = T>,
        change: impl Fn(&mut Frame, &T),
    ) -> Self {
        let values: Vec<T> = values.into_iter().collect();
        let changed = self.frames.iter().flat_map(|frame| {
            values.iter().map(|value| {
                let mut frame = frame.clone();
                change(&mut frame, value);
                frame
            })
        });
        self.frames = changed.collect();
        self
    }

    /// Judged as a sequence too.
    pub(super) fn in_sequence(mut self) -> Self {
        self.judged = Judged::InSequence;
        self
    }
}

/// Emptiness up to `low`, `opacity` per voxel from `high` on.
pub(super) fn ramp(low: f64, high: f64, opacity: f64) -> TransferFunction {
    through(&[(low, 0.0), (high, opacity)])
}

/// A function through values and opacities; warm below, cool above.
pub(super) fn through(points: &[(f64, f64)]) -> TransferFunction {
    let last = (points.len() - 1).max(1) as f64;
    let points = points.iter().enumerate().map(|(i, &(value, opacity))| {
        let f = i as f64 / last;
        ControlPoint {
            value,
            opacity,
            color: [1.0 - 0.5 * f, 0.6, 0.3 + 0.5 * f],
        }
    });
    TransferFunction::new(points.collect(), 1.0).expect("hazards' tables ascend")
}

/// An eye that looks along `direction` with a field of view in degrees.
pub(super) fn looking(eye: DVec3, direction: DVec3, fov_y_degrees: f64) -> Camera {
    Camera {
        eye,
        target: eye + direction,
        up: DVec3::Z,
        projection: Projection::Perspective { fov_y_degrees },
    }
}

/// Parallel rays along `direction`, from a plane through `eye`, over a picture of this height.
pub(super) fn parallel(eye: DVec3, direction: DVec3, height: f64) -> Camera {
    Camera {
        projection: Projection::Orthographic { height },
        ..looking(eye, direction, 45.0)
    }
}

/// Directions in which methods differ: along each axis both ways, along diagonals, and oblique.
pub(super) const DIRECTIONS: [DVec3; 10] = [
    DVec3::X,
    DVec3::NEG_X,
    DVec3::Y,
    DVec3::NEG_Y,
    DVec3::Z,
    DVec3::NEG_Z,
    DVec3::new(1.0, 1.0, 0.0),
    DVec3::new(-1.0, 1.0, 1.0),
    DVec3::new(0.8, 0.5, -0.33),
    DVec3::new(-0.2, -0.9, 0.4),
];
