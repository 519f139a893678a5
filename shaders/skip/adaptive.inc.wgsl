// Strides by block, as its data and the transfer function vary. Twin of skip::adaptive.
#import shared/blocks
#import step/several

struct Segment {
    // Lattice points per sample.
    stride: u32,
    way: Way,
}

fn skip_begin(ray: Ray, pixel: vec2u, tile: Tile, k: u32) -> Segment {
    return Segment(1u, way_of(ray));
}

// The samples from k on that lie in its block, as far as whole strides go; of a stride that does not fit, the largest half
// that does. A block's byte is 0 where it is empty, otherwise 1 + log2 of its stride.
fn skip_next(segment: ptr<function, Segment>, state: vec4f, ray: Ray, k: u32) -> vec2u {
    if k >= ray.k_end {
        return vec2u(k);
    }
    let at = lattice(ray, k);
    let block = block_at(at);
    let code = block_byte(block);
    let inside = min(leap((*segment).way, ray, at, block, 1.0, REACH), ray.k_end - k);
    if code == 0u {
        return vec2u(k + inside);
    }
    let log2_stride = min(code - 1u, firstLeadingBit(inside));
    (*segment).stride = 1u << log2_stride;
    return vec2u(k, k + ((inside >> log2_stride) << log2_stride));
}
