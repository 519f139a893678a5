// The rays of one picture, affine in the pixel, in local coordinates (box [0, extent]; unit: smallest voxel spacing), and what
// its samples are read by. Mirrors gpu::abi::View, made in f64 from lattice::RayFrame.

// lattice::MAX_CLIP_PLANES.
const MAX_CLIP_PLANES = 12u;

struct View {
    start: vec3f,
    step: f32,
    start_dx: vec3f,
    // Scale from depth along the unnormalised direction to the stored depth in [0, 1]: a power of two, so exact.
    depth_scale: f32,
    start_dy: vec3f,
    // How far rasterised rectangles are grown outward, in local units.
    grow: f32,
    dir: vec3f,
    // Edge of a leaf block in voxels.
    block: f32,
    dir_dx: vec3f,
    // Depth of the rays' start plane before the eye.
    start_depth: f32,
    dir_dy: vec3f,
    // How far a sample reaches along its ray to both sides, in steps (lattice::RayFrame::reach): 0 or 1/2.
    reach: f32,
    extent: vec3f,
    pad2: f32,
    grid_from_local: vec3f,
    pad3: f32,
    // (size - 1) / 2 of the whole picture.
    centre: vec2f,
    // Top left pixel of this tile in the whole picture.
    origin: vec2u,
    // Pixels of this tile.
    size: vec2u,
    pad4: u32,
    pad5: u32,
    clip_from_local: mat4x4f,
    // Unit normal and distance, local coordinates; what is on the normal's side is drawn. Zeros after the last.
    clip_planes: array<vec4f, MAX_CLIP_PLANES>,
    // Voxels along x, y, z.
    dims: vec3f,
    // Table coordinate of a raw texel: x = (raw - raw_origin) * x_scale.
    x_scale: f32,
    inverse_dims: vec3f,
    raw_origin: f32,
    // Leaf blocks along x, y, z.
    block_dims: vec3u,
    // Where in shared/blocks' `blocks` what follows the blocks begins, in words: majorants, or cells.
    after_blocks: u32,
    // Table entries N, and how near to an entry counts as on it.
    entries: f32,
    snap: f32,
    // Opacity at which a ray stops.
    ert: f32,
    // How near to a cell's face a sample may be read as of the cell behind it, in voxels: filters round positions.
    face: f32,
}

@group(0) @binding(0) var<uniform> view: View;

// Start and unnormalised direction of the ray through a pixel of this tile.
struct Line {
    start: vec3f,
    dir: vec3f,
}

fn line_through(pixel: vec2u) -> Line {
    let p = vec2f(pixel + view.origin) - view.centre;
    return Line(
        view.start + p.x * view.start_dx + p.y * view.start_dy,
        view.dir + p.x * view.dir_dx + p.y * view.dir_dy,
    );
}
