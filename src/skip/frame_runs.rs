//! Beam masks for a whole picture: the runs of every tile, found once, for who asks pixel by pixel.

use super::beam_masks::{BeamMasks, Collapse, TileRuns};
use super::plan::Listed;
use crate::lattice::{Ray, RayFrame};
use crate::octree::Occupancy;

/// Edge of a tile in pixels: as on the other backends.
const TILE: u32 = 8;

/// The runs of every tile of a picture.
#[derive(Debug)]
pub struct FrameRuns {
    tiles: Vec<TileRuns>,
    /// Tiles per row.
    columns: u32,
}

impl FrameRuns {
    pub(super) fn new(occupancy: &Occupancy, frame: &RayFrame) -> Self {
        let masks = BeamMasks::new(occupancy.clone());
        let [columns, rows] = frame.size.map(|n| n.div_ceil(TILE));
        let span = |tile: u32, a: usize| tile * TILE..((tile + 1) * TILE).min(frame.size[a]);
        let tiles = (0..columns * rows)
            .map(|i| {
                let mut runs = TileRuns::default();
                let [x, y] = [span(i % columns, 0), span(i / columns, 1)];
                masks.find(frame, x, y, Collapse::Runs, &mut runs);
                runs
            })
            .collect();
        Self { tiles, columns }
    }

    /// The runs of the pixel's tile on its ray.
    pub(super) fn segments(&self, ray: &Ray<f64>, pixel: [u32; 2]) -> Listed {
        let tile = &self.tiles[(pixel[1] / TILE * self.columns + pixel[0] / TILE) as usize];
        // Whoever reaches half a step into a run lies at most one sample before or behind it.
        let (pad, all) = ((2.0 * ray.reach).ceil(), [ray.k_near, ray.k_end]);
        (0..tile.len())
            .map(|i| tile.range(ray, i))
            .map(|[first, end]| [(first - pad).max(all[0]), (end + pad).min(all[1])])
            .filter(|[first, end]| first < end)
            .map(|[first, end]| first as u32..end as u32)
            .collect()
    }
}
