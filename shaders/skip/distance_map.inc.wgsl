// Leaps of the Chebyshev distance, in blocks, to the nearest active block. Twin of skip::distance_map.

// Distances, x fastest, four to a word, the first in the lowest byte; 0: active.
@group(1) @binding(3) var<storage, read> blocks: array<u32>;

// How far beyond an empty block's face the sample after a leap may lie (distance_map::REACH).
const REACH = 0.4375;

struct Segment {
    // Nothing is known before the march.
    unused: u32,
}

fn skip_begin(ray: Ray, pixel: vec2u, tile: Tile) -> Segment {
    return Segment(0u);
}

// From sample k on: the sample itself where its block is active, otherwise an empty segment after the leap.
fn skip_next(segment: ptr<function, Segment>, ray: Ray, k: u32) -> vec2u {
    let at = lattice(ray, k);
    let block = clamp(floor(at / view.block), vec3f(0.0), vec3f(settings.block_dims) - 1.0);
    let cell = vec3u(block);
    let i = (cell.z * settings.block_dims.y + cell.y) * settings.block_dims.x + cell.x;
    let distance = f32(blocks[i / 4u] >> (i % 4u * 8u) & 0xffu);
    let parallel = ray.delta == vec3f(0.0);
    let face = select(
        (block + 1.0 - distance) * view.block - REACH,
        (block + distance) * view.block + REACH,
        vec3f(0.0) < ray.delta,
    );
    let samples = select((face - at) / select(ray.delta, vec3f(1.0), parallel), vec3f(1e30), parallel);
    let least = min(min(samples.x, samples.y), samples.z);
    // No farther than the ray goes: the number must fit.
    let leap = u32(clamp(ceil(least), 1.0, f32(ray.k_end) + 1.0));
    let next = min(k, ray.k_end) + select(leap, 0u, distance == 0.0);
    return vec2u(next, next + select(0u, 1u, distance == 0.0));
}
