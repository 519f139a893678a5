//! What is found out before the march: of every pixel's ray (the oracle's contributing samples, segment-list's segments), or
//! of every tile's beam (beam-cells' runs).

use super::dispatch::Dispatch;
use super::march::SETTINGS_STRIDE;
use super::tiles::TILE;
use super::{Job, MAX_TARGET, RASTER};
use crate::gpu::timer::{Place, SpanTimer};
use crate::skip::{MOST_SEGMENTS, Skip};

/// A pass before the march that lists what it is to march.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Listing {
    /// The segments of every ray.
    Segments,
    /// The runs of every tile.
    Beams,
}

impl Listing {
    /// That of a method, if it has one.
    pub(super) fn of(skip: Skip) -> Option<Self> {
        match skip {
            Skip::SegmentList => Some(Self::Segments),
            Skip::BeamCells => Some(Self::Beams),
            _ => None,
        }
    }

    /// The file in `shaders/`, and its entry point.
    pub(super) fn shader(self) -> &'static str {
        match self {
            Self::Segments => "segments",
            Self::Beams => "beams",
        }
    }

    /// Tiles to a workgroup.
    fn tiles(self) -> u32 {
        match self {
            Self::Segments => 1,
            Self::Beams => 64,
        }
    }
}

/// Words that the job's method keeps for every pixel, or every tile.
pub(super) fn ray_words(job: &Job) -> u32 {
    match job.skip {
        // One bit per sample.
        Skip::Oracle => (job.scene.frame.max_samples() / 32.0).ceil() as u32,
        Skip::SegmentList | Skip::BeamCells => 2 * MOST_SEGMENTS as u32,
        _ => 0,
    }
}

/// Bytes that the job's method keeps for so many pixels.
pub(super) fn ray_bytes(job: &Job, [width, height]: [u32; 2]) -> u64 {
    let count = match Listing::of(job.skip) {
        Some(Listing::Beams) => [width, height].map(|n| u64::from(n.div_ceil(TILE))),
        _ => [width, height].map(u64::from),
    };
    count[0] * count[1] * 4 * u64::from(ray_words(job))
}

/// Bytes of a pixel's colour, and of its counters.
const PIXEL_BYTES: u64 = 16;

/// Edge of the largest piece of a picture that is drawn at once, whose pixels and words must fit a binding.
pub(super) fn largest_piece(job: &Job, limits: &wgpu::Limits) -> u32 {
    let largest = MAX_TARGET.min(limits.max_texture_dimension_2d);
    let bytes_per_pixel = (ray_bytes(job, [TILE; 2]) / u64::from(TILE * TILE)).max(PIXEL_BYTES);
    let bytes = limits
        .max_storage_buffer_binding_size
        .min(limits.max_buffer_size);
    let pixels = bytes / bytes_per_pixel;
    // Whole tiles; a single one is tried whatever it takes.
    (pixels.isqrt() as u32 / 8 * 8).clamp(8, largest)
}

/// Lists what is to be marched in the tiles that the dispatches march.
pub(super) fn list(
    encoder: &mut wgpu::CommandEncoder,
    (listing, pipeline): (Listing, &wgpu::ComputePipeline),
    [scene, skip]: [&wgpu::BindGroup; 2],
    dispatches: &[Dispatch],
    timer: &SpanTimer,
) {
    let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
        label: Some(listing.shader()),
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
            dispatch.launch(&mut pass, listing.tiles());
        }
    }
}
