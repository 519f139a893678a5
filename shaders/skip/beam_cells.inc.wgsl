// The runs of the ray's tile (shaders/beams.wgsl), cut down at both ends to cells that may contribute. Twin of
// skip::beam_cells.
#import shared/blocks
#import shared/beams
#import step/one

@group(1) @binding(2) var<storage, read> lists: array<vec2f>;

// See skip::beam_cells.
const MARGIN = 0x1p-6;

struct Segment {
    slot: u32,
    list: u32,
    // A depth s lies at sample s * scale - offset.
    scale: f32,
    offset: f32,
    way: Way,
}

fn skip_begin(ray: Ray, pixel: vec2u, tile: Tile, k: u32) -> Segment {
    return Segment(0u, list_of(tile), ray.length / view.step, ray.t_box / view.step + 0.5, way_of(ray));
}

// Cells to the nearest one that may contribute, two bits for each (octree::Cells).
fn cell_distance(cell: vec3u) -> u32 {
    let dims = vec3u(view.dims);
    let word = view.after_blocks + (cell.z * dims.y + cell.y) * ((dims.x + 15u) / 16u) + cell.x / 16u;
    return (blocks[word] >> (cell.x % 16u * 2u)) & 3u;
}

// How many samples on from the one whose outer end is at `grid` are certain to show nothing. `direction` and `behind` are
// those of the way that is gone, `inverse` its samples per voxel.
fn free_samples(grid: vec3f, inverse: vec3f, direction: vec3f, behind: vec3f, most: f32) -> u32 {
    count_skip();
    let at = grid - 0.5;
    let cell = clamp(floor(at), vec3f(0.0), view.dims - 1.0);
    let distance = cell_distance(vec3u(cell));
    // So near to a face, the filter tells which cell a sample lies in.
    let is_at_face = any(abs(at - cell - 0.5) > vec3f(0.5 - view.face));
    let face = cell + behind + (f32(distance) - MARGIN) * direction;
    let samples = (face - at) * inverse;
    let least = min(min(samples.x, samples.y), samples.z);
    let whole = u32(clamp(ceil(least), 1.0, most));
    // An interval ends where the next begins: the last one that begins in emptiness may end beyond it.
    let taken = distance == 0u || (distance == 1u && is_at_face);
    return select(whole - u32(2.0 * view.reach), 0u, taken);
}

fn skip_next(segment: ptr<function, Segment>, state: vec4f, ray: Ray, k: u32) -> vec2u {
    let slot = (*segment).slot;
    (*segment).slot = slot + 1u;
    var run = vec2f(0.0, -1.0);
    if slot < settings.ray_words / 2u {
        run = lists[slot * list_count() + (*segment).list];
    }
    if run.y < 0.0 {
        return vec2u(max(k, ray.k_end));
    }
    // Positions are rounded; blocks reach farther than that.
    let pad = 0.0625 + view.reach;
    let at = run * (*segment).scale - (*segment).offset;
    let most = f32(ray.k_end) + 1.0;
    var first = max(max(k, ray.k_near), u32(clamp(ceil(at.x - pad), 0.0, f32(ray.k_end))));
    var end = max(first, u32(clamp(ceil(at.y + pad), 0.0, f32(ray.k_end))));
    let way = (*segment).way;
    var free = 1u;
    while first < end && free > 0u {
        free = free_samples(lattice_front(ray, first), way.inverse, way.direction, way.behind, most);
        first = min(first + free, end);
    }
    free = 1u;
    while first < end && free > 0u {
        free = free_samples(lattice_back(ray, end - 1u), -way.inverse, -way.direction, 1.0 - way.behind, most);
        end -= min(free, end - first);
    }
    return vec2u(first, end);
}
