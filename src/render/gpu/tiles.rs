//! Which 8x8 pixel tiles can show anything: the others are not marched.
//!
//! Boxes around the active parts are projected on the CPU in f64; a tile that no box's rectangle touches is left clear.
//! Beam masks tell by themselves, and what runs of layers each tile's rays go through.

use glam::{DMat4, DVec3};
use rayon::prelude::*;

use crate::gpu::abi::Tile;
use crate::lattice::RayFrame;
use crate::skip::beam_masks::{BeamMasks, Collapse, TileRuns};

/// Edge of a tile in pixels: the marcher's workgroup.
pub(super) const TILE: u32 = 8;

/// The tiles of one target, one bit each while they are being found.
pub(super) struct TileMask {
    tiles: [u32; 2],
    marked: Vec<bool>,
}

impl TileMask {
    /// No tile of a target of `size` pixels.
    pub(super) fn new(size: [u32; 2]) -> Self {
        let tiles = size.map(|n| n.div_ceil(TILE));
        Self {
            tiles,
            marked: vec![false; (tiles[0] * tiles[1]) as usize],
        }
    }

    /// Marks the tiles that a box's projection may touch. `clip_from_local` is that of the whole picture of
    /// `picture` pixels, of which the target begins at `origin`.
    pub(super) fn mark(
        &mut self,
        clip_from_local: &DMat4,
        picture: [u32; 2],
        origin: [u32; 2],
        [low, high]: [DVec3; 2],
    ) {
        let mut min = [f64::INFINITY; 2];
        let mut max = [f64::NEG_INFINITY; 2];
        let mut behind = 0;
        for i in 0..8u32 {
            let pick = |bit: u32, a: f64, b: f64| if i >> bit & 1 == 0 { a } else { b };
            let corner = DVec3::new(
                pick(0, low.x, high.x),
                pick(1, low.y, high.y),
                pick(2, low.z, high.z),
            );
            let clip = *clip_from_local * corner.extend(1.0);
            // In front of the near plane, where dividing is safe: z is what clips.
            if clip.z <= 0.0 {
                behind += 1;
                continue;
            }
            let pixel = [
                (clip.x / clip.w * 0.5 + 0.5) * f64::from(picture[0]),
                (0.5 - clip.y / clip.w * 0.5) * f64::from(picture[1]),
            ];
            for a in 0..2 {
                min[a] = min[a].min(pixel[a]);
                max[a] = max[a].max(pixel[a]);
            }
        }
        if behind == 8 {
            return;
        }
        if behind > 0 {
            self.marked.fill(true);
            return;
        }
        // Half a pixel would do for the rasteriser's rounding; a whole one costs next to nothing.
        let first = |a: usize| {
            ((min[a] - 1.0 - f64::from(origin[a])) / f64::from(TILE))
                .floor()
                .max(0.0) as u32
        };
        let last = |a: usize| ((max[a] + 1.0 - f64::from(origin[a])) / f64::from(TILE)).floor();
        if last(0) < 0.0 || last(1) < 0.0 {
            return;
        }
        let end = [0, 1].map(|a| (last(a) as u32).saturating_add(1).min(self.tiles[a]));
        for y in first(1)..end[1] {
            let row = (y * self.tiles[0]) as usize;
            if first(0) < end[0] {
                self.marked[row + first(0) as usize..row + end[0] as usize].fill(true);
            }
        }
    }

    /// The marked tiles as the marcher reads them, without runs.
    pub(super) fn list(&self) -> Vec<Tile> {
        let width = self.tiles[0] as usize;
        self.marked
            .iter()
            .enumerate()
            .filter(|(_, marked)| **marked)
            .map(|(i, _)| Tile {
                at: packed((i % width) as u32, (i / width) as u32),
                first_run: 0,
                run_count: 0,
                axis: 0,
            })
            .collect()
    }
}

/// One run for each tile, from where its first begins to where its last ends: where lists of runs are longer than what an
/// adapter binds. More samples, and the same picture.
pub(super) fn joined(mut tiles: Vec<Tile>, runs: &[[f32; 2]]) -> (Vec<Tile>, Vec<[f32; 2]>) {
    let mut of_tiles = Vec::with_capacity(tiles.len());
    for tile in &mut tiles {
        let first = tile.first_run as usize;
        let own = &runs[first..first + tile.run_count as usize];
        if let (Some([begin, _]), Some([_, end])) = (own.first(), own.last()) {
            (tile.first_run, tile.run_count) = (of_tiles.len() as u32, 1);
            of_tiles.push([*begin, *end]);
        }
    }
    (tiles, of_tiles)
}

/// Column and row as the marcher reads them.
fn packed(x: u32, y: u32) -> u32 {
    x | y << 16
}

/// What stands for the ends of runs that have none, in grid coordinates: beyond every ray, and far from overflow.
const FAR: f64 = 1e20;

/// The tiles whose beams meet an active block, and the runs that they share out: begin and end along the tile's axis, in
/// grid coordinates. The target of `size` pixels begins at `origin` in the frame's picture.
pub(super) fn tile_runs(
    masks: &BeamMasks,
    frame: &RayFrame,
    origin: [u32; 2],
    size: [u32; 2],
) -> (Vec<Tile>, Vec<[f32; 2]>) {
    let span = |tile: u32, a: usize| {
        let first = tile * TILE;
        origin[a] + first..origin[a] + (first + TILE).min(size[a])
    };
    let rows: Vec<(Vec<Tile>, Vec<[f32; 2]>)> = (0..size[1].div_ceil(TILE))
        .into_par_iter()
        .map_init(TileRuns::default, |found, y| {
            let (mut tiles, mut runs) = (Vec::new(), Vec::new());
            for x in 0..size[0].div_ceil(TILE) {
                masks.find(frame, span(x, 0), span(y, 1), Collapse::Runs, found);
                if found.is_empty() {
                    continue;
                }
                let first_run = runs.len() as u32;
                match found.axis() {
                    Some(_) => runs.extend(
                        found
                            .spans()
                            .iter()
                            .map(|span| span.map(|c| c.clamp(-FAR, FAR) as f32)),
                    ),
                    None => runs.push([-FAR as f32, FAR as f32]),
                }
                tiles.push(Tile {
                    at: packed(x, y),
                    first_run,
                    run_count: runs.len() as u32 - first_run,
                    axis: found.axis().unwrap_or(3) as u32,
                });
            }
            (tiles, runs)
        })
        .collect();
    let mut all = (Vec::new(), Vec::new());
    for (tiles, runs) in rows {
        let first = all.1.len() as u32;
        all.0.extend(tiles.iter().map(|t| Tile {
            first_run: t.first_run + first,
            ..*t
        }));
        all.1.extend(runs);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Orbit;

    #[test]
    fn every_pixel_that_a_point_of_a_box_projects_to_is_in_a_marked_tile() {
        let extent = DVec3::new(64.0, 50.0, 30.0);
        let picture = [100, 70];
        for azimuth_degrees in [0.0, 33.0, 180.0, 271.0] {
            for distance_edges in [0.2, 0.9, 3.0] {
                let camera = Orbit {
                    azimuth_degrees,
                    distance_edges,
                    ..Orbit::default()
                }
                .camera(extent);
                let clip_from_local = camera.clip_from_local(picture);
                let bounds = [DVec3::new(10.0, 20.0, 5.0), DVec3::new(22.0, 30.0, 9.0)];
                let mut mask = TileMask::new(picture);
                mask.mark(&clip_from_local, picture, [0, 0], bounds);
                let list = mask.list();
                for i in 0..1000 {
                    let f = DVec3::new(
                        f64::from(i % 10),
                        f64::from(i / 10 % 10),
                        f64::from(i / 100),
                    ) / 9.0;
                    let clip =
                        clip_from_local * (bounds[0] + f * (bounds[1] - bounds[0])).extend(1.0);
                    let x = (clip.x / clip.w * 0.5 + 0.5) * 100.0;
                    let y = (0.5 - clip.y / clip.w * 0.5) * 70.0;
                    if clip.z > 0.0 && (0.0..100.0).contains(&x) && (0.0..70.0).contains(&y) {
                        let tile = packed(x as u32 / TILE, y as u32 / TILE);
                        assert!(list.iter().any(|t| t.at == tile), "pixel {x} {y}");
                    }
                }
            }
        }
    }
}
