//! What memory and the gather instruction allow at best, whatever the arithmetic: the floor under a sample's cost.

use std::hint::black_box;
use std::time::Instant;

use rayon::prelude::*;

/// Gathers of one sample of 8-bit voxels, eight rays at a time: four rows of two neighbours each.
pub(crate) const GATHERS_PER_PACKET: f64 = 4.0;

/// Rays per packet.
pub(crate) const LANES: f64 = 8.0;

/// Gathers of one measurement.
#[cfg(target_arch = "x86_64")]
const GATHERS: usize = 1 << 20;

/// Bytes that one thread reads a nanosecond, front to back over all of `bytes`, all threads at work.
pub(crate) fn bytes_per_ns(bytes: &[u8]) -> f64 {
    let words: &[u64] = bytemuck::cast_slice(&bytes[..bytes.len() / 8 * 8]);
    let best = (0..9)
        .map(|_| {
            let start = Instant::now();
            let chunk = words.len().div_ceil(rayon::current_num_threads());
            let sum: u64 = words
                .par_chunks(chunk)
                .map(|words| words.iter().fold(0u64, |a, &w| a.wrapping_add(w)))
                .reduce(|| 0, u64::wrapping_add);
            black_box(sum);
            start.elapsed().as_secs_f64() * 1e9
        })
        .fold(f64::INFINITY, f64::min);
    bytes.len() as f64 / best / rayon::current_num_threads() as f64
}

/// Nanoseconds of one thread for one gather of eight 32-bit words, at the addresses of rays that are neighbours and
/// advance together through a working set of `bytes`; all threads at work. `None` where there is no such instruction.
#[cfg(target_arch = "x86_64")]
pub(crate) fn ns_per_gather(bytes: &[u8]) -> Option<f64> {
    if !is_x86_feature_detected!("avx2") {
        return None;
    }
    let best = (0..9)
        .map(|_| {
            let start = Instant::now();
            (0..rayon::current_num_threads())
                .into_par_iter()
                .for_each(|thread| {
                    // SAFETY: AVX2 was found just above.
                    #[allow(unsafe_code)]
                    black_box(unsafe { gathers(bytes, GATHERS, thread * 64) });
                });
            start.elapsed().as_secs_f64() * 1e9 / GATHERS as f64
        })
        .fold(f64::INFINITY, f64::min);
    Some(best)
}

#[cfg(not(target_arch = "x86_64"))]
pub(crate) fn ns_per_gather(_: &[u8]) -> Option<f64> {
    None
}

/// Sums `count` gathers from `bytes`, four at a time in independent chains as in a sample.
///
/// # Safety
/// The processor must have AVX2, and `bytes` must be at least 512 long.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
#[allow(unsafe_code)]
unsafe fn gathers(bytes: &[u8], count: usize, from: usize) -> i32 {
    use std::arch::x86_64::{
        __m256i, _mm256_add_epi32, _mm256_i32gather_epi32, _mm256_set1_epi32, _mm256_setr_epi32,
    };

    // The largest power of two that fits: wrapping by a mask costs nothing.
    let mask = (1usize << bytes.len().ilog2()) - 1;
    // Two rows of four rays, half a voxel apart, in rows of 256.
    let lanes = _mm256_setr_epi32(0, 0, 1, 1, 256, 256, 257, 257);
    let mut sums = [_mm256_set1_epi32(0); 4];
    let mut at = from;
    for _ in 0..count / 4 {
        for (row, sum) in sums.iter_mut().enumerate() {
            // The farthest byte read is 257 + 3 beyond `base`, which stays that far below the end.
            let base = (at + row * 256) & mask;
            let base = base.min(bytes.len() - 512) as i32;
            let index: __m256i = _mm256_add_epi32(_mm256_set1_epi32(base), lanes);
            // SAFETY: all eight words lie inside `bytes`, as argued above; gathers need no alignment.
            let words = unsafe { _mm256_i32gather_epi32::<1>(bytes.as_ptr().cast(), index) };
            *sum = _mm256_add_epi32(*sum, words);
        }
        // On along the rays: a step through the slices and a little aside.
        at = at.wrapping_add(65_536 + 257);
    }
    let sum = sums
        .into_iter()
        .fold(_mm256_set1_epi32(0), |a, b| _mm256_add_epi32(a, b));
    // SAFETY: eight 32-bit integers are what the register holds.
    let lanes: [i32; 8] = unsafe { std::mem::transmute(sum) };
    lanes.iter().fold(0, |a, &b| a.wrapping_add(b))
}
