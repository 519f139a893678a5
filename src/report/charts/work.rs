//! Samples taken over samples that contribute, and what time that takes.

use super::super::figure::{Axis, Figure};
use super::super::model::{Case, Model};
use super::{by, file_name, ms, noise, series};

/// One for each scene: of its steps, sizes and thresholds those that most cases were measured at.
pub(super) fn figures(model: &Model) -> Vec<Figure> {
    model
        .scenes()
        .into_iter()
        .filter_map(|scene| figure(model, &scene.name))
        .collect()
}

fn figure(model: &Model, scene: &str) -> Option<Figure> {
    let contributes = |c: &Case| c.record.contributing > 0.0;
    let groups = by(model.of_scene(scene).filter(contributes), |c| {
        format!("{} {:?} {}", c.record.step, c.record.size, c.record.ert)
    });
    // Of groups of one size that with the smallest step, where skipping counts most.
    let of_methods = |cases: &Vec<Case>| {
        let mut methods: Vec<&str> = cases.iter().map(|c| c.record.method.as_str()).collect();
        methods.sort_unstable();
        methods.dedup();
        methods.len()
    };
    let finest = |cases: &Vec<Case>| -cases[0].record.step_voxels;
    let cases = groups.into_values().max_by(|a, b| {
        let by_number = of_methods(a).cmp(&of_methods(b));
        by_number.then(finest(a).total_cmp(&finest(b)))
    })?;
    if of_methods(&cases) < 3 {
        return None;
    }
    let first = cases[0];
    let [width, height] = first.record.size;
    Some(Figure {
        id: format!("work-{}", file_name(scene)),
        title: format!(
            "Time over samples taken for each that contributes: {}, step {}, {width}x{height}, ERT {}",
            first.scene.title, first.record.step, first.record.ert
        ),
        note: format!(
            "Of each pixel {} samples on average add something to the picture; methods take as many times more as stands \
             across: a count that depends on no machine. At 1 is the oracle, which takes no other. Lines join block sizes. {}",
            super::super::number::short(first.record.contributing),
            noise(&cases)
        ),
        x: Axis::new("samples taken over samples that contribute"),
        y: Axis::new("ms a frame"),
        series: series(
            &cases,
            |c| c.record.block as f64,
            |c| c.record.samples / c.record.contributing,
            ms,
        ),
        ..Figure::default()
    })
}
