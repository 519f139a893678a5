//! How a march is cut into dispatches of bounded length.

use super::Job;
use super::tiles::TILE;
use crate::skip::Skip;

/// Samples, and steps that find them, of one invocation in one dispatch. Mesa's software driver ends an invocation silently
/// after 65,535 iterations, and real drivers have watchdogs.
pub(super) const MAX_ITERATIONS: u32 = 8_192;

/// Samples that one dispatch may take at most on hardware: about 100 ms on the slowest integrated GPUs.
const MAX_SAMPLES_PER_DISPATCH: u64 = 1 << 27;

/// Workgroups per row of a dispatch: below the 65,535 that every adapter allows.
pub(super) const TILES_PER_ROW: u32 = 32_768;

/// One dispatch of the march.
pub(super) struct Dispatch {
    pub(super) tile_first: u32,
    pub(super) tile_count: u32,
    pub(super) resume: bool,
    pub(super) store_progress: bool,
    /// Whether to hand it to the device on its own.
    pub(super) submit: bool,
}

impl Dispatch {
    /// A workgroup for every so many tiles.
    pub(super) fn launch(&self, pass: &mut wgpu::ComputePass, tiles: u32) {
        let groups = self.tile_count.div_ceil(tiles);
        let rows = groups.div_ceil(TILES_PER_ROW);
        pass.dispatch_workgroups(groups.min(TILES_PER_ROW), rows, 1);
    }
}

/// Cuts a march into dispatches of bounded length.
pub(super) fn dispatches(job: &Job, tile_count: u32, is_software: bool) -> Vec<Dispatch> {
    // A step finds a segment or passes one by: at most two for each block on the way. Methods that find their segments as
    // they go may take a step before every sample. A dispatch that runs out of samples may have to find segments again.
    let [x, y, z] = job.block_dims();
    let finds_on_the_way = job.skip.method().shader != Skip::Box.method().shader;
    let samples = job.scene.frame.max_samples();
    let steps = f64::from(2 * (x + y + z) + 16) + if finds_on_the_way { samples } else { 0.0 };
    let [of_samples, of_steps] =
        [samples, steps].map(|n| ((n / f64::from(MAX_ITERATIONS)).ceil() as u32).max(1));
    let rounds = if of_samples == 1 && of_steps == 1 {
        1
    } else {
        of_samples + of_steps
    };
    let longest = samples + steps;
    let per_tile = longest.min(2.0 * f64::from(MAX_ITERATIONS)) as u64 * u64::from(TILE * TILE);
    // A software driver has no watchdog, and splitting costs it a barrier.
    let tiles_at_once = if is_software && rounds == 1 {
        tile_count.max(1)
    } else {
        ((MAX_SAMPLES_PER_DISPATCH / per_tile.max(1)) as u32).clamp(1, tile_count.max(1))
    };
    let mut list = Vec::new();
    for round in 0..rounds {
        for tile_first in (0..tile_count.max(1)).step_by(tiles_at_once as usize) {
            list.push(Dispatch {
                tile_first,
                tile_count: tiles_at_once.min(tile_count - tile_first.min(tile_count)),
                resume: round > 0,
                store_progress: round + 1 < rounds,
                submit: true,
            });
        }
    }
    list
}
