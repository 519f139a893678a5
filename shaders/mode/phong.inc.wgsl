// The first surface, lit. The state keeps the sample that hit it and 1; it is lit once, at the end.
#import shared/first_hit

fn mode_finish(state: vec4f, ray: Ray) -> vec4f {
    if state.a == 0.0 {
        return vec4f(0.0);
    }
    return vec4f(lit_surface(ray, u32(state.x)), 1.0);
}
