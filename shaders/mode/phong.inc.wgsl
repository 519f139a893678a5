// The first surface, lit.
#import shared/surface

fn mode_sample(state: ptr<function, vec4f>, x: f32, k: u32, ray: Ray) -> bool {
    if !is_inside(x, mode.iso) {
        return false;
    }
    *state = vec4f(lit_surface(ray, k), 1.0);
    return true;
}

fn mode_done(state: vec4f) -> bool {
    return state.a >= 1.0;
}

fn mode_finish(state: vec4f, ray: Ray) -> vec4f {
    return state;
}
