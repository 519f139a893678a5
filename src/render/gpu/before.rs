//! What is found out of every pixel's ray before it is marched, and kept in some words for each: the oracle's contributing
//! samples, segment-list's segments.

use super::{Job, MAX_TARGET};
use crate::skip::Skip;
use crate::skip::segment_list::MOST_SEGMENTS;

/// Words for every pixel that the job's method keeps.
pub(super) fn ray_words(job: &Job) -> u32 {
    match job.skip {
        // One bit per sample.
        Skip::Oracle => (job.scene.frame.max_samples() / 32.0).ceil() as u32,
        Skip::SegmentList => 2 * MOST_SEGMENTS as u32,
        _ => 0,
    }
}

/// Edge of the largest piece of a picture that is drawn at once, whose words must fit a binding.
pub(super) fn largest_piece(job: &Job, limits: &wgpu::Limits) -> u32 {
    let largest = MAX_TARGET.min(limits.max_texture_dimension_2d);
    let bytes_per_pixel = u64::from(ray_words(job)) * 4;
    let bytes = limits
        .max_storage_buffer_binding_size
        .min(limits.max_buffer_size);
    let Some(pixels) = bytes.checked_div(bytes_per_pixel) else {
        return largest;
    };
    // Whole tiles; a single one is tried whatever it takes.
    (pixels.isqrt() as u32 / 8 * 8).clamp(8, largest)
}
