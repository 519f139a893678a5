// One sample stands for one point of the lattice: every lossless method.

// See march.
const SEGMENTS_AHEAD = 5u;

fn step_sample(state: ptr<function, vec4f>, segment: ptr<function, Segment>, k: u32, ray: Ray) -> bool {
    return mode_sample(state, sample_x(lattice(ray, k)), k, ray);
}

fn step_length(segment: ptr<function, Segment>) -> u32 {
    return 1u;
}
