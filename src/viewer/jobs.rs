//! Work that takes its time beside the window: loading, saving, orbits, sweeps. Each has a thread of its own, tells how far
//! it is, and can be stopped.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex, PoisonError};

use eframe::egui::Context;

use crate::error::{Error, Result};
use crate::octree::BLOCKS;
use crate::output::{self, PngEncoding};
use crate::render::{Choice, Settings};
use crate::scene::{Picture, Progress};
use crate::skip::{Cuts, Skip};
use crate::transfer::TransferFunction;
use crate::volume::{Reading, Source, Statistics, Volume};

use super::look::Way;
use super::overlay::{Key, Overlay};
use super::renderers::{Renderers, chosen, of_panic};

/// What a job is told from outside, and tells.
#[derive(Debug, Default)]
pub struct Control {
    permille: AtomicU32,
    cancelled: AtomicBool,
    drawing: Mutex<Option<Arc<Progress>>>,
    reading: Arc<Reading>,
}

impl Control {
    /// How much is done, 0 to 1; `None` where the job does not tell.
    pub fn fraction(&self) -> Option<f32> {
        let permille = self.permille.load(Ordering::Relaxed);
        let told = (permille > 0).then(|| permille as f32 / 1000.0);
        // After the file is read, its values are counted.
        told.or_else(|| Some(self.reading.fraction()? as f32 * 0.8))
    }

    /// Asks the job to stop.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
        self.reading.cancel();
        let drawing = self.drawing.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(progress) = &*drawing {
            progress.cancel();
        }
    }

    /// Notes how far it is.
    ///
    /// # Errors
    /// [`Error::Cancelled`] where it is to stop.
    fn at(&self, fraction: f64) -> Result<()> {
        let permille = (fraction * 1000.0).clamp(1.0, 1000.0);
        self.permille.store(permille as u32, Ordering::Relaxed);
        if self.cancelled.load(Ordering::Relaxed) {
            Err(Error::Cancelled)
        } else {
            Ok(())
        }
    }

    fn draws(&self, progress: Arc<Progress>) {
        *self.drawing.lock().unwrap_or_else(PoisonError::into_inner) = Some(progress);
    }
}

/// A picture to make at full quality.
#[derive(Debug, Clone)]
pub struct Shot {
    /// The volume.
    pub volume: Arc<Volume>,
    /// Its transfer function.
    pub transfer: TransferFunction,
    /// How.
    pub way: Way,
    /// The settings.
    pub settings: Settings,
    /// Behind the picture, linear; `None`: nothing.
    pub background: Option<[f32; 3]>,
}

/// What is to be done.
#[derive(Debug)]
pub enum Job {
    /// Read a volume.
    Load(Source),
    /// Write a picture.
    Save(Box<Shot>, PathBuf),
    /// Draw a picture for the clipboard.
    Copy(Box<Shot>),
    /// Write a picture per view, numbered, into a folder.
    Orbit(Box<Shot>, Vec<crate::camera::Camera>, PathBuf),
    /// Time all lossless methods in all blocks.
    Sweep(Box<Shot>),
    /// Classify the blocks that an overlay shows; the number tells which document it is for.
    Overlay(Arc<Volume>, Box<Key>, u64),
}

/// What a job tells.
#[derive(Debug)]
pub enum Done {
    /// A volume was read.
    Loaded(Box<Source>, Arc<Volume>, Box<Statistics>),
    /// A picture for the clipboard.
    Copied(Box<Picture>),
    /// Something was written; a line that says what.
    Wrote(String),
    /// One point of a sweep: the choice and its frame time in ms.
    Swept(Choice, f64),
    /// The blocks of a document.
    Classified(u64, Box<Key>, Box<Overlay>),
    /// It came to an end.
    Finished(u64),
    /// It failed.
    Failed(Error),
}

impl Job {
    /// In few words.
    pub fn label(&self) -> String {
        match self {
            Self::Load(source) => format!("reading {}", source.volume),
            Self::Save(_, path) => format!("drawing {}", path.display()),
            Self::Copy(_) => "drawing a picture to copy".to_owned(),
            Self::Orbit(_, views, _) => format!("drawing {} pictures", views.len()),
            Self::Sweep(_) => "timing methods and block sizes".to_owned(),
            Self::Overlay(..) => "classifying blocks".to_owned(),
        }
    }

    /// Starts the job; what it tells wakes the window.
    pub fn start(self, id: u64, told: &Sender<Done>, context: &Context) -> Running {
        let control = Arc::<Control>::default();
        let label = self.label();
        let own = Arc::clone(&control);
        let spawned = std::thread::Builder::new().name("job".to_owned()).spawn({
            let (told, context) = (told.clone(), context.clone());
            move || {
                let tell = |done| {
                    // A window that is gone need not know.
                    let _ = told.send(done);
                    context.request_repaint();
                };
                // A panic, as which a driver's failure may come, is an error like others.
                let work = AssertUnwindSafe(|| self.run(&own, &tell));
                match catch_unwind(work) {
                    Ok(Ok(()) | Err(Error::Cancelled)) => {}
                    Ok(Err(error)) => tell(Done::Failed(error)),
                    Err(panic) => tell(Done::Failed(of_panic(panic.as_ref()))),
                }
                tell(Done::Finished(id));
            }
        });
        if let Err(error) = spawned {
            let error = Error::Gpu(format!("no thread to work in: {error}"));
            let _ = told.send(Done::Failed(error));
            let _ = told.send(Done::Finished(id));
        }
        Running { id, label, control }
    }

    fn run(self, control: &Control, tell: &impl Fn(Done)) -> Result<()> {
        match self {
            Self::Load(source) => {
                let volume = control.reading.watch(|| source.load())?;
                let statistics = Box::new(Statistics::of(&volume));
                control.check()?;
                tell(Done::Loaded(Box::new(source), Arc::new(volume), statistics));
            }
            Self::Save(shot, path) => {
                save(&shot, &path, control)?;
                tell(Done::Wrote(format!("wrote {}", path.display())));
            }
            Self::Copy(shot) => {
                let picture = picture(&shot, &mut Renderers::default(), control)?;
                tell(Done::Copied(Box::new(picture)));
            }
            Self::Orbit(shot, views, folder) => {
                orbit(*shot, &views, &folder, control)?;
                let [pattern, count] = [
                    folder.join("%04d.png").display().to_string(),
                    views.len().to_string(),
                ];
                tell(Done::Wrote(format!(
                    "wrote {count} pictures; a video of them: ffmpeg -framerate 30 -i {pattern} -pix_fmt yuv420p orbit.mp4"
                )));
            }
            Self::Sweep(shot) => sweep(&shot, control, tell)?,
            Self::Overlay(volume, key, document) => {
                let overlay = Overlay::new(&volume, &key)?;
                tell(Done::Classified(document, key, Box::new(overlay)));
            }
        }
        Ok(())
    }
}

impl Control {
    fn check(&self) -> Result<()> {
        if self.cancelled.load(Ordering::Relaxed) {
            Err(Error::Cancelled)
        } else {
            Ok(())
        }
    }
}

/// A job under way.
#[derive(Debug)]
pub struct Running {
    /// Told when it ends.
    pub id: u64,
    /// What it is.
    pub label: String,
    /// How far it is, and the way to stop it.
    pub control: Arc<Control>,
}

fn save(shot: &Shot, path: &Path, control: &Control) -> Result<()> {
    output::Format::from_path(path)?;
    let picture = picture(shot, &mut Renderers::default(), control)?;
    output::write(&picture, path, PngEncoding::default())
}

fn picture(shot: &Shot, renderers: &mut Renderers, control: &Control) -> Result<Picture> {
    let what = (&shot.way, &shot.settings, false);
    let renderer = renderers.for_picture(what, &shot.volume, &shot.transfer)?;
    control.draws(renderer.progress());
    control.check()?;
    let settings = chosen(renderer, &shot.way, &shot.settings)?;
    let picture = renderer.render(&settings)?.picture;
    Ok(match shot.background {
        Some(color) => output::over(&picture, color),
        None => picture,
    })
}

fn orbit(
    mut shot: Shot,
    views: &[crate::camera::Camera],
    folder: &Path,
    control: &Control,
) -> Result<()> {
    std::fs::create_dir_all(folder).map_err(|e| Error::io(folder, e))?;
    let mut renderers = Renderers::default();
    for (i, camera) in views.iter().enumerate() {
        control.at(i as f64 / views.len() as f64)?;
        shot.settings.camera = *camera;
        let path = folder.join(format!("{i:04}.png"));
        let picture = picture(&shot, &mut renderers, control)?;
        output::write(&picture, &path, PngEncoding::default())?;
    }
    Ok(())
}

/// Box once, then every method that skips in every block size: the least of two frames after one that warms.
fn sweep(shot: &Shot, control: &Control, tell: &impl Fn(Done)) -> Result<()> {
    let mut renderers = Renderers::default();
    let renderer = renderers.for_picture(
        (&shot.way, &shot.settings, false),
        &shot.volume,
        &shot.transfer,
    )?;
    control.draws(renderer.progress());
    let candidates: Vec<Choice> = renderer
        .candidates(&BLOCKS)
        .into_iter()
        .filter(|c| c.skip != Skip::HalfSplit || c.cuts == Cuts::default())
        .collect();
    for (i, choice) in candidates.iter().enumerate() {
        control.at(i as f64 / candidates.len() as f64)?;
        let settings = choice.in_settings(&shot.settings);
        let mut least = f64::INFINITY;
        for round in 0..3 {
            control.check()?;
            let ms = renderer.draw(&settings)?.frame_ms;
            if round > 0 {
                least = least.min(ms);
            }
        }
        tell(Done::Swept(*choice, least));
    }
    Ok(())
}
