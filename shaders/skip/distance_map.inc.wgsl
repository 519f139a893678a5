// Leaps of the Chebyshev distance, in blocks, to the nearest active block (0: active). Twin of skip::distance_map.
#import shared/blocks
#import step/one

struct Segment {
    // Nothing is known before the march.
    unused: u32,
}

fn skip_begin(ray: Ray, pixel: vec2u, tile: Tile, k: u32) -> Segment {
    return Segment(0u);
}

// From sample k on: the sample itself where its block is active and may add something, otherwise an empty segment after the
// leap.
fn skip_next(segment: ptr<function, Segment>, state: vec4f, ray: Ray, k: u32) -> vec2u {
    let at = lattice_front(ray, k);
    let block = block_at(at);
    let distance = block_byte(block);
    let is_taken = distance == 0u && may_add(block, state);
    // An interval ends where the next begins: the last one that begins in emptiness may end beyond it.
    let whole = leap(ray, at, block, max(f32(distance), 1.0)) - u32(2.0 * view.reach);
    let free = select(whole, 0u, is_taken);
    let next = min(k, ray.k_end) + free;
    return vec2u(next, next + select(0u, 1u, free == 0u));
}
