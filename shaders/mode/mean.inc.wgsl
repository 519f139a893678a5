// The mean place in the window over all samples of the ray inside the box, taken or left out, as the opacity of white.
#import shared/window

fn mode_sample(state: ptr<function, vec4f>, x: f32, k: u32, ray: Ray) -> bool {
    let v = in_window(x);
    (*state).x += v;
    return v > 0.0;
}

fn mode_done(state: vec4f) -> bool {
    return false;
}

fn mode_finish(state: vec4f, ray: Ray) -> vec4f {
    let samples = f32(ray.k_end - min(ray.k_near, ray.k_end));
    return vec4f(state.x / max(samples, 1.0));
}
