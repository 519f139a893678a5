//! A long run: `cargo bench --bench soak -- [FRAMES]`, 10,000 unless told otherwise.
//!
//! Random views, tables, methods, blocks and sizes, one after another on one renderer on the best adapter there is. Memory
//! must not grow by more than 32 MB once 500 frames (or a fifth of them) have warmed all up, no frame may fail, and every
//! hundredth picture is drawn by box too and must be the same to the bit. Errors that the device reports fail a frame.

use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context, Result, ensure};
use hollowcast::camera::Orbit;
use hollowcast::render::{BackendChoice, Renderer, Settings};
use hollowcast::sample::Sampler;
use hollowcast::skip::{METHODS, Skip};
use hollowcast::transfer::{ControlPoint, TransferFunction};
use hollowcast::volume::phantom;

/// Frames that may warm up: pipelines, pools and the largest target.
const WARM_UP: u32 = 500;
/// How far memory may grow after them.
const MAX_GROWTH_BYTES: u64 = 32 << 20;
/// Each of these frames is drawn by box too.
const CHECKED: u32 = 100;

/// A small generator (xorshift64): runs repeat.
struct Random(u64);

impl Random {
    fn below(&mut self, n: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) % n
    }

    /// From 0 to 1.
    fn part(&mut self) -> f64 {
        self.below(1 << 20) as f64 / f64::from(1 << 20)
    }

    fn of<T: Copy>(&mut self, values: &[T]) -> T {
        values[self.below(values.len() as u64) as usize]
    }
}

/// Memory of this process that is resident, in bytes; `None` where the system does not tell.
fn resident_bytes() -> Option<u64> {
    let pages = std::fs::read_to_string("/proc/self/statm").ok()?;
    let pages: u64 = pages.split_whitespace().nth(1)?.parse().ok()?;
    Some(pages * 4096)
}

fn table(random: &mut Random) -> Result<TransferFunction> {
    let low = 20.0 + 150.0 * random.part();
    let point = |value, opacity| ControlPoint {
        value,
        opacity,
        color: [0.9, 0.6, 0.4],
    };
    let points = vec![
        point(low, 0.0),
        point(low + 5.0 + 80.0 * random.part(), random.part()),
    ];
    Ok(TransferFunction::new(points, 1.0)?)
}

fn main() -> Result<()> {
    let frames = std::env::args()
        .find_map(|a| a.parse().ok())
        .unwrap_or(10_000);
    let warm_up = WARM_UP.min(frames / 5);
    let mut random = Random(0x9E37_79B9_7F4A_7C15);
    let mut renderer = Renderer::new(BackendChoice::Gpu)?;
    let methods: Vec<Skip> = METHODS
        .iter()
        .filter(|m| m.lossless && !m.is_limit && m.backends.contains(&"gpu"))
        .map(|m| m.skip)
        .collect();
    let volume = Arc::new(phantom::make("shells", [41, 37, 48])?);
    renderer.set_volume(Arc::clone(&volume))?;
    renderer.set_transfer(table(&mut random)?);
    let start = Instant::now();
    let mut warm = None;
    for frame in 0..frames {
        if random.below(10) == 0 {
            renderer.set_transfer(table(&mut random)?);
        }
        let orbit = Orbit {
            azimuth_degrees: 360.0 * random.part(),
            elevation_degrees: 180.0 * random.part() - 90.0,
            distance_edges: 0.1 + 2.0 * random.part(),
            ..Orbit::default()
        };
        let settings = Settings {
            skip: random.of(&methods),
            sampler: Some(Sampler::Exact),
            block: random.of(&[4, 8, 16]),
            step_voxels: random.of(&[0.5, 1.0]),
            ert: random.of(&[0.98, 1.0]),
            size: [random.below(64) as u32 + 1, random.below(64) as u32 + 1],
            table_entries: 256,
            ..Settings::new(orbit.camera(volume.extent()))
        };
        let picture = renderer
            .render(&settings)
            .with_context(|| format!("frame {frame}: {settings:?}"))?
            .picture;
        if frame % CHECKED == 0 {
            let by_box = Settings {
                skip: Skip::Box,
                ..settings
            };
            let differing = renderer
                .render(&by_box)?
                .picture
                .difference(&picture)
                .pixels;
            ensure!(
                differing == 0,
                "frame {frame}: {differing} pixels differ from box: {settings:?}"
            );
        }
        if frame == warm_up {
            warm = resident_bytes();
        }
    }
    println!("{frames} frames in {:.0} s", start.elapsed().as_secs_f64());
    if let (Some(warm), Some(now)) = (warm, resident_bytes()) {
        let grown = now.saturating_sub(warm);
        println!(
            "resident: {} MiB after frame {warm_up}, {} MiB at the end",
            warm >> 20,
            now >> 20
        );
        ensure!(
            grown <= MAX_GROWTH_BYTES,
            "memory grew by {} MiB",
            grown >> 20
        );
    }
    Ok(())
}
