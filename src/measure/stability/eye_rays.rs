//! Box casting whose rays begin at the eye, all in f32: what most renderers do, and what a far camera breaks.
//!
//! From 10^5 voxels away, neighbouring f32 lengths are 2^-7 voxel apart, from 10^7 away a voxel: samples bunch and gap.
//! Here to show what it costs; [`crate::lattice`] begins its rays on a plane before the box that is found in f64.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::scenery::Frame;
use crate::camera::Projection;
use crate::error::Result;
use crate::mode::emission_absorption::State;
use crate::sample::{cell, trilinear};
use crate::scene::Picture;
use crate::transfer::{Domain, Table, lookup};
use crate::volume::{Volume, statistics};
use crate::with_voxels;

/// Emission and absorption over every sample in the box.
pub(super) fn draw(volume: &Volume, frame: &Frame) -> Result<Picture> {
    let settings = &frame.settings;
    let range = statistics::stored_range(volume);
    let domain = Domain::new(volume, range, settings.table_entries)?;
    let table = frame.transfer.bake(&domain, settings.step_voxels);
    let [width, height] = settings.size.map(|n| n as usize);
    let mut rgba = vec![[0.0; 4]; width * height];
    let rays = Rays::new(frame);
    with_voxels!(&volume.voxels, voxels => {
        let value = |at: Vec3| {
            let [x, y, z] = [0, 1, 2].map(|a| cell(at[a]));
            let last = volume.dims.map(|n| n as i32 - 1);
            let stored = |dx: i32, dy: i32, dz: i32| {
                let i = [x.0 as i32 + dx, y.0 as i32 + dy, z.0 as i32 + dz];
                let [i, j, k] = [0, 1, 2].map(|a| i[a].clamp(0, last[a]) as usize);
                f32::from(voxels[(k * volume.dims[1] + j) * volume.dims[0] + i])
            };
            let row = |dy, dz| [stored(0, dy, dz), stored(1, dy, dz)];
            let corners = [[row(0, 0), row(1, 0)], [row(0, 1), row(1, 1)]];
            trilinear(corners, [x.1, y.1, z.1])
        };
        rgba.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
            for (x, pixel) in row.iter_mut().enumerate() {
                *pixel = rays.march(x, y, volume, &table, settings.ert, &value);
            }
        });
    });
    Ok(Picture {
        size: settings.size,
        rgba,
    })
}

/// Rays of one picture, in f32 from the eye on.
struct Rays {
    eye: Vec3,
    right: Vec3,
    down: Vec3,
    forward: Vec3,
    /// Whether right and down move the ray's direction, else its start.
    spreads: bool,
    centre: [f32; 2],
    step: f32,
}

impl Rays {
    fn new(frame: &Frame) -> Self {
        let settings = &frame.settings;
        let camera = &settings.camera;
        let forward = camera.forward();
        let right = forward.cross(camera.up).normalize_or(DVec3::X);
        let height = f64::from(settings.size[1]);
        let (scale, spreads) = match camera.projection {
            Projection::Perspective { fov_y_degrees } => (
                (fov_y_degrees.to_radians() * 0.5).tan() * 2.0 / height,
                true,
            ),
            Projection::Orthographic { height: edge } => (edge / height, false),
        };
        Self {
            eye: camera.eye.as_vec3(),
            right: (right * scale).as_vec3(),
            down: (forward.cross(right) * scale).as_vec3(),
            forward: forward.as_vec3(),
            spreads,
            centre: settings.size.map(|n| n as f32 * 0.5 - 0.5),
            step: settings.step_voxels as f32,
        }
    }

    fn march(
        &self,
        x: usize,
        y: usize,
        volume: &Volume,
        table: &Table,
        ert: f32,
        value: &impl Fn(Vec3) -> f32,
    ) -> [f32; 4] {
        let across =
            self.right * (x as f32 - self.centre[0]) + self.down * (y as f32 - self.centre[1]);
        let (start, direction) = if self.spreads {
            (self.eye, (self.forward + across).normalize())
        } else {
            (self.eye + across, self.forward)
        };
        let extent = volume.extent().as_vec3();
        let grid_from_local = (1.0 / volume.voxel_size()).as_vec3();
        let (t0, t1) = (
            (Vec3::ZERO - start) / direction,
            (extent - start) / direction,
        );
        // Rays in a plane of the box divide zero by zero; `min` and `max` leave such numbers out.
        let entry = t0.min(t1).max_element();
        let exit = t0.max(t1).min_element();
        let samples = ((exit - entry) / self.step - 0.5).ceil().max(0.0) as u32;
        let mut state = State::init();
        let domain = table.domain();
        for k in 0..samples {
            let t = entry + (k as f32 + 0.5) * self.step;
            if t < 0.0 {
                continue;
            }
            let x = (value((start + t * direction) * grid_from_local) - domain.origin as f32)
                * domain.scale as f32;
            let (lower, fraction) = lookup(x, table.rgba().len() as f32, domain.snap() as f32);
            let i = lower as usize;
            let [a, b] = [i, (i + 1).min(table.rgba().len() - 1)].map(|i| table.rgba()[i]);
            let color = std::array::from_fn(|c| a[c] + fraction * (b[c] - a[c]));
            state.add(color);
            if ert < 1.0 && state.done(ert) {
                break;
            }
        }
        state.rgba
    }
}
