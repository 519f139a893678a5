//! The three tables of the main paper, beside ours.

use super::super::charts::noise;
use super::super::model::{Case, Model};
use super::super::number::{percent, short};
use super::super::papers::{self, Split};
use super::structures::Building;
use super::{NONE, Row, Table, commands, head, or_none, published};
use crate::measure::suite::Paper;

/// What takes the place of the paper's data.
const FOOT: &str = "The foot of the paper is not available: another solid scan takes its place, and its ratios alone can be compared.";

/// The tables of which something was measured.
pub(super) fn tables(model: &Model) -> Vec<Table> {
    let mut tables = vec![
        preprocessing(model),
        split(model, Paper::Foot, 2),
        split(model, Paper::Teapot, 3),
    ];
    tables.retain(|t| t.rows.iter().any(|r| !r.is_published));
    tables
}

/// The paper's name of a data set, and what it measured of it.
fn of_paper(paper: Paper) -> (&'static str, &'static Split) {
    match paper {
        Paper::Foot => ("foot", &papers::FOOT),
        Paper::Teapot => ("teapot", &papers::TEAPOT),
    }
}

/// Of the cases beside a data set those at the largest pictures, by kind, each in one block size and with one threshold of
/// early termination: those with which half-split is fastest.
fn comparable<'a>(model: &Model<'a>, paper: Paper) -> Vec<Vec<Case<'a>>> {
    let Some(scene) = model.beside(paper) else {
        return Vec::new();
    };
    let cases: Vec<Case> = model
        .of_scene(&scene.name)
        .filter(|c| papers::SPLIT_METHODS.contains(&c.record.method.as_str()))
        .collect();
    let steps = papers::TEAPOT.steps.map(|(step, _)| step);
    let is_split =
        |c: &&Case| c.record.method == "half-split" && steps.contains(&c.record.step.as_str());
    let largest = cases.iter().filter(is_split).map(|c| c.record.size).max();
    let cases: Vec<Case> = cases
        .into_iter()
        .filter(|c| Some(c.record.size) == largest)
        .collect();
    let mut kinds: Vec<String> = cases.iter().map(Case::kind).collect();
    kinds.sort();
    kinds.dedup();
    let of_kind = |kind: String| {
        let own: Vec<Case> = cases.iter().filter(|c| c.kind() == kind).copied().collect();
        let splits = own.iter().filter(is_split);
        let best = splits.min_by(|a, b| a.ms().total_cmp(&b.ms()))?.record;
        let is_drawn_so = |c: &Case| {
            c.record.ert == best.ert && (c.record.method == "box" || c.record.block == best.block)
        };
        Some(own.into_iter().filter(is_drawn_so).collect())
    };
    kinds.into_iter().filter_map(of_kind).collect()
}

fn find<'a>(cases: &[Case<'a>], method: &str, step: &str) -> Option<Case<'a>> {
    let is_it = |c: &&Case| c.record.method == method && c.record.step == step;
    cases.iter().find(is_it).copied()
}

/// What a scene is drawn from, in words.
fn drawn_from(case: &Case) -> String {
    match &case.scene.stand_in {
        Some(phantom) => format!("{phantom}, which stands in for {}", case.scene.volume),
        None => case.scene.title.clone(),
    }
}

/// Time saved against box in per cent, as the paper has it.
fn gain(box_ms: f64, ms: f64) -> String {
    percent(1.0 - ms / box_ms)
}

/// Table 2 or 3: the kernel's times by step.
fn split(model: &Model, paper: Paper, number: usize) -> Table {
    let (name, published_split) = of_paper(paper);
    let mut rows = Vec::new();
    let kinds = comparable(model, paper);
    for (step, [base, octree, half]) in published_split.steps {
        rows.push(published(vec![
            step.to_owned(),
            "paper".to_owned(),
            format!("{base:.3}"),
            format!("{octree:.3}"),
            gain(base, octree),
            format!("{half:.3}"),
            gain(base, half),
            format!("{:.2}", base / half),
        ]));
        rows.extend(kinds.iter().filter_map(|cases| measured(cases, step)));
    }
    let ours: Vec<Case> = kinds.into_iter().flatten().collect();
    let ours_is = ours.first().map_or(String::new(), |c| {
        let [width, height] = c.record.size;
        let split = ours.iter().find(|c| c.record.method == "half-split");
        format!(
            "Ours: {}, {width}x{height}, {} views, ERT {}, blocks of {}.",
            drawn_from(c),
            c.record.views,
            c.record.ert,
            split.map_or(0, |c| c.record.block)
        )
    });
    let place = match paper {
        Paper::Foot => format!(" {FOOT}"),
        Paper::Teapot => String::new(),
    };
    Table {
        id: format!("table-{number}"),
        title: format!("Table {number}: {name}, kernel time"),
        note: format!(
            "{ours_is}{place} Steps are in parts of the cube's edge; a gain is the share of box's time that is saved. {}",
            noise(&ours)
        ),
        head: head(&[
            "step",
            "where",
            "W (box) ms",
            "octree-encoded ms",
            "gain %",
            "half-split ms",
            "gain %",
            "box / half-split",
        ]),
        rows,
    }
}

/// A row of ours. Cases of one group took turns; the time of box is that of the same turns.
fn measured(cases: &[Case], step: &str) -> Option<Row> {
    let base = find(cases, "box", step)?;
    let half = find(cases, "half-split", step)?;
    let octree = find(cases, "octree-encoded", step);
    Some(Row {
        cells: vec![
            step.to_owned(),
            base.kind(),
            short(base.ms()),
            or_none(octree.map(|c| c.ms())),
            octree.map_or(NONE.to_owned(), |c| gain(base.ms(), c.ms())),
            short(half.ms()),
            gain(base.ms(), half.ms()),
            format!("{:.2}", base.ms() / half.ms()),
        ],
        is_published: false,
        commands: commands([Some(base), octree, Some(half)].iter().flatten()),
    })
}

/// Table 1.
fn preprocessing(model: &Model) -> Table {
    let mut rows = Vec::new();
    let mut noises = Vec::new();
    for paper in [Paper::Foot, Paper::Teapot] {
        let (name, split) = of_paper(paper);
        let row = |data: &str, place: &str, ms: [Option<f64>; 3]| -> Vec<String> {
            let ratio = ms[0].zip(ms[2]).map(|(base, half)| half / base);
            [data.to_owned(), place.to_owned()]
                .into_iter()
                .chain(ms.into_iter().chain([ratio]).map(or_none))
                .collect()
        };
        rows.push(published(row(name, "paper", split.preprocess_ms.map(Some))));
        for cases in comparable(model, paper) {
            let of_method = |method: &str| -> Vec<Case> {
                cases
                    .iter()
                    .filter(|c| c.record.method == method)
                    .copied()
                    .collect()
            };
            let found = papers::SPLIT_METHODS.map(of_method);
            let times = found.each_ref().map(|own| {
                let first = own.first()?;
                let building = Building::of(own);
                noises.extend(building.noise);
                Some(first.scene.load_ms + building.build_ms + building.edit_ms)
            });
            rows.push(Row {
                cells: row(&cases[0].scene.title, &cases[0].kind(), times),
                is_published: false,
                commands: commands(found.iter().filter_map(|own| own.first())),
            });
        }
    }
    Table {
        id: "table-1".to_owned(),
        title: "Table 1: preprocessing".to_owned(),
        note: format!(
            "Reading the volume (once), and for ours building, classifying and culling for all views: three axes of the octree \
             where views look along each. {FOOT} {}",
            super::structures::noise_of_building(&noises)
        ),
        head: head(&[
            "data",
            "where",
            "W (box) ms",
            "octree-encoded ms",
            "half-split ms",
            "half-split / box",
        ]),
        rows,
    }
}
