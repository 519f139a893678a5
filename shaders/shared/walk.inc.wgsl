// A walk from block to block by index (Amanatides & Woo 1987). Where it leaves a block follows from the index of the plane:
// nothing accumulates and nothing is nudged. Twin of skip::grid_dda.
#import shared/blocks

struct Segment {
    // The block that the walk has come to.
    block: vec3f,
    // Samples per voxel, by axis; 1 where the ray is parallel.
    inverse: vec3f,
}

fn skip_begin(ray: Ray, pixel: vec2u, tile: Tile, k: u32) -> Segment {
    let parallel = ray.delta == vec3f(0.0);
    return Segment(block_at(lattice_front(ray, k)), 1.0 / select(ray.delta, vec3f(1.0), parallel));
}

// The samples from k on that lie before the block's end, or the empty segment there; and on to the next block. A sample on
// a face, or one that rounding put there, counts as of either side: an inactive block answers for half a voxel around it.
fn skip_next(segment: ptr<function, Segment>, state: vec4f, ray: Ray, k: u32) -> vec2u {
    const FAR = 1e30;
    let block = (*segment).block;
    let forward = vec3f(0.0) < ray.delta;
    let next = block + select(vec3f(-1.0), vec3f(1.0), forward);
    // Outermost blocks reach outwards without end.
    let stays = (ray.delta == vec3f(0.0)) | (next < vec3f(0.0)) | (vec3f(view.block_dims) <= next);
    let plane = max(block, next);
    let leave = select((plane * view.block - ray.entry) * (*segment).inverse - 0.5, vec3f(FAR), stays);
    let least = min(min(leave.x, leave.y), leave.z);
    (*segment).block = select(block, next, (leave <= vec3f(least)) & !stays);
    let is_active = block_bit(block) && may_add(block, state);
    // Samples that reach from one block into the next are the active one's.
    let before = ceil(least + select(-view.reach, view.reach, is_active));
    let end = max(k, u32(clamp(before, 0.0, f32(ray.k_end))));
    return vec2u(select(end, k, is_active), end);
}
