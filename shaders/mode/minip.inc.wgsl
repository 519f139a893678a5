// Minimum intensity projection: black, as opaque as the lowest value lies below the upper end of the window (which is
// what this window measures: mode::Parameters).
#import shared/window

fn mode_sample(state: ptr<function, vec4f>, x: f32, k: u32, ray: Ray) -> bool {
    let v = in_window(x);
    let is_more = (*state).x < v;
    (*state).x = max((*state).x, v);
    return is_more;
}

// Nothing is brighter than the window's end.
fn mode_done(state: vec4f) -> bool {
    return state.x >= 1.0;
}

fn mode_finish(state: vec4f, ray: Ray) -> vec4f {
    return vec4f(vec3f(0.0), state.x);
}
