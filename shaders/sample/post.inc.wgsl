// Post-classification: the interpolated value is looked up. Twin of transfer::lookup.

@group(0) @binding(7) var<storage, read> table: array<vec4f>;

fn post_classify(x_raw: f32) -> vec4f {
    let clamped = clamp(x_raw, 0.0, settings.entries - 1.0);
    let nearest = floor(clamped + 0.5);
    let x = select(clamped, nearest, abs(clamped - nearest) < settings.snap);
    let lower = floor(x);
    let i = u32(lower);
    let a = table[i];
    let b = table[min(i + 1u, u32(settings.entries) - 1u)];
    return a + (x - lower) * (b - a);
}
