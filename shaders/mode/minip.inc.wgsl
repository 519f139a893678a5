// Minimum intensity projection: black, as opaque as the lowest value lies below the upper end of the window (which is
// what this window measures: mode::Parameters).
#import shared/highest

fn mode_finish(state: vec4f, ray: Ray) -> vec4f {
    return vec4f(vec3f(0.0), state.x);
}
