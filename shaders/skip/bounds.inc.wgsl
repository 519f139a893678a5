// Segments known before the march: the bounding box, or the rasterised bounds of each part of the volume, near part
// first. Used by box, hull and half-split, which share one compiled pipeline so that they share every bit.

// Depth layers 2i and 2i + 1: entry and exit of segment i, in depth along the unnormalised direction times depth_scale.
@group(1) @binding(0) var bounds: texture_depth_2d_array;

struct Segment {
    index: u32,
    pixel: vec2u,
    // Samples per stored depth, and the box's entry in samples.
    scale: f32,
    offset: f32,
}

fn skip_begin(ray: Ray, pixel: vec2u) -> Segment {
    let scale = ray.length / (view.depth_scale * view.step);
    return Segment(0u, pixel, scale, ray.t_box / view.step + 0.5);
}

// The next segment [x, y) at or after sample k; empty at the end of the ray.
fn skip_next(segment: ptr<function, Segment>, ray: Ray, k: u32) -> vec2u {
    var first = k;
    var end = ray.k_end;
    if settings.segment_count == 0u {
        return vec2u(first, end);
    }
    var found = false;
    while !found && (*segment).index < settings.segment_count {
        let i = (*segment).index;
        (*segment).index = i + 1u;
        let entry = textureLoad(bounds, (*segment).pixel, 2u * i, 0);
        let exit = textureLoad(bounds, (*segment).pixel, 2u * i + 1u, 0);
        // One sample more at each end: the rasteriser rounds.
        let k_entry = max(ceil(entry * (*segment).scale - (*segment).offset) - 1.0, 0.0);
        let k_exit = max(ceil(exit * (*segment).scale - (*segment).offset) + 1.0, 0.0);
        let starts_near = (settings.near_mask >> i & 1u) != 0u;
        first = max(k, select(u32(k_entry), ray.k_near, starts_near));
        // An exit of zero was never drawn.
        end = select(0u, min(u32(k_exit), ray.k_end), exit > 0.0);
        found = first < end;
    }
    return select(vec2u(0u), vec2u(first, end), found);
}
