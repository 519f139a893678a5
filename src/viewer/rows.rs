//! Rows of a panel: a name, a control, and what the control does as its tooltip.

use eframe::egui::{
    CollapsingHeader, Color32, ComboBox, DragValue, Frame, Panel, Response, RichText, Ui,
};

/// A panel that paints no ground of its own: the window is cleared to it, which costs a software adapter nothing.
pub(super) fn bare(panel: Panel, ui: &Ui) -> Panel {
    panel.frame(Frame::side_top_panel(ui.style()).fill(Color32::TRANSPARENT))
}

/// A part of a panel that can be folded away.
pub(super) fn section(ui: &mut Ui, title: &str, tip: &str, open: bool, add: impl FnOnce(&mut Ui)) {
    CollapsingHeader::new(RichText::new(title).strong())
        .id_salt(title)
        .default_open(open)
        .show(ui, add)
        .header_response
        .on_hover_text(tip);
}

/// A tooltip, whether or not the control can be used just now.
pub(super) fn tip(response: Response, tip: &str) -> Response {
    response.on_hover_text(tip).on_disabled_hover_text(tip)
}

/// A name and a control beside it.
pub(super) fn row(ui: &mut Ui, name: &str, tip: &str, add: impl FnOnce(&mut Ui) -> Response) {
    let label = ui.label(name).on_hover_text(tip);
    add(ui).labelled_by(label.id).on_hover_text(tip);
    ui.end_row();
}

/// A choice from a list; each with its own words and tooltip.
pub(super) fn choice<T: PartialEq>(
    ui: &mut Ui,
    (salt, name, tip): (&str, &str, &str),
    value: &mut T,
    shown: &str,
    all: impl IntoIterator<Item = (T, String, String)>,
) {
    row(ui, name, tip, |ui| {
        ComboBox::from_id_salt(salt)
            .selected_text(shown)
            .width(150.0)
            .show_ui(ui, |ui| {
                for (one, words, tip) in all {
                    ui.selectable_value(value, one, words).on_hover_text(tip);
                }
            })
            .response
    });
}

/// A number to drag or type.
pub(super) fn number(
    ui: &mut Ui,
    (name, tip): (&str, &str),
    value: &mut f64,
    range: std::ops::RangeInclusive<f64>,
    speed: f64,
) {
    row(ui, name, tip, |ui| {
        ui.add(
            DragValue::new(value)
                .range(range)
                .speed(speed)
                .max_decimals(6),
        )
    });
}

/// A linear colour, chosen as an sRGB one.
pub(super) fn color(ui: &mut Ui, (name, tip): (&str, &str), value: &mut [f64; 3]) {
    row(ui, name, tip, |ui| {
        let mut srgb = super::command::srgb(*value);
        let response = ui.color_edit_button_srgb(&mut srgb);
        if response.changed() {
            *value = super::look::linear(srgb).map(f64::from);
        }
        response
    });
}
