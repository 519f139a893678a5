//! The mode and its parameters.

use eframe::egui::{Grid, Slider, Ui};

use crate::mode::{DepthCue, Light, Lighting, MODES, Mode, Window};
use crate::volume::Statistics;

use super::document::Document;
use super::look::Look;
use super::rows::{choice, color, number, row, section};

/// The section of the left panel.
pub(super) fn show(document: &mut Document, ui: &mut Ui) {
    section(ui, "Mode", "what is done with the samples", true, |ui| {
        Grid::new("mode").num_columns(2).show(ui, |ui| {
            let before = document.look.mode.name();
            let mut name = before;
            let all = MODES
                .iter()
                .map(|row| (row.name, row.name.to_owned(), row.summary.to_owned()));
            choice(
                ui,
                ("mode", "mode", "WHAT is done with the samples"),
                &mut name,
                before,
                all,
            );
            if name != before
                && let Some(row) = MODES.iter().find(|row| row.name == name)
            {
                document.look.mode = (row.suited_to)(&document.statistics);
            }
            parameters(ui, &mut document.look.mode, &document.statistics);
            depth_cue(ui, &mut document.look);
        });
    });
}

/// Fading with depth, in modes whose colours may.
fn depth_cue(ui: &mut Ui, look: &mut Look) {
    if DepthCue::check(1.0, &look.mode, "gpu").is_err() {
        look.depth_cue = 0.0;
        return;
    }
    let tip = "share of light that colours lose at the farthest point of the box; 0: none";
    row(ui, "depth cue", tip, |ui| {
        ui.add(Slider::new(&mut look.depth_cue, 0.0..=1.0).max_decimals(2))
    });
}

fn parameters(ui: &mut Ui, mode: &mut Mode, statistics: &Statistics) {
    match mode {
        Mode::EmissionAbsorption => {}
        Mode::Shaded(lighting) => light(ui, lighting),
        Mode::Grey(w) | Mode::Mip(w) | Mode::Minip(w) | Mode::Mean(w) => window(ui, w, statistics),
        Mode::Normals { iso } => surface(ui, "surface at", iso, statistics),
        Mode::Phong {
            iso,
            color: surface_color,
            lighting,
        } => {
            surface(ui, "surface at", iso, statistics);
            color(ui, ("colour", "colour of the surface"), surface_color);
            light(ui, lighting);
        }
        Mode::TwoSurfaces {
            outer,
            iso,
            color: inner_color,
            lighting,
        } => {
            surface(ui, "outer at", &mut outer.iso, statistics);
            color(
                ui,
                ("outer colour", "colour of the outer surface"),
                &mut outer.color,
            );
            row(ui, "outer opacity", "opacity of the outer surface", |ui| {
                ui.add(Slider::new(&mut outer.opacity, 0.01..=1.0))
            });
            // The inner surface lies above the outer one.
            let least = outer.iso + speed(statistics) * 0.1;
            *iso = iso.max(least);
            surface(ui, "inner at", iso, statistics);
            color(
                ui,
                ("inner colour", "colour of the inner surface"),
                inner_color,
            );
            light(ui, lighting);
        }
    }
}

/// What a point of dragging changes of a data value.
fn speed(statistics: &Statistics) -> f64 {
    let [low, high] = statistics.value_range();
    ((high - low) / 500.0).max(1e-6)
}

fn window(ui: &mut Ui, window: &mut Window, statistics: &Statistics) {
    let speed = speed(statistics);
    let [low, high] = statistics.value_range();
    let reach = (high - low).max(1.0);
    number(
        ui,
        ("from", "data value of brightness 0"),
        &mut window.low,
        low - reach..=window.high - speed * 0.1,
        speed,
    );
    number(
        ui,
        ("to", "data value of brightness 1"),
        &mut window.high,
        window.low + speed * 0.1..=high + reach,
        speed,
    );
}

fn surface(ui: &mut Ui, name: &str, iso: &mut f64, statistics: &Statistics) {
    let [low, high] = statistics.value_range();
    let tip = "data value from which on matter is solid";
    number(
        ui,
        (name, tip),
        iso,
        low..=high.max(low + 1.0) * 2.0,
        speed(statistics),
    );
}

fn light(ui: &mut Ui, lighting: &mut Lighting) {
    let from = match lighting.light {
        Light::From(direction) => direction,
        Light::Headlight => [1.0, -1.0, 2.0],
    };
    let all = [
        (Light::Headlight, "headlight", "light comes from the eye"),
        (
            Light::From(from),
            "direction",
            "light comes from far away in a direction of the volume's axes",
        ),
    ];
    let shown = if lighting.light == Light::Headlight {
        "headlight"
    } else {
        "direction"
    };
    let all = all.map(|(light, name, tip)| (light, name.to_owned(), tip.to_owned()));
    choice(
        ui,
        ("light", "light", "where the light comes from"),
        &mut lighting.light,
        shown,
        all,
    );
    if let Light::From(direction) = &mut lighting.light {
        for (part, name) in direction.iter_mut().zip(["light x", "light y", "light z"]) {
            number(
                ui,
                (name, "direction that the light comes from"),
                part,
                -10.0..=10.0,
                0.02,
            );
        }
        if *direction == [0.0; 3] {
            direction[2] = 0.02;
        }
    }
    number(
        ui,
        ("ambient", "ambient reflection"),
        &mut lighting.ambient,
        0.0..=4.0,
        0.01,
    );
    number(
        ui,
        ("diffuse", "diffuse reflection"),
        &mut lighting.diffuse,
        0.0..=4.0,
        0.01,
    );
    number(
        ui,
        ("specular", "specular reflection"),
        &mut lighting.specular,
        0.0..=4.0,
        0.01,
    );
    number(
        ui,
        ("shininess", "exponent of specular reflection"),
        &mut lighting.shininess,
        1.0..=1000.0,
        0.5,
    );
}
