//! The panel at the left: the volumes, how they are drawn, what is shown of them, and the numbers.

use eframe::egui::{
    Checkbox, CollapsingHeader, DragValue, Grid, Panel, RichText, ScrollArea, Slider, Ui,
};

use crate::octree::BLOCKS;
use crate::render::{BackendChoice, MethodChoice};
use crate::sample::Sampler;
use crate::skip::{HalfCut, METHODS, Skip, SlabCount};

use super::app::{App, Compare};
use super::document::Document;
use super::look::Way;
use super::rows::{choice, row};
use super::{mode_panel, status};

/// The panel.
pub(super) fn left(app: &mut App, ui: &mut Ui) {
    Panel::left("settings")
        .default_size(292.0)
        .min_size(250.0)
        .show(ui, |ui| {
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
                format!("{}\n{x} x {y} x {z} voxels, {kind}", app.documents[i].name)
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

fn section(ui: &mut Ui, title: &str, open: bool, add: impl FnOnce(&mut Ui)) {
    CollapsingHeader::new(RichText::new(title).strong())
        .id_salt(title)
        .default_open(open)
        .show(ui, add);
}

fn ways(app: &mut App, ui: &mut Ui) {
    let compares = app.shown.compare != Compare::Off;
    let Some(document) = app.document_mut() else {
        return;
    };
    let title = if compares { "Method, left" } else { "Method" };
    section(ui, title, true, |ui| way(ui, "a", &mut document.way));
    if compares {
        section(ui, "Method, right", true, |ui| {
            way(ui, "b", &mut document.other);
        });
    }
}

fn way(ui: &mut Ui, salt: &str, way: &mut Way) {
    Grid::new(("way", salt)).num_columns(2).show(ui, |ui| {
        let auto = "the method, blocks and cuts that promise the least time for this picture on this adapter";
        let methods = METHODS.iter().map(|m| {
            let tip = format!("{}; {}", m.summary, m.known_failure);
            (MethodChoice::Only(m.skip), m.name.to_owned(), tip)
        });
        let methods = [(MethodChoice::Auto, "auto".to_owned(), auto.to_owned())].into_iter().chain(methods);
        let shown = way.method.name();
        choice(ui, ("method", "skip by", "WHERE samples are taken"), &mut way.method, shown, methods);
        let reads_blocks = matches!(way.method, MethodChoice::Only(skip) if skip.reads_blocks());
        if reads_blocks {
            let blocks = BLOCKS.map(|b| (b, format!("{b} voxels"), format!("leaf blocks of {b} x {b} x {b} voxels")));
            let shown = format!("{} voxels", way.block);
            choice(ui, ("block", "blocks", "edge of the octree's leaf blocks"), &mut way.block, &shown, blocks);
        }
        if way.method == MethodChoice::Only(Skip::HalfSplit) {
            let halves = HalfCut::ALL.iter().map(|&h| (h, h.name().to_owned(), String::from("where the volume is cut in two")));
            let shown = way.cuts.half.name();
            choice(ui, ("half", "cut", "where half-split cuts"), &mut way.cuts.half, shown, halves);
        }
        if way.method == MethodChoice::Only(Skip::KCuts) {
            let counts = [SlabCount::Auto, SlabCount::Middle].into_iter().chain([2, 3, 4, 6, 8].map(SlabCount::AtMost));
            let counts = counts.map(|c| (c, c.to_string(), String::from("slabs at most, as many as pay, or two halves")));
            let shown = way.cuts.slabs.to_string();
            choice(ui, ("slabs", "cuts", "into how many slabs k-cuts cuts"), &mut way.cuts.slabs, &shown, counts);
        }
        let samplers = Sampler::ALL.iter().map(|&s| (Some(s), s.name().to_owned(), sampler_tip(s).to_owned()));
        let suited = (None, "as suits".to_owned(), "hardware on a hardware adapter, else exact".to_owned());
        let shown = way.sampler.map_or("as suits", Sampler::name);
        choice(ui, ("sampler", "sampler", "HOW one sample is taken"), &mut way.sampler, shown, [suited].into_iter().chain(samplers));
        row(ui, "step", "distance of samples in voxels of the smallest spacing", |ui| {
            ui.add(DragValue::new(&mut way.step_voxels).range(0.05..=8.0).speed(0.01).max_decimals(4))
        });
        row(ui, "stop at", "opacity at which a ray stops; 1: never", |ui| {
            ui.add(Slider::new(&mut way.ert, 0.5..=1.0).max_decimals(3))
        });
        let backends = BackendChoice::ALL.iter().map(|&b| (b, b.name().to_owned(), backend_tip(b).to_owned()));
        let shown = way.backend.name();
        choice(ui, ("backend", "drawn by", "what draws"), &mut way.backend, shown, backends);
    });
}

fn sampler_tip(sampler: Sampler) -> &'static str {
    match sampler {
        Sampler::Hardware => "the adapter's trilinear filter",
        Sampler::Exact => "eight loads and f32 interpolation",
        Sampler::Tricubic => "64 voxels, smooth to the second derivative, by the adapter's filter",
        Sampler::TricubicExact => "64 voxels, smooth to the second derivative, in f32",
        Sampler::Nearest => "the voxel that the sample lies in",
    }
}

fn backend_tip(backend: BackendChoice) -> &'static str {
    match backend {
        BackendChoice::Auto => "a hardware GPU if there is one, else the CPU, else a software GPU",
        BackendChoice::Gpu => "the best adapter there is, hardware or software",
        BackendChoice::Cpu => "the processor, with SIMD",
        BackendChoice::Reference => "the processor in double precision: slow",
    }
}

fn clipping(document: &mut Document, ui: &mut Ui) {
    section(ui, "Clipping", false, |ui| {
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
            if add
                .on_hover_text("cut through the middle, across x")
                .clicked()
            {
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
    });
}

fn background(document: &mut Document, ui: &mut Ui) {
    section(ui, "Background", false, |ui| {
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
    });
}

fn showing(app: &mut App, ui: &mut Ui) {
    section(ui, "Show", true, |ui| {
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
    });
}
