// The adapter's trilinear filter.

@group(0) @binding(5) var volume: texture_3d<f32>;
@group(0) @binding(6) var volume_filter: sampler;
// Premultiplied colour and opacity of every voxel, where they are classified before they are interpolated.
@group(0) @binding(10) var colors: texture_3d<f32>;

// The raw texel at a grid position.
fn fetch_at(grid: vec3f) -> f32 {
    return textureSampleLevel(volume, volume_filter, grid * view.inverse_dims, 0.0).x;
}

// The raw texel at the fraction `f`, per axis, from voxel `lower` to the next.
fn fetch(lower: vec3f, f: vec3f) -> f32 {
    return fetch_at(lower + f + 0.5);
}

// The same of colours.
fn fetch_color_at(grid: vec3f) -> vec4f {
    return textureSampleLevel(colors, volume_filter, grid * view.inverse_dims, 0.0);
}

fn fetch_color(lower: vec3f, f: vec3f) -> vec4f {
    return fetch_color_at(lower + f + 0.5);
}
