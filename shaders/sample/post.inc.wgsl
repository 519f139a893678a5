// Post-classification: the interpolated value is looked up. Twin of transfer::lookup.

@group(0) @binding(7) var<storage, read> table: array<vec4f>;

fn classify(x: f32, k: u32, ray: Ray) -> vec4f {
    let clamped = clamp(x, 0.0, view.entries - 1.0);
    let nearest = floor(clamped + 0.5);
    let snapped = select(clamped, nearest, abs(clamped - nearest) < view.snap);
    let lower = floor(snapped);
    let i = u32(lower);
    let a = table[i];
    let b = table[min(i + 1u, u32(view.entries) - 1u)];
    return a + (snapped - lower) * (b - a);
}
