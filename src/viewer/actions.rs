//! What keys and menus do.

use eframe::egui::{Event, Key, Modifiers, ThemePreference, Ui};

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

/// Keys, what they do, and in which words.
pub const SHORTCUTS: &[(Modifiers, Key, Action, &str)] = &[
    (Modifiers::COMMAND, Key::O, Action::Open, "open a volume"),
    (
        Modifiers::COMMAND,
        Key::S,
        Action::SavePicture,
        "save a picture",
    ),
    (
        Modifiers::COMMAND.plus(Modifiers::SHIFT),
        Key::C,
        Action::CopyCommand,
        "copy the command line that draws the same",
    ),
    (
        Modifiers::COMMAND.plus(Modifiers::SHIFT),
        Key::Z,
        Action::Redo,
        "redo",
    ),
    (Modifiers::COMMAND, Key::Z, Action::Undo, "undo"),
    (Modifiers::NONE, Key::Home, Action::Home, "the default view"),
    (
        Modifiers::NONE,
        Key::P,
        Action::Parallel,
        "parallel rays or perspective",
    ),
    (
        Modifiers::COMMAND,
        Key::Num1,
        Action::Along(0, false),
        "look along x from its negative end",
    ),
    (
        Modifiers::COMMAND,
        Key::Num2,
        Action::Along(1, false),
        "look along y from its negative end",
    ),
    (
        Modifiers::COMMAND,
        Key::Num3,
        Action::Along(2, false),
        "look along z from its negative end",
    ),
    (
        Modifiers::NONE,
        Key::Num1,
        Action::Along(0, true),
        "look along x",
    ),
    (
        Modifiers::NONE,
        Key::Num2,
        Action::Along(1, true),
        "look along y",
    ),
    (
        Modifiers::NONE,
        Key::Num3,
        Action::Along(2, true),
        "look along z",
    ),
    (
        Modifiers::NONE,
        Key::M,
        Action::NextMethod,
        "the next method",
    ),
    (
        Modifiers::NONE,
        Key::C,
        Action::Compare,
        "compare: off, split, side by side, difference",
    ),
    (Modifiers::NONE, Key::H, Action::Heat, "samples per pixel"),
    (
        Modifiers::NONE,
        Key::L,
        Action::Leaves,
        "the octree's active leaves",
    ),
    (Modifiers::NONE, Key::U, Action::Hull, "the hull's faces"),
    (Modifiers::NONE, Key::K, Action::Cut, "the plane of the cut"),
    (Modifiers::NONE, Key::X, Action::Outline, "the volume's box"),
    (
        Modifiers::NONE,
        Key::B,
        Action::Sweep,
        "time methods in all block sizes",
    ),
    (Modifiers::NONE, Key::T, Action::Theme, "light or dark"),
    (Modifiers::NONE, Key::F1, Action::Help, "this sheet"),
    (
        Modifiers::NONE,
        Key::Escape,
        Action::Stop,
        "stop what is under way, close what is open",
    ),
];

/// What the pointer and the keys that are held do, for the sheet.
pub const POINTER: &[(&str, &str)] = &[
    ("drag", "turn about the centre"),
    ("drag with shift, or the middle button", "move"),
    ("wheel, pinch", "come nearer, go away"),
    (
        "drag with the right button",
        "look around from where you are",
    ),
    (
        "W A S D Q E, held",
        "fly: forward, left, back, right, down, up",
    ),
    (
        "double click",
        "turn about the first thing that is hit there",
    ),
    ("ctrl+C", "copy the picture"),
    (
        "drag in the transfer function",
        "move a point; a double click adds one, a right click takes one away, the wheel shows fewer values",
    ),
];

/// Takes the keys that were pressed, unless something is being typed.
pub fn shortcuts(app: &mut App, ui: &Ui) {
    if app.is_typing() {
        if ui.input(|i| i.key_pressed(Key::Escape)) {
            app.dialog = None;
        }
        return;
    }
    for (modifiers, key, action, _) in SHORTCUTS {
        if ui.input_mut(|i| i.consume_key(*modifiers, *key)) {
            app.perform(*action);
        }
    }
    if ui.input(|i| i.events.iter().any(|e| matches!(e, Event::Copy))) {
        app.perform(Action::CopyPicture);
    }
}

impl App {
    /// Whether keys are for what is typed or read.
    pub(super) fn is_typing(&self) -> bool {
        let reads = matches!(self.dialog, Some(Dialog::Path(_) | Dialog::Help));
        reads || self.context.text_edit_focused()
    }

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
    fn every_key_has_one_meaning_and_modified_keys_come_first() {
        for (i, (modifiers, key, ..)) in SHORTCUTS.iter().enumerate() {
            for (other, same, ..) in &SHORTCUTS[i + 1..] {
                assert!(key != same || modifiers != other, "{key:?}");
                // `consume_key` ignores shift that was not asked for.
                assert!(key != same || !other.contains(*modifiers), "{key:?}");
            }
        }
    }

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
