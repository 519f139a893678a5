// Pre-integration (Engel, Kraus & Ertl 2001): the values at both ends of the sample's interval are looked up together, in
// a table of all pairs. Twin of sample::pre_integrated.

// entries * entries: from value `front` to value `back` at front * entries + back.
@group(0) @binding(7) var<storage, read> pairs: array<vec4f>;

// The end of an interval is the beginning of the next: its value is kept.
var<private> kept_x: f32;
// The interval that begins with it; none yet.
var<private> kept_k: u32 = 0xffffffffu;

fn interval_end(ray: Ray, k: u32) -> vec3f {
    return ray.entry + clamp(f32(k), ray.drawn.x, ray.drawn.y) * ray.delta;
}

// A value on the table, snapped to an entry as classification after interpolation does.
fn on_table(x: f32) -> f32 {
    let clamped = clamp(x, 0.0, view.entries - 1.0);
    let nearest = floor(clamped + 0.5);
    return select(clamped, nearest, abs(clamped - nearest) < view.snap);
}

fn classify(x: f32, k: u32, ray: Ray) -> vec4f {
    if kept_k != k {
        kept_x = on_table(sample_x(interval_end(ray, k)));
    }
    let front = kept_x;
    let back = on_table(sample_x(interval_end(ray, k + 1u)));
    kept_x = back;
    kept_k = k + 1u;

    let n = u32(view.entries);
    let i = vec2u(u32(front), u32(back));
    let f = vec2f(front, back) - floor(vec2f(front, back));
    let next = min(i + 1u, vec2u(n - 1u));
    let low = mix_pair(pairs[i.x * n + i.y], pairs[i.x * n + next.y], f.y);
    let high = mix_pair(pairs[next.x * n + i.y], pairs[next.x * n + next.y], f.y);
    return mix_pair(low, high, f.x);
}

// a + f * (b - a) is a exactly where f is 0.
fn mix_pair(a: vec4f, b: vec4f, f: f32) -> vec4f {
    return a + f * (b - a);
}
