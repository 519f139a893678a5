//! The table of speeds: pictures per second of every mode, with and without skipping.

use hollowcast::measure::compare::{Comparison, Row};
use serde::Serialize;
use serde_json::{Value, json};

use super::table;

/// A mode on one backend at one step and block size: box against the fastest other method, and slices.
#[derive(Debug, Serialize)]
struct Speeds<'a> {
    mode: &'static str,
    backend: &'static str,
    step: &'a str,
    block: usize,
    box_per_second: f64,
    /// The fastest of the methods that were compared, box among them.
    best: &'a str,
    best_per_second: f64,
    gain: f64,
    /// `None` where no slices were drawn.
    slices_per_second: Option<f64>,
    box_samples_per_pixel: f64,
    best_samples_per_pixel: f64,
    best_skip_steps_per_pixel: f64,
    contributing_samples_per_pixel: f64,
    /// By all methods together.
    differing_pixels_vs_box: u64,
}

fn per_second(row: &Row) -> f64 {
    1e3 / row.frame_ms
}

fn is_slices(row: &Row) -> bool {
    row.method == "slices"
}

/// What the rows of one mode say, by step, block and backend.
fn speeds<'a>(mode: &'static str, rows: &'a [Row]) -> Vec<Speeds<'a>> {
    let of_one = |a: &Row, b: &Row| (&a.step, a.block, a.backend) == (&b.step, b.block, b.backend);
    rows.chunk_by(of_one)
        .filter_map(|rows| {
            let rays = || rows.iter().filter(|r| !is_slices(r));
            let by_box = rays().find(|r| r.method == "box")?;
            let best = rays().min_by(|a, b| a.frame_ms.total_cmp(&b.frame_ms))?;
            Some(Speeds {
                mode,
                backend: by_box.backend,
                step: &by_box.step,
                block: by_box.block,
                box_per_second: per_second(by_box),
                best: best.method,
                best_per_second: per_second(best),
                gain: best.speedup_vs_box,
                slices_per_second: rows.iter().find(|r| is_slices(r)).map(per_second),
                box_samples_per_pixel: by_box.samples_per_pixel,
                best_samples_per_pixel: best.samples_per_pixel,
                best_skip_steps_per_pixel: best.skip_steps_per_pixel,
                contributing_samples_per_pixel: best.contributing_samples_per_pixel,
                differing_pixels_vs_box: rays().map(|r| r.differing_pixels_vs_box).sum(),
            })
        })
        .collect()
}

/// The table for the eye.
pub(super) fn text(modes: &[(&'static str, Comparison)]) -> String {
    let head = [
        "mode",
        "backend",
        "step",
        "best",
        "block",
        "box /s",
        "best /s",
        "gain",
        "slices /s",
        "box samples/px",
        "best samples/px",
        "skips/px",
        "used/px",
        "pixels off",
    ];
    let cells: Vec<Vec<String>> = modes
        .iter()
        .flat_map(|(mode, comparison)| speeds(mode, &comparison.rows))
        .map(|s| {
            vec![
                s.mode.to_owned(),
                s.backend.to_owned(),
                s.step.to_owned(),
                s.best.to_owned(),
                s.block.to_string(),
                format!("{:.1}", s.box_per_second),
                format!("{:.1}", s.best_per_second),
                format!("{:.2}", s.gain),
                s.slices_per_second
                    .map_or("-".to_owned(), |n| format!("{n:.1}")),
                format!("{:.1}", s.box_samples_per_pixel),
                format!("{:.1}", s.best_samples_per_pixel),
                format!("{:.1}", s.best_skip_steps_per_pixel),
                format!("{:.1}", s.contributing_samples_per_pixel),
                s.differing_pixels_vs_box.to_string(),
            ]
        })
        .collect();
    table::columns(&head, &cells, 4)
}

/// The same as JSON, with all rows that it is made from.
pub(super) fn json(modes: &[(&'static str, Comparison)]) -> Value {
    modes
        .iter()
        .map(|(mode, comparison)| {
            json!({
                "mode": mode,
                "speeds": speeds(mode, &comparison.rows),
                "rows": comparison.rows,
            })
        })
        .collect()
}
