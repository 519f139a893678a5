// Leaps of the Chebyshev distance, in blocks, to the nearest active block (0: active). Twin of skip::distance_map.
#import shared/blocks
#import step/one

struct Segment {
    way: Way,
}

fn skip_begin(ray: Ray, pixel: vec2u, tile: Tile, k: u32) -> Segment {
    return Segment(way_of(ray));
}

// From sample k on: those in its block where that is active and may add something, otherwise the empty segment after the
// leap.
fn skip_next(segment: ptr<function, Segment>, state: vec4f, ray: Ray, k: u32) -> vec2u {
    let at = lattice_front(ray, k);
    let block = block_at(at);
    let distance = block_byte(block);
    let is_taken = distance == 0u && may_add(block, state);
    let whole = leap((*segment).way, ray, at, block, max(f32(distance), 1.0), select(REACH, 0.0, is_taken));
    // An interval ends where the next begins: the last one that begins in emptiness may end beyond it.
    let free = select(whole - u32(2.0 * view.reach), 0u, is_taken);
    let taken = select(u32(free == 0u), whole, is_taken);
    let next = k + free;
    return min(vec2u(next, next + taken), vec2u(ray.k_end));
}
