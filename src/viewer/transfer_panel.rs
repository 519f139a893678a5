//! The transfer function's editor at the bottom: histogram, points to drag, presets, files.

use eframe::egui::{
    Align2, Color32, FontId, Id, Mesh, Painter, Panel, PointerButton, Pos2, Rect, Response, Sense,
    Shape, Stroke, Ui, pos2, vec2,
};

use crate::transfer::{ControlPoint, PRESETS, TransferFunction};

use super::actions::Action;
use super::app::App;
use super::command::srgb;
use super::dialogs::Dialog;
use super::document::Document;
use super::editor::{Axes, add_point, move_point, remove_point, with_points};
use super::look::linear;
use super::path_dialog::PathFor;
use super::rows;

/// How near a point the pointer takes hold of it, in points of the screen.
const REACH: f32 = 11.0;

/// The panel.
pub fn bottom(app: &mut App, ui: &mut Ui) {
    if app.document().is_none() {
        return;
    }
    let panel = rows::bare(Panel::bottom("transfer").exact_size(176.0), ui);
    panel.show(ui, |ui| {
        // Tools that find no room must not make the editor wider than the window.
        let width = ui.available_width();
        ui.horizontal_wrapped(|ui| tools(app, ui));
        if let Some(document) = app.document_mut() {
            editor(document, ui, width);
        }
    });
}

fn tools(app: &mut App, ui: &mut Ui) {
    let (can_undo, can_redo) = app.document().map_or((false, false), |d| {
        (d.history.can_undo(), d.history.can_redo())
    });
    let mut button = |enabled: bool, name: &str, tip: &str| {
        let button = ui.add_enabled(enabled, eframe::egui::Button::new(name));
        rows::tip(button, tip).clicked()
    };
    let undo = button(can_undo, "undo", "undo the last edit (ctrl+Z)");
    let redo = button(can_redo, "redo", "redo it (ctrl+shift+Z)");
    let load = button(true, "load", "read a TOML file of control points");
    let save = button(true, "save", "write one, for --tf");
    for (asked, action) in [(undo, Action::Undo), (redo, Action::Redo)] {
        if asked {
            app.perform(action);
        }
    }
    for (asked, purpose) in [(load, PathFor::LoadTransfer), (save, PathFor::SaveTransfer)] {
        if asked {
            app.dialog = Some(Dialog::path(purpose));
        }
    }
    let Some(document) = app.document_mut() else {
        return;
    };
    ui.separator();
    ui.menu_button("presets", |ui| presets(document, ui))
        .response
        .on_hover_text("transfer functions that look at the histogram");
    ui.separator();
    ui.checkbox(&mut document.axes.near_zero, "near zero")
        .on_hover_text("draw small opacities apart: height is the opacity's fourth root");
    if ui
        .button("all values")
        .on_hover_text("show all values; the wheel shows fewer")
        .clicked()
    {
        document.axes.values = Axes::whole(&document.statistics).values;
    }
    selected(document, ui);
}

fn presets(document: &mut Document, ui: &mut Ui) {
    for preset in PRESETS {
        let button = ui.button(preset.name).on_hover_text(preset.summary);
        if button.clicked()
            && let Ok(transfer) = preset.transfer_function(&document.statistics)
        {
            document.look.transfer = transfer;
            document.selected = None;
            ui.close();
        }
    }
}

/// The selected point's numbers.
fn selected(document: &mut Document, ui: &mut Ui) {
    let transfer = &document.look.transfer;
    let Some((i, mut point)) = document
        .selected
        .and_then(|i| Some((i, *transfer.points().get(i)?)))
    else {
        return;
    };
    ui.separator();
    let mut color = srgb(point.color);
    let picked = ui
        .color_edit_button_srgb(&mut color)
        .on_hover_text("colour of the selected point");
    if picked.changed() {
        point.color = linear(color).map(f64::from);
    }
    let [low, high] = document.statistics.value_range();
    let drag = |value| eframe::egui::DragValue::new(value);
    ui.add(
        drag(&mut point.value)
            .speed((high - low).max(1e-6) / 500.0)
            .max_decimals(4)
            .prefix("value "),
    )
    .on_hover_text("data value of the selected point");
    ui.add(
        drag(&mut point.opacity)
            .speed(0.002)
            .range(0.0..=1.0)
            .max_decimals(6)
            .prefix("opacity "),
    )
    .on_hover_text("its opacity per voxel");
    if point != transfer.points()[i] {
        let mut points = move_point(transfer, i, point.value, point.opacity);
        points[i].color = point.color;
        document.look.transfer = with_points(transfer, points);
    }
}

/// Where values and opacities lie on the screen.
#[derive(Clone, Copy)]
struct Place {
    rect: Rect,
    axes: Axes,
}

impl Place {
    fn at(&self, value: f64, opacity: f64) -> Pos2 {
        let x = self.rect.left() + self.rect.width() * self.axes.x(value) as f32;
        pos2(
            x,
            self.rect.bottom() - self.rect.height() * self.axes.y(opacity) as f32,
        )
    }

    fn of(&self, at: Pos2) -> (f64, f64) {
        let x = f64::from((at.x - self.rect.left()) / self.rect.width());
        let y = f64::from((self.rect.bottom() - at.y) / self.rect.height());
        (self.axes.value(x), self.axes.opacity(y))
    }

    fn nearest(&self, points: &[ControlPoint], at: Pos2) -> Option<usize> {
        let off = |p: &ControlPoint| self.at(p.value, p.opacity).distance(at);
        let near = points.iter().enumerate().map(|(i, p)| (i, off(p)));
        near.filter(|(_, off)| *off <= REACH)
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .map(|(i, _)| i)
    }
}

/// The id of the area whose points are dragged, for tests that drag them.
pub fn editor_id() -> Id {
    Id::unique("transfer editor")
}

fn editor(document: &mut Document, ui: &mut Ui, width: f32) {
    let size = vec2(width, ui.available_height() - 16.0);
    let (outer, _) = ui.allocate_exact_size(size, Sense::hover());
    let rect = outer.shrink2(vec2(8.0, 6.0));
    let response = ui.interact(outer, editor_id(), Sense::click_and_drag());
    response.widget_info(|| {
        eframe::egui::WidgetInfo::labeled(eframe::egui::Role::Canvas, true, "opacity over values")
    });
    let place = Place {
        rect,
        axes: document.axes,
    };
    edit(document, ui, &response, place);
    let painter = ui.painter_at(outer);
    paint(document, &painter, place, ui);
    let font = FontId::proportional(12.0);
    if document.selected.is_none() {
        let hint = "drag points, double click to add one, right click to take one away";
        let color = ui.visuals().weak_text_color();
        painter.text(
            rect.center_top(),
            Align2::CENTER_TOP,
            hint,
            font.clone(),
            color,
        );
    }
    if let Some(at) = response.hover_pos() {
        let (value, opacity) = place.of(at);
        let text = format!("{value:.4}: opacity {opacity:.4}");
        let color = ui.visuals().weak_text_color();
        painter.text(rect.right_top(), Align2::RIGHT_TOP, text, font, color);
    }
}

fn edit(document: &mut Document, ui: &Ui, response: &Response, place: Place) {
    let transfer = &document.look.transfer;
    let pointer = response.interact_pointer_pos();
    if (response.drag_started() || response.clicked())
        && let Some(at) = ui.input(|i| i.pointer.press_origin()).or(pointer)
    {
        document.selected = place.nearest(transfer.points(), at);
    }
    let (Some(at), near) = (
        pointer,
        pointer.and_then(|at| place.nearest(transfer.points(), at)),
    ) else {
        scroll(document, ui, response, place);
        return;
    };
    let (value, opacity) = place.of(at);
    let edited = if response.double_clicked() && near.is_none() {
        let (points, i) = add_point(transfer, value, opacity);
        document.selected = Some(i);
        Some(points)
    } else if let (true, Some(i)) = (response.secondary_clicked(), near) {
        document.selected = None;
        Some(remove_point(transfer, i))
    } else {
        document
            .selected
            // The last way that a quick pointer makes may come with its letting go.
            .filter(|_| {
                let primary = PointerButton::Primary;
                response.dragged_by(primary) || response.drag_stopped_by(primary)
            })
            .map(|i| move_point(transfer, i, value, opacity))
    };
    if let Some(points) = edited {
        document.look.transfer = with_points(transfer, points);
    }
    scroll(document, ui, response, place);
}

fn scroll(document: &mut Document, ui: &Ui, response: &Response, place: Place) {
    let wheel = ui.input(|i| i.smooth_scroll_delta().y);
    if let Some(at) = response.hover_pos()
        && wheel != 0.0
    {
        let x = f64::from((at.x - place.rect.left()) / place.rect.width());
        let whole = Axes::whole(&document.statistics).values;
        let factor = (-f64::from(wheel) * 0.004).exp();
        document.axes.zoom(factor, x.clamp(0.0, 1.0), whole);
    }
}

fn paint(document: &Document, painter: &Painter, place: Place, ui: &Ui) {
    let rect = place.rect;
    let transfer = &document.look.transfer;
    painter.rect_filled(rect.expand(4.0), 3.0, ui.visuals().extreme_bg_color);
    let clipped = painter.with_clip_rect(rect.expand2(vec2(0.0, 4.0)));
    let bar = ui.visuals().weak_text_color().gamma_multiply(0.45);
    for ([from, to], height) in &document.bars {
        let [left, right] = [*from, *to].map(|v| place.at(v, 0.0).x);
        let top = rect.bottom() - rect.height() * *height as f32;
        clipped.rect_filled(
            Rect::from_x_y_ranges(left..=right.max(left + 1.0), top..=rect.bottom()),
            0.0,
            bar,
        );
    }
    clipped.add(area(transfer, place));
    let line: Vec<Pos2> = samples(transfer, place.axes)
        .map(|value| place.at(value, transfer.at(value).1))
        .collect();
    let strong = ui.visuals().strong_text_color();
    clipped.line(line, Stroke::new(1.5, strong));
    for (i, point) in transfer.points().iter().enumerate() {
        let [r, g, b] = srgb(point.color);
        let at = place.at(point.value, point.opacity);
        let is_selected = document.selected == Some(i);
        let radius = if is_selected { 7.0 } else { 5.0 };
        let ring = Stroke::new(if is_selected { 2.5 } else { 1.5 }, strong);
        painter.with_clip_rect(rect.expand(8.0)).circle(
            at,
            radius,
            Color32::from_rgb(r, g, b),
            ring,
        );
    }
    let font = FontId::proportional(11.0);
    let weak = ui.visuals().weak_text_color();
    let below = rect.bottom() + 5.0;
    let outside = ui.painter();
    for (f, anchor) in [
        (0.0, Align2::LEFT_TOP),
        (0.5, Align2::CENTER_TOP),
        (1.0, Align2::RIGHT_TOP),
    ] {
        let x = rect.left() + rect.width() * f;
        let text = format!("{:.4}", place.axes.value(f64::from(f)));
        let text = text.trim_end_matches('0').trim_end_matches('.').to_owned();
        outside.text(pos2(x, below), anchor, text, font.clone(), weak);
    }
}

/// Values to draw the function at: evenly over what is shown, and at its points.
fn samples(transfer: &TransferFunction, axes: Axes) -> impl Iterator<Item = f64> {
    let mut values: Vec<f64> = (0..=128)
        .map(|i| axes.value(f64::from(i) / 128.0))
        .collect();
    values.extend(transfer.points().iter().map(|p| p.value));
    values.retain(|v| (0.0..=1.0).contains(&axes.x(*v)));
    values.sort_by(f64::total_cmp);
    values.into_iter()
}

/// What lies below the function, in its colours.
fn area(transfer: &TransferFunction, place: Place) -> Shape {
    let mut mesh = Mesh::default();
    for value in samples(transfer, place.axes) {
        let (color, opacity) = transfer.at(value);
        let [r, g, b] = srgb(color);
        let color = Color32::from_rgba_unmultiplied(r, g, b, 150);
        let n = mesh.vertices.len() as u32;
        mesh.colored_vertex(place.at(value, opacity), color);
        mesh.colored_vertex(place.at(value, 0.0), color);
        if n >= 2 {
            mesh.add_triangle(n - 2, n - 1, n);
            mesh.add_triangle(n - 1, n, n + 1);
        }
    }
    Shape::mesh(mesh)
}
