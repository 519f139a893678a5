// Counters per pixel: samples, contributing samples, skip steps, and the distance to the first contributing sample
// (bits of an f32, local units from the ray's start; f32::MAX where there is none).

@group(1) @binding(1) var<storage, read_write> work: array<vec4u>;

const NO_HIT = 0x7f7fffffu;

var<private> counted: vec4u;

fn count_begin(at: u32) {
    counted = vec4u(0u, 0u, 0u, NO_HIT);
    if settings.resume != 0u {
        counted = work[at];
    }
}

fn count_skip() {
    counted.z += 1u;
}

// A look at the data that adds nothing.
fn count_probe() {
    counted.x += 1u;
}

fn count_sample(contributes: bool, k: u32, ray: Ray) {
    counted.x += 1u;
    if contributes {
        counted.y += 1u;
        let t = ray.t_box + (f32(k) + 0.5) * view.step;
        counted.w = select(counted.w, bitcast<u32>(t), counted.w == NO_HIT);
    }
}

fn count_end(at: u32) {
    work[at] = counted;
}
