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

use eframe::egui::Context;

use crate::error::{Error, Result};
use crate::gpu::Gpu;
use crate::measure::metrics::metrics;
use crate::render::{Choice, FrameTimes, Renderer, Settings};
use crate::scene::{Picture, Progress};
use crate::skip::Skip;

use super::direct::Canvas;
use super::image;
use super::look::Way;
use super::renderers::{Renderers, chosen, of_panic};
use super::reply::{Compared, Details, Drawn, Frame, GAIN, Pixels, Reply, Request, Stage};
use super::verdict::Verdict;

/// The longest edge of pictures that methods are weighed on, in pixels.
const WEIGHED_EDGE: u32 = 320;

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
    pub fn start(replies: Sender<Reply>, context: Context, window: Option<Gpu>) -> Result<Self> {
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
                run(&own, window.as_ref(), &send);
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

fn run(shared: &Shared, window: Option<&Gpu>, send: &impl Fn(Reply)) {
    // A window's device that was lost is no longer drawn on, until there is another window.
    let alive = || window.filter(|gpu| !gpu.is_lost());
    let open = || Renderers::on(alive().cloned());
    let mut renderers = open();
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
        let mut done = attempt(&request, (&mut renderers, alive()), shared, send);
        if matches!(done, Err(Error::Gpu(_))) {
            // The device may be lost: it is opened anew, once.
            tracing::warn!("opening the backends anew");
            // A device tells that it is lost when it is waited for, which a failure may come before.
            let _ = window.map(Gpu::wait);
            renderers = open();
            done = attempt(&request, (&mut renderers, alive()), shared, send);
        }
        match done {
            Ok(()) | Err(Error::Cancelled) => {}
            Err(error) => {
                if matches!(error, Error::Gpu(_)) {
                    renderers = open();
                }
                send(Reply::Failed(error));
            }
        }
    }
}

/// Serves a request; a panic (which is how a driver's failure may come) is an error like others.
fn attempt(
    request: &Request,
    (renderers, window): (&mut Renderers, Option<&Gpu>),
    shared: &Shared,
    send: &impl Fn(Reply),
) -> Result<()> {
    let work = AssertUnwindSafe(|| serve(request, (renderers, window), shared, send));
    catch_unwind(work).unwrap_or_else(|panic| Err(of_panic(panic.as_ref())))
}

/// Draws, then counts and weighs as long as nothing else is asked for.
fn serve(
    request: &Request,
    (renderers, window): (&mut Renderers, Option<&Gpu>),
    shared: &Shared,
    send: &impl Fn(Reply),
) -> Result<()> {
    let at_rest = !request.is_moving;
    let start = Instant::now();
    let mut drawn: Vec<Drawn> = Vec::new();
    let mut pictures: Vec<Picture> = Vec::new();
    let is_single = request.pictures.len() == 1;
    for (way, settings) in &request.pictures {
        shared.at(Stage::Building, None);
        let renderer = take(renderers, way, settings, request)?;
        let stoppable = at_rest.then(|| renderer.progress());
        let settings = chosen(renderer, way, settings)?;
        let preparation = renderer.prepare(&settings)?;
        shared.at(Stage::Drawing, stoppable);
        if at_rest && shared.is_superseded() {
            return Ok(());
        }
        // Two pictures are held against each other on the processor: they are fetched.
        let gpu = window.filter(|_| is_single && renderer.info().backend == "gpu");
        let Painted {
            shown,
            picture,
            times,
            read_back_ms,
        } = paint(renderer, gpu, &settings, request.backdrop)?;
        pictures.extend(picture);
        drawn.push(Drawn {
            shown,
            settings,
            sampler: renderer.sampler(&settings),
            backend: renderer.info().clone(),
            times,
            read_back_ms,
            preparation,
        });
    }
    let compared = match &pictures[..] {
        [a, b] => Some(compare(a, b, request.difference)),
        _ => None,
    };
    let settings = drawn[0].settings;
    send(Reply::Frame(Box::new(Frame {
        ticket: request.ticket,
        level: request.level,
        is_moving: request.is_moving,
        drawn,
        compared,
        whole_ms: start.elapsed().as_secs_f64() * 1e3,
    })));
    if !at_rest || shared.is_superseded() {
        return Ok(());
    }
    let way = &request.pictures[0].0;
    let renderer = take(renderers, way, &settings, request)?;
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

/// A picture that was made for the screen.
struct Painted {
    shown: Pixels,
    /// Where it was fetched.
    picture: Option<Picture>,
    times: FrameTimes,
    read_back_ms: f64,
}

/// Draws a picture: on the window's device, where `gpu` is it, straight into what the window shows.
fn paint(
    renderer: &mut Renderer,
    gpu: Option<&Gpu>,
    settings: &Settings,
    backdrop: [f32; 3],
) -> Result<Painted> {
    if let Some(gpu) = gpu.filter(|_| settings.slices.is_none()) {
        let (canvas, times) = Canvas::draw(gpu, renderer, settings, backdrop)?;
        return Ok(Painted {
            shown: Pixels::Canvas(canvas),
            picture: None,
            times,
            read_back_ms: 0.0,
        });
    }
    let rendered = renderer.render(settings)?;
    Ok(Painted {
        shown: Pixels::Image(image::shown(&rendered.picture, backdrop)),
        times: rendered.times,
        read_back_ms: rendered.read_back_ms,
        picture: Some(rendered.picture),
    })
}

/// The renderer for a picture, with the request's volume and transfer function.
fn take<'a>(
    renderers: &'a mut Renderers,
    way: &Way,
    settings: &Settings,
    request: &Request,
) -> Result<&'a mut Renderer> {
    let what = (way, settings, request.is_moving);
    renderers.for_picture(what, &request.volume, &request.transfer)
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
    if settings.skip == Skip::Oracle || settings.slices.is_some() || shared.is_superseded() {
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
