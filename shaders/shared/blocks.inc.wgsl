// What methods with a shader of their own know of every leaf block, and where a ray leaves one.
#import shared/ray
#import shared/march_settings
#import bound/{BOUND}

// Bits as octree::Occupancy has them, or bytes, x fastest, the first in a word's lowest bits; after them, where a mode is
// bounded, the majorants as bytes.
@group(1) @binding(3) var<storage, read> blocks: array<u32>;

// How far beyond an empty block's face the sample after a leap may lie (distance_map::REACH).
const REACH = 0.4375;

// The block that a grid position lies in; the outermost reach outwards without end.
fn block_at(at: vec3f) -> vec3f {
    return clamp(floor(at / view.block), vec3f(0.0), vec3f(view.block_dims) - 1.0);
}

// Whether a block is active, where `blocks` holds bits. Rows start on a 64-bit word.
fn block_bit(block: vec3f) -> bool {
    let b = vec3u(block);
    let row = (view.block_dims.x + 63u) / 64u * 2u;
    let word = (b.z * view.block_dims.y + b.y) * row + b.x / 32u;
    return ((blocks[word] >> (b.x % 32u)) & 1u) != 0u;
}

// What is known of a block, where `blocks` holds bytes.
fn block_byte(block: vec3f) -> u32 {
    let b = vec3u(block);
    let i = (b.z * view.block_dims.y + b.y) * view.block_dims.x + b.x;
    return (blocks[i / 4u] >> (i % 4u * 8u)) & 0xffu;
}

// How a ray goes through blocks.
struct Way {
    // Samples per voxel along each axis; 1e30 where the ray is parallel.
    inverse: vec3f,
    // 1 or -1: where it goes.
    direction: vec3f,
    // 0 or 1: which face of a block it comes from.
    behind: vec3f,
}

fn way_of(ray: Ray) -> Way {
    let parallel = ray.delta == vec3f(0.0);
    let inverse = select(1.0 / select(ray.delta, vec3f(1.0), parallel), vec3f(1e30), parallel);
    let behind = select(vec3f(0.0), vec3f(1.0), ray.delta < vec3f(0.0));
    return Way(inverse, 1.0 - 2.0 * behind, behind);
}

// How many samples on from the one at `at` are certain to lie less than `distance` blocks and `reach` voxels from `block`,
// which it lies in; that one included. Twin of distance_map::leap.
fn leap(way: Way, ray: Ray, at: vec3f, block: vec3f, distance: f32, reach: f32) -> u32 {
    let face = (block + way.behind) * view.block + (distance * view.block + reach) * way.direction;
    let samples = (face - at) * way.inverse;
    let least = min(min(samples.x, samples.y), samples.z);
    // No farther than the ray goes: the number must fit.
    return u32(clamp(ceil(least), 1.0, f32(ray.k_end) + 1.0));
}
