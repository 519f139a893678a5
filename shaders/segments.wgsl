// Before the march: lists the segments of every ray, merged, in as many slots as there are; what follows the last but one
// is one segment up to the last exit. Twin of skip::segment_list.
#import shared/walk
#import shared/lanes

@group(0) @binding(2) var<storage, read> tiles: array<Tile>;
// See skip/segment_list.
@group(1) @binding(1) var<storage, read_write> lists: array<vec2u>;

@compute @workgroup_size(8, 8)
fn segments(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) index: u32) {
    let tile_index = group.y * settings.tiles_per_row + group.x;
    if tile_index >= settings.tile_count {
        return;
    }
    let tile = tiles[settings.tile_first + tile_index];
    let pixel = pixel_of(tile, index);
    if any(pixel >= view.size) {
        return;
    }
    let at = pixel.y * view.size.x + pixel.x;
    let stride = view.size.x * view.size.y;
    let slots = settings.ray_words / 2u;

    let ray = ray_through(pixel);
    var k = ray.k_near;
    var walk = skip_begin(ray, pixel, tile, k);
    var slot = 0u;
    var open = vec2u(0u);
    while k < ray.k_end {
        let next = skip_next(&walk, vec4f(0.0), ray, k);
        k = next.y;
        if next.x == next.y {
            continue;
        }
        let is_last = slot + 1u == slots && open.y > 0u;
        if next.x > open.y && !is_last {
            if open.y > 0u {
                lists[slot * stride + at] = open;
                slot += 1u;
            }
            open.x = next.x;
        }
        open.y = next.y;
    }
    // Where there is no segment at all this is the list's end.
    lists[slot * stride + at] = open;
    if open.y > 0u && slot + 1u < slots {
        lists[(slot + 1u) * stride + at] = vec2u(0u);
    }
}
