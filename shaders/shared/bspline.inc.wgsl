// The cubic B-spline over four voxels an axis by eight trilinear fetches (Sigg & Hadwiger, GPU Gems 2, 2005): the lower two
// of four weighted neighbours are one fetch between them, the upper two another. Twin of sample::bspline.

// Rounded, a + t * (b - a) may leave a and b; what blocks promise of their samples holds only if it does not.
fn between(a: f32, b: f32, t: f32) -> f32 {
    return clamp(a + t * (b - a), min(a, b), max(a, b));
}

fn sample_x(grid: vec3f) -> f32 {
    let shifted = grid - 0.5;
    let lower = floor(shifted);
    let f = shifted - lower;
    let g = 1.0 - f;
    // Six times the weights of voxels lower - 1 to lower + 2.
    let w0 = g * g * g;
    let w1 = 4.0 + f * f * (3.0 * f - 6.0);
    let w2 = 4.0 + g * g * (3.0 * g - 6.0);
    let w3 = f * f * f;
    // Places of the two fetches, from the lower voxel of their pair; division may round up.
    let a = min(w1 / (w0 + w1), vec3f(1.0));
    let b = min(w3 / (w2 + w3), vec3f(1.0));
    let t = (w2 + w3) / 6.0;
    let low = lower - 1.0;
    let high = lower + 1.0;
    let x00 = between(fetch(low, a), fetch(vec3f(high.x, low.yz), vec3f(b.x, a.yz)), t.x);
    let x10 = between(
        fetch(vec3f(low.x, high.y, low.z), vec3f(a.x, b.y, a.z)),
        fetch(vec3f(high.xy, low.z), vec3f(b.xy, a.z)),
        t.x,
    );
    let x01 = between(fetch(vec3f(low.xy, high.z), vec3f(a.xy, b.z)), fetch(vec3f(high.x, low.y, high.z), vec3f(b.x, a.y, b.z)), t.x);
    let x11 = between(fetch(vec3f(low.x, high.yz), vec3f(a.x, b.yz)), fetch(high, b), t.x);
    let raw = between(between(x00, x10, t.y), between(x01, x11, t.y), t.z);
    return (raw - settings.raw_origin) * settings.x_scale;
}
