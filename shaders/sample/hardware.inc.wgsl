// Trilinear interpolation by the adapter's filter. Twin of sample::Sampler::Hardware.
#import fetch/filter

fn sample_x(grid: vec3f) -> f32 {
    return (fetch_at(grid) - view.raw_origin) * view.x_scale;
}

fn sample_rgba(grid: vec3f) -> vec4f {
    return fetch_color_at(grid);
}
