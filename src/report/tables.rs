//! The published tables beside what was measured, and tables of what the charts leave out.

use super::charts::noise;
use super::model::{Case, Model};
use super::number::{bytes, percent, short};
use super::papers::{self, Split};
use crate::measure::suite::Paper;

/// Nothing was measured.
const NONE: &str = "\u{2013}";

/// A table.
#[derive(Debug)]
pub(super) struct Table {
    pub(super) id: String,
    pub(super) title: String,
    pub(super) note: String,
    pub(super) head: Vec<String>,
    pub(super) rows: Vec<Row>,
}

/// A row: its first cell names it.
#[derive(Debug)]
pub(super) struct Row {
    pub(super) cells: Vec<String>,
    /// Whether someone else measured it.
    pub(super) is_published: bool,
    /// What measures its numbers again.
    pub(super) commands: Vec<String>,
}

fn head(names: &[&str]) -> Vec<String> {
    names.iter().map(|&n| n.to_owned()).collect()
}

fn published(cells: Vec<String>) -> Row {
    Row {
        cells,
        is_published: true,
        commands: Vec::new(),
    }
}

/// The three tables of the main paper.
pub(super) fn splits(model: &Model) -> Vec<Table> {
    let foot = "The foot of the paper is not available: another solid scan takes its place, and its ratios alone can be compared.";
    let mut tables = vec![preprocessing(model)];
    for (paper, split, number, name, note) in [
        (Paper::Foot, &papers::FOOT, 2, "foot", foot),
        (Paper::Teapot, &papers::TEAPOT, 3, "teapot", ""),
    ] {
        tables.push(split_table(
            model,
            paper,
            split,
            &format!("Table {number}: {name}"),
            note,
        ));
    }
    tables.retain(|t| t.rows.iter().any(|r| !r.is_published));
    tables
}

/// Of the cases beside a data set, those of one kind in one block size at the largest pictures: the block in which
/// half-split is fastest.
fn comparable<'a>(model: &Model<'a>, paper: Paper) -> Vec<Vec<Case<'a>>> {
    let Some(scene) = model.beside(paper) else {
        return Vec::new();
    };
    let cases: Vec<Case> = model
        .of_scene(&scene.name)
        .filter(|c| papers::SPLIT_METHODS.contains(&c.record.method.as_str()))
        .collect();
    let steps = papers::TEAPOT.steps.map(|(step, _)| step);
    let mut kinds: Vec<String> = cases.iter().map(Case::kind).collect();
    kinds.sort();
    kinds.dedup();
    let of_kind = |kind: String| {
        let own: Vec<Case> = cases.iter().filter(|c| c.kind() == kind).copied().collect();
        let is_split =
            |c: &&Case| c.record.method == "half-split" && steps.contains(&c.record.step.as_str());
        let largest = own.iter().filter(is_split).map(|c| c.record.size).max()?;
        let best = own
            .iter()
            .filter(is_split)
            .filter(|c| c.record.size == largest)
            .min_by(|a, b| a.ms().total_cmp(&b.ms()))?;
        let is_drawn_so = |c: &Case| {
            c.record.size == largest
                && c.record.ert == best.record.ert
                && (c.record.method == "box" || c.record.block == best.record.block)
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

fn split_table(model: &Model, paper: Paper, split: &Split, title: &str, note: &str) -> Table {
    let mut rows = Vec::new();
    let kinds = comparable(model, paper);
    for (step, [base, octree, half]) in split.steps {
        rows.push(published(vec![
            step.to_owned(),
            "paper".to_owned(),
            short(base),
            short(octree),
            gain(base, octree),
            short(half),
            gain(base, half),
            short(base / half),
        ]));
        for cases in &kinds {
            let (Some(base), Some(half)) =
                (find(cases, "box", step), find(cases, "half-split", step))
            else {
                continue;
            };
            let octree = find(cases, "octree-encoded", step);
            // Cases of one group took turns; the time of box beside each is that of its own turns.
            rows.push(Row {
                cells: vec![
                    step.to_owned(),
                    base.kind(),
                    short(base.ms()),
                    octree.map_or(NONE.to_owned(), |c| short(c.ms())),
                    octree.map_or(NONE.to_owned(), |c| gain(base.ms(), c.ms())),
                    short(half.ms()),
                    gain(base.ms(), half.ms()),
                    short(base.ms() / half.ms()),
                ],
                is_published: false,
                commands: [Some(base), octree, Some(half)]
                    .into_iter()
                    .flatten()
                    .map(|c| c.record.command.clone())
                    .collect(),
            });
        }
    }
    let ours: Vec<Case> = kinds.into_iter().flatten().collect();
    let ours_is = ours.first().map_or(String::new(), |c| {
        let [width, height] = c.record.size;
        let block = ours
            .iter()
            .find(|c| c.record.method == "half-split")
            .map_or(0, |c| c.record.block);
        format!(
            "Ours: {}, {width}x{height}, {} views, blocks of {block}.",
            drawn_from(c),
            c.record.views
        )
    });
    Table {
        id: format!(
            "table-{}",
            title
                .chars()
                .filter(char::is_ascii_digit)
                .collect::<String>()
        ),
        title: format!("{title}, kernel time"),
        note: format!(
            "{ours_is} {note} Steps are in parts of the cube's edge. {}",
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

fn preprocessing(model: &Model) -> Table {
    let mut rows = Vec::new();
    for (paper, name, split) in [
        (Paper::Foot, "foot", &papers::FOOT),
        (Paper::Teapot, "teapot", &papers::TEAPOT),
    ] {
        let row = |ms: [Option<f64>; 3]| -> Vec<String> {
            let base = ms[0].unwrap_or(f64::NAN);
            ms.iter()
                .map(|ms| ms.map_or(NONE.to_owned(), short))
                .chain([ms[2].map_or(NONE.to_owned(), |half| short(half / base))])
                .collect()
        };
        let named = |place: &str, ms| [vec![name.to_owned(), place.to_owned()], row(ms)].concat();
        rows.push(published(named("paper", split.preprocess_ms.map(Some))));
        for cases in comparable(model, paper) {
            let found = papers::SPLIT_METHODS.map(|m| cases.iter().find(|c| c.record.method == m));
            let times = found.map(|case| {
                let case = case?;
                Some(case.scene.load_ms + case.record.preprocess_ms + case.record.cull_ms)
            });
            rows.push(Row {
                cells: named(&cases[0].kind(), times),
                is_published: false,
                commands: found
                    .into_iter()
                    .flatten()
                    .map(|c| c.record.command.clone())
                    .collect(),
            });
        }
    }
    Table {
        id: "table-1".to_owned(),
        title: "Table 1: preprocessing".to_owned(),
        note: "Reading the volume, and for ours building, classifying and culling for all views: three axes of the octree \
               where views look along each. The foot of the paper is not available: another solid scan takes its place."
            .to_owned(),
        head: head(&["data", "where", "W (box) ms", "octree-encoded ms", "half-split ms", "half-split / box"]),
        rows,
    }
}

/// Pictures per second by mode.
pub(super) fn modes(model: &Model) -> Option<Table> {
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
            let numbers = papers::MODES.iter().map(|(_, rates)| short(rates[i]));
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
        let rates = found
            .iter()
            .map(|c| c.map_or(NONE.to_owned(), |c| short(1000.0 / c.ms())));
        let place = format!("{}, {}", first.record.method, first.kind());
        rows.push(Row {
            cells: [first.scene.title.clone(), place]
                .into_iter()
                .chain(rates)
                .collect(),
            is_published: false,
            commands: found
                .iter()
                .flatten()
                .map(|c| c.record.command.clone())
                .collect(),
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

/// Memory, preprocessing and the time of a table's edit, by scene, method and block.
pub(super) fn structures(model: &Model) -> Option<Table> {
    let mut rows: Vec<Row> = Vec::new();
    for case in model
        .usual()
        .filter(|c| c.record.structure_bytes > 0 && c.record.method != "auto")
    {
        let record = case.record;
        let names = [
            case.scene.title.clone(),
            record.method.clone(),
            record.backend.clone(),
            record.block.to_string(),
        ];
        if rows.iter().any(|r| r.cells[..4] == names) {
            continue;
        }
        let share = record.structure_bytes as f64 / case.scene.bytes as f64;
        rows.push(Row {
            cells: names
                .into_iter()
                .chain([
                    bytes(record.structure_bytes),
                    percent(share),
                    short(record.preprocess_ms),
                    short(record.cull_ms),
                ])
                .collect(),
            is_published: false,
            commands: vec![record.command.clone()],
        });
    }
    (!rows.is_empty()).then(|| Table {
        id: "structures".to_owned(),
        title: "What stands besides the volume".to_owned(),
        note: "Memory, also as a share of the voxels' own; building it once for a volume and all views; and classifying and \
               culling, which follows every edit of the table."
            .to_owned(),
        head: head(&["scene", "method", "backend", "block", "memory", "% of voxels", "build ms", "table edit ms"]),
        rows,
    })
}

/// Every case with all that was measured of it.
pub(super) fn everything(model: &Model) -> Table {
    let rows = model.cases.iter().map(|case| {
        let r = case.record;
        let error = |f: &dyn Fn(&crate::measure::suite::ErrorRecord) -> String| {
            r.error.as_ref().map_or(NONE.to_owned(), f)
        };
        let or_none = |number: Option<f64>| number.map_or(NONE.to_owned(), short);
        Row {
            cells: vec![
                case.scene.title.clone(),
                r.method.clone(),
                case.kind(),
                r.mode.clone(),
                r.step.clone(),
                r.block.to_string(),
                r.ert.clone(),
                format!("{}x{}", r.size[0], r.size[1]),
                format!(
                    "{} ({} to {})",
                    short(r.frame_ms.median),
                    short(r.frame_ms.q1),
                    short(r.frame_ms.q3)
                ),
                short(r.box_ms / r.frame_ms.median),
                r.noise.map_or(NONE.to_owned(), percent),
                short(r.samples),
                short(r.contributing),
                short(r.skip_steps),
                bytes(r.structure_bytes),
                r.differing_pixels_vs_box.to_string(),
                short(r.max_abs_vs_box),
                error(&|e| short(e.rms)),
                error(&|e| short(e.max_abs)),
                error(&|e| short(-20.0 * e.rms.log10())),
                error(&|e| percent(e.off_share)),
                error(&|e| or_none(e.ssim)),
                error(&|e| or_none(e.flip)),
            ],
            is_published: false,
            commands: case.commands(),
        }
    });
    Table {
        id: "everything".to_owned(),
        title: "Every case".to_owned(),
        note: format!(
            "Errors are of linear colour multiplied by opacity, full scale 1, against the converged picture of the first view. {}",
            noise(&model.cases)
        ),
        head: head(&[
            "scene",
            "method",
            "where",
            "mode",
            "step",
            "block",
            "ERT",
            "size",
            "ms (quartiles)",
            "times box",
            "noise %",
            "samples/px",
            "contributing/px",
            "skip steps/px",
            "memory",
            "pixels off box",
            "most off box",
            "RMS",
            "max",
            "PSNR dB",
            "% off by 1/255",
            "SSIM",
            "FLIP",
        ]),
        rows: rows.collect(),
    }
}
