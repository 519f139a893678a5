//! Asking the worker for pictures: only where something that they follow from has changed.

use std::time::{Duration, Instant};

use crate::error::Result;
use crate::render::Settings;
use crate::sample::Sampler;

use super::app::{App, Asked, BACKDROP, Compare};
use super::jobs::Job;
use super::look::{Way, linear};
use super::overlay::Key;
use super::quality::Level;
use super::reply::Request;

/// The longest that the window waits for a moving picture before it is painted without.
const PATIENCE: Duration = Duration::from_millis(100);

impl App {
    /// Asks for a picture of this size, where it would be another one.
    pub(super) fn ask(&mut self, size: [u32; 2]) {
        let Some(document) = self.documents.get(self.current) else {
            return;
        };
        let mut ways = vec![document.way];
        if self.shown.compare != Compare::Off {
            ways.push(document.other);
        }
        let asked = Asked {
            document: document.id,
            look: document.look.clone(),
            ways,
            view: document.view,
            size,
            difference: self.shown.compare == Compare::Difference,
        };
        let now = self.now();
        if self
            .asked
            .as_ref()
            .is_some_and(|(before, ..)| *before != asked)
        {
            self.quality.moved(now);
        }
        let (level, is_moving) = self.quality.level(now);
        if let Some(rest) = self.quality.until_rest(now) {
            self.context.request_repaint_after(rest);
        }
        let asked = (asked, level, is_moving);
        if self.asked.as_ref() == Some(&asked) {
            return;
        }
        let is_other_scene = self
            .asked
            .as_ref()
            .is_none_or(|(before, ..)| *before != asked.0);
        if is_other_scene {
            self.screen.verdict = None;
        }
        match self.request(&asked) {
            Ok(request) => self.worker.ask(request),
            Err(error) => self.complain(&error),
        }
        self.asked = Some(asked);
        self.follow_overlay();
    }

    /// Waits for a moving picture that was asked for, so that it is painted in this frame: painting the window meanwhile, with
    /// the picture before, would take as much of a software adapter's time as drawing does. Not for long: the window stays
    /// alive whatever the picture takes.
    pub(super) fn await_moving(&mut self) {
        let is_there = |app: &Self| {
            let frame = app.screen.frame.as_ref();
            frame.is_some_and(|frame| frame.ticket == app.ticket)
        };
        let is_moving = self.asked.as_ref().is_some_and(|(.., moving)| *moving);
        if !is_moving || is_there(self) {
            return;
        }
        let start = Instant::now();
        self.worker.await_reply(true);
        while let Some(left) = PATIENCE.checked_sub(start.elapsed())
            && let Ok(reply) = self.replies.recv_timeout(left)
        {
            self.take_reply(reply);
            if is_there(self) {
                break;
            }
        }
        self.worker.await_reply(false);
        self.waited = Some(start.elapsed());
    }

    fn request(&mut self, (asked, level, is_moving): &(Asked, Level, bool)) -> Result<Request> {
        self.ticket += 1;
        let document = &self.documents[self.current];
        let size = level.size(asked.size);
        let picture = |way: &Way| {
            let settings = way.settings(&document.look, &document.view, &document.volume, size)?;
            let step_voxels = settings.step_voxels * level.step;
            Ok((
                *way,
                Settings {
                    step_voxels,
                    ..settings
                },
            ))
        };
        Ok(Request {
            ticket: self.ticket,
            volume: document.volume.clone(),
            transfer: document.look.transfer.clone(),
            pictures: asked.ways.iter().map(picture).collect::<Result<_>>()?,
            backdrop: linear(document.look.background.unwrap_or(BACKDROP)),
            level: *level,
            is_moving: *is_moving,
            difference: asked.difference,
        })
    }

    /// Classifies blocks anew, where an overlay shows them and they are others than those known.
    pub(super) fn follow_overlay(&mut self) {
        let wants = self.shown.leaves || self.shown.hull || self.shown.cut;
        let (Some(document), Some(settings), true) = (self.document(), self.drawn(), wants) else {
            return;
        };
        let drawn = self.screen.frame.as_ref().and_then(|f| f.drawn.first());
        let sampler = drawn.map_or(Sampler::Exact, |d| d.sampler);
        let settings = Settings {
            step_voxels: document.way.step_voxels,
            mode: document.look.mode,
            ..settings
        };
        let key = Key::of(&document.look.transfer, &settings, sampler);
        let is_known = document
            .overlay
            .as_ref()
            .is_some_and(|(known, _)| *known == key);
        let wanted = (document.id, key);
        if is_known || self.classifying.is_some() {
            return;
        }
        let volume = document.volume.clone();
        self.classifying = Some(wanted.clone());
        self.start_job(Job::Overlay(volume, Box::new(wanted.1), wanted.0));
    }
}
