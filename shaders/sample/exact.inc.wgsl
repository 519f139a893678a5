// Trilinear interpolation, computed. Twin of sample::Sampler::Exact.
#import fetch/exact

// Premultiplied colour and opacity of every voxel, where they are classified before they are interpolated.
@group(0) @binding(10) var colors: texture_3d<f32>;

fn sample_x(grid: vec3f) -> f32 {
    let shifted = grid - 0.5;
    let lower = floor(shifted);
    return (fetch(lower, shifted - lower) - settings.raw_origin) * settings.x_scale;
}

fn color(x: i32, y: i32, z: i32) -> vec4f {
    return textureLoad(colors, vec3i(x, y, z), 0);
}

fn sample_rgba(grid: vec3f) -> vec4f {
    let shifted = grid - 0.5;
    let lower = floor(shifted);
    let f = shifted - lower;
    let last = settings.dims - 1.0;
    let a = vec3i(clamp(lower, vec3f(0.0), last));
    let b = vec3i(clamp(lower + 1.0, vec3f(0.0), last));
    let x00 = along(color(a.x, a.y, a.z), color(b.x, a.y, a.z), f.x);
    let x10 = along(color(a.x, b.y, a.z), color(b.x, b.y, a.z), f.x);
    let x01 = along(color(a.x, a.y, b.z), color(b.x, a.y, b.z), f.x);
    let x11 = along(color(a.x, b.y, b.z), color(b.x, b.y, b.z), f.x);
    return along(along(x00, x10, f.y), along(x01, x11, f.y), f.z);
}

fn along(a: vec4f, b: vec4f, f: f32) -> vec4f {
    return a + f * (b - a);
}
