//! Memory, preprocessing and the time of a table's edit.

use super::super::model::{Case, Model};
use super::super::number::{bytes, percent, short};
use super::{Row, Table, commands, head, median};
use crate::measure::statistics::noise;

/// What it took to build the structures of one method: medians over the cases that built the same.
pub(super) struct Building {
    pub(super) build_ms: f64,
    pub(super) edit_ms: f64,
    /// Of their sum; `None` of fewer than three cases.
    pub(super) noise: Option<f64>,
}

impl Building {
    /// Of cases of one method, scene, block and backend, at least one.
    pub(super) fn of(cases: &[Case]) -> Self {
        let all = |number: fn(&Case) -> f64| cases.iter().map(number).collect::<Vec<f64>>();
        Self {
            build_ms: median(&all(|c| c.record.preprocess_ms)),
            edit_ms: median(&all(|c| c.record.cull_ms)),
            noise: noise(&all(|c| c.record.preprocess_ms + c.record.cull_ms)),
        }
    }
}

/// How far times of building can be trusted, in words.
pub(super) fn noise_of_building(noises: &[f64]) -> String {
    if noises.is_empty() {
        return "Noise: unknown, each was built fewer than three times.".to_owned();
    }
    format!(
        "Noise: medians over the cases that built the same are good to {} % (standard error).",
        percent(median(noises))
    )
}

/// By scene, method, backend and block.
pub(super) fn table(model: &Model) -> Option<Table> {
    let has_structures = |c: &Case| c.record.structure_bytes > 0 && c.record.method != "auto";
    let mut groups: Vec<([String; 4], Vec<Case>)> = Vec::new();
    for case in model.usual().filter(has_structures) {
        let record = case.record;
        let names = [
            case.scene.title.clone(),
            record.method.clone(),
            record.backend.clone(),
            record.block.to_string(),
        ];
        match groups.iter_mut().find(|(n, _)| *n == names) {
            Some((_, cases)) => cases.push(case),
            None => groups.push((names, vec![case])),
        }
    }
    let mut noises = Vec::new();
    let rows: Vec<Row> = groups
        .into_iter()
        .map(|(names, cases)| {
            let building = Building::of(&cases);
            noises.extend(building.noise);
            // Some keep something for every pixel: the most of all sizes.
            let most = cases.iter().map(|c| c.record.structure_bytes).max();
            let most = most.unwrap_or(0);
            let numbers = [
                bytes(most),
                percent(most as f64 / cases[0].scene.bytes as f64),
                short(building.build_ms),
                short(building.edit_ms),
            ];
            Row {
                cells: names.into_iter().chain(numbers).collect(),
                is_published: false,
                commands: commands(cases.first()),
            }
        })
        .collect();
    (!rows.is_empty()).then(|| Table {
        id: "structures".to_owned(),
        title: "What stands besides the volume".to_owned(),
        note: format!(
            "Memory, also as a share of the voxels' own; building it once for a volume and all views; and classifying and \
             culling, which follows every edit of the table. {}",
            noise_of_building(&noises)
        ),
        head: head(&["scene", "method", "backend", "block", "memory", "% of voxels", "build ms", "table edit ms"]),
        rows,
    })
}
