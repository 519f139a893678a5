//! The picture: shown, turned, compared, and drawn over.

use eframe::egui::{
    Align2, Color32, CursorIcon, FontId, Id, Key, Painter, PointerButton, Pos2, Rect, Response,
    Sense, Stroke, TextureHandle, Ui, pos2, vec2,
};
use glam::DVec3;

use super::app::{App, Compare, OnCanvas};
use super::captions;
use super::document::Document;
use super::overlay::{MOST, Projector, Rectangle, box_edges};

/// Radians per point that is dragged.
const TURN: f64 = 0.008;

/// The longest edge of the box is flown along in so many seconds.
const FLIGHT: f64 = 3.0;

/// One picture's place.
pub(super) struct Pane {
    /// Where the whole picture would be.
    pub(super) rect: Rect,
    /// What of it is seen.
    pub(super) seen: Rect,
    /// Which one it is.
    pub(super) which: usize,
}

/// Takes what the pointer does to the picture, asks for the one that follows from it, and draws what there is.
pub(super) fn show(app: &mut App, ui: &mut Ui) {
    let rect = ui.available_rect_before_wrap();
    let response = ui.allocate_rect(rect, Sense::click_and_drag());
    let painter = ui.painter_at(rect);
    if app.document().is_none() {
        welcome(&painter, rect, !app.jobs.is_empty(), ui);
        return;
    }
    let panes = panes(app, rect);
    steer(app, ui, &response, &panes);
    if app.shown.compare == Compare::Split {
        divide(app, ui, rect);
    }
    let pixels = panes[0].rect.size() * ui.ctx().pixels_per_point();
    let most = ui.input(|i| i.max_texture_side).clamp(16, 8192) as u32;
    app.ask([pixels.x, pixels.y].map(|n| (n.round() as u32).clamp(16, most)));
    app.await_moving();
    for pane in &panes {
        picture(app, &painter, pane);
        if let Some(document) = app.document() {
            over(app, document, &painter.with_clip_rect(pane.seen), pane.rect);
        }
    }
    captions::captions(app, &painter, rect, &panes);
    if let Some(document) = app.document() {
        let camera = document.view.camera(document.volume.voxel_size());
        captions::cross(&painter, rect, &camera);
    }
}

fn welcome(painter: &Painter, rect: Rect, is_loading: bool, ui: &Ui) {
    let text = if is_loading {
        "reading the volume…"
    } else {
        "Drop a volume here, or open one: ctrl+O\nNRRD, MetaImage, NIfTI, raw, or phantom:NAME:SIZE"
    };
    let color = ui.visuals().weak_text_color();
    painter.text(
        rect.center(),
        Align2::CENTER_CENTER,
        text,
        FontId::proportional(17.0),
        color,
    );
}

fn panes(app: &App, rect: Rect) -> Vec<Pane> {
    let whole = |seen: Rect, which: usize| Pane { rect, seen, which };
    match app.shown.compare {
        Compare::Off | Compare::Difference => vec![whole(rect, 0)],
        Compare::Split => {
            let x = rect.left() + rect.width() * app.shown.divider;
            let left = Rect::from_min_max(rect.min, pos2(x, rect.bottom()));
            let right = Rect::from_min_max(pos2(x, rect.top()), rect.max);
            vec![whole(left, 0), whole(right, 1)]
        }
        Compare::SideBySide => {
            let half = vec2((rect.width() * 0.5).floor() - 1.0, rect.height());
            let left = Rect::from_min_size(rect.min, half);
            let right = Rect::from_min_size(pos2(rect.right() - half.x, rect.top()), half);
            [left, right]
                .into_iter()
                .enumerate()
                .map(|(which, rect)| Pane {
                    rect,
                    seen: rect,
                    which,
                })
                .collect()
        }
    }
}

/// What pointer and keys do to the view.
fn steer(app: &mut App, ui: &Ui, response: &Response, panes: &[Pane]) {
    let (wheel, pinch, shift, held, dt) = ui.input(|i| {
        let held = [Key::W, Key::S, Key::D, Key::A, Key::E, Key::Q].map(|key| i.key_down(key));
        let held = if i.modifiers.command {
            [false; 6]
        } else {
            held
        };
        (
            i.smooth_scroll_delta().y,
            i.zoom_delta(),
            i.modifiers.shift,
            held,
            i.stable_dt,
        )
    });
    let is_typing = app.is_typing();
    if response.double_clicked()
        && let Some(at) = response.interact_pointer_pos()
    {
        centre(app, panes, at);
    }
    let Some(document) = app.document_mut() else {
        return;
    };
    let size = document.volume.voxel_size();
    let motion = response.drag_delta();
    let (dx, dy) = (f64::from(motion.x), f64::from(motion.y));
    if motion.length_sq() > 0.0 {
        let height = f64::from(response.rect.height().max(1.0));
        let is_panning = response.dragged_by(PointerButton::Middle)
            || (shift && response.dragged_by(PointerButton::Primary));
        if is_panning {
            document.view.pan(dx / height, dy / height, size);
        } else if response.dragged_by(PointerButton::Primary) {
            document.view.orbit(-dx * TURN, -dy * TURN, size);
        } else if response.dragged_by(PointerButton::Secondary) {
            document.view.look(-dx * TURN * 0.5, -dy * TURN * 0.5, size);
        }
    }
    if response.contains_pointer() {
        let factor = (-f64::from(wheel) * 0.0025).exp() / f64::from(pinch);
        if (factor - 1.0).abs() > 1e-6 {
            document.view.zoom(factor, size);
        }
    }
    let [forward, back, right, left, up, down] = held.map(f64::from);
    if !is_typing && held.contains(&true) {
        let way = document.volume.extent().max_element() / FLIGHT * f64::from(dt.min(0.1));
        let [ahead, aside, above] = [forward - back, right - left, up - down].map(|n| n * way);
        document.view.fly(ahead, aside, above, size);
        ui.ctx().request_repaint();
    }
}

/// Turns about the first thing that the ray at `at` meets.
fn centre(app: &mut App, panes: &[Pane], at: Pos2) {
    let Some(pane) = panes.iter().find(|pane| pane.seen.contains(at)) else {
        return;
    };
    let (Some(details), Some(document)) = (&app.screen.details, app.document()) else {
        return;
    };
    let settings = details.settings;
    let [width, height] = settings.size;
    let x = (at.x - pane.rect.left()) / pane.rect.width() * width as f32;
    let y = (at.y - pane.rect.top()) / pane.rect.height() * height as f32;
    let [x, y] = [(x as u32).min(width - 1), (y as u32).min(height - 1)];
    let t = details.first_hit[(y * width + x) as usize];
    let volume = &document.volume;
    if let Ok(frame) = settings
        .camera
        .ray_frame(volume, settings.size, settings.step_voxels)
        && t.is_finite()
    {
        let from_centre = |i: u32, n: u32| f64::from(i) - (f64::from(n) * 0.5 - 0.5);
        let (px, py) = (from_centre(x, width), from_centre(y, height));
        let start = frame.start + frame.start_dx * px + frame.start_dy * py;
        let dir = (frame.dir + frame.dir_dx * px + frame.dir_dy * py).normalize();
        let size = volume.voxel_size();
        let point = (start + dir * f64::from(t)) / size;
        if let Some(document) = app.document_mut() {
            document.view.centre_on(point, size);
        }
    }
}

/// The divider of a split view.
fn divide(app: &mut App, ui: &Ui, rect: Rect) {
    let x = rect.left() + rect.width() * app.shown.divider;
    let handle = Rect::from_center_size(pos2(x, rect.center().y), vec2(12.0, rect.height()));
    let response = ui
        .interact(handle, Id::unique("divider"), Sense::drag())
        .on_hover_and_drag_cursor(CursorIcon::ResizeHorizontal);
    if response.dragged() {
        let moved = response.drag_delta().x / rect.width();
        app.shown.divider = (app.shown.divider + moved).clamp(0.02, 0.98);
    }
}

fn picture(app: &App, painter: &Painter, pane: &Pane) {
    let screen = &app.screen;
    let sent = |texture: &Option<TextureHandle>| texture.as_ref().map(TextureHandle::id);
    let picture = |i: usize| screen.pictures.get(i).and_then(OnCanvas::id);
    let texture = if app.shown.compare == Compare::Difference {
        sent(&screen.difference)
    } else if app.shown.heat && pane.which == 0 {
        sent(&screen.heat).or(picture(0))
    } else {
        picture(pane.which).or(picture(0))
    };
    if let Some(texture) = texture {
        let uv = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        painter
            .with_clip_rect(pane.seen)
            .image(texture, pane.rect, uv, Color32::WHITE);
    }
}

/// Leaves, hull, cut and box.
fn over(app: &App, document: &Document, painter: &Painter, rect: Rect) {
    let size = [rect.width(), rect.height()].map(|n| n.max(1.0) as u32);
    let camera = document.view.camera(document.volume.voxel_size());
    let projector = Projector::new(&camera, size);
    let line = |ends: [DVec3; 2], stroke: Stroke| {
        if let Some(ends) = projector.line(ends) {
            let at = ends.map(|[x, y]| rect.min + rect.size() * vec2(x as f32, y as f32));
            painter.line_segment(at, stroke);
        }
    };
    let rectangles = |all: &[Rectangle], color: Color32, width: f32| {
        let every = all.len().div_ceil(MOST).max(1);
        for corners in all.iter().step_by(every) {
            for i in 0..4 {
                line(
                    [corners[i], corners[(i + 1) % 4]],
                    Stroke::new(width, color),
                );
            }
        }
    };
    if let Some((_, overlay)) = &document.overlay {
        if app.shown.leaves {
            rectangles(
                &overlay.leaves(),
                Color32::from_rgba_unmultiplied(90, 200, 255, 38),
                1.0,
            );
        }
        if app.shown.hull {
            rectangles(
                &overlay.hull(&camera),
                Color32::from_rgba_unmultiplied(255, 190, 60, 70),
                1.0,
            );
        }
        if app.shown.cut {
            let color = Color32::from_rgb(255, 90, 120);
            rectangles(&[overlay.cut(&camera)], color, 2.0);
        }
    }
    if app.shown.outline || app.shown.leaves || app.shown.hull || app.shown.cut {
        let stroke = Stroke::new(1.0, Color32::from_gray(140));
        for edge in box_edges(document.volume.extent()) {
            line(edge, stroke);
        }
    }
}
