// Emission and absorption, front to back, premultiplied (Yu et al. 2016, equations 6 and 7). Twin of
// mode::emission_absorption::State.
#import sample/{CLASSIFICATION}
#import cue/{CUE}

fn mode_sample(state: ptr<function, vec4f>, x: f32, k: u32, ray: Ray) -> bool {
    let color = classify(x, k, ray);
    *state = *state + (1.0 - (*state).a) * vec4f(cued(color.rgb, f32(k), ray), color.a);
    return any(color != vec4f(0.0));
}

fn mode_done(state: vec4f) -> bool {
    return state.a >= view.ert;
}

fn mode_finish(state: vec4f, ray: Ray) -> vec4f {
    return state;
}
