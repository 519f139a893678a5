// The adapter's trilinear filter.

@group(0) @binding(5) var volume: texture_3d<f32>;
@group(0) @binding(6) var volume_filter: sampler;

// The raw texel at a grid position.
fn fetch_at(grid: vec3f) -> f32 {
    return textureSampleLevel(volume, volume_filter, grid * settings.inverse_dims, 0.0).x;
}

// The raw texel at the fraction `f`, per axis, from voxel `lower` to the next.
fn fetch(lower: vec3f, f: vec3f) -> f32 {
    return fetch_at(lower + f + 0.5);
}
