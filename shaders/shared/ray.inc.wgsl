// The one sample lattice: sample k lies at entry + (k + 1/2) * delta in grid coordinates. Twin of lattice::RayBasis::ray.
#import shared/view

// Direction components below this magnitude are exactly zero (lattice::PARALLEL).
const PARALLEL = 0x1p-40;
// How near to an end of its range a sample may lie, in steps (lattice::EDGE).
const EDGE = 0x1p-10;

struct Ray {
    entry: vec3f,
    delta: vec3f,
    // Where the part that is drawn begins and ends, in steps from the entry into the box.
    drawn: vec2f,
    k_near: u32,
    k_end: u32,
    // Unclamped entry into the box, local units from the ray's start.
    t_box: f32,
    // Length of the unnormalised direction: local units per unit of depth.
    length: f32,
}

fn ray_through(pixel: vec2u) -> Ray {
    let l = line_through(pixel);
    let length = sqrt(dot(l.dir, l.dir));
    let raw = l.dir / length;
    let parallel = abs(raw) < vec3f(PARALLEL);
    let d = select(raw, vec3f(0.0), parallel);
    // A parallel ray is inside a slab for ever or never: divide by one and replace the result.
    let inverse = 1.0 / select(raw, vec3f(1.0), parallel);
    let t0 = (vec3f(0.0) - l.start) * inverse;
    let t1 = (view.extent - l.start) * inverse;
    const FAR = 1e30;
    let outside = (l.start < vec3f(0.0)) | (view.extent < l.start);
    let parallel_in = select(vec3f(-FAR), vec3f(FAR), outside);
    let near3 = select(min(t0, t1), parallel_in, parallel);
    let far3 = select(max(t0, t1), vec3f(FAR), parallel);
    let t_in = max(max(near3.x, near3.y), near3.z);
    let t_out = min(min(far3.x, far3.y), far3.z);

    let missed = t_out < t_in;
    let t_box = select(t_in, 0.0, missed);
    let chord = select(t_out - t_in, 0.0, missed);
    var ray: Ray;
    ray.entry = (l.start + t_box * d) * view.grid_from_local;
    ray.delta = d * view.step * view.grid_from_local;
    var k_near = max(ceil(-t_box / view.step - (0.5 + EDGE)), 0.0);
    var k_end = max(ceil(chord / view.step - (0.5 + EDGE)), 0.0);
    var drawn = vec2f(max(-t_box / view.step, 0.0), chord / view.step);
    // To the first that is none, not to a count of them: a driver that makes uniforms constants of its code (Mesa's software
    // driver) would compile the loop again for every frame, and keep what it compiled.
    for (var i = 0u; i < MAX_CLIP_PLANES; i++) {
        let plane = view.clip_planes[i];
        if all(plane.xyz == vec3f(0.0)) {
            break;
        }
        let height = dot(plane.xyz, l.start) + plane.w;
        let along = dot(plane.xyz, d);
        let is_parallel = abs(along) < PARALLEL;
        let t = -height / select(along, 1.0, is_parallel);
        let s = (t - t_box) / view.step;
        let k = ceil(s - (0.5 + EDGE));
        // Where the ray passes the plane, one of its sides begins with the sample that the other ends before.
        k_near = select(k_near, max(k_near, k), !is_parallel && along > 0.0);
        k_end = select(k_end, max(min(k_end, k), 0.0), !is_parallel && along < 0.0);
        k_end = select(k_end, 0.0, is_parallel && height < 0.0);
        drawn.x = select(drawn.x, max(drawn.x, s), !is_parallel && along > 0.0);
        drawn.y = select(drawn.y, min(drawn.y, s), !is_parallel && along < 0.0);
    }
    ray.drawn = drawn;
    ray.k_near = u32(min(k_near, k_end));
    ray.k_end = u32(k_end);
    ray.t_box = t_box;
    ray.length = length;
    return ray;
}

// Grid position of sample k.
fn lattice(ray: Ray, k: u32) -> vec3f {
    return ray.entry + (f32(k) + 0.5) * ray.delta;
}

// Grid position from where on sample k reaches along the ray; of one that is a point, that point.
fn lattice_front(ray: Ray, k: u32) -> vec3f {
    return ray.entry + (f32(k) + (0.5 - view.reach)) * ray.delta;
}

// The same where it reaches to.
fn lattice_back(ray: Ray, k: u32) -> vec3f {
    return ray.entry + (f32(k) + (0.5 + view.reach)) * ray.delta;
}
