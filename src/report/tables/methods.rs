//! Methods by scenes: what each gains, takes and costs.

use std::collections::BTreeMap;

use super::super::charts::noise;
use super::super::model::{Case, Model};
use super::super::number::{bytes, short};
use super::{NONE, Row, Table, commands};
use crate::measure::suite::CaseRecord;
use crate::skip::METHODS;

/// The least number of methods that makes a table worth reading.
const FEW: usize = 4;

/// A number of a case, for one table: a part of its name, its title and what stands in a cell.
type Number = (&'static str, &'static str, fn(&Case) -> String);

const NUMBERS: [Number; 4] = [
    ("speed", "times as fast as box", speed),
    ("samples", "samples taken for each that contributes", |c| {
        short(c.record.samples / c.record.contributing)
    }),
    (
        "memory",
        "memory besides the volume, and the block edge in voxels",
        memory,
    ),
    ("build", "ms to build, classify and cull", |c| {
        short(c.record.preprocess_ms + c.record.cull_ms)
    }),
];

/// A lossy method tells its error with its time.
fn speed(case: &Case) -> String {
    let record = case.record;
    let times = short(record.box_ms / case.ms());
    if record.lossless {
        times
    } else {
        format!("{times} (off by {})", short(record.max_abs_vs_box))
    }
}

fn memory(case: &Case) -> String {
    let CaseRecord {
        structure_bytes,
        block,
        ..
    } = *case.record;
    match (structure_bytes, &case.record.chosen) {
        (0, _) => NONE.to_owned(),
        (some, Some(chosen)) => format!("{} ({chosen})", bytes(some)),
        (some, None) => format!("{} ({block})", bytes(some)),
    }
}

/// For each backend and sampler one table of each number, at the step, size and threshold that most methods were measured
/// at in most scenes; of block sizes the fastest.
pub(super) fn tables(model: &Model) -> Vec<Table> {
    let mut groups: BTreeMap<_, Vec<Case>> = BTreeMap::new();
    for case in model.usual() {
        let r = case.record;
        let key = (r.step.clone(), r.size, r.ert.clone());
        groups.entry(key).or_default().push(case);
    }
    // Of equals the finest step, where skipping counts most.
    let finest = |cases: &[Case]| -cases[0].record.step_voxels;
    let Some(cases) = groups.into_values().max_by(|a, b| {
        let by_number = pairs(a).cmp(&pairs(b));
        by_number.then(finest(a).total_cmp(&finest(b)))
    }) else {
        return Vec::new();
    };
    let mut kinds: BTreeMap<String, Vec<Case>> = BTreeMap::new();
    for case in cases {
        kinds.entry(case.kind()).or_default().push(case);
    }
    kinds.retain(|_, cases| methods(cases).len() >= FEW);
    let of_kind = |(kind, cases): (&String, &Vec<Case>)| NUMBERS.map(|n| table(kind, cases, n));
    kinds.iter().flat_map(of_kind).collect()
}

/// How many methods were measured in how many scenes.
fn pairs(cases: &[Case]) -> usize {
    let mut pairs: Vec<(&str, &str)> = cases
        .iter()
        .map(|c| (c.scene.name.as_str(), c.record.method.as_str()))
        .collect();
    pairs.sort_unstable();
    pairs.dedup();
    pairs.len()
}

/// The methods of some cases, in the order of the table of methods; auto is the last.
fn methods<'a>(cases: &[Case<'a>]) -> Vec<&'a str> {
    let mut names: Vec<&str> = cases.iter().map(|c| c.record.method.as_str()).collect();
    let place = |name: &str| METHODS.iter().position(|m| m.name == name);
    names.sort_by_key(|name| place(name).unwrap_or(METHODS.len()));
    names.dedup();
    names
}

fn table(kind: &str, cases: &[Case], (id, title, cell): Number) -> Table {
    let mut scenes: Vec<&Case> = Vec::new();
    for case in cases {
        if !scenes.iter().any(|c| c.scene.name == case.scene.name) {
            scenes.push(case);
        }
    }
    let fastest = |method: &str, scene: &str| {
        let own = |c: &&Case| c.record.method == method && c.scene.name == scene;
        let all = cases.iter().filter(own);
        all.min_by(|a, b| a.ms().total_cmp(&b.ms()))
    };
    let row = |method: &str| {
        let found: Vec<Option<&Case>> = scenes
            .iter()
            .map(|s| fastest(method, &s.scene.name))
            .collect();
        let mut cells = vec![method.to_owned()];
        cells.extend(found.iter().map(|c| c.map_or(NONE.to_owned(), cell)));
        if id == "speed" {
            let logs = found.iter().flatten();
            let logs: Vec<f64> = logs.map(|c| (c.record.box_ms / c.ms()).ln()).collect();
            cells.push(short((logs.iter().sum::<f64>() / logs.len() as f64).exp()));
        }
        Row {
            cells,
            is_published: false,
            commands: commands(found.iter().copied().flatten()),
        }
    };
    let rows = methods(cases).into_iter().map(row).collect();
    let mut head = vec!["method".to_owned()];
    head.extend(scenes.iter().map(|c| c.scene.title.clone()));
    if id == "speed" {
        head.push("mean".to_owned());
    }
    let note = match id {
        "speed" => format!(
            "The mean is geometric; of block sizes the fastest counts. {}",
            noise(cases)
        ),
        "build" => "Each was built once: the noise is unknown.".to_owned(),
        "samples" => {
            "Counted: it depends on no machine, but for where k-cuts cuts and what auto chooses."
                .to_owned()
        }
        _ => String::new(),
    };
    let first = cases[0].record;
    let [width, height] = first.size;
    Table {
        id: format!("methods-{id}-{}", super::super::charts::file_name(kind)),
        title: format!(
            "{kind}: {title} (step {}, {width}x{height}, ERT {})",
            first.step, first.ert
        ),
        note,
        head,
        rows,
    }
}
