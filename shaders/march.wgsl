// The one marcher: walks the segments of a ray, asks the sampler for a value at each index and hands it to the mode, which
// asks for more (its colour, its gradient) where it needs it.
#import shared/ray
#import shared/march_settings
#import shared/lanes
#import skip/{SKIP}
#import sample/{SAMPLER}
#import mode/{MODE}
#import count/{COUNT}
#import bound/{BOUND}

// Segments to look for before the samples of the first are taken, and one that ends the last of them; just one where what is
// found next depends on the samples taken, or on the segment that they are in.
const LOOK_AHEAD = min(SEGMENTS_AHEAD, BLOCKS_AHEAD);

@group(0) @binding(2) var<storage, read> tiles: array<Tile>;
// The mode's state while a picture is in work, the pixels at its end; row by row.
@group(0) @binding(3) var<storage, read_write> target_rgba: array<vec4f>;
// Next sample index, where a picture takes more than one dispatch.
@group(0) @binding(4) var<storage, read_write> progress: array<u32>;

// Progress of a ray whose pixel stands.
const FINISHED = 0xffffffffu;

@compute @workgroup_size(8, 8)
fn march(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) index: u32) {
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

    // Invocations that run in step wait for each other, at every sample, while one of them looks for its next segment. So
    // each looks for several at a time, and then takes their samples.
    var segment = skip_begin(ray, pixel, tile, k);
    // The segments found, in order: where they begin and end.
    var starts = vec4u(0u);
    var ends = vec4u(0u);
    // One more, which may be longer than is known yet.
    var open = vec2u(0u);
    var k_found = k;
    var steps_left = settings.max_iterations;
    var samples_left = settings.max_iterations;
    var finished = false;
    loop {
        var found = min(open.y, 1u);
        starts.x = open.x;
        ends.x = open.y;
        var end = open.y;
        open = vec2u(0u);
        while k_found < ray.k_end && found < LOOK_AHEAD && steps_left > 0u {
            let next = skip_next(&segment, state, ray, k_found);
            k_found = next.y;
            steps_left -= 1u;
            count_skip();
            if next.x < next.y {
                // Those that meet are one.
                let joins = found > 0u && next.x == end;
                end = next.y;
                found += select(1u, 0u, joins);
                let slot = vec4u(0u, 1u, 2u, 3u) == vec4u(found - 1u);
                starts = select(starts, vec4u(next.x), slot & vec4<bool>(!joins));
                ends = select(ends, vec4u(end), slot);
                if found > 4u {
                    open = next;
                }
            }
        }
        if found == 0u {
            k = k_found;
            finished = k >= ray.k_end;
            break;
        }
        found = min(found, 4u);
        k = starts.x;
        while found > 0u && !finished && samples_left > 0u {
            let contributes = step_sample(&state, &segment, k, ray);
            count_sample(contributes, k, ray);
            k += step_length(&segment);
            samples_left -= min(step_length(&segment), samples_left);
            finished = mode_done(state);
            if k >= ends.x {
                starts = vec4u(starts.yzw, 0u);
                ends = vec4u(ends.yzw, 0u);
                found -= 1u;
                k = max(k, starts.x);
            }
        }
        if finished || found > 0u {
            break;
        }
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
