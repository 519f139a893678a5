// The bounding box, position by position: one in an empty block is neither loaded nor accumulated. Twin of
// skip::octree_encoded.
#import shared/blocks
#import step/one

struct Segment {
    // Nothing is known before the march.
    unused: u32,
}

fn skip_begin(ray: Ray, pixel: vec2u, tile: Tile, k: u32) -> Segment {
    return Segment(0u);
}

// Sample k where its block is active and may add something, otherwise the empty segment after it.
fn skip_next(segment: ptr<function, Segment>, state: vec4f, ray: Ray, k: u32) -> vec2u {
    let next = min(k, ray.k_end);
    let begin = lattice_front(ray, k);
    let front = block_at(begin);
    var is_active = block_bit(front) && may_add(front, state);
    // Where a sample is an interval. Not asked of `view.reach` itself: see shared/march_settings.
    if any(begin != lattice(ray, k)) {
        // What lies between the values of two blocks that touch is theirs too: their supports overlap.
        let back = block_at(lattice_front(ray, k + 1u));
        is_active = is_active || block_bit(back) || any(abs(back - front) > vec3f(1.0));
    }
    return vec2u(next + select(1u, 0u, is_active), next + 1u);
}
