//! What `auto` chooses, against box and against the best that an exhaustive search finds, on a declared grid of cases.
//!
//! `cargo bench --bench auto -- [cpu|gpu] [part of a case's name]`. A case fails against box where the time ratio's lower
//! 95 % bootstrap bound over 15 interleaved pairs exceeds 1.05. Against the best of the search, it is off where the same
//! bound exceeds 1.10; at most one case in ten may be off. Exit code 1 where either does not hold.

use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;

use anyhow::Result;
use hollowcast::camera::Orbit;
use hollowcast::measure::statistics::{Ratio, interleaved, median, paired_ratio};
use hollowcast::measure::verify::View;
use hollowcast::render::{BLOCKS, BackendChoice, Choice, Renderer, Settings};
use hollowcast::transfer::TransferFunction;
use hollowcast::volume::{self, Statistics, Volume};

/// Width and height of every picture.
const SIZE: [u32; 2] = [256, 256];
/// Pairs of the final.
const PAIRS: usize = 15;
/// Rounds of the search.
const ROUNDS: usize = 3;
/// How many of the search go into the final with box and auto.
const FINALISTS: usize = 3;
/// A case fails where auto certainly takes more than this of box's time.
const OVER_BOX: f64 = 1.05;
/// A case is off where auto certainly takes more than this of the best's time.
const OVER_BEST: f64 = 1.10;
/// Share of the cases that must not be off.
const SHARE: f64 = 0.9;

/// Volumes, each with two tables.
const VOLUMES: &[(&str, [&str; 2])] = &[
    ("data/qim3d_shell.nrrd", ["translucent", "surface"]),
    ("data/stent.nrrd", ["translucent", "opaque"]),
    ("phantom:pot:128", ["ramp:40:255:0.3", "ramp:120:255:0.02"]),
    ("phantom:shells:96", ["ramp:40:255:0.3", "ramp:40:255:0.01"]),
    ("phantom:sphere:128", ["translucent", "ramp:40:255:0.02"]),
    ("phantom:thin:96", ["translucent", "ramp:40:255:0.1"]),
    ("phantom:capsules:112", ["translucent", "ramp:40:255:0.02"]),
    ("phantom:gyroid:96", ["translucent", "ramp:40:255:0.02"]),
    ("phantom:menger:81", ["translucent", "ramp:40:255:0.02"]),
    ("phantom:full:64", ["ramp:0:255:0.3", "ramp:0:255:0.01"]),
    ("phantom:noise:64", ["ramp:40:255:0.3", "ramp:250:255:0.1"]),
    ("phantom:empty:96", ["ramp:40:255:0.3", "ramp:40:255:0.1"]),
    (
        "phantom:ramp:96x64x128",
        ["ramp:200:255:0.3", "ramp:60:255:0.02"],
    ),
];

/// Where each case looks from, and its step in voxels: every volume and table meets two of four views and both steps.
const VIEWS: [(&str, f64); 4] = [("far", 0.5), ("near", 1.0), ("side", 1.0), ("cavity", 0.5)];

struct Case {
    name: String,
    volume: Arc<Volume>,
    transfer: TransferFunction,
    settings: Settings,
}

/// The grid, one case after another; only those whose name holds `part`.
fn cases(part: &str) -> Result<Vec<Case>> {
    let mut cases = Vec::new();
    for (spec, tables) in VOLUMES {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(spec);
        let spec_or_path = if spec.starts_with("phantom:") {
            (*spec).to_owned()
        } else {
            path.display().to_string()
        };
        let volume = Arc::new(volume::load(&spec_or_path, None)?);
        for (t, table) in tables.iter().enumerate() {
            let transfer = TransferFunction::from_spec(table, &Statistics::of(&volume))?;
            for (view, step_voxels) in VIEWS.iter().skip(t).step_by(2) {
                let name = format!("{spec} {table} {view} {step_voxels}");
                if !name.contains(part) {
                    continue;
                }
                let orbit = |azimuth_degrees, elevation_degrees, distance_edges| {
                    Orbit {
                        azimuth_degrees,
                        elevation_degrees,
                        distance_edges,
                        ..Orbit::default()
                    }
                    .camera(volume.extent())
                };
                let camera = match *view {
                    "far" => orbit(30.0, 20.0, 2.0),
                    "near" => orbit(120.0, -35.0, 1.1),
                    "side" => orbit(0.0, 0.0, 1.5),
                    _ => View::Cavity.camera(&volume, &transfer, false),
                };
                let settings = Settings {
                    step_voxels: *step_voxels,
                    size: SIZE,
                    ..Settings::new(camera)
                };
                cases.push(Case {
                    name,
                    volume: Arc::clone(&volume),
                    transfer: transfer.clone(),
                    settings,
                });
            }
        }
    }
    Ok(cases)
}

/// What came of a case.
struct Verdict {
    over_box: Ratio,
    over_best: Ratio,
    words: String,
}

fn main() -> Result<ExitCode> {
    let args: Vec<String> = std::env::args()
        .skip(1)
        .filter(|a| !a.starts_with("--"))
        .collect();
    let backends = [BackendChoice::Cpu, BackendChoice::Gpu];
    let named = |b: &BackendChoice| args.iter().any(|a| a == b.name());
    let all = !backends.iter().any(named);
    let part = args.iter().find(|a| !["cpu", "gpu"].contains(&a.as_str()));
    let cases = cases(part.map_or("", String::as_str))?;
    let mut passed = true;
    for &backend in backends.iter().filter(|b| all || named(b)) {
        let mut renderer = Renderer::new(backend)?;
        println!("{} {}", renderer.info().backend, renderer.info().adapter);
        println!("ratios: median (95 % bounds)");
        let (mut over_box, mut off) = (0, 0);
        for case in &cases {
            let verdict = judge(&mut renderer, case)?;
            let fails = verdict.over_box.lower > OVER_BOX;
            let is_off = verdict.over_best.lower > OVER_BEST;
            over_box += u32::from(fails);
            off += u32::from(is_off);
            println!(
                "{:4} {:48} /box {} /best {} {}",
                match (fails, is_off) {
                    (true, _) => "FAIL",
                    (false, true) => "off",
                    (false, false) => "ok",
                },
                case.name.trim_start_matches("phantom:"),
                words(&verdict.over_box),
                words(&verdict.over_best),
                verdict.words,
            );
        }
        let within = 1.0 - f64::from(off) / cases.len() as f64;
        println!(
            "{}: {} cases; over box in {over_box}; within {:.0} % of the best in {:.1} %",
            backend.name(),
            cases.len(),
            100.0 * (OVER_BEST - 1.0),
            100.0 * within,
        );
        passed &= over_box == 0 && within >= SHARE;
    }
    Ok(ExitCode::from(u8::from(!passed)))
}

fn words(ratio: &Ratio) -> String {
    format!(
        "{:.2} ({:.2}-{:.2})",
        ratio.median, ratio.lower, ratio.upper
    )
}

/// Searches exhaustively, then lets the best, box and auto draw in pairs.
fn judge(renderer: &mut Renderer, case: &Case) -> Result<Verdict> {
    renderer.set_volume(Arc::clone(&case.volume))?;
    renderer.set_transfer(case.transfer.clone());
    let auto = renderer.choose(&case.settings)?;
    let mut tried = renderer.candidates(&BLOCKS);
    let mut draw = |choice: &Choice| -> Result<f64> {
        Ok(renderer.draw(&choice.in_settings(&case.settings))?.frame_ms)
    };
    let mut times = vec![Vec::new(); tried.len()];
    for choice in &tried {
        draw(choice)?;
    }
    for i in interleaved(tried.len(), ROUNDS) {
        // Who took twice the best's time in the first round is out.
        let least = times
            .iter()
            .flatten()
            .copied()
            .fold(f64::INFINITY, f64::min);
        if times[i].first().is_none_or(|first| *first < 2.0 * least) {
            times[i].push(draw(&tried[i])?);
        }
    }
    let base = tried[0];
    let mut order: Vec<usize> = (0..tried.len()).collect();
    order.sort_by(|&a, &b| median(&times[a]).total_cmp(&median(&times[b])));
    tried = order
        .into_iter()
        .take(FINALISTS)
        .map(|i| tried[i])
        .collect();
    for choice in [base, auto] {
        if !tried.contains(&choice) {
            tried.push(choice);
        }
    }
    let mut finals = vec![Vec::new(); tried.len()];
    for i in interleaved(tried.len(), PAIRS) {
        finals[i].push(draw(&tried[i])?);
    }
    let place = |choice: &Choice| {
        tried
            .iter()
            .position(|c| c == choice)
            .expect("it was added")
    };
    let best = (0..tried.len())
        .min_by(|&a, &b| median(&finals[a]).total_cmp(&median(&finals[b])))
        .expect("box is there");
    let ratio = |a: usize, b: usize| {
        let pairs = finals[a].iter().zip(&finals[b]).map(|(a, b)| [*a, *b]);
        paired_ratio(&pairs.collect::<Vec<_>>())
    };
    Ok(Verdict {
        over_box: ratio(place(&auto), place(&base)),
        over_best: ratio(place(&auto), best),
        words: format!(
            "auto {} {:.1} ms; best {} {:.1} ms; box {:.1} ms",
            auto.words(),
            median(&finals[place(&auto)]),
            tried[best].words(),
            median(&finals[best]),
            median(&finals[place(&base)]),
        ),
    })
}
