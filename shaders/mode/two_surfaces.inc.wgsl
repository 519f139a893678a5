// A translucent surface before a lit one: opacity tells what has been crossed, for the outer one's is above 0 and the
// inner one is opaque.
#import shared/surface

fn mode_sample(state: ptr<function, vec4f>, x: f32, k: u32, ray: Ray) -> bool {
    let meets_outer = (*state).a == 0.0 && is_inside(x, mode.outer_iso);
    if meets_outer {
        *state = vec4f(mode.outer_color.rgb * mode.outer_color.a, mode.outer_color.a);
    }
    let meets_inner = (*state).a < 1.0 && is_inside(x, mode.iso);
    if meets_inner {
        *state = vec4f((*state).rgb + (1.0 - (*state).a) * lit_surface(ray, k), 1.0);
    }
    return meets_outer || meets_inner;
}

fn mode_done(state: vec4f) -> bool {
    return state.a >= 1.0;
}

fn mode_finish(state: vec4f, ray: Ray) -> vec4f {
    return state;
}
