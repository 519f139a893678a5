// The samples that contribute, which a march before this one has noted (shaders/count/contributing). Twin of skip::oracle.
#import shared/ray
#import shared/march_settings
#import step/one

// settings.ray_words words for every pixel: bit k % 32 of word k / 32 is sample k.
@group(1) @binding(3) var<storage, read> contributing: array<u32>;

struct Segment {
    first_word: u32,
}

fn skip_begin(ray: Ray, pixel: vec2u, tile: Tile, k: u32) -> Segment {
    return Segment((pixel.y * view.size.x + pixel.x) * settings.ray_words);
}

// The next run within sample k's word, or the empty segment after the word.
fn skip_next(segment: ptr<function, Segment>, state: vec4f, ray: Ray, k: u32) -> vec2u {
    if k >= ray.k_end {
        return vec2u(k);
    }
    let bits = contributing[(*segment).first_word + k / 32u] >> (k % 32u);
    if bits == 0u {
        return vec2u((k / 32u + 1u) * 32u);
    }
    let gap = countTrailingZeros(bits);
    return k + gap + vec2u(0u, countTrailingZeros(~(bits >> gap)));
}
