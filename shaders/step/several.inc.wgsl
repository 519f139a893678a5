// One sample stands for its segment's stride of lattice points (a power of two) and lies in their middle. Twin of
// skip::adaptive.

fn step_at(segment: ptr<function, Segment>, ray: Ray, k: u32) -> vec3f {
    return ray.entry + (f32(k) + 0.5 * f32((*segment).stride)) * ray.delta;
}

// Composited with itself as often as the stride doubles: 1 - (1 - a)^stride (adaptive::over_stride).
fn step_color(segment: ptr<function, Segment>, color: vec4f) -> vec4f {
    var sum = color;
    for (var stride = (*segment).stride; stride > 1u; stride /= 2u) {
        sum *= 2.0 - sum.a;
    }
    return sum;
}

fn step_length(segment: ptr<function, Segment>) -> u32 {
    return (*segment).stride;
}
