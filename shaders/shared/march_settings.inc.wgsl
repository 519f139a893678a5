// Everything a march needs besides its rays. Mirrors gpu::abi::MarchSettings.

struct MarchSettings {
    // Voxels along x, y, z.
    dims: vec3f,
    // Table coordinate of a raw texel: x = (raw - raw_origin) * x_scale.
    x_scale: f32,
    inverse_dims: vec3f,
    raw_origin: f32,
    // Table entries N, and how near to an entry counts as on it.
    entries: f32,
    snap: f32,
    // Opacity at which a ray stops.
    ert: f32,
    // Segments per ray that the bounds hold; 0, where takes_runs is too: the bounding box.
    segment_count: u32,
    // Bit i: segment i starts at the near plane, because an active block lies there.
    near_mask: u32,
    tile_count: u32,
    tiles_per_row: u32,
    // Of samples and of steps, each.
    max_iterations: u32,
    resume: u32,
    store_progress: u32,
    tile_first: u32,
    // Whether segments are the runs of the ray's tile.
    takes_runs: u32,
    // Leaf blocks along x, y, z.
    block_dims: vec3u,
    // Words for every pixel of what is found out before the march.
    ray_words: u32,
    // Where in shared/blocks' `blocks` the majorants begin, in words; not read where there are none.
    majorants: u32,
    pad1: u32,
    pad2: u32,
    pad3: u32,
}

// 8x8 pixels to march. Mirrors gpu::abi::Tile.
struct Tile {
    // Column in the low, row in the high half-word.
    at: u32,
    // Its runs: a slice of skip/bounds' `runs`.
    first_run: u32,
    run_count: u32,
    // The axis that its runs lie along; 3: its only run is the whole ray.
    axis: u32,
}

// In storage: branches are taken by it, and a driver that makes uniforms constants of its code compiles that for every frame.
@group(0) @binding(1) var<storage, read> settings: MarchSettings;
