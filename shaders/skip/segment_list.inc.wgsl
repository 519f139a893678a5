// Segments listed for every pixel before the march (shaders/segments.wgsl).
#import shared/ray
#import shared/march_settings
#import step/one

// The segments [x, y) of every pixel, ascending, slot by slot; one that ends at 0 ends a list that is not full.
@group(1) @binding(3) var<storage, read> lists: array<vec2u>;

struct Segment {
    slot: u32,
    pixel: u32,
}

fn skip_begin(ray: Ray, pixel: vec2u, tile: Tile, k: u32) -> Segment {
    return Segment(0u, pixel.y * view.size.x + pixel.x);
}

fn skip_next(segment: ptr<function, Segment>, state: vec4f, ray: Ray, k: u32) -> vec2u {
    let slot = (*segment).slot;
    (*segment).slot = slot + 1u;
    var next = vec2u(0u);
    if slot < settings.ray_words / 2u {
        next = lists[slot * view.size.x * view.size.y + (*segment).pixel];
    }
    if next.y == 0u {
        return vec2u(max(k, ray.k_end));
    }
    return max(vec2u(k), next);
}
