// A translucent surface before a lit one. The state keeps the sample that hit the inner one, the outer one's opacity once
// that is hit, the sample that hit it, and 1 once the inner one is.
#import shared/surface

fn mode_sample(state: ptr<function, vec4f>, x: f32, k: u32, ray: Ray) -> bool {
    let hits_outer = (*state).y == 0.0 && is_inside(x, mode.outer_iso);
    (*state).y = select((*state).y, mode.outer_color.a, hits_outer);
    (*state).z = select((*state).z, f32(k), hits_outer);
    let hits_inner = (*state).y < 1.0 && is_inside(x, mode.iso);
    *state = select(*state, vec4f(f32(k), (*state).yz, 1.0), hits_inner);
    return hits_outer || hits_inner;
}

fn mode_done(state: vec4f) -> bool {
    return max(state.y, state.a) >= 1.0;
}

fn mode_finish(state: vec4f, ray: Ray) -> vec4f {
    if state.y == 0.0 {
        return vec4f(0.0);
    }
    let color = cued_surface(mode.outer_color.rgb, ray, u32(state.z), mode.outer_iso);
    let outer = vec4f(color, 1.0) * state.y;
    if state.a == 0.0 {
        return outer;
    }
    return outer + (1.0 - state.y) * vec4f(lit_surface(ray, u32(state.x)), 1.0);
}
