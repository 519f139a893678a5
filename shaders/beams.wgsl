// Before the march: lists the runs of every tile in which its rays, together as one beam, may meet something, in as many slots
// as there are; the last reaches to the end of all. Twin of skip::beam_cells, BeamCells::runs.
#import shared/blocks
#import shared/beams

@group(0) @binding(2) var<storage, read> tiles: array<Tile>;
// See shared/beams.
@group(1) @binding(1) var<storage, read_write> lists: array<vec2f>;

const FAR = 1e30;

// Where the sides of a beam meet planes, `side` where rays start and `by` on for each unit of depth; `otherwise` where they
// do not.
fn depth_of(planes: vec3f, side: vec3f, by: vec3f, meets: vec3<bool>, otherwise: f32) -> vec3f {
    return select(vec3f(otherwise), (planes - side) / select(vec3f(1.0), by, meets), meets);
}

@compute @workgroup_size(64)
fn beams(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) index: u32) {
    let tile_index = (group.y * settings.tiles_per_row + group.x) * 64u + index;
    if tile_index >= settings.tile_count {
        return;
    }
    let tile = tiles[settings.tile_first + tile_index];
    let list = list_of(tile);
    let stride = list_count();
    let slots = settings.ray_words / 2u;

    // The beam's middle and half of what it spans, in grid coordinates, where rays start and for each unit of depth.
    let half = 3.5;
    let p = vec2f(vec2u(tile.at & 0xffffu, tile.at >> 16u) * 8u + view.origin) - view.centre + half;
    let start_local = view.start + p.x * view.start_dx + p.y * view.start_dy;
    let start = start_local * view.grid_from_local;
    let dir = (view.dir + p.x * view.dir_dx + p.y * view.dir_dy) * view.grid_from_local;
    let start_spread = half * (abs(view.start_dx) + abs(view.start_dy));
    let start_half = start_spread * view.grid_from_local;
    let dir_half = half * (abs(view.dir_dx) + abs(view.dir_dy)) * view.grid_from_local;
    // Its upper and its lower side, and which way these go.
    let upper = start + start_half;
    let upper_by = dir + dir_half;
    let lower = start - start_half;
    let lower_by = dir - dir_half;
    let none = vec3f(0.0);
    let upper_rises = upper_by > none;
    let lower_falls = lower_by < none;

    let enters = max(
        depth_of(none, upper, upper_by, upper_rises, 0.0),
        depth_of(view.dims, lower, lower_by, lower_falls, 0.0),
    );
    let leaves = min(
        depth_of(none, upper, upper_by, upper_by < none, FAR),
        depth_of(view.dims, lower, lower_by, lower_by > none, FAR),
    );
    var s = max(max(max(enters.x, enters.y), enters.z), 0.0);
    // No ray goes farther than from its start to the farthest corner, and directions are of unit length at least: a beam that
    // widens in all directions never leaves the box.
    let farthest = max(abs(start_local), abs(view.extent - start_local)) + start_spread;
    let s_out = min(min(min(leaves.x, leaves.y), leaves.z), length(farthest));
    // On by a quarter of a block at least, whatever rounds.
    let least = 0.25 * view.block / max(max(abs(dir.x), abs(dir.y)), abs(dir.z));

    var slot = 0u;
    // The run that is not listed yet; none.
    var open = vec2f(0.0, -1.0);
    var steps_left = settings.max_iterations;
    while s < s_out {
        let at = start + s * dir;
        let around = start_half + s * dir_half;
        let block = block_at(at);
        let distance = f32(block_byte(block));
        // What is known to be empty; the outermost blocks reach outwards without end.
        let first = block - (distance - 1.0);
        let end = block + distance;
        let low = select(first * view.block - REACH, vec3f(-FAR), first <= none);
        let high = select(end * view.block + REACH, vec3f(FAR), end >= vec3f(view.block_dims));
        let free = min(
            depth_of(high, upper, upper_by, upper_rises, FAR),
            depth_of(low, lower, lower_by, lower_falls, FAR),
        );
        let free_to = min(min(free.x, free.y), free.z);
        let is_inside = all(low <= at - around) && all(at + around <= high);
        // Where it may meet something, on to the middle's next block; to the end, where this takes too long.
        let faces = (block + select(none, vec3f(1.0), dir > none)) * view.block;
        let on = depth_of(faces, start, dir, dir != none, FAR);
        steps_left -= 1u;
        let taken_to = select(max(min(min(on.x, on.y), on.z), s + least), max(s_out, s + least), steps_left == 0u);
        let fits = distance > 0.0 && is_inside && s + least <= free_to && steps_left > 0u;
        let next = select(taken_to, free_to, fits);
        if !fits {
            let is_new = s > open.y && (open.y < 0.0 || slot + 1u < slots);
            if is_new && open.y >= 0.0 {
                lists[slot * stride + list] = open;
                slot += 1u;
            }
            open = vec2f(select(open.x, s, is_new), next);
        }
        s = next;
    }
    // Where there is no run at all this is the list's end.
    lists[slot * stride + list] = open;
    if open.y >= 0.0 && slot + 1u < slots {
        lists[(slot + 1u) * stride + list] = vec2f(0.0, -1.0);
    }
}
