//! The window's state, and what happens once per frame: replies are taken, panels drawn, and where anything that the picture
//! follows from has changed, a new one is asked for.

use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use eframe::egui::{self, Context, TextureHandle, TextureId, Ui};

use crate::error::{Error, Result};
use crate::render::Settings;
use crate::volume::Source;

use super::dialogs::Dialog;
use super::direct::WindowGpu;
use super::document::Document;
use super::jobs::{Done, Job, Running, Shot};
use super::look::{Look, Way};
use super::overlay::Key;
use super::path_dialog::{self, Picked};
use super::quality::{Level, Quality};
use super::reply::{Details, Frame, Pixels, Reply, Stage};
use super::session::{Kept, Recent};
use super::verdict::Verdict;
use super::view::View;
use super::worker::Worker;
use super::{canvas, dialogs, panels, status, transfer_panel};

/// What stands behind a picture that has no background, sRGB: as dark as the window.
pub(super) const BACKDROP: [u8; 3] = [22, 24, 28];

/// How many frame times the small graph shows.
pub(super) const TIMES: usize = 90;

/// A line for the user, until it is dismissed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Message {
    /// Whether something went wrong.
    pub is_error: bool,
    /// What.
    pub text: String,
}

/// How two ways are put beside each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Compare {
    /// One picture.
    Off,
    /// The one left of a divider, the other right of it.
    Split,
    /// Both, whole.
    SideBySide,
    /// Where they differ.
    Difference,
}

/// What is shown besides the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "each is a checkbox of its own, independent of the others"
)]
pub struct Shown {
    /// How two ways are compared.
    pub compare: Compare,
    /// Where a split view is divided, as a part of its width.
    pub divider: f32,
    /// Samples per pixel in place of the picture.
    pub heat: bool,
    /// The active leaves' outer faces.
    pub leaves: bool,
    /// The faces of both halves' hulls.
    pub hull: bool,
    /// The plane that half-split cuts at.
    pub cut: bool,
    /// The volume's box.
    pub outline: bool,
}

impl Default for Shown {
    fn default() -> Self {
        Self {
            compare: Compare::Off,
            divider: 0.5,
            heat: false,
            leaves: false,
            hull: false,
            cut: false,
            outline: false,
        }
    }
}

/// All that a picture follows from: asked for again only when it changes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Asked {
    pub(super) document: u64,
    pub(super) look: Look,
    pub(super) ways: Vec<Way>,
    pub(super) view: View,
    pub(super) size: [u32; 2],
    pub(super) difference: bool,
}

/// Where a picture on the screen lies: in a texture that bytes are sent to, or in one that it was drawn into.
#[derive(Default)]
pub(super) struct OnCanvas {
    pub(super) sent: Option<TextureHandle>,
    pub(super) direct: Option<TextureId>,
    /// Which of the two is the last.
    pub(super) is_direct: bool,
}

impl OnCanvas {
    /// The last one.
    pub(super) fn id(&self) -> Option<TextureId> {
        let sent = self.sent.as_ref().map(TextureHandle::id);
        if self.is_direct { self.direct } else { sent }
    }
}

/// A frame on the screen.
#[derive(Default)]
pub(super) struct OnScreen {
    pub(super) frame: Option<Frame>,
    pub(super) pictures: Vec<OnCanvas>,
    pub(super) difference: Option<TextureHandle>,
    pub(super) details: Option<Details>,
    pub(super) heat: Option<TextureHandle>,
    pub(super) verdict: Option<Verdict>,
    /// Frame times in ms, the last last.
    pub(super) times: VecDeque<f32>,
}

/// What a window leaves to the one that is opened in its place.
pub(super) struct Carried {
    documents: Vec<Document>,
    current: usize,
    shown: Shown,
    messages: Vec<Message>,
}

/// The window.
pub struct App {
    pub(super) context: Context,
    pub(super) documents: Vec<Document>,
    pub(super) current: usize,
    /// What is shown besides the picture.
    pub shown: Shown,
    pub(super) quality: Quality,
    pub(super) screen: OnScreen,
    pub(super) recent: Recent,
    pub(super) jobs: Vec<Running>,
    pub(super) messages: Vec<Message>,
    pub(super) dialog: Option<Dialog>,
    pub(super) picked: (Sender<Picked>, Receiver<Picked>),
    pub(super) worker: Worker,
    /// The device that pictures are drawn on, where it is the window's own.
    pub(super) window: Option<WindowGpu>,
    pub(super) replies: Receiver<Reply>,
    pub(super) told: (Sender<Done>, Receiver<Done>),
    /// What a session says of volumes that are still being read.
    pub(super) awaited: Vec<Kept>,
    /// What was asked for last, in which quality, and whether as something that moves.
    pub(super) asked: Option<(Asked, Level, bool)>,
    pub(super) ticket: u64,
    pub(super) next_id: u64,
    /// The blocks that are being classified, and of which document.
    pub(super) classifying: Option<(u64, Key)>,
    /// How long this frame waited for its picture.
    pub(super) waited: Option<Duration>,
    /// When the last frame that waited began, and how long it did.
    awaited_before: Option<(Duration, Duration)>,
    start: Instant,
}

impl App {
    /// A window with nothing open. Pictures on the GPU are drawn on `window`, where it is given.
    ///
    /// # Errors
    /// Where the system gives no thread to draw in.
    pub fn new(context: &Context, recent: Recent, window: Option<WindowGpu>) -> Result<Self> {
        let (sender, replies) = channel();
        Ok(Self {
            context: context.clone(),
            documents: Vec::new(),
            current: 0,
            shown: Shown::default(),
            quality: Quality::default(),
            screen: OnScreen::default(),
            recent,
            jobs: Vec::new(),
            messages: Vec::new(),
            dialog: None,
            picked: channel(),
            worker: Worker::start(
                sender,
                context.clone(),
                window.as_ref().map(|w| w.gpu.clone()),
            )?,
            window,
            replies,
            told: channel(),
            awaited: Vec::new(),
            asked: None,
            ticket: 0,
            next_id: 0,
            classifying: None,
            waited: None,
            awaited_before: None,
            start: Instant::now(),
        })
    }

    /// Opens a volume.
    pub fn open(&mut self, source: Source) {
        self.start_job(Job::Load(source));
    }

    /// Opens what a session kept.
    pub fn restore(&mut self, kept: Vec<Kept>) {
        for kept in kept {
            self.open(kept.source.clone());
            self.awaited.push(kept);
        }
    }

    /// What outlives the window's device, when that is lost.
    pub(super) fn carry_on(&mut self) -> Carried {
        self.stop();
        Carried {
            documents: std::mem::take(&mut self.documents),
            current: self.current,
            shown: self.shown,
            messages: std::mem::take(&mut self.messages),
        }
    }

    /// Goes on with what another window left.
    pub(super) fn go_on_with(&mut self, carried: Carried) {
        let Carried {
            documents,
            current,
            shown,
            messages,
        } = carried;
        self.next_id = documents.iter().map(|d| d.id).max().unwrap_or(0);
        self.documents = documents;
        self.current = current;
        self.shown = shown;
        self.messages = messages;
        self.say("the graphics device was lost: the window was opened anew".to_owned());
    }

    /// The document that is shown.
    pub fn document(&self) -> Option<&Document> {
        self.documents.get(self.current)
    }

    /// The same, to change.
    pub fn document_mut(&mut self) -> Option<&mut Document> {
        self.documents.get_mut(self.current)
    }

    /// Whether all that was asked for is drawn, at full quality, and nothing is under way.
    pub fn is_at_rest(&self) -> bool {
        let is_drawn = self
            .screen
            .frame
            .as_ref()
            .is_some_and(|frame| frame.ticket == self.ticket && !frame.is_moving);
        self.jobs.is_empty() && is_drawn && self.worker.stage() == Stage::Idle
    }

    /// What went wrong or was done, the last last.
    pub fn messages(&self) -> &[Message] {
        &self.messages
    }

    /// The settings that the picture on the screen was drawn with, once it is there.
    pub fn drawn(&self) -> Option<Settings> {
        Some(self.screen.frame.as_ref()?.drawn.first()?.settings)
    }

    /// The backend that drew the picture on the screen, and whether it did so on the window's own device.
    pub fn drawn_by(&self) -> Option<(&'static str, bool)> {
        let drawn = self.screen.frame.as_ref()?.drawn.first()?;
        let is_direct = matches!(drawn.shown, Pixels::Canvas(_));
        Some((drawn.backend.backend, is_direct))
    }

    /// How the two pictures on the screen differ: pixels with any bit different, and the largest difference of a channel.
    pub fn difference(&self) -> Option<(u64, f64)> {
        let compared = self.screen.frame.as_ref()?.compared.as_ref()?;
        Some((compared.pixels, compared.max_abs))
    }

    /// Width and height that pictures on the screen have at full quality.
    pub(super) fn asked_size(&self) -> Option<[u32; 2]> {
        Some(self.asked.as_ref()?.0.size)
    }

    pub(super) fn stage(&self) -> Stage {
        self.worker.stage()
    }

    pub(super) fn stop(&self) {
        self.worker.cancel();
        for job in &self.jobs {
            job.control.cancel();
        }
    }

    pub(super) fn now(&self) -> Duration {
        self.start.elapsed()
    }

    pub(super) fn start_job(&mut self, job: Job) {
        self.next_id += 1;
        let running = job.start(self.next_id, &self.told.0, &self.context);
        self.jobs.push(running);
    }

    pub(super) fn say(&mut self, text: String) {
        self.messages.push(Message {
            is_error: false,
            text,
        });
    }

    pub(super) fn complain(&mut self, error: &Error) {
        let text = error.to_string();
        if !self.messages.iter().any(|message| message.text == text) {
            self.messages.push(Message {
                is_error: true,
                text,
            });
        }
    }

    /// A picture of the current document as it stands, by the way that is on the screen, at any size.
    pub(super) fn shot(&self, size: [u32; 2], transparent: bool) -> Result<Option<Shot>> {
        let Some(document) = self.document() else {
            return Ok(None);
        };
        let Document {
            volume,
            look,
            way,
            view,
            ..
        } = document;
        Ok(Some(Shot {
            volume: volume.clone(),
            transfer: look.transfer.clone(),
            way: *way,
            settings: way.settings(look, view, volume, size)?,
            background: if transparent {
                None
            } else {
                look.linear_background()
            },
        }))
    }

    /// One frame of the window.
    pub fn show(&mut self, ui: &mut Ui) {
        let now = self.now();
        tracing::debug!("at {:.0} ms: window", now.as_secs_f64() * 1e3);
        if let Some((began, waited)) = self.awaited_before.take() {
            let around = now.saturating_sub(began).saturating_sub(waited);
            self.quality.measured_around(around.as_secs_f64() * 1e3);
        }
        self.receive();
        path_dialog::take_picked(self);
        let dropped = ui.input(|i| i.raw.dropped_files.clone());
        for file in dropped {
            self.open(Source::new(&file.path().display().to_string()));
        }
        super::shortcuts::take(self, ui);
        status::top(self, ui);
        status::bottom(self, ui);
        panels::left(self, ui);
        transfer_panel::bottom(self, ui);
        dialogs::show(self, ui);
        // Last: it asks for the picture that follows from all that was changed before.
        egui::CentralPanel::no_frame().show(ui, |ui| canvas::show(self, ui));
        self.awaited_before = self.waited.take().map(|waited| (now, waited));
        let is_dragging = ui.input(|i| i.pointer.any_down());
        if let Some(document) = self.document_mut()
            && !is_dragging
        {
            let edit = document.edit();
            document.history.keep(&edit);
        }
        // A picture that is drawn or a job that runs is followed; otherwise nothing is redrawn.
        if !self.jobs.is_empty() || self.worker.stage() != Stage::Idle {
            ui.ctx().request_repaint_after(Duration::from_millis(150));
        }
    }
}
