//! The charts that the cases allow.

use std::collections::BTreeMap;

use super::figure::{Axis, Figure, Point, Series};
use super::model::{Case, Model};
use super::number::{percent, short};
use super::papers::REAL_TIME_MS;
use crate::measure::statistics::{line_through, median};
use crate::measure::suite::CaseRecord;

/// All charts for which something was measured.
pub(super) fn all(model: &Model) -> Vec<Figure> {
    let mut figures = paretos(model);
    figures.extend(volume_size(model));
    figures.extend(image_size(model));
    figures.extend(blocks(model));
    figures.extend(work(model));
    figures
}

/// How far the times of these cases can be trusted, in words.
pub(super) fn noise(cases: &[Case]) -> String {
    let noises: Vec<f64> = cases.iter().filter_map(|c| c.record.noise).collect();
    if noises.is_empty() {
        return "Noise of the times: unknown, of fewer than three runs each.".to_owned();
    }
    let most = noises.iter().copied().fold(0.0, f64::max);
    format!(
        "Noise: medians are good to {} % (standard error), the worst to {} %.",
        percent(median(&noises)),
        percent(most)
    )
}

/// Cases as series: one for each method and kind, in the order of `x`.
fn series<'a>(
    cases: impl IntoIterator<Item = Case<'a>>,
    x: impl Fn(&Case) -> f64,
    y: impl Fn(&Case) -> f64,
) -> Vec<Series> {
    let mut all: Vec<Series> = Vec::new();
    for case in cases {
        let (method, kind) = (&case.record.method, case.kind());
        let point = case.point(x(&case), y(&case));
        match all
            .iter_mut()
            .find(|s| s.method == *method && s.kind == kind)
        {
            Some(series) => series.points.push(point),
            None => all.push(Series {
                method: method.clone(),
                kind,
                mark: case.mark(),
                points: vec![point],
            }),
        }
    }
    for series in &mut all {
        series.points.sort_by(|a, b| a.x.total_cmp(&b.x));
    }
    all
}

/// Of cases that differ in nothing but their blocks, the fastest.
fn fastest_blocks<'a>(cases: impl Iterator<Item = Case<'a>>) -> Vec<Case<'a>> {
    let mut fastest: BTreeMap<String, Case> = BTreeMap::new();
    for case in cases {
        let record = case.record;
        let key = format!(
            "{} {} {} {} {} {:?}",
            record.method,
            case.kind(),
            record.step,
            record.ert,
            case.scene.name,
            record.size
        );
        let best = fastest.entry(key).or_insert(case);
        if case.ms() < best.ms() {
            *best = case;
        }
    }
    fastest.into_values().collect()
}

fn ms(case: &Case) -> f64 {
    case.ms()
}

fn rms(case: &Case) -> f64 {
    case.record.error.as_ref().map_or(f64::NAN, |e| e.rms)
}

/// Error over time: every scene, then all of them.
fn paretos(model: &Model) -> Vec<Figure> {
    let mut figures = Vec::new();
    let mut measured = Vec::new();
    for scene in model.scenes() {
        let cases = fastest_blocks(
            model
                .of_scene(&scene.name)
                .filter(|c| c.record.error.is_some()),
        );
        if cases.is_empty() {
            continue;
        }
        let size = cases[0].record.error.as_ref().map_or(0, |e| e.size[0]);
        figures.push(
            Figure {
                id: format!("pareto-{}", scene.name),
                title: format!("Error over time: {}", scene.title),
                note: format!(
                    "Root mean square error against the converged picture ({size} pixels squared, linear colour, full scale 1) \
                     over frame time; of block sizes the fastest. Lossless methods lie at the height of their step: they \
                     change the time alone. {}",
                    noise(&cases)
                ),
                x: Axis::log("ms a frame"),
                y: Axis::log("RMS error"),
                levels: levels(&cases),
                series: by_step(series(cases.iter().copied(), ms, rms)),
                front: Vec::new(),
            }
            .with_front(),
        );
        measured.push(cases);
    }
    if measured.len() > 1 {
        figures.insert(0, over_all(&measured));
    }
    figures
}

/// Points joined from step to step: where the step decides the error, in the order of errors.
fn by_step(mut all: Vec<Series>) -> Vec<Series> {
    for series in &mut all {
        series.points.sort_by(|a, b| a.y.total_cmp(&b.y));
    }
    all
}

/// The errors of box, by kind and step, as far as their names have room.
fn levels(cases: &[Case]) -> Vec<(f64, String)> {
    let mut levels: Vec<(f64, String)> = Vec::new();
    for case in cases.iter().filter(|c| c.record.method == "box") {
        let level = rms(case);
        let is_near = |other: &f64| (level / other).log10().abs() < 0.04;
        if level > 0.0 && !levels.iter().any(|(l, _)| is_near(l)) {
            levels.push((level, format!("box, {}", case.record.step)));
        }
    }
    levels
}

/// Geometric means over scenes, of what was measured in all of them.
fn over_all(measured: &[Vec<Case>]) -> Figure {
    let key = |c: &Case| {
        (
            c.record.method.clone(),
            c.kind(),
            c.record.step.clone(),
            c.record.ert.clone(),
        )
    };
    let mut all: Vec<Series> = Vec::new();
    for first in &measured[0] {
        let same: Vec<&Case> = measured
            .iter()
            .filter_map(|cases| cases.iter().find(|c| key(c) == key(first)))
            .collect();
        if same.len() < measured.len() {
            continue;
        }
        let mean = |of: &dyn Fn(&Case) -> f64| {
            let logs: f64 = same.iter().map(|c| of(c).ln()).sum();
            (logs / same.len() as f64).exp()
        };
        let (x, y) = (mean(&ms), mean(&rms));
        let commands: Vec<&str> = same.iter().map(|c| c.record.command.as_str()).collect();
        let point = Point {
            x,
            y,
            label: format!(
                "{}, step {}, {}: {} ms, RMS error {}",
                first.record.method,
                first.record.step,
                first.kind(),
                short(x),
                short(y)
            ),
            command: commands.join("\n"),
        };
        let (method, kind) = (&first.record.method, first.kind());
        match all
            .iter_mut()
            .find(|s| s.method == *method && s.kind == kind)
        {
            Some(series) => series.points.push(point),
            None => all.push(Series {
                method: method.clone(),
                kind,
                mark: first.mark(),
                points: vec![point],
            }),
        }
    }
    let every: Vec<Case> = measured.iter().flatten().copied().collect();
    Figure {
        id: "pareto".to_owned(),
        title: format!("Error over time: all {} scenes", measured.len()),
        note: format!("Geometric means over the scenes. {}", noise(&every)),
        x: Axis::log("ms a frame"),
        y: Axis::log("RMS error"),
        series: by_step(all),
        front: Vec::new(),
        levels: Vec::new(),
    }
    .with_front()
}

/// What all cases of a figure but what is across must share, to be of one figure.
fn by<'a>(
    cases: impl Iterator<Item = Case<'a>>,
    key: impl Fn(&Case) -> String,
) -> BTreeMap<String, Vec<Case<'a>>> {
    let mut groups: BTreeMap<String, Vec<Case>> = BTreeMap::new();
    for case in cases {
        groups.entry(key(&case)).or_default().push(case);
    }
    groups
}

/// How many different numbers there are.
fn distinct(cases: &[Case], number: impl Fn(&Case) -> f64) -> usize {
    let mut numbers: Vec<f64> = cases.iter().map(number).collect();
    numbers.sort_by(f64::total_cmp);
    numbers.dedup();
    numbers.len()
}

/// The cases whose method and kind were measured at so many different numbers.
fn varied<'a>(cases: &[Case<'a>], number: impl Fn(&Case) -> f64, least: usize) -> Vec<Case<'a>> {
    let is_varied = |c: &&Case| {
        let is_same = |o: &&Case| o.record.method == c.record.method && o.kind() == c.kind();
        let own: Vec<Case> = cases.iter().filter(is_same).copied().collect();
        distinct(&own, &number) >= least
    };
    cases.iter().filter(is_varied).copied().collect()
}

fn voxels_an_axis(case: &Case) -> f64 {
    case.scene
        .dims
        .iter()
        .map(|&n| n as f64)
        .product::<f64>()
        .cbrt()
}

fn pixels_an_axis(case: &Case) -> f64 {
    case.record
        .size
        .map(f64::from)
        .iter()
        .product::<f64>()
        .sqrt()
}

/// Exponents of growth, the slopes in these figures, in words.
fn exponents(series: &[Series]) -> String {
    let slopes: Vec<String> = series
        .iter()
        .filter(|s| s.points.len() > 1)
        .map(|s| {
            let logs: Vec<[f64; 2]> = s.points.iter().map(|p| [p.x.ln(), p.y.ln()]).collect();
            format!("{} ({}) {:.2}", s.method, s.kind, line_through(&logs)[1])
        })
        .collect();
    if slopes.is_empty() {
        return String::new();
    }
    format!(
        "Time grows with the power of what is across, of: {}.",
        slopes.join("; ")
    )
}

fn volume_size(model: &Model) -> Vec<Figure> {
    let groups = by(model.usual().filter(|c| c.scene.family.is_some()), |c| {
        let family = c.scene.family.as_deref().unwrap_or_default();
        format!("{family}-{}-{}", c.record.step, c.record.ert)
    });
    let mut figures = Vec::new();
    for (key, cases) in groups {
        if distinct(&cases, voxels_an_axis) < 2 {
            continue;
        }
        let cases = fastest_blocks(cases.into_iter());
        let series = series(cases.iter().copied(), voxels_an_axis, ms);
        figures.push(Figure {
            id: format!("volume-size-{}", file_name(&key)),
            title: format!(
                "Frame time over volume size: {}, step {}",
                cases[0].scene.family.as_deref().unwrap_or_default(),
                cases[0].record.step
            ),
            note: format!(
                "Beside figure 4 of the paper on standard accelerators, which draws such curves for a VolumePro 1000 and four \
                 graphics cards without giving numbers: it finds the board's growth linear and that of the cards quadratic, \
                 and calls {REAL_TIME_MS} ms real time. {} {}",
                exponents(&series),
                noise(&cases)
            ),
            x: Axis::log("voxels an axis"),
            y: Axis::log("ms a frame"),
            series,
            front: Vec::new(),
            levels: vec![(REAL_TIME_MS, "20 ms: real time".to_owned())],
        });
    }
    figures
}

fn image_size(model: &Model) -> Vec<Figure> {
    let groups = by(model.usual(), |c| {
        format!("{}-{}-{}", c.scene.name, c.record.step, c.record.ert)
    });
    let mut figures = Vec::new();
    for (key, cases) in groups {
        // Methods that were measured in one size alone tell nothing of growth.
        let cases = fastest_blocks(varied(&cases, pixels_an_axis, 3).into_iter());
        if cases.is_empty() {
            continue;
        }
        let series = series(cases.iter().copied(), pixels_an_axis, ms);
        figures.push(Figure {
            id: format!("image-size-{}", file_name(&key)),
            title: format!(
                "Frame time over image size: {}, step {}",
                cases[0].scene.title, cases[0].record.step
            ),
            note: format!("{} {}", exponents(&series), noise(&cases)),
            x: Axis::log("pixels an axis"),
            y: Axis::log("ms a frame"),
            series,
            front: Vec::new(),
            levels: Vec::new(),
        });
    }
    figures
}

fn blocks(model: &Model) -> Vec<Figure> {
    let has_blocks = |c: &Case| c.record.structure_bytes > 0 && c.record.method != "auto";
    let groups = by(model.usual().filter(has_blocks), |c| {
        format!(
            "{}-{}-{}-{}",
            c.scene.name, c.record.step, c.record.size[0], c.record.ert
        )
    });
    let block = |c: &Case| c.record.block as f64;
    let mut figures = Vec::new();
    for (key, cases) in groups {
        let cases = varied(&cases, block, 3);
        if cases.is_empty() {
            continue;
        }
        let CaseRecord {
            step, size, ert, ..
        } = cases[0].record;
        let [width, height] = size;
        let of = format!(
            "{}, step {step}, {width}x{height}, ERT {ert}",
            cases[0].scene.title
        );
        let figure = |id: &str, title: &str, label: &str, y: fn(&Case) -> f64| Figure {
            id: format!("{id}-{}", file_name(&key)),
            title: format!("{title}: {of}"),
            note: noise(&cases),
            x: Axis::log("block edge in voxels"),
            y: Axis::log(label),
            series: series(cases.iter().copied(), block, y),
            front: Vec::new(),
            levels: Vec::new(),
        };
        figures.push(figure(
            "blocks",
            "Frame time over block size",
            "ms a frame",
            ms,
        ));
        figures.push(Figure {
            note: String::new(),
            ..figure("memory", "Structure memory over block size", "KiB", |c| {
                c.record.structure_bytes as f64 / 1024.0
            })
        });
    }
    figures
}

/// Samples taken over samples that contribute.
fn work(model: &Model) -> Option<Figure> {
    let cases = fastest_blocks(model.usual().filter(|c| c.record.contributing > 0.0));
    let contributing = |c: &Case| c.record.contributing;
    let diagonal =
        "the fewer samples beyond those that contribute, the nearer to the oracle's line";
    (!cases.is_empty()).then(|| Figure {
        id: "samples".to_owned(),
        title: "Samples taken over samples that contribute".to_owned(),
        note: format!(
            "Per pixel; these counts depend on no machine: {diagonal}. Of block sizes the fastest."
        ),
        x: Axis::log("contributing samples a pixel"),
        y: Axis::log("samples a pixel"),
        series: series(cases.iter().copied(), contributing, |c| c.record.samples),
        front: Vec::new(),
        levels: Vec::new(),
    })
}

/// A key as a part of a file's name.
pub(super) fn file_name(key: &str) -> String {
    let plain = |c: char| {
        if c.is_ascii_alphanumeric() || c == '-' || c == '.' {
            c
        } else {
            '_'
        }
    };
    key.chars().map(plain).collect()
}
