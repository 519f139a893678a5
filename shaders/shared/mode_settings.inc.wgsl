// The parameters of a mode in table coordinates; those that it does not read are zero. Mirrors gpu::abi::ModeSettings.

struct ModeSettings {
    // Unit direction towards the light, local axes; not read where light_is_eye is 1.
    light: vec3f,
    light_is_eye: u32,
    // Linear colour of the (inner) surface.
    color: vec3f,
    ambient: f32,
    // Linear colour and opacity of the outer surface, not premultiplied.
    outer_color: vec4f,
    diffuse: f32,
    specular: f32,
    shininess: f32,
    // Step in voxels: what opacities per voxel are raised to.
    opacity_ratio: f32,
    // Brightness (x - window_low) * window_scale, which counts as 0 up to window_dead.
    window_low: f32,
    window_scale: f32,
    window_dead: f32,
    // 1 where data values rise with table coordinates, -1 where they fall.
    direction: f32,
    // Of the (inner) surface.
    iso: f32,
    outer_iso: f32,
    // Length of a gradient up to which it has no direction to speak of.
    least_gradient: f32,
    // Table coordinates per number in the volume of gradients, and how many of its cells an edge of a voxel takes.
    gradient_scale: f32,
    cells_per_voxel: f32,
    // Share of light lost at the farthest point of the box; depths are from the plane that rays start on.
    cue_strength: f32,
    cue_start: f32,
    cue_scale: f32,
}

@group(0) @binding(8) var<uniform> mode: ModeSettings;
