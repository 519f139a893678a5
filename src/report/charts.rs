//! The charts that the cases allow.

mod blocks;
mod growth;
mod pareto;
mod work;

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::figure::{self, Figure, Series};
use super::model::{Case, Model};
use super::number::percent;
use crate::measure::statistics::median;

/// All charts for which something was measured.
pub(super) fn all(model: &Model) -> Vec<Figure> {
    let mut figures = pareto::figures(model);
    figures.extend(growth::over_volumes(model));
    figures.extend(growth::over_images(model));
    figures.extend(blocks::figures(model));
    figures.extend(work::figures(model));
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

/// What the kinds of a figure's cases are called: with where rays stop and the pictures' size where these differ.
struct Kinds {
    has_ert: bool,
    has_size: bool,
}

impl Kinds {
    fn of(cases: &[Case]) -> Self {
        let differ = |part: fn(&Case, &Case) -> bool| cases.iter().any(|c| part(c, &cases[0]));
        Self {
            has_ert: differ(|a, b| a.record.ert != b.record.ert),
            has_size: differ(|a, b| a.record.size != b.record.size),
        }
    }

    fn name(&self, case: &Case) -> String {
        let mut name = case.kind();
        if self.has_ert {
            name = format!("{name}, ERT {}", case.record.ert);
        }
        if self.has_size {
            let [width, height] = case.record.size;
            name = format!("{name}, {width}x{height}");
        }
        name
    }
}

/// Cases as series: one for each method and kind, joined in the order of `along`.
fn series(
    cases: &[Case],
    along: impl Fn(&Case) -> f64,
    x: impl Fn(&Case) -> f64,
    y: impl Fn(&Case) -> f64,
) -> Vec<Series> {
    let kinds = Kinds::of(cases);
    let mut all: Vec<Series> = Vec::new();
    for case in sorted(cases, along) {
        let point = case.point(x(&case), y(&case));
        figure::add(&mut all, &case.record.method, &kinds.name(&case), point);
    }
    all
}

/// Cases in the order in which their points are joined.
fn sorted<'a>(cases: &[Case<'a>], along: impl Fn(&Case) -> f64) -> Vec<Case<'a>> {
    let mut sorted = cases.to_vec();
    sorted.sort_by(|a, b| along(a).total_cmp(&along(b)));
    sorted
}

/// Of cases that differ in nothing but their blocks, the fastest. Blocks change what lossy methods draw: all of these are
/// kept.
fn fastest_blocks<'a>(cases: impl Iterator<Item = Case<'a>>) -> Vec<Case<'a>> {
    let key = |case: &Case| {
        let record = case.record;
        let block = (!record.lossless).then_some(record.block);
        let [method, step, ert, scene] =
            [&record.method, &record.step, &record.ert, &record.scene].map(String::clone);
        (method, case.kind(), step, ert, scene, record.size, block)
    };
    let mut fastest = BTreeMap::new();
    for case in cases {
        let best = fastest.entry(key(&case)).or_insert(case);
        if case.ms() < best.ms() {
            *best = case;
        }
    }
    fastest.into_values().collect()
}

/// Cases by what all of a figure must share.
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

/// The cases whose method and kind were measured at so many different numbers.
fn varied<'a>(cases: &[Case<'a>], number: impl Fn(&Case) -> f64, least: usize) -> Vec<Case<'a>> {
    let is_varied = |case: &&Case| {
        let is_same = |o: &&Case| o.record.method == case.record.method && o.kind() == case.kind();
        let mut numbers: Vec<f64> = cases.iter().filter(is_same).map(&number).collect();
        numbers.sort_by(f64::total_cmp);
        numbers.dedup();
        numbers.len() >= least
    };
    cases.iter().filter(is_varied).copied().collect()
}

fn ms(case: &Case) -> f64 {
    case.ms()
}

fn step(case: &Case) -> f64 {
    case.record.step_voxels
}

/// The edges of a picture, one where they are equal.
fn edges([width, height]: [u32; 2]) -> String {
    if width == height {
        width.to_string()
    } else {
        format!("{width}x{height}")
    }
}

/// A key as a part of a file's name. Different keys give different names: what cannot stand in one stands as its number.
pub(super) fn file_name(key: &str) -> String {
    let mut name = String::new();
    for c in key.chars() {
        if c.is_ascii_alphanumeric() || c == '-' || c == '.' {
            name.push(c);
        } else {
            // Writing to a String cannot fail.
            let _ = write!(name, "_{:x}_", u32::from(c));
        }
    }
    name
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn different_keys_give_different_names() {
        assert_eq!(file_name("shell-0.5"), "shell-0.5");
        assert_ne!(file_name("\u{e9}"), file_name("\u{fc}"));
        assert_ne!(edges([24, 12]), edges([24, 48]));
    }
}
