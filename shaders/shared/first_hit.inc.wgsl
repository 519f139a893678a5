// The first sample inside the surface: what normals and phong look for. The state keeps its index in x, and 1 in a.
#import shared/surface

fn mode_sample(state: ptr<function, vec4f>, x: f32, k: u32, ray: Ray) -> bool {
    let hits = is_inside(x, mode.iso);
    *state = select(*state, vec4f(f32(k), 0.0, 0.0, 1.0), hits);
    return hits;
}

fn mode_done(state: vec4f) -> bool {
    return state.a > 0.0;
}
