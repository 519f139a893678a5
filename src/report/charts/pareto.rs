//! Error over time.

use super::super::figure::{self, Axis, Figure, Point, Series};
use super::super::model::{Case, Model};
use super::super::number::short;
use super::{Kinds, fastest_blocks, file_name, ms, noise, series, sorted, step};
use crate::skip::METHODS;

/// Every scene, after all of them.
pub(super) fn figures(model: &Model) -> Vec<Figure> {
    let mut figures = Vec::new();
    let mut measured = Vec::new();
    for scene in model.scenes() {
        let has_error = |c: &Case| c.record.error.is_some();
        let cases = fastest_blocks(model.of_scene(&scene.name).filter(has_error));
        let Some(error) = cases.first().and_then(|c| c.record.error.as_ref()) else {
            continue;
        };
        let [width, height] = error.size;
        figures.push(
            Figure {
                id: format!("pareto-{}", file_name(&scene.name)),
                title: format!("Error over time: {}", scene.title),
                note: format!(
                    "Root mean square error against the converged picture ({width}x{height} pixels, linear colour, full scale \
                     1) over frame time; of block sizes the fastest. Lines join the steps of a method. Lossless methods lie \
                     at the height of their step: they change the time alone. {}",
                    noise(&cases)
                ),
                x: Axis::new("ms a frame"),
                y: Axis::new("RMS error"),
                levels: levels(&cases),
                series: series(&cases, step, ms, rms),
                ..Figure::default()
            }
            .with_front_of(is_a_way_to_draw),
        );
        measured.push(cases);
    }
    if measured.len() > 1 {
        figures.insert(0, over_all(&measured));
    }
    figures
}

fn rms(case: &Case) -> f64 {
    case.record.error.as_ref().map_or(f64::NAN, |e| e.rms)
}

/// The errors of box without early termination, by step and sampler.
fn levels(cases: &[Case]) -> Vec<(f64, String)> {
    let mut levels: Vec<(f64, String)> = Vec::new();
    let is_whole_box = |c: &&Case| c.record.method == "box" && c.record.ert == "off";
    for case in cases.iter().filter(is_whole_box) {
        let level = rms(case);
        let is_near = |other: &f64| (level / other).log10().abs() < 0.06;
        if level > 0.0 && !levels.iter().any(|(l, _)| is_near(l)) {
            let name = format!("box at {}, {}", case.record.step, case.record.sampler);
            levels.push((level, name));
        }
    }
    levels
}

/// Geometric means over scenes, of what was measured in all of them.
fn over_all(measured: &[Vec<Case>]) -> Figure {
    let key = |c: &Case| {
        let r = c.record;
        let block = (!r.lossless).then_some(r.block);
        (
            r.method.clone(),
            c.kind(),
            r.step.clone(),
            r.ert.clone(),
            r.size,
            block,
        )
    };
    let every: Vec<Case> = measured.iter().flatten().copied().collect();
    let kinds = Kinds::of(&every);
    let mut all: Vec<Series> = Vec::new();
    for first in sorted(&measured[0], step) {
        let of_scenes = measured.iter();
        let same: Vec<&Case> = of_scenes
            .filter_map(|cases| cases.iter().find(|c| key(c) == key(&first)))
            .collect();
        if same.len() < measured.len() {
            continue;
        }
        let mean = |of: fn(&Case) -> f64| {
            let logs: f64 = same.iter().map(|c| of(c).ln()).sum();
            (logs / same.len() as f64).exp()
        };
        let (x, y) = (mean(ms), mean(rms));
        let record = first.record;
        let kind = kinds.name(&first);
        let commands: Vec<&str> = same.iter().map(|c| c.record.command.as_str()).collect();
        let point = Point {
            x,
            y,
            label: format!(
                "{}, step {}, {kind}: {} ms, RMS error {}",
                record.method,
                record.step,
                short(x),
                short(y)
            ),
            command: commands.join("\n"),
        };
        figure::add(&mut all, &record.method, &kind, point);
    }
    Figure {
        id: "pareto".to_owned(),
        title: format!("Error over time: all {} scenes", measured.len()),
        note: format!(
            "Geometric means over the scenes, of what was measured in all of them. {}",
            noise(&every)
        ),
        x: Axis::new("ms a frame"),
        y: Axis::new("RMS error"),
        series: all,
        ..Figure::default()
    }
    .with_front_of(is_a_way_to_draw)
}

/// Of these series the front is made: the oracle, which is told what to sample, is a limit that nobody can draw by.
fn is_a_way_to_draw(series: &Series) -> bool {
    METHODS
        .iter()
        .all(|m| !m.is_limit || m.name != series.method)
}
