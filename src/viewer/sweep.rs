//! The chart of a sweep: frame time over block size, a line per method. A click on a point draws by it.

use eframe::egui::{
    Align2, Color32, CursorIcon, FontId, Painter, Pos2, Rect, Sense, Stroke, Ui, Window, pos2, vec2,
};

use crate::octree::BLOCKS;
use crate::render::Choice;
use crate::skip::{METHODS, Skip};

use super::app::App;
use super::rows;

/// How near a point a click counts as on it.
const REACH: f32 = 14.0;

/// A line per method, told apart in grey too.
const COLORS: [Color32; 8] = [
    Color32::from_rgb(230, 159, 0),
    Color32::from_rgb(86, 180, 233),
    Color32::from_rgb(0, 158, 115),
    Color32::from_rgb(240, 228, 66),
    Color32::from_rgb(0, 114, 178),
    Color32::from_rgb(213, 94, 0),
    Color32::from_rgb(204, 121, 167),
    Color32::from_rgb(170, 170, 170),
];

/// Draws the window; tells whether it stays open.
pub(super) fn show(app: &mut App, ui: &Ui) -> bool {
    let mut is_open = true;
    let mut taken = None;
    let mut again = false;
    let is_running = app.jobs.iter().any(|job| job.label.starts_with("timing"));
    let Some(document) = app.document() else {
        return false;
    };
    let current = app.drawn().map(|settings| Choice::of(&settings));
    Window::new("Frame time by block size")
        .open(&mut is_open)
        .collapsible(false)
        .default_pos([380.0, 70.0])
        .default_size([540.0, 340.0])
        .show(ui.ctx(), |ui| {
            let rows = &document.sweep;
            taken = chart(ui, rows, current);
            ui.horizontal(|ui| {
                let button = eframe::egui::Button::new("time again");
                let tip =
                    "draw the picture on the screen by every lossless method in every block size";
                again = rows::tip(ui.add_enabled(!is_running, button), tip).clicked();
                ui.weak(if is_running {
                    "timing…"
                } else {
                    "click a point to draw by it"
                });
            });
        });
    if let Some(choice) = taken {
        app.take(choice);
    }
    if again {
        app.sweep();
    }
    is_open
}

/// Draws what was timed; a choice where one was clicked.
fn chart(ui: &mut Ui, rows: &[(Choice, f64)], current: Option<Choice>) -> Option<Choice> {
    let (outer, response) =
        ui.allocate_exact_size(vec2(ui.available_width().max(500.0), 280.0), Sense::click());
    let painter = ui.painter_at(outer);
    let rect = Rect::from_min_max(outer.min + vec2(58.0, 10.0), outer.max - vec2(112.0, 24.0));
    painter.rect_filled(rect, 2.0, ui.visuals().extreme_bg_color);
    let most = rows.iter().map(|r| r.1).fold(1e-3, f64::max) * 1.05;
    let weak = ui.visuals().weak_text_color();
    let font = FontId::proportional(11.0);
    for i in 0..=4 {
        let y = rect.bottom() - rect.height() * i as f32 / 4.0;
        painter.hline(rect.x_range(), y, Stroke::new(0.5, weak));
        let text = format!("{:.1} ms", most * f64::from(i) / 4.0);
        painter.text(
            pos2(rect.left() - 4.0, y),
            Align2::RIGHT_CENTER,
            text,
            font.clone(),
            weak,
        );
    }
    for block in BLOCKS {
        let x = rect.left() + rect.width() * place(block);
        painter.text(
            pos2(x, rect.bottom() + 4.0),
            Align2::CENTER_TOP,
            block.to_string(),
            font.clone(),
            weak,
        );
    }
    let at = |choice: &Choice, ms: f64| {
        let y = rect.bottom() - rect.height() * (ms / most) as f32;
        pos2(rect.left() + rect.width() * place(choice.block), y)
    };
    let mut label = outer.top() + 12.0;
    for (i, method) in METHODS.iter().enumerate() {
        let own: Vec<&(Choice, f64)> = rows.iter().filter(|r| r.0.skip == method.skip).collect();
        let Some((_, ms)) = own.first() else {
            continue;
        };
        let color = COLORS[i % COLORS.len()];
        if method.skip == Skip::Box {
            let y = at(&own[0].0, *ms).y;
            painter.hline(rect.x_range(), y, Stroke::new(1.5, color));
        } else {
            let line: Vec<Pos2> = own.iter().map(|(c, ms)| at(c, *ms)).collect();
            for p in &line {
                painter.circle_filled(*p, 3.5, color);
            }
            painter.line(line, Stroke::new(1.5, color));
        }
        key(
            &painter,
            pos2(rect.right() + 8.0, label),
            method.name,
            color,
        );
        label += 16.0;
    }
    if let Some((choice, ms)) = rows.iter().find(|r| Some(r.0) == current) {
        painter.circle_stroke(
            at(choice, *ms),
            7.0,
            Stroke::new(1.5, ui.visuals().strong_text_color()),
        );
    }
    let pointer = response.hover_pos()?;
    let near = rows
        .iter()
        .map(|row| (row, at(&row.0, row.1).distance(pointer)))
        .filter(|(_, off)| *off < REACH)
        .min_by(|a, b| a.1.total_cmp(&b.1))?;
    let (choice, ms) = near.0;
    let clicked = response.clicked();
    response
        .on_hover_cursor(CursorIcon::PointingHand)
        .on_hover_text(format!("{}: {ms:.1} ms", choice.words()));
    clicked.then_some(*choice)
}

/// Where a block size stands on the axis, 0 to 1: evenly by its logarithm.
fn place(block: usize) -> f32 {
    let last = BLOCKS.len() - 1;
    let i = BLOCKS.iter().position(|&b| b == block).unwrap_or(0);
    0.04 + 0.92 * i as f32 / last as f32
}

fn key(painter: &Painter, at: Pos2, name: &str, color: Color32) {
    painter.circle_filled(at, 4.0, color);
    painter.text(
        at + vec2(9.0, 0.0),
        Align2::LEFT_CENTER,
        name,
        FontId::proportional(11.5),
        color,
    );
}
