// The one marcher: walks the segments of a ray, asks the sampler for a value at each index and hands it to the mode.
#import shared/ray
#import shared/march_settings
#import skip/{SKIP}
#import sample/{SAMPLER}
#import sample/post
#import mode/{MODE}
#import count/{COUNT}

@group(0) @binding(2) var<storage, read> tiles: array<Tile>;
// The mode's state while a picture is in work, the pixels at its end; row by row.
@group(0) @binding(3) var<storage, read_write> target_rgba: array<vec4f>;
// Next sample index, where a picture takes more than one dispatch.
@group(0) @binding(4) var<storage, read_write> progress: array<u32>;

@compute @workgroup_size(8, 8)
fn march(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    let tile_index = group.y * settings.tiles_per_row + group.x;
    if tile_index >= settings.tile_count {
        return;
    }
    let tile = tiles[settings.tile_first + tile_index];
    let pixel = vec2u(tile.at & 0xffffu, tile.at >> 16u) * 8u + local.xy;
    if any(pixel >= view.size) {
        return;
    }
    let at = pixel.y * view.size.x + pixel.x;

    let ray = ray_through(pixel);
    var state = mode_init();
    var k = ray.k_near;
    if settings.resume != 0u {
        state = mode_load(target_rgba[at]);
        k = progress[at];
    }
    count_begin(at);

    // Rays that stop early are over for every later dispatch too.
    var k_stop = k;
    var segment = skip_begin(ray, pixel, tile, k);
    var left = settings.max_iterations;
    var finished = false;
    loop {
        // Only where a lane has used up its segment: no cost per sample. Every step advances k or the segment.
        while k >= k_stop && !finished && left > 0u {
            let next = skip_next(&segment, ray, k);
            k = next.x;
            k_stop = next.y;
            finished = k >= ray.k_end;
            left -= 1u;
            count_skip();
        }
        if finished || left == 0u {
            break;
        }
        let color = step_color(&segment, post_classify(sample_x(step_at(&segment, ray, k))));
        count_sample(color, k, ray);
        state = mode_add(state, color);
        k += step_length(&segment);
        left -= 1u;
        finished = mode_done(state);
    }

    if settings.store_progress != 0u {
        progress[at] = select(k, 0xffffffffu, finished);
    }
    target_rgba[at] = mode_store(state);
    count_end(at);
}
