//! What comes back from the worker and from jobs.

use eframe::egui::{ColorImage, Context, TextureHandle, TextureOptions};

use crate::render::Choice;

use super::app::{App, BACKDROP, OnCanvas, TIMES};
use super::document::Document;
use super::image;
use super::jobs::Done;
use super::look::linear;
use super::reply::{Frame, Pixels, Reply};

impl App {
    pub(super) fn receive(&mut self) {
        while let Ok(reply) = self.replies.try_recv() {
            self.take_reply(reply);
        }
        while let Ok(done) = self.told.1.try_recv() {
            match done {
                Done::Loaded(source, volume, statistics) => {
                    self.next_id += 1;
                    match Document::new(self.next_id, *source, volume, *statistics) {
                        Ok(document) => self.add(document),
                        Err(error) => self.complain(&error),
                    }
                }
                Done::Copied(picture) => {
                    let image = image::shown(&picture, linear(BACKDROP));
                    self.context.copy_image(image);
                    self.say("copied the picture".to_owned());
                }
                Done::Wrote(text) => self.say(text),
                Done::Swept(choice, ms) => {
                    if let Some(document) = self.document_mut() {
                        document.sweep.push((choice, ms));
                    }
                }
                Done::Classified(id, key, overlay) => {
                    let document = self.documents.iter_mut().find(|d| d.id == id);
                    if let Some(document) = document {
                        document.overlay = Some((*key, *overlay));
                    }
                    self.classifying = None;
                    self.follow_overlay();
                }
                Done::Finished(id) => self.jobs.retain(|job| job.id != id),
                Done::Failed(error) => {
                    self.classifying = None;
                    self.complain(&error);
                }
            }
        }
    }

    pub(super) fn take_reply(&mut self, reply: Reply) {
        match reply {
            Reply::Frame(frame) => self.take_frame(*frame),
            Reply::Details(mut details) if details.ticket == self.ticket => {
                let image = std::mem::take(&mut details.heat);
                let options = TextureOptions::NEAREST;
                set_texture(&self.context, &mut self.screen.heat, "heat", image, options);
                self.screen.details = Some(*details);
            }
            Reply::Weighed(ticket, verdict) if ticket == self.ticket => {
                self.screen.verdict = Some(verdict);
            }
            Reply::Details(_) | Reply::Weighed(..) => {}
            Reply::Failed(error) => self.complain(&error),
        }
    }

    fn add(&mut self, mut document: Document) {
        for warning in &document.volume.warnings {
            self.say(format!("{}: {warning}", document.short_name()));
        }
        let awaited = self
            .awaited
            .iter()
            .position(|k| k.source == document.source);
        if let Some(place) = awaited {
            document.restore(&self.awaited.remove(place));
        }
        self.recent.add(&document.source);
        self.documents.push(document);
        self.current = self.documents.len() - 1;
    }

    fn take_frame(&mut self, mut frame: Frame) {
        if frame.ticket != self.ticket && !frame.is_moving {
            return;
        }
        self.quality.measured(frame.level, frame.drawing_ms());
        tracing::debug!(
            "at {:.0} ms: picture of {:?} pixels by {} in {:.1} ms, {}: {}",
            self.now().as_secs_f64() * 1e3,
            frame.drawn[0].settings.size,
            Choice::of(&frame.drawn[0].settings).words(),
            frame.whole_ms,
            if frame.is_moving { "moving" } else { "at rest" },
            frame.level.words()
        );
        let times = &mut self.screen.times;
        times.push_back(frame.drawn[0].times.frame_ms as f32);
        while times.len() > TIMES {
            times.pop_front();
        }
        let is_enlarged = frame.level.scale < 1.0;
        self.screen
            .pictures
            .resize_with(frame.drawn.len(), OnCanvas::default);
        for (place, drawn) in self.screen.pictures.iter_mut().zip(&mut frame.drawn) {
            match &mut drawn.shown {
                Pixels::Image(image) => {
                    // Where a pixel of the picture is one of the screen, there is nothing to interpolate.
                    let options = if is_enlarged {
                        TextureOptions::LINEAR
                    } else {
                        TextureOptions::NEAREST
                    };
                    let image = std::mem::take(image);
                    set_texture(&self.context, &mut place.sent, "picture", image, options);
                    place.is_direct = false;
                }
                Pixels::Canvas(canvas) => {
                    if let Some(window) = &self.window {
                        window.show(canvas, is_enlarged, &mut place.direct);
                        place.is_direct = true;
                    }
                }
            }
        }
        if let Some(image) = frame.compared.as_mut().and_then(|c| c.image.take()) {
            set_texture(
                &self.context,
                &mut self.screen.difference,
                "difference",
                image,
                TextureOptions::NEAREST,
            );
        }
        self.screen.frame = Some(frame);
        self.follow_overlay();
    }
}

fn set_texture(
    context: &Context,
    place: &mut Option<TextureHandle>,
    name: &str,
    image: ColorImage,
    options: TextureOptions,
) {
    match place {
        Some(texture) => texture.set(image, options),
        None => *place = Some(context.load_texture(name, image, options)),
    }
}
