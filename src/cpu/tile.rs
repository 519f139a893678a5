//! One tile of pixels, packet by packet.

use super::march::{Job, Marcher, Pixel, Skipping, Tally};
use super::packet::{LANES, Packet, Voxel};
use crate::lattice::RayBasis;
use crate::skip::beam_masks::TileRuns;

/// Pixels of a packet: two rows of four, whose rays stay closer together than those of one row.
const PACKET: [u32; 2] = [4, 2];

/// A tile's pixels: from (x, y) on, `width` x the number of rows it is drawn into.
#[derive(Debug, Clone, Copy)]
pub(super) struct TileArea {
    pub(super) x: u32,
    pub(super) y: u32,
}

/// Draws a tile into its rows, which are as long as it is wide. Every path runs this function, inlined into one that has
/// its instructions.
#[inline(always)]
pub(super) fn draw<P: Packet, V: Voxel, O: Pixel>(
    job: &Job<'_, V>,
    area: TileArea,
    rows: &mut [&mut [O]],
) {
    let (width, height) = (rows[0].len() as u32, rows.len() as u32);
    let mut runs = TileRuns::default();
    if let Skipping::Layers(masks, collapse) = job.skip {
        let (x, y) = (area.x..area.x + width, area.y..area.y + height);
        masks.find(job.frame, x, y, *collapse, &mut runs);
        if runs.is_empty() {
            for row in rows {
                row.fill(O::EMPTY);
            }
            return;
        }
    }
    let basis = job.frame.basis::<P>();
    for y in (0..height).step_by(PACKET[1] as usize) {
        for x in (0..width).step_by(PACKET[0] as usize) {
            draw_packet::<P, V, O>(job, &basis, &runs, area, [x, y], rows);
        }
    }
}

/// Draws the packet whose first pixel is `at`, counted from the tile's.
#[inline(always)]
fn draw_packet<P: Packet, V: Voxel, O: Pixel>(
    job: &Job<'_, V>,
    basis: &RayBasis<P>,
    runs: &TileRuns,
    area: TileArea,
    at: [u32; 2],
    rows: &mut [&mut [O]],
) {
    // Lanes beyond the tile's edge repeat the last pixel.
    let (width, height) = (rows[0].len() as u32, rows.len() as u32);
    let pixel: [[u32; 2]; LANES] = std::array::from_fn(|lane| {
        let lane = lane as u32;
        [
            (at[0] + lane % PACKET[0]).min(width - 1),
            (at[1] + lane / PACKET[0]).min(height - 1),
        ]
    });
    let ray = basis.ray(
        P::from_lanes(pixel.map(|p| (area.x + p[0]) as f32)),
        P::from_lanes(pixel.map(|p| (area.y + p[1]) as f32)),
    );
    macro_rules! march {
        ($count:literal) => {{
            let mut marcher = Marcher::<P, V, $count>::new(job, ray);
            match job.skip {
                Skipping::Box => marcher.take(ray.k_near, ray.k_end),
                Skipping::Distance(map) => marcher.leap(map),
                Skipping::Layers(..) => {
                    let mut k = ray.k_near;
                    for i in 0..runs.len() {
                        let [first, end] = runs.range(&ray, i);
                        // Neighbouring runs may share a lattice point where they round towards each other.
                        marcher.take(first.max(k), end);
                        k = end.max(k);
                    }
                }
            }
            (marcher.pixels(), marcher.tally)
        }};
    }
    let (rgba, tally) = if O::COUNT {
        march!(true)
    } else {
        march!(false)
    };
    let rgba = rgba.map(P::to_lanes);
    let tally = tally.columns();
    for (lane, &[x, y]) in pixel.iter().enumerate() {
        let rgba = rgba.map(|channel| channel[lane]);
        rows[y as usize][x as usize] = O::new(rgba, Tally::<P>::lane(&tally, lane));
    }
}
