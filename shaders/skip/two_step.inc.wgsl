// Probes far apart; the samples between two of them are taken where either shows something. Twin of skip::two_step.
#import shared/ray
#import shared/march_settings
#import step/one

// Samples from one probe to the next (two_step::COARSE).
const COARSE = 8u;

struct Segment {
    // Whether the last probe showed something.
    hit: bool,
}

fn probe(ray: Ray, k: u32) -> bool {
    count_probe();
    let at = min(k, ray.k_end - 1u);
    var state = vec4f(0.0);
    return mode_sample(&state, sample_x(lattice(ray, at)), at, ray);
}

fn skip_begin(ray: Ray, pixel: vec2u, tile: Tile, k: u32) -> Segment {
    if k >= ray.k_end {
        return Segment(false);
    }
    return Segment(probe(ray, k / COARSE * COARSE));
}

fn skip_next(segment: ptr<function, Segment>, state: vec4f, ray: Ray, k: u32) -> vec2u {
    if k >= ray.k_end {
        return vec2u(k);
    }
    let next = (k / COARSE + 1u) * COARSE;
    let before = (*segment).hit;
    let after = probe(ray, next);
    (*segment).hit = after;
    let end = min(next, ray.k_end);
    return vec2u(select(end, k, before || after), end);
}
