// Lays the picture over a target of the caller's, and the depth of the first contributing sample into a second one.
#import shared/view

@group(0) @binding(1) var<storage, read> target_rgba: array<vec4f>;
// As count/on writes it; one element where no depth is wanted.
@group(0) @binding(2) var<storage, read> work: array<vec4u>;

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    // One triangle that covers the viewport.
    let corner = vec2f(vec2u(index << 1u, index) & vec2u(2u));
    return vec4f(corner * 2.0 - 1.0, 0.0, 1.0);
}

fn index_of(position: vec4f) -> u32 {
    let pixel = vec2u(position.xy) - view.origin;
    return pixel.y * view.size.x + pixel.x;
}

@fragment
fn color(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return target_rgba[index_of(position)];
}

struct ColorAndDepth {
    @location(0) color: vec4f,
    @location(1) depth: f32,
}

@fragment
fn color_and_depth(@builtin(position) position: vec4f) -> ColorAndDepth {
    let at = index_of(position);
    let l = line_through(vec2u(position.xy) - view.origin);
    let t = bitcast<f32>(work[at].w);
    // From distance along the ray to depth along the view, measured from the eye.
    let depth = select(t / length(l.dir) + view.start_depth, t, work[at].y == 0u);
    return ColorAndDepth(target_rgba[at], depth);
}
