// Trilinear interpolation by the adapter's filter. Twin of sample::Sampler::Hardware.
#import fetch/filter

// Premultiplied colour and opacity of every voxel, where they are classified before they are interpolated.
@group(0) @binding(10) var colors: texture_3d<f32>;

fn sample_x(grid: vec3f) -> f32 {
    return (fetch_at(grid) - settings.raw_origin) * settings.x_scale;
}

fn sample_rgba(grid: vec3f) -> vec4f {
    return textureSampleLevel(colors, volume_filter, grid * settings.inverse_dims, 0.0);
}
