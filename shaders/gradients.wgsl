// Fills a volume of gradients: to each cell the mean of its voxels' central differences. Twin of sample::gradients::of_cell.

// Mirrors gpu::abi::GradientCells.
struct GradientCells {
    // Edge of a cell in voxels.
    edge: u32,
    // What raw differences are multiplied by, so that half floats hold them.
    scale: f32,
    // Layer of cells that this dispatch begins with.
    first_layer: u32,
    pad1: u32,
}

@group(0) @binding(0) var<uniform> cells: GradientCells;
@group(0) @binding(1) var volume: texture_3d<f32>;
@group(0) @binding(2) var gradient_volume: texture_storage_3d<rgba16float, write>;

fn raw(at: vec3i) -> f32 {
    let last = vec3i(textureDimensions(volume)) - 1;
    return textureLoad(volume, clamp(at, vec3i(0), last), 0).x;
}

@compute @workgroup_size(4, 4, 4)
fn gradients(@builtin(global_invocation_id) id: vec3u) {
    let cell = id + vec3u(0u, 0u, cells.first_layer);
    if any(cell >= textureDimensions(gradient_volume)) {
        return;
    }
    let first = vec3i(cell * cells.edge);
    let end = min(first + i32(cells.edge), vec3i(textureDimensions(volume)));
    var sum = vec3f(0.0);
    for (var z = first.z; z < end.z; z += 1) {
        for (var y = first.y; y < end.y; y += 1) {
            for (var x = first.x; x < end.x; x += 1) {
                let at = vec3i(x, y, z);
                sum += vec3f(
                    raw(at + vec3i(1, 0, 0)) - raw(at - vec3i(1, 0, 0)),
                    raw(at + vec3i(0, 1, 0)) - raw(at - vec3i(0, 1, 0)),
                    raw(at + vec3i(0, 0, 1)) - raw(at - vec3i(0, 0, 1)),
                );
            }
        }
    }
    let voxels = end - first;
    let mean = sum / f32(voxels.x * voxels.y * voxels.z);
    textureStore(gradient_volume, cell, vec4f(mean * cells.scale, 0.0));
}
