//! Box casting whose rays begin at the eye, all in f32: what most renderers do, and what a far camera breaks.
//!
//! From 10^5 voxels away, neighbouring f32 lengths are 2^-7 voxel apart, from 10^7 away a voxel: samples bunch and gap.
//! Here to show what it costs; [`crate::lattice`] begins its rays on a plane before the box that is found in f64.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::scenery::Frame;
use crate::camera::Projection;
use crate::error::Result;
use crate::lattice::{EDGE, PARALLEL};
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
    let rays = Rays::new(volume, frame)?;
    with_voxels!(&volume.voxels, voxels => {
        let value = |at: Vec3| {
            let [x, y, z] = [0, 1, 2].map(|a| cell(at[a]));
            let last = volume.dims.map(|n| n as i32 - 1);
            let stored = |dx: i32, dy: i32, dz: i32| {
                let i = [x.0 as i32 + dx, y.0 as i32 + dy, z.0 as i32 + dz];
                let [i, j, k] = [0, 1, 2].map(|a| i[a].clamp(0, last[a]) as usize);
                f64::from(voxels[(k * volume.dims[1] + j) * volume.dims[0] + i]) as f32
            };
            let row = |dy, dz| [stored(0, dy, dz), stored(1, dy, dz)];
            let corners = [[row(0, 0), row(1, 0)], [row(0, 1), row(1, 1)]];
            trilinear(corners, [x.1, y.1, z.1])
        };
        rgba.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
            for (x, pixel) in row.iter_mut().enumerate() {
                *pixel = rays.march([x, y], volume, &table, settings.ert, &value);
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
    /// Change of the start, and of the direction before it is normalised, per pixel to the right and downwards.
    start: [Vec3; 2],
    direction: [Vec3; 2],
    forward: Vec3,
    centre: [f32; 2],
    step: f32,
}

impl Rays {
    fn new(volume: &Volume, frame: &Frame) -> Result<Self> {
        let settings = &frame.settings;
        let camera = &settings.camera;
        let rays = camera.ray_frame(volume, settings.size, settings.step_voxels)?;
        let start = match camera.projection {
            Projection::Perspective { .. } => [DVec3::ZERO; 2],
            Projection::Orthographic { .. } => [rays.start_dx, rays.start_dy],
        };
        Ok(Self {
            eye: camera.eye.as_vec3(),
            start: start.map(DVec3::as_vec3),
            direction: [rays.dir_dx, rays.dir_dy].map(DVec3::as_vec3),
            forward: rays.dir.as_vec3(),
            centre: settings.size.map(|n| n as f32 * 0.5 - 0.5),
            step: settings.step_voxels as f32,
        })
    }

    fn march(
        &self,
        [x, y]: [usize; 2],
        volume: &Volume,
        table: &Table,
        ert: f32,
        value: &impl Fn(Vec3) -> f32,
    ) -> [f32; 4] {
        let [px, py] = [x as f32 - self.centre[0], y as f32 - self.centre[1]];
        let start = self.eye + self.start[0] * px + self.start[1] * py;
        let direction = self.forward + self.direction[0] * px + self.direction[1] * py;
        let direction = direction.normalize();
        // What counts as parallel, and as in front of the eye, is the lattice's rule: only lengths differ.
        let direction = Vec3::select(
            direction.abs().cmplt(Vec3::splat(PARALLEL as f32)),
            Vec3::ZERO,
            direction,
        );
        let extent = volume.extent().as_vec3();
        let grid_from_local = (1.0 / volume.voxel_size()).as_vec3();
        let [t0, t1] = [Vec3::ZERO, extent].map(|plane| (plane - start) / direction);
        let (mut entry, mut exit) = (f32::NEG_INFINITY, f32::INFINITY);
        for a in 0..3 {
            if direction[a] != 0.0 {
                entry = entry.max(t0[a].min(t1[a]));
                exit = exit.min(t0[a].max(t1[a]));
            } else if start[a] < 0.0 || extent[a] < start[a] {
                return [0.0; 4];
            }
        }
        let margin = 0.5 + EDGE as f32;
        let first = (-entry / self.step - margin).ceil().max(0.0) as u32;
        let end = ((exit - entry) / self.step - margin).ceil().max(0.0) as u32;
        let mut state = State::init();
        let (domain, rgba) = (table.domain(), table.rgba());
        for k in first..end {
            let t = entry + (k as f32 + 0.5) * self.step;
            let x = (value((start + t * direction) * grid_from_local) - domain.origin as f32)
                * domain.scale as f32;
            let (lower, fraction) = lookup(x, rgba.len() as f32, domain.snap() as f32);
            let i = lower as usize;
            let [a, b] = [i, (i + 1).min(rgba.len() - 1)].map(|i| rgba[i]);
            state.add(std::array::from_fn(|c| a[c] + fraction * (b[c] - a[c])));
            if ert < 1.0 && state.rgba[3] > 0.0 && state.done(ert) {
                break;
            }
        }
        state.rgba
    }
}
