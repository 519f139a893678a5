//! A window without a screen, driven step by step.

use std::path::Path;
use std::time::{Duration, Instant};

use eframe::egui::Pos2;
use egui_kittest::Harness;
use hollowcast::viewer::session::Recent;
use hollowcast::viewer::{App, WindowGpu};
use hollowcast::volume::Source;
use image::RgbaImage;

use crate::offscreen::Offscreen;

pub(crate) type TestWindow = Harness<'static, Option<App>>;

pub(crate) fn stent() -> String {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("data/stent.nrrd")
        .display()
        .to_string()
}

/// A window of this size with volumes open.
pub(crate) fn window(size: [f32; 2], scale: f32, volumes: &[&str]) -> TestWindow {
    let mut window = empty(size, scale, Offscreen::new(), None);
    for volume in volumes {
        app(&mut window).open(Source::new(volume));
    }
    settle(&mut window);
    window
}

/// A window of this size with nothing open, and pictures drawn on `gpu` where it is given.
pub(crate) fn empty(
    size: [f32; 2],
    scale: f32,
    offscreen: Offscreen,
    gpu: Option<WindowGpu>,
) -> TestWindow {
    Harness::builder()
        .with_size(size)
        .with_pixels_per_point(scale)
        .renderer(offscreen)
        .with_render_cursor(false)
        .build_ui_state(
            move |ui, app: &mut Option<App>| {
                let open = || App::new(ui.ctx(), Recent::default(), gpu.clone()).unwrap();
                app.get_or_insert_with(open).show(ui);
            },
            None,
        )
}

pub(crate) fn app(window: &mut TestWindow) -> &mut App {
    window.state_mut().as_mut().unwrap()
}

/// Lets time pass until all is drawn.
pub(crate) fn settle(window: &mut TestWindow) {
    let start = Instant::now();
    window.step();
    loop {
        window.step();
        if app(window).is_at_rest() {
            break;
        }
        let messages = app(window).messages();
        assert!(!messages.iter().any(|m| m.is_error), "{messages:?}");
        assert!(
            start.elapsed() < Duration::from_mins(2),
            "the window comes to rest"
        );
        std::thread::sleep(Duration::from_millis(15));
    }
    window.step();
}

pub(crate) fn drag(window: &mut TestWindow, from: Pos2, to: Pos2) {
    window.hover_at(from);
    window.drag_at(from);
    window.step();
    for i in 1..=4u8 {
        window.hover_at(from + (to - from) * (f32::from(i) / 4.0));
        window.step();
    }
    window.drop_at(to);
    window.step();
}

/// Keeps a picture of the window where `HOLLOWCAST_SCREENSHOTS` names a folder: those of the readme are made so.
pub(crate) fn shoot(window: &mut TestWindow, name: &str) -> RgbaImage {
    let image = window.render().unwrap();
    // The harness leaves a margin around what it shows.
    let margin = (8.0 * window.ctx.pixels_per_point()) as u32;
    let inside = |n: u32| n - 2 * margin;
    let (width, height) = (inside(image.width()), inside(image.height()));
    let image = image::imageops::crop_imm(&image, margin, margin, width, height).to_image();
    if let Ok(folder) = std::env::var("HOLLOWCAST_SCREENSHOTS") {
        image.save(Path::new(&folder).join(name)).unwrap();
    }
    image
}

/// How many of a grid of places on the canvas look so.
pub(crate) fn count(image: &RgbaImage, scale: f32, looks: impl Fn([u8; 4]) -> bool) -> usize {
    let places = (0..48)
        .flat_map(|i| (0..24).map(move |j| (480.0 + 14.0 * i as f32, 80.0 + 17.0 * j as f32)));
    let at = |(x, y): (f32, f32)| image.get_pixel((x * scale) as u32, (y * scale) as u32).0;
    places.map(at).filter(|&pixel| looks(pixel)).count()
}
