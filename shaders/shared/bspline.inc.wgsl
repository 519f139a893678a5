// The cubic B-spline over four voxels an axis by eight trilinear fetches (Sigg & Hadwiger, GPU Gems 2, 2005): the lower two
// of four weighted neighbours are one fetch between them, the upper two another. Twin of sample::bspline.

// Where the fetches lie, and what the upper ones weigh.
struct Fetches {
    // Lower voxels of the pairs, and how far towards the upper.
    low: vec3f,
    low_part: vec3f,
    high: vec3f,
    high_part: vec3f,
    weight: vec3f,
}

fn fetches_around(grid: vec3f) -> Fetches {
    let shifted = grid - 0.5;
    let lower = floor(shifted);
    let f = shifted - lower;
    let g = 1.0 - f;
    // Six times the weights of voxels lower - 1 to lower + 2.
    let w0 = g * g * g;
    let w1 = 4.0 + f * f * (3.0 * f - 6.0);
    let w2 = 4.0 + g * g * (3.0 * g - 6.0);
    let w3 = f * f * f;
    // Division may round up.
    let a = min(w1 / (w0 + w1), vec3f(1.0));
    let b = min(w3 / (w2 + w3), vec3f(1.0));
    return Fetches(lower - 1.0, a, lower + 1.0, b, (w2 + w3) / 6.0);
}

// Rounded, a + t * (b - a) may leave a and b; what blocks promise of their samples holds only if it does not.
fn between(a: f32, b: f32, t: f32) -> f32 {
    return clamp(a + t * (b - a), min(a, b), max(a, b));
}

fn sample_x(grid: vec3f) -> f32 {
    let at = fetches_around(grid);
    let low = at.low;
    let high = at.high;
    let a = at.low_part;
    let b = at.high_part;
    let t = at.weight;
    let x00 = between(fetch(low, a), fetch(vec3f(high.x, low.yz), vec3f(b.x, a.yz)), t.x);
    let x10 = between(
        fetch(vec3f(low.x, high.y, low.z), vec3f(a.x, b.y, a.z)),
        fetch(vec3f(high.xy, low.z), vec3f(b.xy, a.z)),
        t.x,
    );
    let x01 = between(
        fetch(vec3f(low.xy, high.z), vec3f(a.xy, b.z)),
        fetch(vec3f(high.x, low.y, high.z), vec3f(b.x, a.y, b.z)),
        t.x,
    );
    let x11 = between(fetch(vec3f(low.x, high.yz), vec3f(a.x, b.yz)), fetch(high, b), t.x);
    let raw = between(between(x00, x10, t.y), between(x01, x11, t.y), t.z);
    return (raw - view.raw_origin) * view.x_scale;
}

fn between_colors(a: vec4f, b: vec4f, t: f32) -> vec4f {
    return clamp(a + t * (b - a), min(a, b), max(a, b));
}

fn sample_rgba(grid: vec3f) -> vec4f {
    let at = fetches_around(grid);
    let low = at.low;
    let high = at.high;
    let a = at.low_part;
    let b = at.high_part;
    let t = at.weight;
    let x00 = between_colors(fetch_color(low, a), fetch_color(vec3f(high.x, low.yz), vec3f(b.x, a.yz)), t.x);
    let x10 = between_colors(
        fetch_color(vec3f(low.x, high.y, low.z), vec3f(a.x, b.y, a.z)),
        fetch_color(vec3f(high.xy, low.z), vec3f(b.xy, a.z)),
        t.x,
    );
    let x01 = between_colors(
        fetch_color(vec3f(low.xy, high.z), vec3f(a.xy, b.z)),
        fetch_color(vec3f(high.x, low.y, high.z), vec3f(b.x, a.y, b.z)),
        t.x,
    );
    let x11 = between_colors(fetch_color(vec3f(low.x, high.yz), vec3f(a.x, b.yz)), fetch_color(high, b), t.x);
    return between_colors(between_colors(x00, x10, t.y), between_colors(x01, x11, t.y), t.z);
}
