// Values come from bricks (octree::Bricks, render::gpu::bricks): copies of those parts of the volume that show anything. A texel holds
// the four voxels around a cell's edge along z, so that two loads give what sample/exact takes eight for, and the same bits.
#import fetch/exact

// Where a brick's first texel lies (11 bits for x, 11 for y, and for z 10 that count bricks); or NO_BRICK.
@group(1) @binding(4) var brick_places: texture_3d<u32>;
@group(1) @binding(5) var brick_texels: texture_3d<f32>;

const NO_BRICK = 0xffffffffu;
// Of texels along z: a cell needs its own and the next, so that a brick ends with the first of the brick behind it.
const BRICK_SLICES = 5;

// The value at a grid position, unless nothing shows there: then there is no brick.
fn read_value(grid: vec3f, x: ptr<function, f32>) -> bool {
    let shifted = grid - 0.5;
    let lower = floor(shifted);
    let f = shifted - lower;
    // The first cell is the one before the first voxel.
    let cell = clamp(vec3i(lower) + 1, vec3i(0), vec3i(view.dims));
    let place = textureLoad(brick_places, cell >> vec3u(2u), 0).x;
    if place == NO_BRICK {
        return false;
    }
    let brick = vec3i(vec3u(place & 0x7ffu, place >> 11u & 0x7ffu, place >> 22u)) * vec3i(1, 1, BRICK_SLICES);
    let at = brick + (cell & vec3i(3));
    let near = textureLoad(brick_texels, at, 0);
    let far = textureLoad(brick_texels, at + vec3i(0, 0, 1), 0);
    let raw = interpolated(vec4f(near.xz, far.xz), vec4f(near.yw, far.yw), f);
    *x = (raw - view.raw_origin) * view.x_scale;
    return true;
}
