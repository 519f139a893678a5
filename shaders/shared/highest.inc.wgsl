// The highest place in the window along the ray: what mip and minip look for. The state keeps it in x.
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
