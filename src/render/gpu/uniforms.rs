//! What the shaders are told of a picture: views, march and mode settings.

use glam::DVec3;

use super::before::ray_words;
use super::dispatch::{Dispatch, MAX_ITERATIONS, TILES_PER_ROW};
use super::faces::Viewer;
use super::gradients::GradientVolume;
use super::{Job, Piece};
use crate::camera::Projection;
use crate::gpu::abi::{MarchSettings, ModeSettings, View};
use crate::gpu::texture::VolumeTexture;
use crate::lattice::MAX_CLIP_PLANES;
use crate::mode::{DepthCue, Light, Parameters, surface};
use crate::skip::beam_cells::MARGIN;

pub(super) fn settings_of(job: &Job, dispatch: &Dispatch) -> MarchSettings {
    let near_mask = job
        .parts
        .iter()
        .enumerate()
        .map(|(i, p)| u32::from(p.starts_near) << i)
        .sum();
    MarchSettings {
        segment_count: job.parts.len() as u32,
        near_mask,
        tile_count: dispatch.tile_count,
        tiles_per_row: TILES_PER_ROW,
        max_iterations: MAX_ITERATIONS,
        resume: u32::from(dispatch.resume),
        store_progress: u32::from(dispatch.store_progress),
        tile_first: dispatch.tile_first,
        takes_runs: u32::from(job.masks.is_some()),
        ray_words: ray_words(job),
    }
}

/// Without a volume of gradients nothing reads what is said of one.
pub(super) fn mode_of(
    job: &Job,
    volume: &VolumeTexture,
    gradients: Option<&GradientVolume>,
) -> ModeSettings {
    let scene = &job.scene;
    let cue = DepthCue::new(scene.depth_cue, scene.frame);
    let x_per_raw = scene.table.domain().scale * volume.stored_per_raw;
    let edge = scene.gradients.cell_edge().unwrap_or(1);
    let p = Parameters::new(&scene.mode, scene.table.domain(), scene.frame.step);
    let lighting = p.lighting;
    let light = match lighting.light {
        Light::Headlight => [0.0; 3],
        Light::From(direction) => surface::unit(direction),
    };
    ModeSettings {
        light: light.map(|c| c as f32),
        light_is_eye: u32::from(lighting.light == Light::Headlight),
        color: p.color.map(|c| c as f32),
        ambient: lighting.ambient as f32,
        outer_color: p.outer_color.map(|c| c as f32),
        diffuse: lighting.diffuse as f32,
        specular: lighting.specular as f32,
        shininess: lighting.shininess as f32,
        opacity_ratio: p.opacity_ratio as f32,
        window_low: p.window_low as f32,
        window_scale: p.window_scale as f32,
        window_dead: p.window_dead as f32,
        direction: p.direction as f32,
        iso: p.iso as f32,
        outer_iso: p.outer_iso as f32,
        least_gradient: p.least_gradient as f32,
        gradient_scale: gradients.map_or(0.0, |g| (x_per_raw / g.scale) as f32),
        cells_per_voxel: 1.0 / edge as f32,
        cue_strength: cue.strength as f32,
        cue_start: cue.start as f32,
        cue_scale: cue.scale as f32,
    }
}

pub(super) fn view_of(
    job: &Job,
    volume: &VolumeTexture,
    piece: &Piece,
    clip_from_local: &glam::DMat4,
) -> View {
    let frame = job.scene.frame;
    let domain = job.scene.table.domain();
    let dims = job.scene.volume.dims.map(|n| n as f32);
    let v = |v: DVec3| v.as_vec3().to_array();
    // The rasteriser sees the piece: zoom the picture's clip space into it.
    let [w, h] = frame.size.map(f64::from);
    let [pw, ph] = piece.size.map(f64::from);
    let [x, y] = piece.origin.map(f64::from);
    let zoom = glam::DMat4::from_cols(
        glam::DVec4::new(w / pw, 0.0, 0.0, 0.0),
        glam::DVec4::new(0.0, h / ph, 0.0, 0.0),
        glam::DVec4::Z,
        glam::DVec4::new((w - 2.0 * x) / pw - 1.0, 1.0 - (h - 2.0 * y) / ph, 0.0, 1.0),
    );
    // Rays start at most a thousandth of the box before it; grown faces stick out a little.
    let depth = frame.extent.length() * 1.01 + 2.0 * grow_of(job);
    let mut clip_planes = [[0.0; 4]; MAX_CLIP_PLANES];
    for (plane, clip) in clip_planes.iter_mut().zip(frame.clipping.planes()) {
        *plane = clip.map(|c| c as f32);
    }
    View {
        start: v(frame.start),
        step: frame.step as f32,
        start_dx: v(frame.start_dx),
        depth_scale: f32::exp2(-(depth.log2().ceil() as f32)),
        start_dy: v(frame.start_dy),
        grow: grow_of(job) as f32,
        dir: v(frame.dir),
        block: job.block as f32,
        dir_dx: v(frame.dir_dx),
        start_depth: (frame.start - job.camera.eye).dot(job.camera.forward()) as f32,
        dir_dy: v(frame.dir_dy),
        reach: frame.reach as f32,
        extent: v(frame.extent),
        pad2: 0.0,
        grid_from_local: v(frame.grid_from_local),
        pad3: 0.0,
        centre: frame.size.map(|n| (f64::from(n) * 0.5 - 0.5) as f32),
        origin: piece.origin,
        size: piece.size,
        pad4: 0,
        pad5: 0,
        clip_from_local: (zoom * *clip_from_local).as_mat4().to_cols_array_2d(),
        clip_planes,
        dims,
        x_scale: (domain.scale * volume.stored_per_raw) as f32,
        inverse_dims: dims.map(|n| 1.0 / n),
        raw_origin: ((domain.origin - volume.stored_at_zero) / volume.stored_per_raw) as f32,
        block_dims: job.block_dims(),
        after_blocks: job.blocks.map_or(0, |words| words.after_blocks),
        entries: domain.entries as f32,
        snap: domain.snap() as f32,
        // Never means never, even where a sample is opaque.
        ert: job.scene.ert_threshold().min(f64::from(f32::MAX)) as f32,
        face: if job.scene.sampler.is_filtered() {
            MARGIN as f32
        } else {
            0.0
        },
    }
}

/// How far faces grow: a quarter voxel, and where the whole box covers few pixels, enough that the rasteriser's
/// snapping to 1/256 of a pixel loses none.
fn grow_of(job: &Job) -> f64 {
    let extent = job.scene.volume.extent();
    let pixel = match job.camera.projection {
        Projection::Perspective { fov_y_degrees } => {
            let farthest = (job.camera.eye - extent * 0.5).length() + extent.length() * 0.5;
            farthest * (fov_y_degrees.to_radians() * 0.5).tan() * 2.0
                / f64::from(job.scene.frame.size[1])
        }
        Projection::Orthographic { height } => height / f64::from(job.scene.frame.size[1]),
    };
    (pixel / 64.0).max(0.25)
}

pub(super) fn viewer_of(job: &Job) -> Viewer {
    let parallel = matches!(job.camera.projection, Projection::Orthographic { .. })
        .then(|| job.camera.forward());
    Viewer {
        eye: job.camera.eye,
        parallel,
        grow: grow_of(job),
        block_size: job.scene.volume.voxel_size() * job.block as f64,
        extent: job.scene.frame.extent,
    }
}
