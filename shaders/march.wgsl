// The one marcher: walks the segments of a ray, asks the sampler for a value at each index and hands it to the mode, which
// asks for more (its colour, its gradient) where it needs it.
#import shared/ray
#import shared/march_settings
#import skip/{SKIP}
#import sample/{SAMPLER}
#import mode/{MODE}
#import count/{COUNT}

@group(0) @binding(2) var<storage, read> tiles: array<Tile>;
// The mode's state while a picture is in work, the pixels at its end; row by row.
@group(0) @binding(3) var<storage, read_write> target_rgba: array<vec4f>;
// Next sample index, where a picture takes more than one dispatch.
@group(0) @binding(4) var<storage, read_write> progress: array<u32>;

// Progress of a ray whose pixel stands.
const FINISHED = 0xffffffffu;

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
    // Nothing seen yet: all modes start from zeros, and finish them to zeros.
    var state = vec4f(0.0);
    var k = ray.k_near;
    if settings.resume != 0u {
        k = progress[at];
        if k == FINISHED {
            return;
        }
        state = target_rgba[at];
    }
    count_begin(at);

    var k_stop = k;
    var segment = skip_begin(ray, pixel, tile, k);
    var left = settings.max_iterations;
    var finished = false;
    loop {
        // Only where a lane has used up its segment: no cost per sample. Every step advances k or the segment.
        while k >= k_stop && !finished && left > 0u {
            let next = skip_next(&segment, state, ray, k);
            k = next.x;
            k_stop = next.y;
            finished = k >= ray.k_end;
            left -= 1u;
            count_skip();
        }
        if finished || left == 0u {
            break;
        }
        let contributes = step_sample(&state, &segment, k, ray);
        count_sample(contributes, k, ray);
        k += step_length(&segment);
        left -= 1u;
        finished = mode_done(state);
    }

    if settings.store_progress != 0u {
        // Rays that stop early are over for every later dispatch too.
        progress[at] = select(k, FINISHED, finished);
    }
    if settings.store_progress == 0u || finished {
        state = mode_finish(state, ray);
    }
    target_rgba[at] = state;
    count_end(at);
}
