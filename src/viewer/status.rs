//! The bars at the top and the bottom, and the live numbers.

use eframe::egui::{
    Color32, Grid, MenuBar, Panel, ProgressBar, Rect, RichText, Sense, Stroke, Ui, pos2, vec2,
};

use crate::render::{Choice, MethodChoice};

use super::actions::Action;
use super::app::{App, Compare};
use super::dialogs::Dialog;
use super::path_dialog::PathFor;
use super::reply::Stage;
use super::rows::{bare, section};

/// Menus.
pub(super) fn top(app: &mut App, ui: &mut Ui) {
    bare(Panel::top("menu"), ui).show(ui, |ui| {
        MenuBar::new().ui(ui, |ui| {
            ui.menu_button("File", |ui| file_menu(app, ui))
                .response
                .on_hover_text("open, save, copy");
            ui.menu_button("View", |ui| view_menu(app, ui))
                .response
                .on_hover_text("where the picture is taken from, and the theme");
            item(
                app,
                ui,
                "Sweep",
                "time methods in all block sizes (B)",
                Action::Sweep,
            );
            item(app, ui, "Help", "the sheet of shortcuts (F1)", Action::Help);
            ui.separator();
            ui.label("compare")
                .on_hover_text("two ways to draw, on one camera (C)");
            let all = [
                (Compare::Off, "off", "one picture"),
                (
                    Compare::Split,
                    "split",
                    "one way left of a divider, the other right of it",
                ),
                (Compare::SideBySide, "side by side", "both pictures, whole"),
                (
                    Compare::Difference,
                    "difference",
                    "where the two differ, and by how much",
                ),
            ];
            for (compare, name, tip) in all {
                ui.selectable_value(&mut app.shown.compare, compare, name)
                    .on_hover_text(tip);
            }
        });
    });
}

fn item(app: &mut App, ui: &mut Ui, name: &str, tip: &str, action: Action) {
    if ui.button(name).on_hover_text(tip).clicked() {
        app.perform(action);
        ui.close();
    }
}

fn file_menu(app: &mut App, ui: &mut Ui) {
    item(
        app,
        ui,
        "Open…",
        "a volume (ctrl+O); dropping a file does it too",
        Action::Open,
    );
    ui.menu_button("Open recent", |ui| {
        for source in app.recent.volumes.clone() {
            let name = ui.button(&source.volume);
            if name.on_hover_text("open it again").clicked() {
                app.open(source);
                ui.close();
            }
        }
    })
    .response
    .on_hover_text("volumes that were opened last");
    ui.separator();
    item(
        app,
        ui,
        "Save picture…",
        "of any size (ctrl+S)",
        Action::SavePicture,
    );
    let mut ask = |name: &str, tip: &str, purpose: PathFor| {
        if ui.button(name).on_hover_text(tip).clicked() {
            app.dialog = Some(Dialog::path(purpose));
            ui.close();
        }
    };
    ask(
        "Save orbit…",
        "numbered pictures all around",
        PathFor::Orbit,
    );
    ask(
        "Save session…",
        "all open volumes and how they are looked at",
        PathFor::SaveSession,
    );
    ask("Restore session…", "what was saved so", PathFor::Session);
    ui.separator();
    item(
        app,
        ui,
        "Copy picture",
        "to the clipboard (ctrl+C)",
        Action::CopyPicture,
    );
    item(
        app,
        ui,
        "Copy command line",
        "that draws the same picture, bit for bit (ctrl+shift+C)",
        Action::CopyCommand,
    );
}

fn view_menu(app: &mut App, ui: &mut Ui) {
    item(app, ui, "Default view", "Home", Action::Home);
    item(
        app,
        ui,
        "Parallel rays",
        "or back to perspective (P)",
        Action::Parallel,
    );
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let key = axis + 1;
        item(
            app,
            ui,
            &format!("Along {name}"),
            &format!("from its positive end ({key})"),
            Action::Along(axis, true),
        );
        item(
            app,
            ui,
            &format!("Along -{name}"),
            &format!("from its negative end (ctrl+{key})"),
            Action::Along(axis, false),
        );
    }
    ui.separator();
    item(
        app,
        ui,
        "Light or dark",
        "the window's theme (T)",
        Action::Theme,
    );
}

/// Progress, quality and the verdict.
pub(super) fn bottom(app: &mut App, ui: &mut Ui) {
    bare(Panel::bottom("status").exact_size(26.0), ui).show(ui, |ui| {
        ui.horizontal_centered(|ui| {
            let mut cancelled = None;
            for (i, job) in app.jobs.iter().enumerate() {
                let fraction = job.control.fraction();
                // Not animated where the job does not tell: that would redraw the window for nothing.
                let bar = ProgressBar::new(fraction.unwrap_or(0.0)).desired_width(190.0).text(&job.label);
                ui.add(bar).on_hover_text(&job.label);
                if ui.small_button("stop").on_hover_text("stop this").clicked() {
                    cancelled = Some(i);
                }
            }
            if let Some(i) = cancelled {
                app.jobs[i].control.cancel();
            }
            let stage = match app.stage() {
                Stage::Idle => None,
                Stage::Building => Some("building"),
                Stage::Drawing => Some("drawing"),
                Stage::Counting => Some("counting samples"),
                Stage::Weighing => Some("trying other methods"),
            };
            if let Some(frame) = &app.screen.frame {
                ui.label(frame.level.words()).on_hover_text("what the picture on the screen is drawn with; saved pictures are always of full quality");
            }
            if let Some(stage) = stage {
                ui.weak(format!("{stage}…"));
            }
            verdict(app, ui);
        });
    });
}

fn verdict(app: &mut App, ui: &mut Ui) {
    let Some(verdict) = &app.screen.verdict else {
        return;
    };
    let better = verdict.better();
    ui.separator();
    ui.label(RichText::new(verdict.words()).strong())
        .on_hover_text(verdict.details());
    if let Some(choice) = better
        && ui
            .small_button("use it")
            .on_hover_text(format!("draw by {} from now on", choice.words()))
            .clicked()
    {
        app.take(choice);
    }
}

impl App {
    /// Draws by this choice from now on.
    pub fn take(&mut self, choice: Choice) {
        if let Some(document) = self.document_mut() {
            document.way.method = MethodChoice::Only(choice.skip);
            document.way.block = choice.block;
            document.way.cuts = choice.cuts;
        }
    }
}

/// What the picture took.
pub(super) fn numbers(app: &App, ui: &mut Ui) {
    let Some(frame) = &app.screen.frame else {
        return;
    };
    let drawn = &frame.drawn[0];
    section(
        ui,
        "Numbers",
        "what the picture on the screen took",
        true,
        |ui| {
            graph(app, ui);
            Grid::new("numbers")
                .num_columns(2)
                .spacing([14.0, 2.0])
                .show(ui, |ui| {
                    let mut line = |name: &str, value: String, tip: &str| {
                        ui.label(name).on_hover_text(tip);
                        ui.label(RichText::new(value).monospace())
                            .on_hover_text(tip);
                        ui.end_row();
                    };
                    let times = drawn.times;
                    let choice = Choice::of(&drawn.settings);
                    let method = choice.skip.method();
                    match drawn.settings.slices {
                        Some(count) => line(
                            "drawn as",
                            format!("slices, {count}"),
                            "polygons across the view",
                        ),
                        None => line("skipped by", method.name.to_owned(), method.summary),
                    }
                    if choice.skip.reads_blocks() {
                        let cut = choice
                            .cut_words()
                            .map_or(String::new(), |c| format!(", cut {c}"));
                        line(
                            "blocks",
                            format!("{} voxels{cut}", choice.block),
                            "edge of the leaf blocks, and where it cuts",
                        );
                    }
                    line(
                        "on",
                        format!("{}, {}", drawn.backend.backend, drawn.sampler.name()),
                        &drawn.backend.adapter,
                    );
                    line(
                        "frame",
                        format!("{:.1} ms", times.frame_ms),
                        "after the structures stand, without fetching the picture",
                    );
                    line(
                        "raster, cast",
                        format!("{:.1} + {:.1} ms", times.raster_ms, times.cast_ms),
                        "rasterising bounds, casting rays",
                    );
                    let preparation = drawn.preparation;
                    line(
                        "build, cull",
                        format!(
                            "{:.1} + {:.1} ms",
                            preparation.preprocess_ms, preparation.cull_ms
                        ),
                        "building trees; classifying and making faces",
                    );
                    line(
                        "structures",
                        bytes(preparation.structure_bytes),
                        "memory of all that stands besides the volume",
                    );
                    if let Some(details) = &app.screen.details {
                        let pixels: f64 = details.settings.size.map(f64::from).iter().product();
                        let counters = details.counters;
                        let share =
                            100.0 * counters.contributing as f64 / (counters.samples.max(1)) as f64;
                        line(
                            "samples a pixel",
                            format!("{:.2}", counters.samples as f64 / pixels),
                            "of the last picture at rest",
                        );
                        line(
                            "contributing",
                            format!("{share:.1} %"),
                            "of the samples, those that add something",
                        );
                    }
                    if let Some((_, overlay)) = app.document().and_then(|d| d.overlay.as_ref()) {
                        let [active, all] = overlay.counts();
                        line(
                            "active leaves",
                            format!("{active} of {all}"),
                            "leaf blocks that something is visible in",
                        );
                    }
                });
        },
    );
}

fn bytes(bytes: u64) -> String {
    let kib = bytes as f64 / 1024.0;
    if kib < 1024.0 {
        format!("{kib:.0} KiB")
    } else {
        format!("{:.1} MiB", kib / 1024.0)
    }
}

/// Frame times as a line, the last at the right.
fn graph(app: &App, ui: &mut Ui) {
    let times = &app.screen.times;
    let (rect, response) =
        ui.allocate_exact_size(vec2(ui.available_width().min(260.0), 34.0), Sense::hover());
    let most = times.iter().copied().fold(1.0, f32::max);
    response.on_hover_text(format!("frame times, up to {most:.1} ms"));
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 2.0, ui.visuals().extreme_bg_color);
    let width = rect.width() / 90.0;
    for (i, ms) in times.iter().rev().enumerate() {
        let x = rect.right() - (i + 1) as f32 * width;
        let top = rect.bottom() - rect.height() * ms / most;
        let bar = Rect::from_min_max(pos2(x, top), pos2(x + width - 0.5, rect.bottom()));
        painter.rect_filled(bar, 0.0, Color32::from_rgb(90, 150, 220));
    }
    painter.hline(
        rect.x_range(),
        rect.bottom(),
        Stroke::new(1.0, ui.visuals().weak_text_color()),
    );
}
