// What steers a march. Mirrors gpu::abi::MarchSettings.

struct MarchSettings {
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
    // Words for every pixel of what is found out before the march.
    ray_words: u32,
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
// What every sample reads is in the view: Mesa's software driver loads from storage lane by lane, from uniforms once for all.
@group(0) @binding(1) var<storage, read> settings: MarchSettings;
