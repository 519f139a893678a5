// Gradients from a volume of them, by the adapter's trilinear filter.

@group(0) @binding(9) var gradient_volume: texture_3d<f32>;

// Over two voxels, per local unit, of data values (in units of the table).
fn gradient(at: vec3f) -> vec3f {
    let place = at * mode.cells_per_voxel / vec3f(textureDimensions(gradient_volume));
    let stored = textureSampleLevel(gradient_volume, volume_filter, place, 0.0).xyz;
    return stored * mode.gradient_scale * view.grid_from_local * mode.direction;
}
