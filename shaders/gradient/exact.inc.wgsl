// Gradients from a volume of them, by eight loads and f32 interpolation. Twin of sample::gradients::interpolated.

@group(0) @binding(9) var gradient_volume: texture_3d<f32>;

fn stored_gradient(x: i32, y: i32, z: i32) -> vec3f {
    return textureLoad(gradient_volume, vec3i(x, y, z), 0).xyz;
}

// Over two voxels, per local unit, of data values (in units of the table).
fn gradient(at: vec3f) -> vec3f {
    let shifted = at * mode.cells_per_voxel - 0.5;
    let lower = floor(shifted);
    let f = shifted - lower;
    let last = vec3f(textureDimensions(gradient_volume)) - 1.0;
    let a = vec3i(clamp(lower, vec3f(0.0), last));
    let b = vec3i(clamp(lower + 1.0, vec3f(0.0), last));
    let x00 = mix(stored_gradient(a.x, a.y, a.z), stored_gradient(b.x, a.y, a.z), f.x);
    let x10 = mix(stored_gradient(a.x, b.y, a.z), stored_gradient(b.x, b.y, a.z), f.x);
    let x01 = mix(stored_gradient(a.x, a.y, b.z), stored_gradient(b.x, a.y, b.z), f.x);
    let x11 = mix(stored_gradient(a.x, b.y, b.z), stored_gradient(b.x, b.y, b.z), f.x);
    let stored = mix(mix(x00, x10, f.y), mix(x01, x11, f.y), f.z);
    return stored * mode.gradient_scale * view.grid_from_local * mode.direction;
}
