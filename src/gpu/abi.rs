//! Structs that Rust writes and WGSL reads; a test reflects the shaders and compares name, offset and size.

use bytemuck::{Pod, Zeroable};

/// `View` in `shaders/shared/view.inc.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct View {
    pub start: [f32; 3],
    pub step: f32,
    pub start_dx: [f32; 3],
    pub depth_scale: f32,
    pub start_dy: [f32; 3],
    pub grow: f32,
    pub dir: [f32; 3],
    pub block: f32,
    pub dir_dx: [f32; 3],
    pub start_depth: f32,
    pub dir_dy: [f32; 3],
    pub reach: f32,
    pub extent: [f32; 3],
    pub pad2: f32,
    pub grid_from_local: [f32; 3],
    pub pad3: f32,
    pub centre: [f32; 2],
    pub origin: [u32; 2],
    pub size: [u32; 2],
    pub pad4: u32,
    pub pad5: u32,
    pub clip_from_local: [[f32; 4]; 4],
    pub clip_planes: [[f32; 4]; 12],
    pub dims: [f32; 3],
    pub x_scale: f32,
    pub inverse_dims: [f32; 3],
    pub raw_origin: f32,
    pub block_dims: [u32; 3],
    pub after_blocks: u32,
    pub entries: f32,
    pub snap: f32,
    pub ert: f32,
    pub face: f32,
}

/// `MarchSettings` in `shaders/shared/march_settings.inc.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct MarchSettings {
    pub segment_count: u32,
    pub near_mask: u32,
    pub tile_count: u32,
    pub tiles_per_row: u32,
    pub max_iterations: u32,
    pub resume: u32,
    pub store_progress: u32,
    pub tile_first: u32,
    pub takes_runs: u32,
    pub ray_words: u32,
}

/// `ModeSettings` in `shaders/shared/mode_settings.inc.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct ModeSettings {
    pub light: [f32; 3],
    pub light_is_eye: u32,
    pub color: [f32; 3],
    pub ambient: f32,
    pub outer_color: [f32; 4],
    pub diffuse: f32,
    pub specular: f32,
    pub shininess: f32,
    pub opacity_ratio: f32,
    pub window_low: f32,
    pub window_scale: f32,
    pub window_dead: f32,
    pub direction: f32,
    pub iso: f32,
    pub outer_iso: f32,
    pub least_gradient: f32,
    pub gradient_scale: f32,
    pub cells_per_voxel: f32,
    pub cue_strength: f32,
    pub cue_start: f32,
    pub cue_scale: f32,
}

/// `GradientCells` in `shaders/gradients.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct GradientCells {
    pub edge: u32,
    pub scale: f32,
    pub first_layer: u32,
    pub pad1: u32,
}

/// `Tile` in `shaders/shared/march_settings.inc.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct Tile {
    pub at: u32,
    pub first_run: u32,
    pub run_count: u32,
    pub axis: u32,
}

#[cfg(test)]
mod tests {
    use std::mem::offset_of;

    use super::*;
    use crate::gpu::shader::compose;

    fn reflect(root: &str, name: &str) -> (u32, Vec<(String, u32)>) {
        let choices = [
            ("SKIP", "bounds"),
            ("SAMPLER", "exact"),
            ("CLASSIFICATION", "post"),
            ("MODE", "phong"),
            ("COUNT", "off"),
            ("GRADIENT", "fly"),
            ("CUE", "on"),
            ("STORE", "volume"),
            ("BOUND", "none"),
        ];
        let module = naga::front::wgsl::parse_str(&compose(root, &choices).unwrap()).unwrap();
        let (_, ty) = module
            .types
            .iter()
            .find(|(_, ty)| ty.name.as_deref() == Some(name))
            .unwrap();
        let naga::TypeInner::Struct { members, span } = &ty.inner else {
            panic!("{name} is a struct")
        };
        (
            *span,
            members
                .iter()
                .map(|m| (m.name.clone().unwrap(), m.offset))
                .collect(),
        )
    }

    macro_rules! mirrors {
        ($struct:ident: $($field:ident),* $(,)?) => {
            mirrors!($struct in "march": $($field),*);
        };
        ($struct:ident in $root:literal: $($field:ident),* $(,)?) => {
            let (span, members) = reflect($root, stringify!($struct));
            assert_eq!(span as usize, size_of::<$struct>());
            let ours = vec![$((stringify!($field).to_owned(), offset_of!($struct, $field) as u32)),*];
            assert_eq!(members, ours);
        };
    }

    #[test]
    fn structs_are_what_the_shaders_read() {
        mirrors!(View: start, step, start_dx, depth_scale, start_dy, grow, dir, block, dir_dx, start_depth, dir_dy, reach,
            extent, pad2, grid_from_local, pad3, centre, origin, size, pad4, pad5,
            clip_from_local, clip_planes, dims, x_scale, inverse_dims, raw_origin, block_dims, after_blocks, entries, snap, ert, face);
        mirrors!(MarchSettings: segment_count, near_mask, tile_count, tiles_per_row, max_iterations, resume, store_progress,
            tile_first, takes_runs, ray_words);
        mirrors!(ModeSettings: light, light_is_eye, color, ambient, outer_color, diffuse, specular, shininess,
            opacity_ratio, window_low, window_scale, window_dead, direction, iso, outer_iso, least_gradient,
            gradient_scale, cells_per_voxel, cue_strength, cue_start, cue_scale);
        mirrors!(GradientCells in "gradients": edge, scale, first_layer, pad1);
        mirrors!(Tile: at, first_run, run_count, axis);
    }
}
