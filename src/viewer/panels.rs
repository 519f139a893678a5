//! The panel at the left: the volumes, how they are drawn, what is shown of them, and the numbers.

use eframe::egui::{Checkbox, DragValue, Grid, Panel, ScrollArea, Ui};

use super::app::{App, Compare};
use super::document::Document;
use super::rows::{bare, section, tip};
use super::{mode_panel, status, way_panel};

/// The panel.
pub(super) fn left(app: &mut App, ui: &mut Ui) {
    let panel = Panel::left("settings").default_size(292.0).min_size(250.0);
    bare(panel, ui).show(ui, |ui| {
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            volumes(app, ui);
            if app.document().is_some() {
                status::numbers(app, ui);
                ways(app, ui);
                if let Some(document) = app.document_mut() {
                    mode_panel::show(document, ui);
                    clipping(document, ui);
                    background(document, ui);
                }
                showing(app, ui);
            }
        });
    });
}

fn volumes(app: &mut App, ui: &mut Ui) {
    let mut close = None;
    for i in 0..app.documents.len() {
        ui.horizontal(|ui| {
            let name = app.documents[i].short_name().to_owned();
            let about = {
                let volume = &app.documents[i].volume;
                let [x, y, z] = volume.dims;
                let kind = volume.voxels.voxel_type().name();
                format!(
                    "{}\n{x} x {y} x {z} voxels, {kind}",
                    app.documents[i].source.volume
                )
            };
            let row = ui
                .selectable_label(i == app.current, name)
                .on_hover_text(about);
            if row.clicked() {
                app.current = i;
            }
            if ui
                .small_button("close")
                .on_hover_text("close this volume")
                .clicked()
            {
                close = Some(i);
            }
        });
    }
    if let Some(i) = close {
        app.documents.remove(i);
        app.current = app.current.min(app.documents.len().saturating_sub(1));
    }
}

/// Tells what a section of rows of [`way_panel`] holds.
const HOW: &str = "where and how samples are taken";

fn ways(app: &mut App, ui: &mut Ui) {
    let compares = app.shown.compare != Compare::Off;
    let Some(document) = app.document_mut() else {
        return;
    };
    let title = if compares { "Method, left" } else { "Method" };
    let mode = document.look.mode;
    section(ui, title, HOW, true, |ui| {
        way_panel::show(ui, "a", &mut document.way, &mode);
    });
    if compares {
        section(ui, "Method, right", HOW, true, |ui| {
            way_panel::show(ui, "b", &mut document.other, &mode);
        });
    }
}

fn clipping(document: &mut Document, ui: &mut Ui) {
    section(
        ui,
        "Clipping",
        "what of the volume is not drawn",
        false,
        |ui| {
            let dims = document.volume.dims;
            Grid::new("clip").num_columns(3).show(ui, |ui| {
                for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
                    let most = dims[axis] as f64;
                    let range = &mut document.look.clip_box[axis];
                    let label = ui.label(name);
                    let mut ends = [range[0].unwrap_or(0.0), range[1].unwrap_or(most)];
                    for end in 0..2 {
                        let allowed = if end == 0 {
                            0.0..=ends[1] - 0.5
                        } else {
                            ends[0] + 0.5..=most
                        };
                        let drag = DragValue::new(&mut ends[end])
                            .range(allowed)
                            .speed(most / 400.0)
                            .max_decimals(1);
                        let tip = if end == 0 {
                            "shown from this voxel on"
                        } else {
                            "shown up to this voxel"
                        };
                        ui.add(drag).labelled_by(label.id).on_hover_text(tip);
                    }
                    *range = [
                        (ends[0] > 0.0).then_some(ends[0]),
                        (ends[1] < most).then_some(ends[1]),
                    ];
                    ui.end_row();
                }
            });
            let mut remove = None;
            for (i, plane) in document.look.clip_planes.iter_mut().enumerate() {
                ui.horizontal(|ui| {
                    let label = ui.label("plane");
                    for (n, part) in plane.iter_mut().enumerate() {
                        let speed = if n == 3 { 0.2 } else { 0.01 };
                        let tip = "shown is what has x*nx + y*ny + z*nz >= d, in voxels";
                        ui.add(DragValue::new(part).speed(speed).max_decimals(2))
                            .labelled_by(label.id)
                            .on_hover_text(tip);
                    }
                    if plane[..3] == [0.0; 3] {
                        // A normal without length is no plane.
                        plane[0] = 0.01;
                    }
                    if ui
                        .small_button("x")
                        .on_hover_text("take this plane away")
                        .clicked()
                    {
                        remove = Some(i);
                    }
                });
            }
            if let Some(i) = remove {
                document.look.clip_planes.remove(i);
            }
            ui.horizontal(|ui| {
                let can_add = document.look.clip_planes.len() < 6;
                let add = ui.add_enabled(can_add, eframe::egui::Button::new("add plane"));
                if tip(add, "cut through the middle, across x").clicked() {
                    document
                        .look
                        .clip_planes
                        .push([1.0, 0.0, 0.0, dims[0] as f64 * 0.5]);
                }
                if ui
                    .button("clip nothing")
                    .on_hover_text("show all of the volume")
                    .clicked()
                {
                    document.look.clip_box = [[None; 2]; 3];
                    document.look.clip_planes.clear();
                }
            });
        },
    );
}

fn background(document: &mut Document, ui: &mut Ui) {
    section(
        ui,
        "Background",
        "what stands behind the picture",
        false,
        |ui| {
            ui.horizontal(|ui| {
                let mut is_set = document.look.background.is_some();
                ui.checkbox(&mut is_set, "colour")
                    .on_hover_text("stand the picture before a colour; else it stays transparent");
                let mut color = document.look.background.unwrap_or([0; 3]);
                ui.color_edit_button_srgb(&mut color)
                    .on_hover_text("colour behind the picture");
                document.look.background = is_set.then_some(color);
                for (name, color) in [("black", [0; 3]), ("white", [255; 3])] {
                    if ui
                        .small_button(name)
                        .on_hover_text("behind the picture")
                        .clicked()
                    {
                        document.look.background = Some(color);
                    }
                }
            });
        },
    );
}

fn showing(app: &mut App, ui: &mut Ui) {
    section(
        ui,
        "Show",
        "what is drawn over the picture, or in its place",
        true,
        |ui| {
            let shown = &mut app.shown;
            for (value, name, tip) in [
                (
                    &mut shown.heat,
                    "samples a pixel (H)",
                    "how many samples each pixel took, as heat",
                ),
                (
                    &mut shown.leaves,
                    "leaves (L)",
                    "outer faces of the octree's active leaves: what is outside them is skipped",
                ),
                (
                    &mut shown.hull,
                    "hull (U)",
                    "faces of both halves' hulls, which half-split rasterises",
                ),
                (
                    &mut shown.cut,
                    "cut (K)",
                    "the plane across the view that half-split cuts at",
                ),
                (&mut shown.outline, "box (X)", "the volume's bounding box"),
            ] {
                ui.checkbox(value, name).on_hover_text(tip);
            }
            ui.add(Checkbox::new(
            &mut app.quality.adapts,
            "hold the frame rate while moving",
        ))
        .on_hover_text(
            "take longer steps and fewer pixels while something moves; never in a saved picture",
        );
            app.follow_overlay();
        },
    );
}
