// Eight loads and f32 interpolation, x first. Twin of sample::trilinear.

@group(0) @binding(5) var volume: texture_3d<f32>;
@group(0) @binding(6) var volume_filter: sampler;
// Premultiplied colour and opacity of every voxel, where they are classified before they are interpolated.
@group(0) @binding(10) var colors: texture_3d<f32>;

fn texel(x: i32, y: i32, z: i32) -> f32 {
    return textureLoad(volume, vec3i(x, y, z), 0).x;
}

// The raw texel at the fraction `f`, per axis, from voxel `lower` to the next.
fn fetch(lower: vec3f, f: vec3f) -> f32 {
    let last = view.dims - 1.0;
    let a = vec3i(clamp(lower, vec3f(0.0), last));
    let b = vec3i(clamp(lower + 1.0, vec3f(0.0), last));
    let x00 = vec2f(texel(a.x, a.y, a.z), texel(b.x, a.y, a.z));
    let x10 = vec2f(texel(a.x, b.y, a.z), texel(b.x, b.y, a.z));
    let x01 = vec2f(texel(a.x, a.y, b.z), texel(b.x, a.y, b.z));
    let x11 = vec2f(texel(a.x, b.y, b.z), texel(b.x, b.y, b.z));
    let low = vec4f(x00.x, x10.x, x01.x, x11.x);
    let high = vec4f(x00.y, x10.y, x01.y, x11.y);
    return interpolated(low, high, f);
}

// What lies at the fraction `f` between four voxels and the next four along x; those before z come first, in these those before
// y. a + f * (b - a) keeps uniform data uniform, to the last bit.
fn interpolated(low: vec4f, high: vec4f, f: vec3f) -> f32 {
    let along_x = low + f.x * (high - low);
    let along_y = along_x.xz + f.y * (along_x.yw - along_x.xz);
    return along_y.x + f.z * (along_y.y - along_y.x);
}

fn voxel_color(x: i32, y: i32, z: i32) -> vec4f {
    return textureLoad(colors, vec3i(x, y, z), 0);
}

// The same of colours.
fn fetch_color(lower: vec3f, f: vec3f) -> vec4f {
    let last = view.dims - 1.0;
    let a = vec3i(clamp(lower, vec3f(0.0), last));
    let b = vec3i(clamp(lower + 1.0, vec3f(0.0), last));
    let x00 = along(voxel_color(a.x, a.y, a.z), voxel_color(b.x, a.y, a.z), f.x);
    let x10 = along(voxel_color(a.x, b.y, a.z), voxel_color(b.x, b.y, a.z), f.x);
    let x01 = along(voxel_color(a.x, a.y, b.z), voxel_color(b.x, a.y, b.z), f.x);
    let x11 = along(voxel_color(a.x, b.y, b.z), voxel_color(b.x, b.y, b.z), f.x);
    return along(along(x00, x10, f.y), along(x01, x11, f.y), f.z);
}

fn along(a: vec4f, b: vec4f, f: f32) -> vec4f {
    return a + f * (b - a);
}
