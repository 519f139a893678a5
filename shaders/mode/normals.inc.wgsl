// The first surface, its normal (local axes, -1 to 1) as colour (0 to 1). The state keeps the sample that hit it and 1;
// where exactly it lies, and how, is found once, at the end.
#import shared/surface

fn mode_sample(state: ptr<function, vec4f>, x: f32, k: u32, ray: Ray) -> bool {
    let hits = is_inside(x, mode.iso);
    *state = select(*state, vec4f(f32(k), 0.0, 0.0, 1.0), hits);
    return hits;
}

fn mode_done(state: vec4f) -> bool {
    return state.a > 0.0;
}

fn mode_finish(state: vec4f, ray: Ray) -> vec4f {
    if state.a == 0.0 {
        return vec4f(0.0);
    }
    let normal = surface_normal(ray, u32(state.x), to_eye(ray));
    return vec4f(0.5 + 0.5 * normal, 1.0);
}
