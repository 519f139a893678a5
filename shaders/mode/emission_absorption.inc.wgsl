// Emission and absorption, front to back, premultiplied (Yu et al. 2016, equations 6 and 7). Twin of
// mode::emission_absorption::State.

fn mode_init() -> vec4f {
    return vec4f(0.0);
}

fn mode_load(stored: vec4f) -> vec4f {
    return stored;
}

fn mode_add(sum: vec4f, sample: vec4f) -> vec4f {
    return sum + (1.0 - sum.a) * sample;
}

fn mode_done(sum: vec4f) -> bool {
    return sum.a >= settings.ert;
}

fn mode_store(sum: vec4f) -> vec4f {
    return sum;
}
