//! `hollowcast bench`: a suite of measurements.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use hollowcast::camera::Camera;
use hollowcast::measure::compare::settings_on;
use hollowcast::measure::machine::Machine;
use hollowcast::measure::statistics::quartiles;
use hollowcast::measure::suite::{
    self, AdapterRecord, Contestant, Group, Header, Heat, Record, Results, SceneRecord, SceneRow,
    Suite, Writer,
};
use hollowcast::measure::truth::Truths;
use hollowcast::mode::Mode;
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
sizes; benches/ has three to begin with. Cases of one scene, mode, size, sampler and step take turns (A B C, A B C, ...), and
do so once more where times scatter. Every finished case is a line of the results, which the command that measures it again
names. A run that was stopped goes on where it was, on the same machine and with the same program; other results are never
overwritten. Volumes are looked for in data/, in data/ beside the suite's folder, then in the folder of --data; a missing one is stood in for where the suite
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

    /// The folder of volumes that do not ship with the program [default: that of the variable `HOLLOWCAST_DATA`]
    #[arg(long, value_name = "FOLDER")]
    data: Option<PathBuf>,
}

/// A suite on its way.
pub(super) struct Bench<'a> {
    pub(super) suite: &'a Suite,
    /// Of every scene, in the suite's order.
    pub(super) places: &'a [Place],
    /// What the suite asks for and what is here, by name.
    pub(super) backends: Vec<String>,
    /// The same, ready to draw the scene that is loaded.
    pub(super) renderers: Vec<Renderer>,
    pub(super) results: Results,
    pub(super) writer: Writer,
    pub(super) loaded: Option<Loaded>,
}

/// A scene, loaded.
pub(super) struct Loaded {
    scene: usize,
    pub(super) volume: Arc<Volume>,
    pub(super) truths: Truths,
}

/// A group whose commands have been parsed.
pub(super) struct Planned {
    pub(super) group: Group,
    commands: Vec<Words>,
}

/// A case's command.
struct Words {
    /// As it is typed.
    line: String,
    /// What it comes to.
    args: compare::Args,
}

pub(super) fn run(args: &Args) -> Result<()> {
    let suite = Suite::read(&args.suite)?;
    let variable = std::env::var_os(suite_words::DATA).map(PathBuf::from);
    let folder = args.data.clone().or(variable);
    let place = |scene| Place::of(scene, &args.suite, folder.as_deref());
    let places = suite.scenes.iter().map(place);
    let places = places.collect::<Result<Vec<_>>>();
    let places = places.map_err(|e| e.in_file(&args.suite))?;
    // All of it is checked before any of it is measured.
    let planned = suite.groups().into_iter().map(|group| {
        let scene = &suite.scenes[group.scene].name;
        Planned::new(group, &suite, &places)
            .map_err(|reason| Error::file(&args.suite, format!("scene \"{scene}\""), reason))
    });
    let planned = planned.collect::<Result<Vec<_>>>()?;
    let (backends, renderers, header) = open(&suite)?;
    let (writer, results) = Writer::open(&args.output, &header)?;
    for (scene, place) in suite.scenes.iter().zip(&places) {
        if let Some(phantom) = &place.stand_in {
            let volume = scene.volume.escape_debug();
            eprintln!("notice: {phantom} stands in for {volume}, which is missing");
        }
    }

    // Voxels are compared when a scene is loaded; what stands in can be told before anything is measured.
    for (row, place) in suite.scenes.iter().zip(&places) {
        if let Some(known) = results.scene(&row.name) {
            known.check_same(&known.voxels_sha256, place.stand_in.as_deref())?;
        }
    }
    let known = results.cases.len();
    let mut bench = Bench {
        suite: &suite,
        places: &places,
        backends,
        renderers,
        results,
        writer,
        loaded: None,
    };
    let progress = Progress::bar("measuring");
    let all: f64 = planned.iter().map(|p| p.group.weight(&suite)).sum();
    let mut before = 0.0;
    for scene in 0..suite.scenes.len() {
        let of_scene = || planned.iter().filter(|p| p.group.scene == scene);
        let pictures = suite.pictures.iter();
        let pictures = pictures.filter(|row| suite.scene(&row.scene) == Some(scene));
        for planned in of_scene() {
            let weight = planned.group.weight(&suite);
            bench.measure(planned, &mut |f| progress.set((before + f * weight) / all))?;
            before += weight;
        }
        // Any group of the scene tells how it is loaded.
        if let Some(planned) = of_scene().next() {
            for row in pictures {
                let shown = bench.show(row, planned);
                shown.map_err(|e| e.in_file(&args.suite))?;
            }
        }
    }
    drop(progress);
    super::print(&summary(&args.output, &bench.results, known))
}

/// Opens what the suite asks for; what is not here is noted.
fn open(suite: &Suite) -> Result<(Vec<String>, Vec<Renderer>, Header)> {
    let of_sweeps = suite.sweeps.iter().flat_map(|s| &s.backends);
    let mut names: Vec<&String> = of_sweeps
        .chain(suite.pictures.iter().map(|p| &p.backend))
        .collect();
    names.sort();
    names.dedup();
    let (mut backends, mut renderers) = (Vec::new(), Vec::new());
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
                backends.push(name.clone());
                renderers.push(renderer);
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
        Some(error) if backends.is_empty() => Err(error),
        _ => Ok((backends, renderers, header)),
    }
}

impl Planned {
    /// Parses a group's commands; gives the reason where one is not taken.
    fn new(group: Group, suite: &Suite, places: &[Place]) -> Result<Self, String> {
        let place = &places[group.scene];
        let commands = group.cases.iter().map(|case| {
            let words = group.words(case, suite, &place.path);
            Ok(Words {
                line: suite_words::line("compare", &place.word, &words),
                args: suite_words::parsed(&words)?,
            })
        });
        let commands = commands.collect::<Result<Vec<_>, String>>()?;
        Ok(Self { group, commands })
    }
}

impl Bench<'_> {
    /// Measures what is left of a group, and writes it down.
    fn measure(&mut self, planned: &Planned, progress: &mut dyn FnMut(f64)) -> Result<()> {
        if planned.commands.iter().all(|c| self.results.has(&c.line)) {
            return Ok(());
        }
        self.load(planned)?;
        let contestants = self.contestants(planned)?;
        let Some(loaded) = self.loaded.as_mut().filter(|_| !contestants.is_empty()) else {
            return Ok(());
        };
        let heat = Heat {
            scene: &self.suite.scenes[planned.group.scene].name,
            group: &planned.group,
            contestants,
        };
        let cases = suite::run(&mut self.renderers, &heat, &mut loaded.truths, progress)?;
        let record = |case| Record::Case(Box::new(case));
        let records: Vec<Record> = cases.iter().cloned().map(record).collect();
        self.writer.append(&records)?;
        self.results.cases.extend(cases);
        Ok(())
    }

    /// Makes the group's scene the one that is loaded, and notes it in the results.
    pub(super) fn load(&mut self, planned: &Planned) -> Result<()> {
        let scene = planned.group.scene;
        if self.loaded.as_ref().is_some_and(|l| l.scene == scene) {
            return Ok(());
        }
        let args = &planned.commands[0].args;
        let start = Instant::now();
        let volume = args.volume.load()?;
        let load_ms = start.elapsed().as_secs_f64() * 1e3;
        let (transfer, _) = args.scene.transfer_and_mode(&volume)?;
        for renderer in &mut self.renderers {
            renderer.set_volume(Arc::clone(&volume))?;
            renderer.set_transfer(transfer.clone());
        }
        let row = &self.suite.scenes[scene];
        let voxels_sha256 = SceneRecord::voxels_sha256(&volume);
        let stand_in = &self.places[scene].stand_in;
        if let Some(known) = self.results.scene(&row.name) {
            known.check_same(&voxels_sha256, stand_in.as_deref())?;
        } else {
            let record = SceneRecord {
                name: row.name.clone(),
                title: titled(row, stand_in.as_deref()),
                volume: row.volume.clone(),
                stand_in: stand_in.clone(),
                voxels_sha256,
                dims: volume.dims,
                bytes: volume.bytes(),
                load_ms,
                paper: row.paper,
                family: row.family.clone(),
            };
            self.writer.append(&[Record::Scene(record.clone())])?;
            self.results.scenes.push(record);
        }
        self.loaded = Some(Loaded {
            scene,
            truths: Truths::new(&volume, &transfer)?,
            volume,
        });
        Ok(())
    }

    /// The cases of a group that are left to measure, on backends that are here and have them.
    fn contestants(&mut self, planned: &Planned) -> Result<Vec<Contestant>> {
        let volume = &self.loaded.as_ref().expect("loaded by the caller").volume;
        let mut contestants = Vec::new();
        for (case, words) in planned.group.cases.iter().zip(&planned.commands) {
            let place = self.backends.iter().position(|n| *n == case.backend);
            let Some(renderer) = place.filter(|_| !self.results.has(&words.line)) else {
                continue;
            };
            let args = &words.args;
            let (_, mode) = args.scene.transfer_and_mode(volume)?;
            let drawing = &mut self.renderers[renderer];
            let views = args.scene.camera.views(volume, args.views);
            let views = views.into_iter().map(|camera| {
                let settings = settings(args, mode, volume, camera)?;
                let settings = settings_on(drawing.info().backend, &settings);
                Ok(match args.methods[0] {
                    MethodChoice::Only(skip) => has(drawing, skip, &settings).then_some(settings),
                    MethodChoice::Auto if !has_classes(drawing, &settings) => None,
                    MethodChoice::Auto => Some(drawing.choose(&settings)?.in_settings(&settings)),
                })
            });
            if let Some(views) = views.collect::<Result<Option<Vec<_>>>>()? {
                contestants.push(Contestant {
                    case: case.clone(),
                    command: words.line.clone(),
                    renderer,
                    views,
                });
            }
        }
        Ok(contestants)
    }
}

/// A scene's title, which tells wherever it stands what was drawn in its place.
fn titled(row: &SceneRow, stand_in: Option<&str>) -> String {
    let title = row.title.as_ref().unwrap_or(&row.name);
    match stand_in {
        Some(phantom) => format!("{title} ({phantom} in its place)"),
        None => title.clone(),
    }
}

/// Whether a renderer draws a method itself, in the mode and classification of these settings.
pub(super) fn has(renderer: &Renderer, skip: Skip, settings: &Settings) -> bool {
    renderer.has(skip)
        && !renderer.withdrawn().contains(&skip)
        && settings.mode.check_backend(renderer.info().backend).is_ok()
        && has_classes(renderer, settings)
}

/// Whether it has the classification: what backend `auto` comes to is not known to the suite.
fn has_classes(renderer: &Renderer, settings: &Settings) -> bool {
    let backend = renderer.info().backend;
    settings.classification.check_backend(backend).is_ok()
}

/// What a command draws in one view.
pub(super) fn settings(
    args: &compare::Args,
    mode: Mode,
    volume: &Volume,
    camera: Camera,
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

/// What was done, how far it can be trusted, and what to do with it.
fn summary(file: &Path, results: &Results, known: usize) -> String {
    let file = file.display();
    let measured = results.cases.len() - known;
    let all = results.cases.len();
    let noises: Vec<f64> = results
        .cases
        .iter()
        .filter_map(|c| Some(c.noise? * 100.0))
        .collect();
    let noise = if noises.is_empty() {
        "unknown, of fewer than three runs each".to_owned()
    } else {
        let noise = quartiles(&noises);
        format!(
            "medians are good to {:.1} % (standard error), a quarter of them not to {:.1} %",
            noise.median, noise.q3
        )
    };
    format!(
        "{file}: {all} cases, {measured} of them measured now\nnoise: {noise}\nhollowcast report {file} -o report.html makes a page of it\n"
    )
}
