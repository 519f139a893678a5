// Trilinear interpolation by the adapter's filter. Twin of sample::Sampler::Hardware.
#import fetch/filter

fn sample_x(grid: vec3f) -> f32 {
    return (fetch_at(grid) - settings.raw_origin) * settings.x_scale;
}
