//! What memory and the gather instruction allow at best, whatever the arithmetic: the floor under a sample's cost.

use std::hint::black_box;
use std::time::Instant;

use rayon::prelude::*;

/// Words gathered for one sample of 8-bit voxels: four rows of two neighbours each.
pub(crate) const WORDS_PER_SAMPLE: f64 = 4.0;

/// Words gathered in one measurement.
#[cfg(target_arch = "x86_64")]
const WORDS: usize = 1 << 23;

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

/// How wide a gather is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Width {
    /// Eight 32-bit words (AVX2).
    Eight,
    /// Sixteen (AVX-512).
    Sixteen,
}

/// Nanoseconds of one thread for gathering one 32-bit word, at the addresses of rays that are neighbours and advance
/// together through a working set of `bytes` (at least 1,024); all threads at work. `None` where there is no such
/// instruction.
#[cfg(target_arch = "x86_64")]
pub(crate) fn ns_per_word(bytes: &[u8], width: Width) -> Option<f64> {
    assert!(bytes.len() >= 1024, "a working set of some rows");
    let (is_there, lanes) = match width {
        Width::Eight => (is_x86_feature_detected!("avx2"), 8),
        Width::Sixteen => (is_x86_feature_detected!("avx512f"), 16),
    };
    if !is_there {
        return None;
    }
    let best = (0..9)
        .map(|_| {
            let start = Instant::now();
            (0..rayon::current_num_threads())
                .into_par_iter()
                .for_each(|thread| {
                    let from = thread * 64;
                    // SAFETY: the instructions were found just above, and `bytes` is long enough.
                    #[allow(unsafe_code)]
                    let sum = unsafe {
                        match width {
                            Width::Eight => eight(bytes, WORDS / lanes, from),
                            Width::Sixteen => sixteen(bytes, WORDS / lanes, from),
                        }
                    };
                    black_box(sum);
                });
            start.elapsed().as_secs_f64() * 1e9 / WORDS as f64
        })
        .fold(f64::INFINITY, f64::min);
    Some(best)
}

#[cfg(not(target_arch = "x86_64"))]
pub(crate) fn ns_per_word(_: &[u8], _: Width) -> Option<f64> {
    None
}

/// Where rays stand within rows of 256, half a voxel apart: the first eight are a packet's.
#[cfg(target_arch = "x86_64")]
const RAYS: [i32; 16] = [
    0, 0, 1, 1, 256, 256, 257, 257, 2, 2, 3, 3, 258, 258, 259, 259,
];

/// Byte offsets of the four rows of a sample's cell, sample by sample along the rays; each with 512 bytes behind it.
#[cfg(target_arch = "x86_64")]
fn rows(bytes: &[u8], from: usize) -> impl Iterator<Item = i32> + use<> {
    // The largest power of two that fits: wrapping by a mask costs nothing.
    let mask = (1usize << bytes.len().ilog2()) - 1;
    let last = bytes.len() - 512;
    // On along the rays: a step through the slices and a little aside.
    (0usize..)
        .map(move |sample| from + sample * (65_536 + 257))
        .flat_map(move |at| [0, 256, 512, 768].map(|row| ((at + row) & mask).min(last) as i32))
}

/// Sums `count` gathers of eight words.
///
/// # Safety
/// The processor must have AVX2, and `bytes` must be at least 1,024 long.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
#[allow(unsafe_code)]
unsafe fn eight(bytes: &[u8], count: usize, from: usize) -> i32 {
    use std::arch::x86_64::{
        _mm256_add_epi32, _mm256_extract_epi32, _mm256_i32gather_epi32, _mm256_loadu_si256,
        _mm256_set1_epi32,
    };

    // SAFETY: sixteen 32-bit integers are there to load eight of.
    let lanes = unsafe { _mm256_loadu_si256(RAYS.as_ptr().cast()) };
    let mut sum = _mm256_set1_epi32(0);
    for base in rows(bytes, from).take(count) {
        let index = _mm256_add_epi32(_mm256_set1_epi32(base), lanes);
        // SAFETY: 512 bytes follow `base`, the farthest read is 259 + 4; gathers need no alignment.
        let words = unsafe { _mm256_i32gather_epi32::<1>(bytes.as_ptr().cast(), index) };
        sum = _mm256_add_epi32(sum, words);
    }
    _mm256_extract_epi32::<0>(sum)
}

/// Sums `count` gathers of sixteen words.
///
/// # Safety
/// The processor must have AVX-512 F, and `bytes` must be at least 1,024 long.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f")]
#[allow(unsafe_code)]
unsafe fn sixteen(bytes: &[u8], count: usize, from: usize) -> i32 {
    use std::arch::x86_64::{
        _mm512_add_epi32, _mm512_i32gather_epi32, _mm512_loadu_si512, _mm512_reduce_add_epi32,
        _mm512_set1_epi32,
    };

    // SAFETY: sixteen 32-bit integers are there to load.
    let lanes = unsafe { _mm512_loadu_si512(RAYS.as_ptr().cast()) };
    let mut sum = _mm512_set1_epi32(0);
    for base in rows(bytes, from).take(count) {
        let index = _mm512_add_epi32(_mm512_set1_epi32(base), lanes);
        // SAFETY: as in `eight`.
        let words = unsafe { _mm512_i32gather_epi32::<1>(index, bytes.as_ptr().cast()) };
        sum = _mm512_add_epi32(sum, words);
    }
    _mm512_reduce_add_epi32(sum)
}
