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
    let block = block_at(lattice(ray, k));
    return vec2u(next + select(1u, 0u, block_bit(block) && may_add(block, state)), next + 1u);
}
