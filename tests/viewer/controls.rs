//! Every control says what it does when the pointer rests on it.

use eframe::egui::accesskit::Role;
use eframe::egui::{Context, Order, Rect};
use egui_kittest::kittest::{NodeT, Queryable};
use hollowcast::mode::MODES;
use hollowcast::render::{MethodChoice, SliceCount};
use hollowcast::skip::Skip;
use hollowcast::viewer::Compare;
use hollowcast::viewer::actions::Action;

use crate::harness::{TestWindow, app, settle, window};

/// What the pointer does something to.
const CONTROLS: &[Role] = &[
    Role::Button,
    Role::CheckBox,
    Role::ColorWell,
    Role::ComboBox,
    Role::RadioButton,
    Role::Slider,
    Role::SpinButton,
    Role::TextInput,
];

fn controls(window: &TestWindow) -> Vec<(String, Rect)> {
    let screen = window.ctx.content_rect();
    let mut all: Vec<(String, Rect)> = window
        .get_all_by(|node| CONTROLS.contains(&node.role()))
        .map(|node| {
            let named = node.accesskit_node();
            let name = named.label().or_else(|| named.value()).unwrap_or_default();
            (format!("{:?} {name}", named.role()), node.rect())
        })
        .collect();
    all.retain(|(_, rect)| screen.contains_rect(*rect) && rect.is_positive());
    all
}

fn shows_tooltip(context: &Context) -> bool {
    let layers = context.memory(|memory| memory.areas().visible_layer_ids());
    layers.iter().any(|layer| layer.order == Order::Tooltip)
}

/// Rests the pointer on every control but those of `known`; tells those that say nothing.
fn silent(window: &mut TestWindow, known: &[(String, Rect)]) -> Vec<String> {
    let mut silent = Vec::new();
    let mut all = controls(window);
    all.retain(|control| !known.contains(control));
    for (name, rect) in all {
        window.hover_at(rect.center());
        window.run_steps(2);
        // The corner of a window closes it, everywhere; and a menu in a menu opens before it could say more than its name.
        let says_itself = name.contains("Close window") || name.contains("Open recent");
        if !says_itself && !shows_tooltip(&window.ctx) {
            window.run_steps(3);
        }
        if !says_itself && !shows_tooltip(&window.ctx) {
            silent.push(format!("{name} at {rect:?}"));
        }
    }
    window.remove_cursor();
    window.run_steps(2);
    silent
}

#[test]
fn every_control_has_a_tooltip() {
    let mut window = window([700.0, 1700.0], 1.0, &["phantom:pot:24"]);
    window.ctx.all_styles_mut(|style| {
        style.interaction.tooltip_delay = 0.0;
        style.interaction.show_tooltips_only_when_still = false;
    });
    for title in ["Clipping", "Background"] {
        window.get_by_label(title).click();
        window.run_steps(20);
    }
    window.get_by_label("add plane").click();
    let none: [String; 0] = [];
    let mut seen = 0;
    for (i, row) in MODES.iter().enumerate() {
        let document = app(&mut window).document_mut().unwrap();
        document.look.mode = (row.suited_to)(&document.statistics);
        let methods = [Skip::HalfSplit, Skip::KCuts, Skip::Box];
        document.way.method = MethodChoice::Only(methods[i % methods.len()]);
        document.way.slices = (row.name == "mip").then_some(SliceCount::Exactly(9));
        app(&mut window).shown.compare = if i == 0 { Compare::Split } else { Compare::Off };
        // The first and those with parameters of their own; the rest repeats them.
        if ["emission-absorption", "mip", "two-surfaces"].contains(&row.name) {
            window.run_steps(3);
            seen += controls(&window).len();
            assert_eq!(silent(&mut window, &[]), none, "{}", row.name);
        }
    }
    assert!(seen > 80, "{seen}");
    let document = app(&mut window).document_mut().unwrap();
    document.look.mode = (MODES[0].suited_to)(&document.statistics);
    settle(&mut window);
    for menu in ["File", "View", "presets"] {
        let known = controls(&window);
        window.get_by_label(menu).click();
        window.run_steps(3);
        assert!(controls(&window).len() > known.len(), "{menu}");
        assert_eq!(silent(&mut window, &known), none, "{menu}");
        window.key_press(eframe::egui::Key::Escape);
        window.run_steps(2);
    }
    for action in [Action::SavePicture, Action::Open, Action::Help] {
        let known = controls(&window);
        app(&mut window).perform(action);
        window.run_steps(3);
        assert_eq!(silent(&mut window, &known), none, "{action:?}");
        app(&mut window).perform(Action::Stop);
        window.run_steps(2);
    }
}
