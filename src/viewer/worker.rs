//! The thread that draws: takes the latest request, sends pictures and what they took, and owns the renderers.
//!
//! A request that comes while a picture at rest is drawn stops it; one that comes while something moves waits its turn, so
//! that frames go on coming. After a picture at rest the worker counts its samples and weighs its method against others, as
//! long as nobody asks for something else.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Sender;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Instant;

use eframe::egui::{ColorImage, Context};

use crate::error::{Error, Result};
use crate::measure::metrics::metrics;
use crate::mode::Mode;
use crate::render::{BackendInfo, Choice, FrameTimes, Preparation, Renderer, Settings};
use crate::sample::Sampler;
use crate::scene::{Counters, Picture, Progress};
use crate::skip::Skip;
use crate::transfer::TransferFunction;
use crate::volume::Volume;

use super::image;
use super::look::Way;
use super::quality::Level;
use super::renderers::{Renderers, chosen};
use super::verdict::Verdict;

/// The longest edge of pictures that methods are weighed on, in pixels.
const WEIGHED_EDGE: u32 = 320;

/// How much larger differences are shown.
pub const GAIN: f32 = 16.0;

/// What to draw.
#[derive(Debug, Clone)]
pub struct Request {
    /// Told with every reply.
    pub ticket: u64,
    /// The volume.
    pub volume: Arc<Volume>,
    /// Its transfer function.
    pub transfer: TransferFunction,
    /// One picture, or two that are compared.
    pub pictures: Vec<(Way, Settings)>,
    /// Behind the pictures, linear.
    pub backdrop: [f32; 3],
    /// What quality the settings are of.
    pub level: Level,
    /// Whether another picture will follow at once: this one is not stopped for it, and nothing more is found out of it.
    pub is_moving: bool,
    /// Whether the difference of two pictures is to be shown.
    pub difference: bool,
}

/// What comes back.
#[derive(Debug)]
pub enum Reply {
    /// The pictures of a request.
    Frame(Box<Frame>),
    /// What the first picture of a request took.
    Details(Box<Details>),
    /// How its method compares.
    Weighed(u64, Verdict),
    /// Nothing could be drawn.
    Failed(Error),
}

/// The pictures of a request.
#[derive(Debug)]
pub struct Frame {
    /// The request's.
    pub ticket: u64,
    /// The request's.
    pub level: Level,
    /// The request's.
    pub is_moving: bool,
    /// The request's.
    pub backdrop: [f32; 3],
    /// As many as were asked for.
    pub drawn: Vec<Drawn>,
    /// How two of one size differ.
    pub compared: Option<Compared>,
    /// From taking the request to sending the reply, in ms.
    pub whole_ms: f64,
}

impl Frame {
    /// What drawing took, in ms: of a moving picture all that it keeps the window waiting; at rest, where structures may have
    /// been built first, the frames themselves.
    pub fn drawing_ms(&self) -> f64 {
        if self.is_moving {
            self.whole_ms
        } else {
            let drawn = self.drawn.iter();
            drawn.map(|d| d.times.frame_ms + d.read_back_ms).sum()
        }
    }
}

/// A picture, and how it was made.
#[derive(Debug)]
pub struct Drawn {
    /// What was drawn.
    pub picture: Picture,
    /// For the screen.
    pub image: ColorImage,
    /// As drawn: with the method that auto chose.
    pub settings: Settings,
    /// As drawn.
    pub sampler: Sampler,
    /// What drew it.
    pub backend: BackendInfo,
    /// What the frame took.
    pub times: FrameTimes,
    /// What fetching the picture took, in ms.
    pub read_back_ms: f64,
    /// What structures took.
    pub preparation: Preparation,
}

/// How two pictures differ.
#[derive(Debug)]
pub struct Compared {
    /// Pixels with any bit different.
    pub pixels: u64,
    /// Largest difference of a channel.
    pub max_abs: f64,
    /// Peak signal-to-noise ratio in dB.
    pub psnr_db: f64,
    /// The difference [`GAIN`] times, where it was asked for.
    pub image: Option<ColorImage>,
}

/// What a picture took of samples.
#[derive(Debug)]
pub struct Details {
    /// The request's.
    pub ticket: u64,
    /// As counted.
    pub settings: Settings,
    /// Sums over all pixels.
    pub counters: Counters,
    /// Samples per pixel, as heat up to `most`.
    pub heat: ColorImage,
    /// The most samples of a pixel.
    pub most: u32,
    /// Distance of the first contributing sample from where the ray starts, per pixel, local units.
    pub first_hit: Vec<f32>,
}

/// What the worker is at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Nothing.
    Idle,
    /// Opening a backend or building structures.
    Building,
    /// Drawing.
    Drawing,
    /// Counting samples.
    Counting,
    /// Trying other methods.
    Weighing,
}

#[derive(Default)]
struct Mailbox {
    request: Option<Request>,
    closed: bool,
    stage: Option<Stage>,
    /// What stops the work in hand, where it may be stopped.
    stoppable: Option<Arc<Progress>>,
}

#[derive(Default)]
struct Shared {
    mailbox: Mutex<Mailbox>,
    wake: Condvar,
    /// Whether the window waits for a reply and need not be woken.
    is_awaited: AtomicBool,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Mailbox> {
        // A panic while it was held has broken nothing in it.
        self.mailbox.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn is_superseded(&self) -> bool {
        let mailbox = self.lock();
        mailbox.closed || mailbox.request.is_some()
    }

    fn at(&self, stage: Stage, stoppable: Option<Arc<Progress>>) {
        let mut mailbox = self.lock();
        mailbox.stage = Some(stage);
        mailbox.stoppable = stoppable;
    }
}

/// The thread and the way to it.
pub struct Worker {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl Worker {
    /// Starts the thread. Every reply wakes the window.
    ///
    /// # Errors
    /// [`Error::Gpu`] where the system gives no thread.
    pub fn start(replies: Sender<Reply>, context: Context) -> Result<Self> {
        let shared = Arc::<Shared>::default();
        let own = Arc::clone(&shared);
        let thread = std::thread::Builder::new()
            .name("draw".to_owned())
            .spawn(move || {
                let send = |reply| {
                    // A window that is gone needs no picture.
                    let _ = replies.send(reply);
                    if !own.is_awaited.load(Ordering::Relaxed) {
                        context.request_repaint();
                    }
                };
                run(&own, &send);
            })
            .map_err(|e| Error::Gpu(format!("no thread to draw in: {e}")))?;
        Ok(Self {
            shared,
            thread: Some(thread),
        })
    }

    /// Asks for pictures in place of what was asked for before.
    pub fn ask(&self, request: Request) {
        let mut mailbox = self.shared.lock();
        mailbox.request = Some(request);
        if let Some(progress) = &mailbox.stoppable {
            progress.cancel();
        }
        self.shared.wake.notify_one();
    }

    /// What it is at.
    pub fn stage(&self) -> Stage {
        let mailbox = self.shared.lock();
        match (mailbox.stage, &mailbox.request) {
            (Some(stage), _) => stage,
            (None, Some(_)) => Stage::Building,
            (None, None) => Stage::Idle,
        }
    }

    /// Says that the window waits for a reply, and so is not woken by one, or no longer does.
    pub fn await_reply(&self, is_awaited: bool) {
        self.shared.is_awaited.store(is_awaited, Ordering::Relaxed);
    }

    /// Stops what is drawn at rest, counted or weighed.
    pub fn cancel(&self) {
        let mut mailbox = self.shared.lock();
        mailbox.request = None;
        if let Some(progress) = &mailbox.stoppable {
            progress.cancel();
        }
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        {
            let mut mailbox = self.shared.lock();
            mailbox.closed = true;
            if let Some(progress) = &mailbox.stoppable {
                progress.cancel();
            }
        }
        self.shared.wake.notify_one();
        if let Some(thread) = self.thread.take() {
            // What it panicked with was told already.
            let _ = thread.join();
        }
    }
}

fn run(shared: &Shared, send: &impl Fn(Reply)) {
    let mut renderers = Renderers::default();
    loop {
        let request = {
            let mut mailbox = shared.lock();
            mailbox.stage = None;
            mailbox.stoppable = None;
            loop {
                if mailbox.closed {
                    return;
                }
                if let Some(request) = mailbox.request.take() {
                    break request;
                }
                mailbox = shared
                    .wake
                    .wait(mailbox)
                    .unwrap_or_else(PoisonError::into_inner);
            }
        };
        let mut done = attempt(&request, &mut renderers, shared, send);
        if matches!(done, Err(Error::Gpu(_))) {
            // The device may be lost: it is opened anew, once.
            tracing::warn!("opening the backends anew");
            renderers = Renderers::default();
            done = attempt(&request, &mut renderers, shared, send);
        }
        match done {
            Ok(()) | Err(Error::Cancelled) => {}
            Err(error) => {
                if matches!(error, Error::Gpu(_)) {
                    renderers = Renderers::default();
                }
                send(Reply::Failed(error));
            }
        }
    }
}

/// Serves a request; a panic (which is how a driver's failure may come) is an error like others.
fn attempt(
    request: &Request,
    renderers: &mut Renderers,
    shared: &Shared,
    send: &impl Fn(Reply),
) -> Result<()> {
    let work = AssertUnwindSafe(|| serve(request, renderers, shared, send));
    catch_unwind(work).unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().cloned();
        let text = text.or_else(|| panic.downcast_ref::<&str>().map(|&s| s.to_owned()));
        Err(Error::Gpu(text.unwrap_or_else(|| "failed".to_owned())))
    })
}

/// Draws, then counts and weighs as long as nothing else is asked for.
fn serve(
    request: &Request,
    renderers: &mut Renderers,
    shared: &Shared,
    send: &impl Fn(Reply),
) -> Result<()> {
    let at_rest = !request.is_moving;
    let start = Instant::now();
    let mut drawn: Vec<Drawn> = Vec::new();
    for (way, settings) in &request.pictures {
        shared.at(Stage::Building, None);
        let renderer = take(renderers, way, &settings.mode, request)?;
        let stoppable = at_rest.then(|| renderer.progress());
        let settings = chosen(renderer, way, settings)?;
        let preparation = renderer.prepare(&settings)?;
        shared.at(Stage::Drawing, stoppable);
        if at_rest && shared.is_superseded() {
            return Ok(());
        }
        let rendered = renderer.render(&settings)?;
        drawn.push(Drawn {
            image: image::shown(&rendered.picture, request.backdrop),
            settings,
            sampler: rendered.sampler,
            backend: renderer.info().clone(),
            times: rendered.times,
            read_back_ms: rendered.read_back_ms,
            preparation,
            picture: rendered.picture,
        });
    }
    let compared = match &drawn[..] {
        [a, b] => Some(compare(&a.picture, &b.picture, request.difference)),
        _ => None,
    };
    let settings = drawn[0].settings;
    send(Reply::Frame(Box::new(Frame {
        ticket: request.ticket,
        level: request.level,
        is_moving: request.is_moving,
        backdrop: request.backdrop,
        drawn,
        compared,
        whole_ms: start.elapsed().as_secs_f64() * 1e3,
    })));
    if !at_rest || shared.is_superseded() {
        return Ok(());
    }
    let way = &request.pictures[0].0;
    let renderer = take(renderers, way, &settings.mode, request)?;
    shared.at(Stage::Counting, Some(renderer.progress()));
    let counted = renderer.count(&settings)?;
    let most = counted.samples.iter().copied().max().unwrap_or(0);
    send(Reply::Details(Box::new(Details {
        ticket: request.ticket,
        settings,
        counters: counted.counters,
        heat: image::heat(&counted.samples, settings.size, most),
        most,
        first_hit: counted.first_hit,
    })));
    let verdict = weigh(renderer, &settings, shared)?;
    if let Some(verdict) = verdict {
        send(Reply::Weighed(request.ticket, verdict));
    }
    Ok(())
}

/// The renderer for a picture, with the request's volume and transfer function.
fn take<'a>(
    renderers: &'a mut Renderers,
    way: &Way,
    mode: &Mode,
    request: &Request,
) -> Result<&'a mut Renderer> {
    renderers.for_picture(way, mode, &request.volume, &request.transfer)
}

fn compare(a: &Picture, b: &Picture, show: bool) -> Compared {
    let difference = a.difference(b);
    Compared {
        pixels: difference.pixels,
        max_abs: difference.max_abs,
        psnr_db: metrics([(a, b)]).psnr_db(),
        image: show.then(|| image::difference(a, b, GAIN)),
    }
}

/// Draws the picture, small, by box, by its own choice and by auto's, in turns; `None` where someone wanted something
/// else meanwhile.
fn weigh(renderer: &mut Renderer, settings: &Settings, shared: &Shared) -> Result<Option<Verdict>> {
    shared.at(Stage::Weighing, Some(renderer.progress()));
    let longest = settings.size[0].max(settings.size[1]);
    let scale = f64::from(WEIGHED_EDGE.min(longest)) / f64::from(longest);
    let size = settings
        .size
        .map(|n| ((f64::from(n) * scale) as u32).max(1));
    let small = Settings { size, ..*settings };
    let current = Choice::of(settings);
    if settings.skip == Skip::Oracle || shared.is_superseded() {
        return Ok(None);
    }
    let base = Choice {
        skip: Skip::Box,
        ..current
    };
    let mut choices = vec![current];
    if base != current {
        choices.push(base);
    }
    let auto = renderer.choose(&small)?;
    if auto.skip != Skip::Box && auto != current {
        choices.push(auto);
    }
    let mut rows: Vec<(Choice, f64)> = choices.iter().map(|&c| (c, f64::INFINITY)).collect();
    for round in 0..4 {
        for (choice, ms) in &mut rows {
            if shared.is_superseded() {
                return Ok(None);
            }
            let settings = choice.in_settings(&small);
            let times = renderer.draw(&settings)?;
            // The first builds and warms.
            if round > 0 {
                *ms = ms.min(times.frame_ms);
            }
        }
    }
    Ok(Some(Verdict { current, rows }))
}
