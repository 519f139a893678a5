// The first surface, its normal (local axes, -1 to 1) as colour (0 to 1). The state keeps the sample that hit it and 1;
// where exactly it lies, and how, is found once, at the end.
#import shared/first_hit

fn mode_finish(state: vec4f, ray: Ray) -> vec4f {
    if state.a == 0.0 {
        return vec4f(0.0);
    }
    let normal = surface_normal(ray, u32(state.x), to_eye(ray));
    return vec4f(0.5 + 0.5 * normal, 1.0);
}
