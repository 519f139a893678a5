//! Interleaved runs of plans, in wall and in processor time.

use std::sync::atomic::AtomicBool;
use std::time::Instant;

use anyhow::Result;
use hollowcast::cpu::{self, CpuPlan};
use hollowcast::lattice::RayFrame;
use hollowcast::scene::Picture;
use hollowcast::transfer::Table;
use hollowcast::volume::Volume;

use crate::{SIZE, scene};

/// Milliseconds of the runs of one plan.
#[derive(Default)]
pub(crate) struct Times {
    /// Wall time of each run.
    pub wall_ms: Vec<f64>,
    /// Processor time of all runs and threads together: what other programs on the machine disturb least.
    pub cpu_ms: f64,
}

impl Times {
    pub(crate) fn median(&self) -> f64 {
        let mut sorted = self.wall_ms.clone();
        sorted.sort_by(f64::total_cmp);
        sorted[sorted.len() / 2]
    }

    pub(crate) fn least(&self) -> f64 {
        self.wall_ms.iter().copied().fold(f64::INFINITY, f64::min)
    }

    pub(crate) fn mean_cpu(&self) -> f64 {
        self.cpu_ms / self.wall_ms.len() as f64
    }
}

impl std::fmt::Display for Times {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "median {:.2} ms, least {:.2}, processor {:.2}",
            self.median(),
            self.least(),
            self.mean_cpu()
        )
    }
}

/// Processor time of this process so far, where the system tells (Linux); else 0.
pub(crate) fn cpu_ms() -> f64 {
    let Ok(threads) = std::fs::read_dir("/proc/self/task") else {
        return 0.0;
    };
    let nanoseconds = threads.flatten().filter_map(|thread| {
        let text = std::fs::read_to_string(thread.path().join("schedstat")).ok()?;
        text.split_whitespace().next()?.parse::<f64>().ok()
    });
    nanoseconds.sum::<f64>() * 1e-6
}

/// Times of every plan, one run of each in turn.
pub(crate) fn interleaved(
    rounds: usize,
    plans: &[&CpuPlan],
    volume: &Volume,
    table: &Table,
    frames: &[RayFrame],
) -> Result<Vec<Times>> {
    let mut times: Vec<Times> = plans.iter().map(|_| Times::default()).collect();
    let mut picture = Picture {
        size: SIZE,
        rgba: Vec::new(),
    };
    let cancel = AtomicBool::new(false);
    for round in 0..=rounds {
        for frame in frames {
            for (plan, times) in plans.iter().zip(&mut times) {
                let cpu = cpu_ms();
                let start = Instant::now();
                cpu::render_into(&scene(volume, table, frame), plan, &cancel, &mut picture)?;
                // The first round warms up.
                if round > 0 {
                    times.wall_ms.push(start.elapsed().as_secs_f64() * 1e3);
                    times.cpu_ms += cpu_ms() - cpu;
                }
            }
        }
    }
    Ok(times)
}
