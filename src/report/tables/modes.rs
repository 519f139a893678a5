//! The table of modes of the ray caster in CUDA, beside ours.

use super::super::charts::noise;
use super::super::model::{Case, Model};
use super::super::papers;
use super::{Row, Table, commands, head, or_none, published};

/// Pictures per second by mode.
pub(super) fn table(model: &Model) -> Option<Table> {
    let of_source = |c: &&Case| papers::MODES.iter().any(|(mode, _)| *mode == c.record.mode);
    let key = |c: &Case| {
        let r = c.record;
        (
            c.scene.name.clone(),
            c.kind(),
            r.method.clone(),
            r.step.clone(),
            r.block,
            r.size,
        )
    };
    let mut keys = Vec::new();
    for case in model.cases.iter().filter(of_source) {
        if !keys.contains(&key(case)) {
            keys.push(key(case));
        }
    }
    let mut rows: Vec<Row> = ["head", "heart"]
        .iter()
        .enumerate()
        .map(|(i, name)| {
            let numbers = papers::MODES
                .iter()
                .map(|(_, rates)| format!("{:.2}", rates[i]));
            published(
                [(*name).to_owned(), "paper".to_owned()]
                    .into_iter()
                    .chain(numbers)
                    .collect(),
            )
        })
        .collect();
    let mut used = Vec::new();
    for wanted in keys {
        let found: Vec<Option<&Case>> = papers::MODES
            .iter()
            .map(|(mode, _)| {
                model
                    .cases
                    .iter()
                    .find(|c| c.record.mode == *mode && key(c) == wanted)
            })
            .collect();
        if found.iter().flatten().count() < 3 {
            continue;
        }
        let first = found.iter().flatten().next()?;
        let rates = found.iter().map(|c| or_none(c.map(|c| 1000.0 / c.ms())));
        let place = format!("{}, {}", first.record.method, first.kind());
        rows.push(Row {
            cells: [first.scene.title.clone(), place]
                .into_iter()
                .chain(rates)
                .collect(),
            is_published: false,
            commands: commands(found.iter().copied().flatten()),
        });
        used.extend(found.into_iter().flatten().copied());
    }
    let first = used.first()?;
    let [width, height] = first.record.size;
    Some(Table {
        id: "modes".to_owned(),
        title: "Pictures per second by mode".to_owned(),
        note: format!(
            "Beside table 1 of the paper on ray casting in CUDA: a head of 256x256x225 and a heart of 256^3 voxels, 512x512, \
             GeForce 9600GT. Ours: {width}x{height}, step {}. {}",
            first.record.step,
            noise(&used)
        ),
        head: head(&["data", "where"])
            .into_iter()
            .chain(papers::MODES.iter().map(|(mode, _)| (*mode).to_owned()))
            .collect(),
        rows,
    })
}
