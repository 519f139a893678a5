// One sample stands for its segment's stride of lattice points and lies in their middle: the mode takes it as often. Twin
// of skip::adaptive.

// See march: samples are as far apart as their segment says.
const SEGMENTS_AHEAD = 1u;

fn step_sample(state: ptr<function, vec4f>, segment: ptr<function, Segment>, k: u32, ray: Ray) -> bool {
    let stride = (*segment).stride;
    let x = sample_x(ray.entry + (f32(k) + 0.5 * f32(stride)) * ray.delta);
    var contributes = false;
    for (var i = 0u; i < stride; i += 1u) {
        contributes = mode_sample(state, x, k + i, ray) || contributes;
    }
    return contributes;
}

fn step_length(segment: ptr<function, Segment>) -> u32 {
    return (*segment).stride;
}
