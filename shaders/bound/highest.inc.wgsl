// The highest place in the window that a block can have against the highest that the ray has seen, which mip and minip keep
// in state.x: a block that lies no higher adds nothing. Twin of skip::Majorants.
#import shared/blocks

// See march: what a ray has seen decides.
const BLOCKS_AHEAD = 1u;

// The byte of a block that reaches the window's end (majorants::FULL).
const FULL = 254.0;

fn may_add(block: vec3f, state: vec4f) -> bool {
    let b = vec3u(block);
    let i = (b.z * view.block_dims.y + b.y) * view.block_dims.x + b.x;
    let byte = (blocks[view.after_blocks + i / 4u] >> (i % 4u * 8u)) & 0xffu;
    return state.x * FULL < f32(byte);
}
