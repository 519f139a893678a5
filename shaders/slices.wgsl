// Polygons across the view through the volume: each fragment is a ray of one sample, and the rasteriser blends what the mode
// makes of it.
#import shared/ray
#import shared/march_settings
#import sample/{SAMPLER}
#import mode/{MODE}
#import blend/{BLEND}

struct Corner {
    @builtin(position) position: vec4f,
    // Of the slice, from the eye along the view: the same at all corners.
    @location(0) @interpolate(flat) depth: f32,
}

@vertex
fn vertex(@location(0) local: vec3f, @location(1) depth: f32) -> Corner {
    return Corner(view.clip_from_local * vec4f(local, 1.0), depth);
}

// The pixel of a ray whose only sample lies on the slice, how aslant it meets the slice, and whether the sample contributes.
struct Fragment {
    color: vec4f,
    slant: f32,
    contributes: bool,
}

fn fragment_of(corner: Corner) -> Fragment {
    let l = line_through(vec2u(corner.position.xy));
    let at = (l.start + (corner.depth - view.start_depth) * l.dir) * view.grid_from_local;
    // From halfway to the slice before to halfway to the one behind.
    var ray: Ray;
    ray.delta = view.step * l.dir * view.grid_from_local;
    ray.entry = at - 0.5 * ray.delta;
    ray.drawn = vec2f(0.0, 1.0);
    var state = vec4f(0.0);
    let contributes = mode_sample(&state, sample_x(at), 0u, ray);
    return Fragment(mode_finish(state, ray), length(l.dir), contributes);
}

@fragment
fn color(corner: Corner) -> @location(0) vec4f {
    let fragment = fragment_of(corner);
    return blended(fragment.color, fragment.slant);
}

// One for the sample, and one more where it contributes: added up.
@fragment
fn count(corner: Corner) -> @location(0) vec4f {
    return vec4f(1.0, select(0.0, 1.0, fragment_of(corner).contributes), 0.0, 0.0);
}
