// The voxel that the sample lies in. Twin of sample::Sampler::Nearest.

@group(0) @binding(5) var volume: texture_3d<f32>;
@group(0) @binding(6) var volume_filter: sampler;
// Premultiplied colour and opacity of every voxel, where they are classified before they are interpolated.
@group(0) @binding(10) var colors: texture_3d<f32>;

fn sample_x(grid: vec3f) -> f32 {
    let voxel = clamp(floor(grid), vec3f(0.0), view.dims - 1.0);
    let raw = textureLoad(volume, vec3i(voxel), 0).x;
    return (raw - view.raw_origin) * view.x_scale;
}

fn sample_rgba(grid: vec3f) -> vec4f {
    let voxel = clamp(floor(grid), vec3f(0.0), view.dims - 1.0);
    return textureLoad(colors, vec3i(voxel), 0);
}
