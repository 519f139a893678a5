//! What is found out of every pixel's ray before it is marched, and kept in some words for each: the oracle's contributing
//! samples, segment-list's segments.

use super::dispatch::Dispatch;
use super::march::SETTINGS_STRIDE;
use super::{Job, MAX_TARGET, RASTER};
use crate::gpu::timer::{Place, SpanTimer};
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

/// Bytes of a pixel's colour, and of its counters.
const PIXEL_BYTES: u64 = 16;

/// Edge of the largest piece of a picture that is drawn at once, whose pixels and words must fit a binding.
pub(super) fn largest_piece(job: &Job, limits: &wgpu::Limits) -> u32 {
    let largest = MAX_TARGET.min(limits.max_texture_dimension_2d);
    let bytes_per_pixel = (u64::from(ray_words(job)) * 4).max(PIXEL_BYTES);
    let bytes = limits
        .max_storage_buffer_binding_size
        .min(limits.max_buffer_size);
    let pixels = bytes / bytes_per_pixel;
    // Whole tiles; a single one is tried whatever it takes.
    (pixels.isqrt() as u32 / 8 * 8).clamp(8, largest)
}

/// Lists the segments of every ray of the tiles that the dispatches march.
pub(super) fn list_segments(
    encoder: &mut wgpu::CommandEncoder,
    pipeline: &wgpu::ComputePipeline,
    [scene, skip]: [&wgpu::BindGroup; 2],
    dispatches: &[Dispatch],
    timer: &SpanTimer,
) {
    let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
        label: Some("segments"),
        timestamp_writes: timer.compute(Place {
            span: RASTER,
            first: true,
            last: true,
        }),
    });
    pass.set_pipeline(pipeline);
    pass.set_bind_group(1, skip, &[]);
    for (i, dispatch) in dispatches.iter().enumerate() {
        // Those that go on with a ray find its list made.
        if !dispatch.resume {
            pass.set_bind_group(0, scene, &[(i as u64 * SETTINGS_STRIDE) as u32]);
            dispatch.launch(&mut pass);
        }
    }
}
