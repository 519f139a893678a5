// What a ray has seen tells nothing of the blocks to come.

// See march.
const BLOCKS_AHEAD = 5u;

fn may_add(block: vec3f, state: vec4f) -> bool {
    return true;
}
