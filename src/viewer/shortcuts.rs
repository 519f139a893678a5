//! Keys: which there are, what they mean, and taking them.

use eframe::egui::{Event, Key, Modifiers, Popup, Ui};

use super::actions::Action;
use super::app::App;
use super::dialogs::Dialog;

/// Keys, what they do, and in which words.
pub(super) const SHORTCUTS: &[(Modifiers, Key, Action, &str)] = &[
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
pub(super) const POINTER: &[(&str, &str)] = &[
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
pub(super) fn take(app: &mut App, ui: &Ui) {
    if app.is_typing() {
        if ui.input(|i| i.key_pressed(Key::Escape)) {
            app.dialog = None;
        }
        return;
    }
    if Popup::is_any_open(ui.ctx()) {
        // A list or menu that is open takes the keys, to be closed by one.
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
}
