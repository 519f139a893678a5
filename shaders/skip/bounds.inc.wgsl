// Segments known before the march: the bounding box, the rasterised bounds of each part of the volume, near part first, or
// the runs of active layers of the ray's tile. Used by box, hull, half-split and beam-masks, which share one compiled
// pipeline so that they share every bit.
#import step/one

// Depth layers 2i and 2i + 1: entry and exit of segment i, in depth along the unnormalised direction times depth_scale.
@group(1) @binding(0) var bounds: texture_depth_2d_array;
// Where runs begin and end along their tile's axis, in grid coordinates and in the order of the rays.
@group(1) @binding(2) var<storage, read> runs: array<vec2f>;

struct Segment {
    // The next segment, and the end of their list.
    index: u32,
    end: u32,
    pixel: vec2u,
    // A bound b lies at sample b * scale - offset, give or take pad samples.
    scale: f32,
    offset: f32,
    pad: f32,
}

fn skip_begin(ray: Ray, pixel: vec2u, tile: Tile, k: u32) -> Segment {
    if settings.takes_runs == 0u {
        let scale = ray.length / (view.depth_scale * view.step);
        // One sample more at each end: the rasteriser rounds.
        return Segment(0u, settings.segment_count, pixel, scale, ray.t_box / view.step + 0.5, 1.0 + view.reach);
    }
    let along = vec3u(0u, 1u, 2u) == vec3u(tile.axis);
    let delta = dot(select(vec3f(0.0), ray.delta, along), vec3f(1.0));
    // Runs along no axis begin and end beyond every ray, whatever the scale.
    let scale = select(1.0 / delta, 1.0, delta == 0.0);
    let entry = dot(select(vec3f(0.0), ray.entry, along), vec3f(1.0));
    let voxels = dot(select(vec3f(0.0), view.dims, along), vec3f(1.0));
    // Roundings of the crossing and of the sample's own position: some twelve of 2^-24 over the whole axis, doubled.
    let pad = view.reach + 0x1p-9 + abs(voxels * scale) * 0x1p-19;
    return Segment(tile.first_run, tile.first_run + tile.run_count, pixel, scale, entry * scale + 0.5, pad);
}

// The next segment [x, y) at or after sample k; from the ray's end on where there is none.
fn skip_next(segment: ptr<function, Segment>, state: vec4f, ray: Ray, k: u32) -> vec2u {
    if settings.segment_count + settings.takes_runs == 0u {
        return vec2u(k, ray.k_end);
    }
    var first = k;
    var end = 0u;
    var found = false;
    while !found && (*segment).index < (*segment).end {
        let i = (*segment).index;
        (*segment).index = i + 1u;
        var bound: vec2f;
        var starts_near = false;
        if settings.takes_runs != 0u {
            bound = runs[i];
        } else {
            bound.x = textureLoad(bounds, (*segment).pixel, 2u * i, 0);
            bound.y = textureLoad(bounds, (*segment).pixel, 2u * i + 1u, 0);
            starts_near = (settings.near_mask >> i & 1u) != 0u;
        }
        let at = bound * (*segment).scale - (*segment).offset;
        let k_entry = clamp(ceil(at.x - (*segment).pad), 0.0, f32(ray.k_end));
        let k_exit = clamp(ceil(at.y + (*segment).pad), 0.0, f32(ray.k_end));
        first = max(k, select(u32(k_entry), ray.k_near, starts_near));
        // An exit of zero was never drawn.
        end = select(u32(k_exit), 0u, settings.takes_runs == 0u && bound.y <= 0.0);
        found = first < end;
    }
    return select(vec2u(max(k, ray.k_end)), vec2u(first, end), found);
}
