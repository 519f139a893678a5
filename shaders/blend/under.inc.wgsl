// Opacity for the way between two slices, which is longer for rays that meet them aslant.

fn blended(color: vec4f, slant: f32) -> vec4f {
    let transparency = exp2(slant * log2(max(1.0 - color.a, 0x1p-24)));
    let a = select(1.0 - transparency, color.a, slant == 1.0 || color.a >= 1.0);
    return vec4f(color.rgb * (a / max(color.a, 1e-20)), a);
}
