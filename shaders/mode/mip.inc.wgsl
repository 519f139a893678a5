// Maximum intensity projection: white, as opaque as the highest place in the window.
#import shared/highest

fn mode_finish(state: vec4f, ray: Ray) -> vec4f {
    return vec4f(state.x);
}
