//! `hollowcast bench`: a suite of measurements.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use hollowcast::measure::compare::settings_on;
use hollowcast::measure::machine::Machine;
use hollowcast::measure::statistics::quartiles;
use hollowcast::measure::suite::{
    self, AdapterRecord, Contestant, Group, Header, Heat, PictureRecord, PictureRow, Record,
    Results, SceneRecord, Shown, Suite, What, Writer,
};
use hollowcast::measure::truth::Truths;
use hollowcast::mode::{MODES, Mode};
use hollowcast::render::{BackendChoice, MethodChoice, Renderer, Settings};
use hollowcast::skip::Skip;
use hollowcast::volume::Volume;
use hollowcast::{Error, Result};

use super::compare;
use super::progress::Progress;
use super::suite_words::{self, Place};

const EXAMPLES: &str = "\
Examples:
  hollowcast bench benches/quick.toml -o quick.jsonl       a little of everything
  hollowcast bench benches/paper.toml --data ~/volumes     the tables of the paper that the main method comes from
  hollowcast report quick.jsonl -o quick.html              what was measured, as a page

A suite is a TOML file of scenes and sweeps over backends, methods, blocks, steps, samplers, modes, early termination and
sizes; benches/ has two to begin with. Cases of one scene, mode, size, sampler and step take turns (A B C, A B C, ...), and
do so once more where times scatter. Every finished case is a line of the results, which the command that measures it again
names. A run that was stopped goes on where it was, on the same machine and with the same program; other results are never
overwritten. Volumes are looked for in data/, then in the folder of --data; a missing one is stood in for where the suite
names a phantom.";

/// Measures a suite of cases, as JSON Lines that `hollowcast report` reads.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Args {
    /// The suite
    #[arg(value_name = "SUITE.toml")]
    suite: PathBuf,

    /// The file of results; one of the same suite and machine is gone on with
    #[arg(short, long, value_name = "FILE", default_value = "results.jsonl")]
    output: PathBuf,

    /// The folder of volumes that do not ship with the program [default: what HOLLOWCAST_DATA names]
    #[arg(long, value_name = "FOLDER")]
    data: Option<PathBuf>,
}

/// The backends that the suite asks for and that are here.
struct Backends {
    names: Vec<String>,
    renderers: Vec<Renderer>,
}

/// A group whose commands have been parsed.
struct Planned {
    group: Group,
    /// For each case, its command and what that comes to.
    commands: Vec<(String, compare::Args)>,
}

/// A scene, loaded.
struct Loaded {
    scene: usize,
    volume: Arc<Volume>,
    truths: Truths,
}

pub(super) fn run(args: &Args) -> Result<()> {
    let suite = Suite::read(&args.suite)?;
    let variable = std::env::var_os(suite_words::DATA).map(PathBuf::from);
    let folder = args.data.clone().or(variable);
    let at_fault = |field: String, reason: String| Error::file(&args.suite, field, reason);
    let places = suite.scenes.iter().map(|s| Place::of(s, folder.as_deref()));
    let places = places.collect::<Result<Vec<_>>>().map_err(|e| match e {
        Error::Setting { field, reason } => at_fault(field, reason),
        other => other,
    })?;
    // All of it is checked before any of it is measured.
    let planned = suite
        .groups()
        .into_iter()
        .map(|group| Planned::new(group, &suite, &places))
        .collect::<Result<Vec<_>, _>>()
        .map_err(|(scene, reason)| {
            at_fault(format!("scene \"{}\"", suite.scenes[scene].name), reason)
        })?;
    let (mut backends, header) = open(&suite)?;
    let (mut writer, mut results) = Writer::open(&args.output, &header)?;
    let known = results.cases.len();
    for place in places.iter().filter(|p| p.stand_in.is_some()) {
        eprintln!(
            "notice: {} stands in for a volume that is missing",
            place.path
        );
    }

    let progress = Progress::bar("measuring");
    let all: f64 = planned.iter().map(|p| p.group.weight(&suite)).sum();
    let mut before = 0.0;
    let mut loaded: Option<Loaded> = None;
    for scene in 0..suite.scenes.len() {
        for planned in planned.iter().filter(|p| p.group.scene == scene) {
            let weight = planned.group.weight(&suite);
            let left = |(command, _): &&(String, compare::Args)| !results.has(command);
            if planned.commands.iter().any(|c| left(&c)) {
                let loaded = load(
                    &mut loaded,
                    scene,
                    planned,
                    &suite,
                    &places,
                    &mut backends,
                    &mut results,
                    &mut writer,
                )?;
                let contestants = planned.contestants(&results, loaded, &mut backends)?;
                if !contestants.is_empty() {
                    let heat = Heat {
                        scene: &suite.scenes[scene].name,
                        group: &planned.group,
                        contestants,
                    };
                    let cases = suite::run(
                        &mut backends.renderers,
                        &heat,
                        &mut loaded.truths,
                        &mut |f| {
                            progress.set((before + f * weight) / all);
                        },
                    )?;
                    let records: Vec<Record> = cases
                        .iter()
                        .map(|c| Record::Case(Box::new(c.clone())))
                        .collect();
                    writer.append(&records)?;
                    results.cases.extend(cases);
                }
            }
            before += weight;
            progress.set(before / all);
        }
        for row in suite
            .pictures
            .iter()
            .filter(|p| suite.scene(&p.scene) == Some(scene))
        {
            if let Some(planned) = planned.iter().find(|p| p.group.scene == scene) {
                let records = {
                    if is_shown(row, &results) || !backends.names.contains(&row.backend) {
                        continue;
                    }
                    let loaded = load(
                        &mut loaded,
                        scene,
                        planned,
                        &suite,
                        &places,
                        &mut backends,
                        &mut results,
                        &mut writer,
                    )?;
                    shown(row, planned, &suite, &places[scene], loaded, &mut backends).map_err(
                        |e| match e {
                            Error::Setting { field, reason } => {
                                at_fault(format!("picture of \"{}\": {field}", row.scene), reason)
                            }
                            other => other,
                        },
                    )?
                };
                let lines: Vec<Record> = records.iter().cloned().map(Record::Picture).collect();
                writer.append(&lines)?;
                results.pictures.extend(records);
            }
        }
    }
    drop(progress);
    super::print(&summary(args, &results, known))
}

/// Whether a row's pictures are in the results: they are written at once.
fn is_shown(row: &PictureRow, results: &Results) -> bool {
    results.pictures.iter().any(|p| {
        p.scene == row.scene
            && p.backend == row.backend
            && p.step == row.step
            && p.size == [row.size; 2]
            && row.methods.contains(&p.method)
    })
}

/// Opens what the suite asks for; what is not here is noted.
fn open(suite: &Suite) -> Result<(Backends, Header)> {
    let of_sweeps = suite.sweeps.iter().flat_map(|s| &s.backends);
    let mut names: Vec<&String> = of_sweeps
        .chain(suite.pictures.iter().map(|p| &p.backend))
        .collect();
    names.sort();
    names.dedup();
    let mut backends = Backends {
        names: Vec::new(),
        renderers: Vec::new(),
    };
    let mut header = Header {
        suite: suite.name.clone(),
        suite_hash: suite.hash.clone(),
        machine: Machine::this().into(),
        adapters: Vec::new(),
        missing: Vec::new(),
    };
    let mut last = None;
    for name in names {
        let choice = BackendChoice::ALL.iter().find(|b| b.name() == name);
        match Renderer::new(*choice.expect("checked when it was read")) {
            Ok(renderer) => {
                header
                    .adapters
                    .push(AdapterRecord::new(name, renderer.info()));
                backends.names.push(name.clone());
                backends.renderers.push(renderer);
            }
            Err(error @ Error::Gpu(_)) => {
                eprintln!("notice: {name} is left out: {error}");
                header.missing.push((name.clone(), error.to_string()));
                last = Some(error);
            }
            Err(error) => return Err(error),
        }
    }
    match last {
        Some(error) if backends.names.is_empty() => Err(error),
        _ => Ok((backends, header)),
    }
}

/// Makes `scene` the one that is loaded, and notes it in the results.
#[expect(
    clippy::too_many_arguments,
    reason = "one place loads a scene, and all of this is of it"
)]
fn load<'a>(
    loaded: &'a mut Option<Loaded>,
    scene: usize,
    planned: &Planned,
    suite: &Suite,
    places: &[Place],
    backends: &mut Backends,
    results: &mut Results,
    writer: &mut Writer,
) -> Result<&'a mut Loaded> {
    if loaded.as_ref().is_none_or(|l| l.scene != scene) {
        let args = &planned.commands[0].1;
        let start = Instant::now();
        let volume = args.volume.load()?;
        let load_ms = start.elapsed().as_secs_f64() * 1e3;
        let (transfer, _) = args.scene.transfer_and_mode(&volume)?;
        for renderer in &mut backends.renderers {
            renderer.set_volume(Arc::clone(&volume))?;
            renderer.set_transfer(transfer.clone());
        }
        let row = &suite.scenes[scene];
        if results.scene(&row.name).is_none() {
            let record = SceneRecord {
                name: row.name.clone(),
                title: row.title.clone().unwrap_or_else(|| row.name.clone()),
                volume: row.volume.clone(),
                stand_in: places[scene].stand_in.clone(),
                dims: volume.dims,
                bytes: volume.bytes(),
                load_ms,
                paper: row.paper,
                family: row.family.clone(),
            };
            writer.append(&[Record::Scene(record.clone())])?;
            results.scenes.push(record);
        }
        *loaded = Some(Loaded {
            scene,
            truths: Truths::new(&volume, &transfer)?,
            volume,
        });
    }
    Ok(loaded.as_mut().expect("loaded just above"))
}

impl Planned {
    /// Parses a group's commands; where one is not taken, gives the scene and the reason.
    fn new(group: Group, suite: &Suite, places: &[Place]) -> Result<Self, (usize, String)> {
        let place = &places[group.scene];
        let commands = group
            .cases
            .iter()
            .map(|case| {
                let words = group.words(case, suite, &place.path);
                let args = suite_words::parsed(&words).map_err(|reason| (group.scene, reason))?;
                Ok((suite_words::line("compare", &place.word, &words), args))
            })
            .collect::<Result<Vec<_>, _>>()?;
        Ok(Self { group, commands })
    }

    /// The cases that are left to measure, on backends that are here and have them.
    fn contestants(
        &self,
        results: &Results,
        loaded: &Loaded,
        backends: &mut Backends,
    ) -> Result<Vec<Contestant>> {
        let mut contestants = Vec::new();
        for (case, (command, args)) in self.group.cases.iter().zip(&self.commands) {
            let place = backends.names.iter().position(|n| *n == case.backend);
            let Some(renderer) = place.filter(|_| !results.has(command)) else {
                continue;
            };
            let (_, mode) = args.scene.transfer_and_mode(&loaded.volume)?;
            let views = args.scene.camera.views(&loaded.volume, args.views);
            let drawing = &mut backends.renderers[renderer];
            let views = views.into_iter().map(|camera| {
                let settings = settings(args, mode, &loaded.volume, camera)?;
                let settings = settings_on(drawing.info().backend, &settings);
                match args.methods[0] {
                    MethodChoice::Only(skip) if !has(drawing, skip, &mode) => Ok(None),
                    MethodChoice::Only(_) => Ok(Some(settings)),
                    MethodChoice::Auto => {
                        Ok(Some(drawing.choose(&settings)?.in_settings(&settings)))
                    }
                }
            });
            if let Some(views) = views.collect::<Result<Option<Vec<_>>>>()? {
                contestants.push(Contestant {
                    case: case.clone(),
                    command: command.clone(),
                    renderer,
                    views,
                });
            }
        }
        Ok(contestants)
    }
}

/// Whether a renderer draws a method itself, in this mode.
fn has(renderer: &Renderer, skip: Skip, mode: &Mode) -> bool {
    renderer.has(skip)
        && !renderer.withdrawn().contains(&skip)
        && mode.check_backend(renderer.info().backend).is_ok()
}

/// What a command draws in one view.
fn settings(
    args: &compare::Args,
    mode: Mode,
    volume: &Volume,
    camera: hollowcast::camera::Camera,
) -> Result<Settings> {
    let skip = match args.methods[0] {
        MethodChoice::Only(skip) => skip,
        MethodChoice::Auto => Skip::Box,
    };
    let clipping = args.scene.clip.clipping(volume)?;
    let step = args.steps[0].in_box(volume.extent());
    Ok(args
        .scene
        .settings(skip, mode, args.blocks[0], step.voxels, camera, &clipping))
}

/// Draws a row of pictures.
fn shown(
    row: &PictureRow,
    planned: &Planned,
    suite: &Suite,
    place: &Place,
    loaded: &mut Loaded,
    backends: &mut Backends,
) -> Result<Vec<PictureRecord>> {
    let scene = &suite.scenes[planned.group.scene];
    let renderer = backends.names.iter().position(|n| *n == row.backend);
    let renderer = &mut backends.renderers[renderer.expect("asked for by its caller")];
    let mut pictured = Vec::new();
    for method in &row.methods {
        let mut words = vec![place.path.clone(), "--tf".to_owned(), scene.tf.clone()];
        words.extend(scene.flags.iter().cloned());
        let mut flag = |name: &str, value: &str| words.extend([name.to_owned(), value.to_owned()]);
        if let Some(camera) = &scene.camera {
            flag("--camera", camera);
        }
        flag("--size", &row.size.to_string());
        if row.mode != MODES[0].name {
            flag("--mode", &row.mode);
        }
        // The words of render and compare part here.
        let mut of_render = words.clone();
        let flags = |words: &mut Vec<String>, pairs: [(&str, &str); 4]| {
            for (name, value) in pairs {
                words.extend([name.to_owned(), value.to_owned()]);
            }
        };
        let block = row.block.to_string();
        flags(
            &mut of_render,
            [
                ("--step", &row.step),
                ("--backend", &row.backend),
                ("--method", method),
                ("--block", &block),
            ],
        );
        flags(
            &mut words,
            [
                ("--steps", &row.step),
                ("--backends", &row.backend),
                ("--methods", method),
                ("--blocks", &block),
            ],
        );
        let args = suite_words::parsed(&words).map_err(|reason| Error::setting("words", reason))?;
        let (_, mode) = args.scene.transfer_and_mode(&loaded.volume)?;
        let camera = args.scene.camera.camera(&loaded.volume, 0.0);
        let settings = settings(&args, mode, &loaded.volume, camera)?;
        let settings = settings_on(renderer.info().backend, &settings);
        if let MethodChoice::Only(skip) = args.methods[0]
            && has(renderer, skip, &mode)
        {
            pictured.push(Shown {
                command: suite_words::line("render", &place.word, &of_render),
                method: method.clone(),
                settings,
            });
        }
    }
    let Some(first) = pictured.first() else {
        return Ok(Vec::new());
    };
    let truth = loaded.truths.of(&first.settings, |_| ())?;
    let about = PictureRecord {
        command: first.command.clone(),
        scene: row.scene.clone(),
        backend: row.backend.clone(),
        method: String::new(),
        step: row.step.clone(),
        what: What::Picture,
        scale: 1.0,
        size: [row.size; 2],
        png: String::new(),
    };
    suite::pictures(renderer, &pictured, &truth, &about)
}

/// What was done, how far it can be trusted, and what to do with it.
fn summary(args: &Args, results: &Results, known: usize) -> String {
    let file = args.output.display();
    let measured = results.cases.len() - known;
    let mut text = format!(
        "{file}: {} cases, {measured} of them measured now\n",
        results.cases.len()
    );
    let noises: Vec<f64> = results
        .cases
        .iter()
        .filter_map(|c| Some(c.noise? * 100.0))
        .collect();
    if !noises.is_empty() {
        let noise = quartiles(&noises);
        text += &format!(
            "noise: medians are good to {:.1} % (standard error), a quarter of them not to {:.1} %\n",
            noise.median, noise.q3
        );
    }
    text + &format!("hollowcast report {file} -o report.html makes a page of it\n")
}
