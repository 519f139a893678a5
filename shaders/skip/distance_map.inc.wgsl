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

// From sample k on: the samples of its block where that is active, otherwise an empty segment after the leap.
fn skip_next(segment: ptr<function, Segment>, ray: Ray, k: u32) -> vec2u {
    let at = lattice(ray, k);
    let block = block_at(at);
    let distance = block_byte(block);
    let is_active = distance == 0u;
    let reach = select(REACH, 0.0, is_active);
    let samples = samples_before(ray, at, block, f32(max(distance, 1u)), reach);
    let next = min(k, ray.k_end) + samples;
    return select(vec2u(next), vec2u(k, min(next, ray.k_end)), is_active);
}
