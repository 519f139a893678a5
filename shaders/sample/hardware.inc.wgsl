// The adapter's trilinear filter. Twin of sample::Sampler::Hardware.

@group(0) @binding(5) var volume: texture_3d<f32>;
@group(0) @binding(6) var volume_filter: sampler;
// Premultiplied colour and opacity of every voxel, where they are classified before they are interpolated.
@group(0) @binding(9) var colors: texture_3d<f32>;

fn sample_x(grid: vec3f) -> f32 {
    let raw = textureSampleLevel(volume, volume_filter, grid * settings.inverse_dims, 0.0).x;
    return (raw - settings.raw_origin) * settings.x_scale;
}

fn sample_rgba(grid: vec3f) -> vec4f {
    return textureSampleLevel(colors, volume_filter, grid * settings.inverse_dims, 0.0);
}
