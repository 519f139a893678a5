//! `hollowcast report`: results of `bench` as a page.

use std::path::PathBuf;

use hollowcast::measure::suite::Results;
use hollowcast::report::Atlas;
use hollowcast::{Error, Result, report};

use super::same_file::is_same_file;

const EXAMPLES: &str = "\
Examples:
  hollowcast bench benches/quick.toml -o quick.jsonl
  hollowcast report quick.jsonl -o quick.html
  hollowcast report laptop.jsonl workstation.jsonl -o both.html --charts charts
  hollowcast stability -o hazards && hollowcast report quick.jsonl --stability hazards/rows.json

The page is one file that needs no network: charts of error over time with their Pareto fronts, the published tables beside
what was measured, pictures, and under each number the command that measures it again. --charts writes its charts as SVG and
PNG files too, and its pictures; --tables its tables as Markdown.";

/// Makes a page of measured results.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Args {
    /// Files that `hollowcast bench` wrote
    #[arg(value_name = "RESULTS", required = true)]
    results: Vec<PathBuf>,

    /// What `hollowcast stability -o FOLDER` wrote: its rows.json, for a table of methods by hazards
    #[arg(long, value_name = "ROWS.json")]
    stability: Option<PathBuf>,

    /// The page
    #[arg(short, long, value_name = "FILE", default_value = "report.html")]
    output: PathBuf,

    /// A folder for the charts as SVG and PNG files, and the pictures
    #[arg(long, value_name = "DIR")]
    charts: Option<PathBuf>,

    /// A file for the tables as Markdown
    #[arg(long, value_name = "FILE.md")]
    tables: Option<PathBuf>,
}

pub(super) fn run(args: &Args) -> Result<()> {
    check_outputs(args)?;
    let atlas = args.stability.as_deref().map(Atlas::read).transpose()?;
    let results = args.results.iter().map(|path| Results::read(path));
    let results = results.collect::<Result<Vec<_>>>()?;
    let figures = report::write(&results, atlas.as_ref(), &args.output)?;
    let mut files = vec![args.output.clone()];
    if let Some(tables) = &args.tables {
        report::write_tables(&results, tables)?;
        files.push(tables.clone());
    }
    if let Some(folder) = &args.charts {
        files.extend(report::write_charts(&figures, folder)?);
        files.extend(report::write_pictures(&results, folder)?);
    }
    let lines: Vec<String> = files.iter().map(|f| f.display().to_string()).collect();
    super::print(&(lines.join("\n") + "\n"))
}

/// Checks, before anything is read, that no output is a folder, an input or another output.
fn check_outputs(args: &Args) -> Result<()> {
    let outputs = [
        ("output", Some(&args.output)),
        ("tables", args.tables.as_ref()),
    ];
    for (name, output) in outputs {
        let Some(output) = output else { continue };
        let bad = |reason: &str| Err(Error::file(output, name, reason));
        if args.results.iter().any(|r| is_same_file(r, output)) {
            return bad("is one of the results, which would be lost");
        }
        if args
            .stability
            .as_ref()
            .is_some_and(|s| is_same_file(s, output))
        {
            return bad("is the table of hazards, which would be lost");
        }
        if output.is_dir() {
            return bad("is a folder");
        }
    }
    match &args.tables {
        Some(tables) if is_same_file(tables, &args.output) => Err(Error::file(
            tables,
            "tables",
            "is the page too, which would be lost",
        )),
        _ => Ok(()),
    }
}
