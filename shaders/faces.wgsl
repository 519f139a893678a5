// Rasterises the faces of a hull: the nearest front face of a pixel is its entry, the farthest back face its exit.
// What is stored, and what the depth test compares, is the depth at which the pixel's own ray meets the face's plane.
#import shared/view

struct Face {
    @builtin(position) position: vec4f,
    // Start and direction of a ray along the face's axis: constant, per pixel right, per pixel down.
    @location(0) @interpolate(flat) plane_minus_start: vec3f,
    @location(1) @interpolate(flat) dir: vec3f,
}

// corner: x, y, z in leaf blocks; w: axis in bits 0-1, bits 2-4: whether the rectangle grows towards +x, +y, +z.
@vertex
fn vertex(@location(0) corner: vec4<u32>) -> Face {
    let voxel_size = 1.0 / view.grid_from_local;
    let axis = corner.w & 3u;
    let towards = vec3f((vec3u(corner.w) >> vec3u(2u, 3u, 4u)) & vec3u(1u)) * 2.0 - 1.0;
    // The last block of an axis may stick out of the volume.
    let on_grid = min(vec3f(corner.xyz) * view.block * voxel_size, view.extent);
    // Outward, and twice as far in the plane: rectangles that meet at an edge then cross each other, so that no pixel
    // centre falls between two edges that the rasteriser snaps differently (T-junctions).
    let outward = vec3u(0u, 1u, 2u) == vec3u(axis);
    let local = on_grid + towards * view.grow * select(vec3f(2.0), vec3f(1.0), outward);
    var face: Face;
    face.position = view.clip_from_local * vec4f(local, 1.0);
    face.plane_minus_start = vec3f(local[axis] - view.start[axis], -view.start_dx[axis], -view.start_dy[axis]);
    face.dir = vec3f(view.dir[axis], view.dir_dx[axis], view.dir_dy[axis]);
    return face;
}

@fragment
fn fragment(face: Face) -> @builtin(frag_depth) f32 {
    let pixel = vec3f(1.0, vec2f(vec2u(face.position.xy) + view.origin) - view.centre);
    let d = dot(face.dir, pixel);
    // A ray parallel to the face meets it nowhere; another face of the same block bounds it.
    let safe = select(d, select(-1e-20, 1e-20, d >= 0.0), abs(d) < 1e-20);
    return clamp(dot(face.plane_minus_start, pixel) / safe * view.depth_scale, 0.0, 1.0);
}
