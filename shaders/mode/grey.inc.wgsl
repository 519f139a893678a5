// Emission and absorption without a table: the place in the window is grey value and opacity per voxel alike.
#import shared/window
#import cue/{CUE}

fn mode_sample(state: ptr<function, vec4f>, x: f32, k: u32, ray: Ray) -> bool {
    let v = in_window(x);
    if v <= 0.0 {
        return false;
    }
    // 1 - (1 - v)^ratio; what is all but opaque counts as opaque, so that no logarithm is infinite.
    let transparency = exp2(mode.opacity_ratio * log2(max(1.0 - v, 0x1p-24)));
    let a = select(max(1.0 - transparency, 0.0), 1.0, v >= 1.0);
    *state = *state + (1.0 - (*state).a) * vec4f(cued(vec3f(v * a), f32(k), ray), a);
    return true;
}

fn mode_done(state: vec4f) -> bool {
    return state.a >= view.ert;
}

fn mode_finish(state: vec4f, ray: Ray) -> vec4f {
    return state;
}
