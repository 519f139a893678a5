//! `hollowcast stability`: where does each method fail?

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use hollowcast::measure::machine::Machine;
use hollowcast::measure::stability::{
    Atlas, Contestant, Found, GROUPS, Hazard, Row, Verdict, Worst, findings, hazards, markdown,
    tallies,
};
use hollowcast::output::{self, PngEncoding};
use hollowcast::render::{BackendChoice, Renderer};
use hollowcast::scene::Picture;
use hollowcast::{Error, Result};
use serde_json::{Value, json};

use super::progress::Progress;
use super::{report, values};

const EXAMPLES: &str = "\
Examples:
  hollowcast stability                                   every method in every hazard
  hollowcast stability --backends gpu,cpu -o report      with pictures, and one backend against the other
  hollowcast stability --group 5 --method two-step,adaptive
  hollowcast stability --hazard eye-far --json

A hazard is a small scene that some method may fail on: a camera inside a wall, rays in block faces, a table of one spike.
Every contestant draws it; a lossless method is wrong where one pixel differs from box in any bit, a lossy one where a
channel is off by more than 1/255, box where it is off the f64 reference of the same scene by more than 2/255 or under
60 dB. Slow: over 1.1 times box's frame, in the hazards whose names begin with time-. Besides the methods:
hardware-filter, the adapter's interpolation in place of the exact one (gpu); pre-classified, voxels looked up before they
are interpolated (gpu); f32-from-eye, rays measured in f32 from the eye (cpu). What the literature's methods are said to
fail at is listed with what was measured. JSON tells of each first frame its error against the ground truth too (pictures
up to 90x90), which has the step's own error in it and is kept in the cache folder. With -o: rows.json, stability.md and, for every hazard in which something is wrong, the worst picture, what
it should be, and eight times the difference. Exit code 1 where a lossless method is wrong, or one
backend's box is off another's.";

/// Shows where each method fails: draws hazards with all of them, and holds them against box and the f64 reference.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Args {
    /// The contestants; box is added [default: all]
    #[arg(long, value_delimiter = ',', value_name = "NAME", value_parser = contestant)]
    method: Vec<Contestant>,

    /// Where the pictures are made; the second and later ones are held against the first
    #[arg(long, value_delimiter = ',', default_value = "gpu", value_parser = values::named(BackendChoice::ALL, BackendChoice::name))]
    backends: Vec<BackendChoice>,

    /// These hazards alone
    #[arg(long, value_delimiter = ',', value_name = "NAME", value_parser = hazard)]
    hazard: Vec<&'static Hazard>,

    /// The hazards of these groups alone, 1 to 9
    #[arg(long, value_delimiter = ',', value_name = "N", value_parser = clap::value_parser!(u8).range(1..=9))]
    group: Vec<u8>,

    /// A folder for rows.json, stability.md and pictures of what went wrong
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,

    /// Report as JSON on standard output instead of a table
    #[arg(long)]
    json: bool,
}

fn contestant(text: &str) -> std::result::Result<Contestant, String> {
    Contestant::all()
        .find(|c| c.name() == text)
        .ok_or_else(|| one_of(Contestant::all().map(Contestant::name)))
}

fn hazard(text: &str) -> std::result::Result<&'static Hazard, String> {
    hazards()
        .find(|h| h.name == text)
        .ok_or_else(|| one_of(hazards().map(|h| h.name)))
}

fn one_of(names: impl Iterator<Item = &'static str>) -> String {
    format!("expected one of {}", names.collect::<Vec<_>>().join(", "))
}

pub(super) fn run(args: &Args) -> Result<()> {
    let chosen: Vec<&Hazard> = hazards()
        .filter(|h| args.hazard.is_empty() || args.hazard.iter().any(|c| c.name == h.name))
        .filter(|h| args.group.is_empty() || args.group.contains(&h.group))
        .collect();
    if chosen.is_empty() {
        return Err(Error::setting("hazard", "none is in the groups given"));
    }
    let mut contestants = args.method.clone();
    if contestants.is_empty() {
        contestants.extend(Contestant::all());
    }
    if let Some(folder) = &args.output {
        check_folder(folder)?;
    }
    let mut backends = args.backends.iter().enumerate();
    if let Some((_, twice)) = backends.find(|(i, b)| args.backends[..*i].contains(b)) {
        let reason = format!("{} is given twice", twice.name());
        return Err(Error::setting("backends", reason));
    }
    let renderers = args
        .backends
        .iter()
        .map(|&choice| Renderer::new(choice))
        .collect::<Result<Vec<_>>>()?;
    if let Some(nowhere) = args
        .method
        .iter()
        .find(|c| !renderers.iter().any(|r| c.is_on(r)))
    {
        let reason = format!("{} is on none of these backends", nowhere.name());
        return Err(Error::setting("method", reason));
    }
    let adapters: Vec<_> = renderers.iter().map(|r| r.info().clone()).collect();
    let mut atlas = Atlas::new(renderers, &contestants)?.with_truths();
    let progress = Progress::bar("drawing hazards");
    let mut rows: Vec<Row> = Vec::new();
    for (i, hazard) in chosen.iter().enumerate() {
        let Found { rows: found, worst } = atlas.run(hazard)?;
        rows.extend(found);
        if let (Some(folder), Some(worst)) = (&args.output, worst) {
            write_worst(folder, hazard.name, &worst)?;
        }
        progress.set((i + 1) as f64 / chosen.len() as f64);
    }
    drop(progress);

    let words: Vec<String> = adapters.iter().map(report::adapter_words).collect();
    let json = json!({
        "adapters": adapters.iter().map(report::adapter_json).collect::<Vec<Value>>(),
        "rows": rows,
        "claims": findings(&rows),
    });
    if let Some(folder) = &args.output {
        write(&folder.join("rows.json"), &format!("{json:#}\n"))?;
        write(
            &folder.join("stability.md"),
            &document(&chosen, &rows, &words),
        )?;
    }
    if args.json {
        super::print_json(&json)?;
    } else {
        super::print(&format!("{}\n\n{}", words.join("\n"), listing(&rows)))?;
    }
    let failed = rows
        .iter()
        .filter(|r| (r.lossless || r.group == 10) && r.verdict == Verdict::Wrong);
    let failed: Vec<String> = failed
        .map(|r| format!("{} in {} on {}", r.method, r.hazard, r.backend))
        .collect();
    if failed.is_empty() {
        Ok(())
    } else {
        Err(Error::Gpu(format!(
            "not as it should be: {}",
            failed.join(", ")
        )))
    }
}

/// The summary of every group, and every row that is not ok.
fn listing(rows: &[Row]) -> String {
    let mut text = String::new();
    // Writing to a String cannot fail.
    for row in rows.iter().filter(|r| r.verdict != Verdict::Ok) {
        let _ = write!(
            text,
            "{:<6} {:<18} {:<34} {:<9}",
            row.verdict, row.method, row.hazard, row.backend
        );
        if let (Verdict::Slow, Some(time)) = (row.verdict, row.time_vs_box) {
            let _ = writeln!(text, "{time:.2} of box's time");
            continue;
        }
        let _ = write!(
            text,
            "{} pixels differ from box, by up to {:.3e}",
            row.differing_pixels_vs_box, row.max_abs_diff_vs_box
        );
        if let Some(error) = row.error_vs_reference {
            let _ = write!(text, "; {:.3}/255 off the reference", error * 255.0);
        }
        text.push('\n');
    }
    text.push('\n');
    for tally in tallies(rows) {
        let [ok, slow, wrong] = tally.rows;
        let _ = writeln!(
            text,
            "group {:>2}, {}: {ok} ok, {slow} slow, {wrong} wrong; lossless methods wrong in {}",
            tally.group,
            GROUPS[usize::from(tally.group) - 1],
            if tally.lossless_wrong.is_empty() {
                "none".to_owned()
            } else {
                tally.lossless_wrong.join(", ")
            },
        );
    }
    for finding in findings(rows) {
        let _ = writeln!(
            text,
            "{} {:<16} {}: {} in {} on {}",
            if finding.is_shown {
                "shown    "
            } else {
                "not shown"
            },
            finding.claim.method,
            finding.claim.about,
            finding.words(),
            finding.claim.hazard,
            finding.backend,
        );
    }
    text
}

/// The report in markdown.
fn document(hazards: &[&Hazard], rows: &[Row], adapters: &[String]) -> String {
    let mut text = "# Where methods fail\n\nMade by `hollowcast stability -o FOLDER`; `hollowcast stability --help` says what \
                    the verdicts mean. A cell that is slow has the frame's time over box's, one that is wrong the largest \
                    difference from box of a channel whose full scale is 1; box's own column the largest difference from \
                    the f64 reference of the same scene, in 255ths.\n"
        .to_owned();
    let build = if cfg!(debug_assertions) {
        "debug"
    } else {
        "release"
    };
    // Writing to a String cannot fail.
    let _ = writeln!(
        text,
        "\nTaken on {} by a {build} build. Verdicts of right and wrong and all differences do not depend on that; times do \
         (hazards whose names begin with `time-`, medians of interleaved runs). Make the table anew on the machine that \
         you care about.",
        Machine::this().words(),
    );
    for adapter in adapters {
        let backend = adapter.split(' ').next().unwrap_or_default();
        let _ = writeln!(text, "\n## On {adapter}\n\n{}", markdown(rows, backend));
    }
    let pairs: Vec<&Row> = rows.iter().filter(|r| r.group == 10).collect();
    if !pairs.is_empty() {
        text.push_str("## One backend against the other\n\nBox's pictures; the largest difference in 255ths.\n\n");
        text.push_str(
            "| hazard | backends | verdict | largest difference |\n| --- | --- | --- | --- |\n",
        );
        for row in pairs {
            let _ = writeln!(
                text,
                "| {} | {} | {} | {:.3} |",
                row.hazard,
                row.backend,
                row.verdict,
                row.max_abs_diff_vs_box * 255.0
            );
        }
    }
    claims(&mut text, rows);
    text.push_str("\n## The hazards\n\n");
    for hazard in hazards {
        let _ = writeln!(
            text,
            "- **{}** (group {}): {}",
            hazard.name, hazard.group, hazard.about
        );
    }
    text
}

/// What the literature's methods are said to fail at, as a table.
fn claims(text: &mut String, rows: &[Row]) {
    let found = findings(rows);
    if found.is_empty() {
        return;
    }
    text.push_str(
        "\n## Where the literature's methods fail\n\n| method | fails where it | hazard | backend | measured | shown |\n\
         | --- | --- | --- | --- | --- | --- |\n",
    );
    for finding in found {
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} |",
            finding.claim.method,
            finding.claim.about,
            finding.claim.hazard,
            finding.backend,
            finding.words(),
            if finding.is_shown { "yes" } else { "no" },
        );
    }
}

fn write(path: &Path, text: &str) -> Result<()> {
    output::write_atomically(path, |file| file.write_all(text.as_bytes()))
}

/// Makes the folder, and checks that files can be written there before minutes are spent on what they are to hold.
fn check_folder(folder: &Path) -> Result<()> {
    output::make_folder(folder)?;
    let trial = folder.join(".trial");
    write(&trial, "")?;
    std::fs::remove_file(&trial).map_err(|e| Error::io(&trial, e))
}

/// How many times the difference is shown.
const AMPLIFIED: f32 = 8.0;

/// The least edge of a picture, in pixels, that can be looked at.
const LEGIBLE: u32 = 256;

/// The picture, what it should be, and their difference, side by side, each with what it is.
fn write_worst(folder: &Path, hazard: &str, worst: &Worst) -> Result<()> {
    let difference = Picture {
        size: worst.picture.size,
        rgba: worst
            .picture
            .rgba
            .iter()
            .zip(&worst.expected.rgba)
            .map(|(a, b)| {
                let apart: [f32; 3] = std::array::from_fn(|c| {
                    ((a[c] - b[c]).abs().max((a[3] - b[3]).abs()) * AMPLIFIED).min(1.0)
                });
                [apart[0], apart[1], apart[2], 1.0]
            })
            .collect(),
    };
    let expected = if worst.method == "box" {
        "reference"
    } else {
        "box"
    };
    let panels = [
        (
            output::over(&worst.picture, [0.0; 3]),
            worst.method.to_owned(),
        ),
        (output::over(&worst.expected, [0.0; 3]), expected.to_owned()),
        (difference, format!("difference x {AMPLIFIED}")),
    ];
    let panels = panels.map(|(picture, words)| {
        let picture = output::enlarged(&picture, LEGIBLE);
        let caption = output::caption(&words, picture.size[0]);
        output::stacked(&[picture, caption])
    });
    let file = format!("{hazard}-{}-{}.png", worst.method, worst.backend);
    output::write(
        &output::side_by_side(&panels, 4),
        &folder.join(file),
        PngEncoding::default(),
    )
}
