//! What stands over the window: asking for a file, the sheet of shortcuts, messages.

use eframe::egui::{Align2, Grid, Key, Modifiers, RichText, ScrollArea, Ui, Window, vec2};

use super::app::App;
use super::path_dialog::{self, PathDialog};
use super::shortcuts::{POINTER, SHORTCUTS};
use super::sweep;

/// What is open.
#[derive(Debug)]
pub(super) enum Dialog {
    /// Asking for a path.
    Path(PathDialog),
    /// Keys and pointer.
    Help,
    /// The chart of a sweep.
    Sweep,
}

/// Draws what is open.
pub(super) fn show(app: &mut App, ui: &mut Ui) {
    messages(app, ui);
    match app.dialog.take() {
        None => {}
        Some(Dialog::Path(dialog)) => path_dialog::show(app, ui, dialog),
        Some(Dialog::Help) => help(app, ui),
        Some(Dialog::Sweep) => {
            app.dialog = sweep::show(app, ui).then_some(Dialog::Sweep);
        }
    }
}

fn help(app: &mut App, ui: &Ui) {
    let mut is_open = true;
    Window::new("Keys and pointer")
        .open(&mut is_open)
        .collapsible(false)
        .anchor(Align2::CENTER_CENTER, vec2(0.0, 0.0))
        .show(ui.ctx(), |ui| {
            ScrollArea::vertical().max_height(460.0).show(ui, |ui| {
                Grid::new("help")
                    .num_columns(2)
                    .striped(true)
                    .show(ui, |ui| {
                        for (what, does) in POINTER {
                            ui.label(RichText::new(*what).strong());
                            ui.label(*does);
                            ui.end_row();
                        }
                        for (modifiers, key, _, does) in SHORTCUTS {
                            ui.label(RichText::new(key_name(*modifiers, *key)).strong());
                            ui.label(*does);
                            ui.end_row();
                        }
                    });
            });
        });
    if is_open {
        app.dialog = Some(Dialog::Help);
    }
}

fn key_name(modifiers: Modifiers, key: Key) -> String {
    let mut name = String::new();
    for (held, word) in [(modifiers.command, "ctrl+"), (modifiers.shift, "shift+")] {
        if held {
            name.push_str(word);
        }
    }
    name + key.name()
}

/// What went wrong or was done, until it is dismissed.
fn messages(app: &mut App, ui: &Ui) {
    if app.messages.is_empty() {
        return;
    }
    let mut dismissed = None;
    Window::new("messages")
        .title_bar(false)
        .resizable(false)
        .anchor(Align2::RIGHT_TOP, vec2(-12.0, 42.0))
        .show(ui.ctx(), |ui| {
            ui.set_max_width(440.0);
            for (i, message) in app.messages.iter().enumerate() {
                ui.horizontal_wrapped(|ui| {
                    if ui
                        .small_button("dismiss")
                        .on_hover_text("take this message away")
                        .clicked()
                    {
                        dismissed = Some(i);
                    }
                    let color = if message.is_error {
                        ui.visuals().error_fg_color
                    } else {
                        ui.visuals().text_color()
                    };
                    ui.label(RichText::new(&message.text).color(color));
                });
            }
        });
    if let Some(i) = dismissed {
        app.messages.remove(i);
    }
}
