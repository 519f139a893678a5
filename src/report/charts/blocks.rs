//! What the size of blocks decides.

use super::super::figure::{Axis, Figure};
use super::super::model::{Case, Model};
use super::{by, edges, file_name, noise, series, varied};

/// What is upwards: a part of the figure's name, a title, a unit and a number.
type Number = (&'static str, &'static str, &'static str, fn(&Case) -> f64);

const NUMBERS: [Number; 5] = [
    ("blocks", "Frame time", "ms a frame", |c| c.ms()),
    ("samples", "Samples", "samples a pixel", |c| {
        c.record.samples
    }),
    ("memory", "Structure memory", "KiB", |c| {
        c.record.structure_bytes as f64 / 1024.0
    }),
    ("build", "Preprocessing", "ms to build", |c| {
        c.record.preprocess_ms + c.record.cull_ms
    }),
    ("edit", "Edit of the table", "ms to cull again", |c| {
        c.record.cull_ms
    }),
];

/// All of them over the block size, for what was measured in three sizes at least.
pub(super) fn figures(model: &Model) -> Vec<Figure> {
    let has_blocks = |c: &Case| c.record.structure_bytes > 0 && c.record.method != "auto";
    let groups = by(model.usual().filter(has_blocks), |c| {
        let record = c.record;
        format!(
            "{}-{}-{}-{}",
            c.scene.name,
            record.step,
            edges(record.size),
            record.ert
        )
    });
    let mut figures = Vec::new();
    for (key, cases) in groups {
        let cases = varied(&cases, block, 3);
        let Some(first) = cases.first() else {
            continue;
        };
        let [width, height] = first.record.size;
        let of = format!(
            "{}, step {}, {width}x{height}, ERT {}",
            first.scene.title, first.record.step, first.record.ert
        );
        figures.extend(NUMBERS.map(|(id, title, unit, number)| Figure {
            id: format!("by-block-{id}-{}", file_name(&key)),
            title: format!("{title} over block size: {of}"),
            note: if id == "blocks" {
                noise(&cases)
            } else {
                String::new()
            },
            x: Axis::chosen("block edge in voxels"),
            y: Axis::new(unit),
            series: series(&cases, block, block, number),
            ..Figure::default()
        }));
    }
    figures
}

fn block(case: &Case) -> f64 {
    case.record.block as f64
}
