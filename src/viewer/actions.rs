//! What keys and menus do; which keys: `shortcuts`.

use eframe::egui::ThemePreference;

use crate::render::{Choice, MethodChoice};
use crate::skip::METHODS;

use super::app::{App, Compare};
use super::command::Drawn;
use super::dialogs::Dialog;
use super::jobs::Job;
use super::path_dialog::PathFor;
use super::view::View;

/// Everything that has a key.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Action {
    /// Open a volume.
    Open,
    /// Write a picture.
    SavePicture,
    /// Copy the picture to the clipboard.
    CopyPicture,
    /// Copy the command line that draws the same.
    CopyCommand,
    /// Undo the last edit.
    Undo,
    /// Redo it.
    Redo,
    /// The default view.
    Home,
    /// Parallel rays or perspective.
    Parallel,
    /// Look along an axis, from its positive or negative end.
    Along(usize, bool),
    /// The next way of comparing.
    Compare,
    /// Samples per pixel.
    Heat,
    /// Leaves.
    Leaves,
    /// Hull.
    Hull,
    /// Cut.
    Cut,
    /// The volume's box.
    Outline,
    /// The next method.
    NextMethod,
    /// Time all block sizes.
    Sweep,
    /// Light or dark.
    Theme,
    /// The sheet of shortcuts.
    Help,
    /// Stop what is under way, close what is open.
    Stop,
}

impl App {
    /// Does what a key or a menu asks for.
    pub fn perform(&mut self, action: Action) {
        let shown = &mut self.shown;
        match action {
            Action::Open => self.dialog = Some(Dialog::path(PathFor::Volume)),
            Action::SavePicture => self.dialog = Some(Dialog::path(PathFor::Picture)),
            Action::CopyPicture => self.copy_picture(),
            Action::CopyCommand => {
                if let Some(size) = self.full_size() {
                    self.copy_command("picture.png", size, false);
                }
            }
            Action::Undo => {
                if let Some(document) = self.document_mut() {
                    let edit = document.history.undo();
                    document.take(edit);
                }
            }
            Action::Redo => {
                if let Some(document) = self.document_mut() {
                    let edit = document.history.redo();
                    document.take(edit);
                }
            }
            Action::Home => {
                if let Some(document) = self.document_mut() {
                    let volume = &document.volume;
                    document.view = View::home(volume.extent(), volume.voxel_size());
                }
            }
            Action::Parallel => {
                if let Some(document) = self.document_mut() {
                    document.view.toggle_parallel(document.volume.voxel_size());
                }
            }
            Action::Along(axis, from_positive) => {
                if let Some(document) = self.document_mut() {
                    let size = document.volume.voxel_size();
                    document.view.along(axis, from_positive, size);
                }
            }
            Action::Compare => {
                shown.compare = match shown.compare {
                    Compare::Off => Compare::Split,
                    Compare::Split => Compare::SideBySide,
                    Compare::SideBySide => Compare::Difference,
                    Compare::Difference => Compare::Off,
                }
            }
            Action::Heat => shown.heat = !shown.heat,
            Action::Leaves => shown.leaves = !shown.leaves,
            Action::Hull => shown.hull = !shown.hull,
            Action::Cut => shown.cut = !shown.cut,
            Action::Outline => shown.outline = !shown.outline,
            Action::NextMethod => {
                if let Some(document) = self.document_mut() {
                    document.way.method = next(document.way.method);
                }
            }
            Action::Sweep => self.sweep(),
            Action::Theme => {
                let other = if self.context.theme() == eframe::egui::Theme::Dark {
                    ThemePreference::Light
                } else {
                    ThemePreference::Dark
                };
                self.context.set_theme(other);
            }
            Action::Help => self.dialog = Some(Dialog::Help),
            Action::Stop => {
                self.stop();
                self.dialog = None;
            }
        }
        self.follow_overlay();
    }

    /// Width and height of the picture on the screen at full quality.
    pub fn full_size(&self) -> Option<[u32; 2]> {
        self.asked_size()
    }

    /// The command line that draws the current document's picture at a size; `None` before there is one on the screen.
    pub fn command_line(&self, output: &str, size: [u32; 2], transparent: bool) -> Option<String> {
        let document = self.document()?;
        let drawn = self.screen.frame.as_ref()?.drawn.first()?;
        let mut look = document.look.clone();
        if transparent {
            look.background = None;
        }
        let way = &document.way;
        let settings = way.settings(&look, &document.view, &document.volume, size);
        let settings = match way.method() {
            MethodChoice::Auto => Choice::of(&drawn.settings).in_settings(&settings.ok()?),
            MethodChoice::Only(_) => settings.ok()?,
        };
        let drawn = Drawn {
            source: &document.source,
            statistics: &document.statistics,
            look: &look,
            view: &document.view,
            settings: &settings,
            sampler: drawn.sampler,
            backend: drawn.backend.backend,
        };
        Some(drawn.line(output))
    }

    pub(super) fn copy_command(&mut self, output: &str, size: [u32; 2], transparent: bool) {
        match self.command_line(output, size, transparent) {
            Some(line) => {
                tracing::info!("copied: {line}");
                self.context.copy_text(line);
                self.say("copied the command line".to_owned());
            }
            None => self.say("there is no picture yet".to_owned()),
        }
    }

    fn copy_picture(&mut self) {
        let Some(size) = self.full_size() else {
            return;
        };
        match self.shot(size, false) {
            Ok(Some(shot)) => self.start_job(Job::Copy(Box::new(shot))),
            Ok(None) => {}
            Err(error) => self.complain(&error),
        }
    }

    /// Times all methods in all blocks beside the window.
    pub fn sweep(&mut self) {
        let size = self.drawn().map_or([256; 2], |settings| settings.size);
        match self.shot(size, false) {
            Ok(Some(mut shot)) => {
                // Slices skip nothing: it is methods that are timed.
                shot.settings.slices = None;
                shot.way.slices = None;
                if let Some(document) = self.document_mut() {
                    document.sweep.clear();
                }
                self.dialog = Some(Dialog::Sweep);
                self.start_job(Job::Sweep(Box::new(shot)));
            }
            Ok(None) => {}
            Err(error) => self.complain(&error),
        }
    }
}

/// The method after this one, of those that draw.
fn next(method: MethodChoice) -> MethodChoice {
    let methods = METHODS.iter().filter(|m| !m.is_limit);
    let all: Vec<MethodChoice> = [MethodChoice::Auto]
        .into_iter()
        .chain(methods.map(|m| MethodChoice::Only(m.skip)))
        .collect();
    let place = all.iter().position(|m| *m == method).map_or(0, |i| i + 1);
    all[place % all.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_next_method_comes_round() {
        let mut method = MethodChoice::Auto;
        let mut count = 0;
        loop {
            method = next(method);
            count += 1;
            if method == MethodChoice::Auto {
                break;
            }
        }
        assert_eq!(count, METHODS.iter().filter(|m| !m.is_limit).count() + 1);
    }
}
