// The rasteriser keeps the highest, whatever the way between two slices.

fn blended(color: vec4f, slant: f32) -> vec4f {
    return color;
}
