// One bit for every sample that contributes: what skip/oracle marches.

// See skip/oracle.
@group(1) @binding(1) var<storage, read_write> noted: array<u32>;

var<private> first_word: u32;

fn count_begin(at: u32) {
    first_word = at * settings.ray_words;
}

fn count_skip() {}

fn count_probe() {}

fn count_sample(contributes: bool, k: u32, ray: Ray) {
    if contributes {
        noted[first_word + k / 32u] |= 1u << (k % 32u);
    }
}

fn count_end(at: u32) {}
