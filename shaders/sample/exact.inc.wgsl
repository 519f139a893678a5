// Trilinear interpolation, computed. Twin of sample::Sampler::Exact.
#import fetch/exact

fn sample_x(grid: vec3f) -> f32 {
    let shifted = grid - 0.5;
    let lower = floor(shifted);
    return (fetch(lower, shifted - lower) - view.raw_origin) * view.x_scale;
}

fn sample_rgba(grid: vec3f) -> vec4f {
    let shifted = grid - 0.5;
    let lower = floor(shifted);
    return fetch_color(lower, shifted - lower);
}
