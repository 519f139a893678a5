// One sample stands for one point of the lattice: every lossless method.
#import store/{STORE}

// See march.
const SEGMENTS_AHEAD = 5u;

fn step_sample(state: ptr<function, vec4f>, segment: ptr<function, Segment>, k: u32, ray: Ray) -> bool {
    var x: f32;
    if !read_value(lattice(ray, k), &x) {
        return false;
    }
    return mode_sample(state, x, k, ray);
}

fn step_length(segment: ptr<function, Segment>) -> u32 {
    return 1u;
}
