// Emission and absorption, each sample lit by the gradient around it.
#import sample/{CLASSIFICATION}
#import shared/surface

fn mode_sample(state: ptr<function, vec4f>, x: f32, k: u32, ray: Ray) -> bool {
    var color = classify(x, k, ray);
    if all(color == vec4f(0.0)) {
        return false;
    }
    let g = gradient(lattice(ray, k));
    let length = sqrt(dot(g, g));
    // Where nothing changes there is no surface to light: the colour stays as it is.
    if length > mode.least_gradient {
        let eye = to_eye(ray);
        let n = -g / length;
        // Walls are seen from both sides.
        let light = reflected(select(n, -n, dot(n, eye) < 0.0), eye);
        color = vec4f(color.rgb * light.x + color.a * light.y, color.a);
    }
    *state = *state + (1.0 - (*state).a) * vec4f(cued(color.rgb, f32(k), ray), color.a);
    return true;
}

fn mode_done(state: vec4f) -> bool {
    return state.a >= view.ert;
}

fn mode_finish(state: vec4f, ray: Ray) -> vec4f {
    return state;
}
