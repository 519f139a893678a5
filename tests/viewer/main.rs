//! The window, driven as a user does: with a real worker, real volumes, and a picture at the end that the command line must
//! draw again.

mod offscreen;

use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use eframe::egui::{Key, Modifiers, Pos2, Rect, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use hollowcast::mode::{Light, Lighting, Mode, Window};
use hollowcast::render::MethodChoice;
use hollowcast::skip::Skip;
use hollowcast::viewer::session::Recent;
use hollowcast::viewer::{App, Compare};

use image::RgbaImage;
use offscreen::Offscreen;

type TestWindow = Harness<'static, Option<App>>;

fn stent() -> String {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("data/stent.nrrd")
        .display()
        .to_string()
}

/// A window of this size with volumes open.
fn window(size: [f32; 2], scale: f32, volumes: &[&str]) -> TestWindow {
    let mut window = Harness::builder()
        .with_size(size)
        .with_pixels_per_point(scale)
        .renderer(Offscreen::new())
        .with_render_cursor(false)
        .build_ui_state(
            |ui, app: &mut Option<App>| {
                let open = || App::new(ui.ctx(), Recent::default()).unwrap();
                app.get_or_insert_with(open).show(ui);
            },
            None,
        );
    for volume in volumes {
        app(&mut window).open(volume);
    }
    settle(&mut window);
    window
}

fn app(window: &mut TestWindow) -> &mut App {
    window.state_mut().as_mut().unwrap()
}

/// Lets time pass until all is drawn.
fn settle(window: &mut TestWindow) {
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

/// Where the transfer function's points can be dragged.
fn editor(window: &TestWindow) -> Rect {
    window
        .get_by_label("opacity over values")
        .rect()
        .shrink2(vec2(8.0, 6.0))
}

fn drag(window: &mut TestWindow, from: Pos2, to: Pos2) {
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

#[test]
fn what_is_saved_is_what_the_copied_command_line_draws() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window([1000.0, 700.0], 1.0, &[&stent()]);

    // A control point is dragged: the picture follows.
    let before = app(&mut window).document().unwrap().look.transfer.clone();
    let area = editor(&window);
    let (at, i) = {
        let document = app(&mut window).document().unwrap();
        let i = before.points().len() - 1;
        let point = before.points()[i];
        let x = document.axes.x(point.value) as f32;
        let y = document.axes.y(point.opacity) as f32;
        (
            area.left_bottom() + vec2(x * area.width(), -y * area.height()),
            i,
        )
    };
    drag(&mut window, at, at + vec2(-60.0, -30.0));
    settle(&mut window);
    let after = app(&mut window).document().unwrap().look.transfer.clone();
    assert!(after.points()[i].opacity > before.points()[i].opacity + 0.1);
    assert!(after.points()[i].value < before.points()[i].value);

    // Another method is chosen from the list.
    window.get_by_label("skip by").click();
    window.run_steps(3);
    // In the list's popup, that is: the numbers may name it too.
    let listed = window.get_all_by_label("beam-masks");
    listed.last().expect("it is in the list").click();
    settle(&mut window);
    assert_eq!(app(&mut window).drawn().unwrap().skip, Skip::BeamMasks);

    // Two ways are compared: they are the same to the bit.
    app(&mut window).document_mut().unwrap().other.method = MethodChoice::Only(Skip::Box);
    window.get_by_label("difference").click();
    settle(&mut window);
    assert_eq!(app(&mut window).shown.compare, Compare::Difference);
    assert_eq!(app(&mut window).difference().map(|d| d.0), Some(0));

    for name in ["picture.npy", "picture.png"] {
        assert_drawn_again(&mut window, folder.path(), name);
    }

    // So it is with parallel rays, clipping, a background and another mode ...
    window.key_press(Key::P);
    window.step();
    let document = app(&mut window).document_mut().unwrap();
    let high = document.statistics.value_range()[1];
    document.look.mode = Mode::Mip(Window {
        low: 3.7,
        high: high * 0.9,
    });
    document.look.clip_box = [[None; 2], [Some(10.25), None], [None, Some(200.0)]];
    document.look.clip_planes = vec![[1.0, 0.3, -0.2, 11.5]];
    document.look.background = Some([10, 200, 31]);
    settle(&mut window);
    assert_drawn_again(&mut window, folder.path(), "clipped.png");

    // ... and with one that only a graphics adapter has.
    let document = app(&mut window).document_mut().unwrap();
    document.look.mode = Mode::Phong {
        iso: high * 0.4,
        color: [0.0, 1.0, 0.0],
        lighting: Lighting {
            light: Light::From([1.0, -0.5, 2.25]),
            shininess: 11.0,
            ..Lighting::default()
        },
    };
    document.way.step_voxels = 0.75;
    settle(&mut window);
    assert_drawn_again(&mut window, folder.path(), "lit.npy");
}

/// Saves the picture, and lets the copied command line draw it again: the same file, byte by byte.
fn assert_drawn_again(window: &mut TestWindow, folder: &Path, name: &str) {
    let saved = folder.join(name);
    let drawn = folder.join(format!("again-{name}"));
    let size = [120, 90];
    app(window)
        .save_picture(saved.clone(), size, false)
        .unwrap();
    settle(window);
    let output = drawn.display().to_string();
    let line = app(window).command_line(&output, size, false).unwrap();
    let run = Command::new("sh")
        .args([
            "-c",
            &format!("hollowcast() {{ \"$BIN\" \"$@\"; }}\n{line}"),
        ])
        .env("BIN", env!("CARGO_BIN_EXE_hollowcast"))
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&run.stderr);
    assert!(run.status.success(), "{line}\n{said}");
    assert!(
        std::fs::read(saved).unwrap() == std::fs::read(drawn).unwrap(),
        "{line}"
    );
}

#[test]
fn a_window_at_rest_asks_for_no_frame_and_a_moving_one_comes_back_to_full_quality() {
    let mut window = window([800.0, 600.0], 1.0, &["phantom:pot:48"]);
    let repaint = |window: &TestWindow| {
        window
            .output()
            .viewport_output
            .values()
            .map(|v| v.repaint_delay)
            .min()
    };
    for _ in 0..3 {
        window.step();
    }
    assert_eq!(repaint(&window), Some(Duration::MAX));

    let eye = app(&mut window).document().unwrap().view.eye;
    let centre = Pos2::new(560.0, 240.0);
    drag(&mut window, centre, centre + vec2(60.0, 10.0));
    assert_ne!(app(&mut window).document().unwrap().view.eye, eye);
    settle(&mut window);
    let settings = app(&mut window).drawn().unwrap();
    assert_eq!(settings.step_voxels, 0.5);
    assert_eq!(Some(settings.size), app(&mut window).full_size());
}

#[test]
fn keys_and_menus_reach_what_they_name() {
    let mut window = window([1280.0, 720.0], 1.0, &["phantom:shells:32"]);
    window.key_press(Key::P);
    window.step();
    assert!(app(&mut window).document().unwrap().view.is_parallel());
    for key in [Key::L, Key::U, Key::K, Key::H] {
        window.key_press(key);
        window.step();
    }
    settle(&mut window);
    let shown = app(&mut window).shown;
    assert!(shown.leaves && shown.hull && shown.cut && shown.heat);
    window.key_press(Key::F1);
    window.step();
    window.get_by_label("fly: forward, left, back, right, down, up");
    window.key_press(Key::Escape);
    window.step();
    assert!(
        window
            .query_by_label("fly: forward, left, back, right, down, up")
            .is_none()
    );

    // An edit is undone and redone.
    let method = |window: &mut TestWindow| app(window).document().unwrap().way.method;
    window.key_press(Key::M);
    settle(&mut window);
    assert_eq!(method(&mut window), MethodChoice::Only(Skip::Box));
    window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    window.step();
    assert_eq!(method(&mut window), MethodChoice::Auto);
    window.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    window.step();
    assert_eq!(method(&mut window), MethodChoice::Only(Skip::Box));

    // A file that is not there is told of, and the message goes away.
    app(&mut window).open("missing.nrrd");
    let start = Instant::now();
    while app(&mut window).messages().is_empty() && start.elapsed() < Duration::from_secs(20) {
        window.step();
        std::thread::sleep(Duration::from_millis(15));
    }
    window.step();
    assert!(app(&mut window).messages()[0].text.contains("missing.nrrd"));
    window.get_by_label("dismiss").click();
    window.step();
    assert!(app(&mut window).messages().is_empty());
}

/// Keeps a picture of the window where `HOLLOWCAST_SCREENSHOTS` names a folder: those of the readme are made so.
fn shoot(window: &mut TestWindow, name: &str) -> RgbaImage {
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
fn count(image: &RgbaImage, scale: f32, looks: impl Fn([u8; 4]) -> bool) -> usize {
    let places = (0..48)
        .flat_map(|i| (0..24).map(move |j| (480.0 + 14.0 * i as f32, 80.0 + 17.0 * j as f32)));
    let at = |(x, y): (f32, f32)| image.get_pixel((x * scale) as u32, (y * scale) as u32).0;
    places.map(at).filter(|&pixel| looks(pixel)).count()
}

#[test]
fn the_window_shows_pictures_comparisons_and_what_is_skipped() {
    let warm = |p: [u8; 4]| p[0] > p[2].saturating_add(20);
    let mut small = window([1280.0, 720.0], 2.0, &["phantom:pot:32"]);
    let image = shoot(&mut small, "twice.png");
    assert_eq!((image.width(), image.height()), (2528, 1408));
    assert!(count(&image, 2.0, warm) > 30);
    drop(small);

    let mut window = window([1280.0, 720.0], 1.0, &[&stent()]);
    let document = app(&mut window).document_mut().unwrap();
    document.way.method = MethodChoice::Only(Skip::HalfSplit);
    document.view.zoom(0.85, document.volume.voxel_size());
    settle(&mut window);
    let picture = shoot(&mut window, "window.png");
    let seen = count(&picture, 1.0, |p| p[0] > 90);
    assert!(seen > 8, "{seen}");

    let document = app(&mut window).document_mut().unwrap();
    document.way.method = MethodChoice::Only(Skip::Box);
    document.other.method = MethodChoice::Only(Skip::BeamMasks);
    app(&mut window).shown.compare = Compare::Split;
    settle(&mut window);
    let split = shoot(&mut window, "compare.png");
    // Skipping changes nothing: but for captions and divider the picture is what it was.
    let seen_again = count(&split, 1.0, |p| p[0] > 90);
    assert!(seen_again.abs_diff(seen) <= 20, "{seen} {seen_again}");
    assert_eq!(app(&mut window).difference().map(|d| d.0), Some(0));

    app(&mut window).document_mut().unwrap().way.method = MethodChoice::Only(Skip::HalfSplit);
    let shown = &mut app(&mut window).shown;
    (shown.compare, shown.heat, shown.leaves, shown.cut) = (Compare::Off, true, true, true);
    settle(&mut window);
    let heat = shoot(&mut window, "overlay.png");
    assert_ne!(heat, picture);
}
