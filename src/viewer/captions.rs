//! What is written over the picture: what each is, the legend of heat, the axis cross.

use eframe::egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Stroke, StrokeKind, pos2, vec2};
use glam::DVec3;

use crate::camera::Camera;
use crate::output::heat;
use crate::render::Choice;
use crate::scene::Picture;

use super::app::{App, Compare};
use super::canvas::Pane;
use super::image;
use super::reply::GAIN;
use super::view::across;

/// What each picture is, in its corner; the divider; the legend of heat; the number of a difference.
pub(super) fn captions(app: &App, painter: &Painter, rect: Rect, panes: &[Pane]) {
    let caption = |at: Pos2, anchor: Align2, text: String| {
        let font = FontId::proportional(13.0);
        let galley = painter.layout_no_wrap(text, font, Color32::from_gray(235));
        let place = anchor.anchor_size(at, galley.size());
        painter.rect_filled(place.expand(4.0), 3.0, Color32::from_black_alpha(150));
        painter.galley(place.min, galley, Color32::WHITE);
    };
    let Some(document) = app.document() else {
        return;
    };
    let frame = app.screen.frame.as_ref();
    let drawn_by = |which: usize| {
        let way = if which == 0 {
            &document.way
        } else {
            &document.other
        };
        let drawn = frame.and_then(|f| f.drawn.get(which));
        drawn.map_or_else(
            || way.words(),
            |d| {
                let choice = d.settings.slices.map_or_else(
                    || Choice::of(&d.settings).words(),
                    |count| format!("slices, {count}"),
                );
                format!("{choice}: {:.1} ms", d.times.frame_ms)
            },
        )
    };
    let [top, margin] = [rect.top() + 10.0, 12.0];
    match app.shown.compare {
        Compare::Off => {}
        Compare::Difference => {
            if let Some(compared) = frame.and_then(|f| f.compared.as_ref()) {
                let text = if compared.pixels == 0 {
                    "not one bit differs".to_owned()
                } else {
                    format!(
                        "{} pixels differ, by {:.2e} at most, PSNR {:.1} dB; shown {GAIN} times",
                        compared.pixels, compared.max_abs, compared.psnr_db
                    )
                };
                caption(pos2(rect.center().x, top), Align2::CENTER_TOP, text);
            }
        }
        Compare::Split | Compare::SideBySide => {
            let (a, b) = (&panes[0], &panes[1]);
            caption(
                pos2(a.seen.left() + margin, top),
                Align2::LEFT_TOP,
                drawn_by(0),
            );
            caption(
                pos2(b.seen.right() - margin, top),
                Align2::RIGHT_TOP,
                drawn_by(1),
            );
            let x = if app.shown.compare == Compare::Split {
                a.seen.right()
            } else {
                rect.center().x
            };
            let stroke = Stroke::new(2.0, Color32::from_gray(230));
            painter.vline(x, rect.y_range(), stroke);
            if app.shown.compare == Compare::Split {
                let at = pos2(x, rect.center().y);
                painter.circle_filled(at, 7.0, Color32::from_gray(230));
            }
        }
    }
    if app.shown.heat
        && let Some(details) = &app.screen.details
    {
        legend(painter, rect, details.most);
    }
}

/// The bar of heat: what its colours count.
fn legend(painter: &Painter, rect: Rect, most: u32) {
    let bar = Rect::from_min_size(
        pos2(rect.right() - 232.0, rect.bottom() - 44.0),
        vec2(220.0, 12.0),
    );
    painter.rect_filled(
        bar.expand2(vec2(8.0, 18.0)),
        3.0,
        Color32::from_black_alpha(160),
    );
    let image = image::shown(
        &Picture {
            size: [110, 1],
            rgba: (0..110).map(|i| heat::color(i as f32 / 109.0)).collect(),
        },
        [0.0; 3],
    );
    for (i, color) in image.pixels.iter().enumerate() {
        let x = bar.left() + i as f32 * 2.0;
        let cell = Rect::from_min_size(pos2(x, bar.top()), vec2(2.0, bar.height()));
        painter.rect_filled(cell, 0.0, *color);
    }
    painter.rect_stroke(
        bar,
        0.0,
        Stroke::new(1.0, Color32::from_gray(90)),
        StrokeKind::Outside,
    );
    let font = FontId::proportional(12.0);
    let white = Color32::from_gray(235);
    let below = bar.bottom() + 2.0;
    painter.text(
        pos2(bar.left(), below),
        Align2::LEFT_TOP,
        "0",
        font.clone(),
        white,
    );
    painter.text(
        pos2(bar.center().x, below),
        Align2::CENTER_TOP,
        "samples a pixel",
        font.clone(),
        white,
    );
    painter.text(
        pos2(bar.right(), below),
        Align2::RIGHT_TOP,
        most.to_string(),
        font,
        white,
    );
}

/// The three axes as the camera sees them.
pub(super) fn cross(painter: &Painter, rect: Rect, camera: &Camera) {
    const LENGTH: f64 = 26.0;
    let centre = pos2(rect.left() + 44.0, rect.bottom() - 44.0);
    let (right, top) = across(camera);
    let forward = camera.forward();
    let mut axes = [
        (DVec3::X, "x", Color32::from_rgb(240, 90, 90)),
        (DVec3::Y, "y", Color32::from_rgb(110, 210, 110)),
        (DVec3::Z, "z", Color32::from_rgb(100, 150, 255)),
    ];
    // The farthest first, so that nearer ones cover it.
    axes.sort_by(|a, b| b.0.dot(forward).total_cmp(&a.0.dot(forward)));
    for (axis, name, color) in axes {
        let tip = vec2(
            (axis.dot(right) * LENGTH) as f32,
            (-axis.dot(top) * LENGTH) as f32,
        );
        painter.line_segment([centre, centre + tip], Stroke::new(2.5, color));
        let at = centre + tip * 1.32;
        painter.text(
            at,
            Align2::CENTER_CENTER,
            name,
            FontId::proportional(12.0),
            color,
        );
    }
}
