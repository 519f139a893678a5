//! The window, driven as a user does: with a real worker, real volumes, and a picture at the end that the command line must
//! draw again.

mod controls;
mod files;
mod harness;
mod offscreen;

use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use eframe::egui::{Key, Modifiers, Pos2, Rect, vec2};
use egui_kittest::kittest::Queryable;
use hollowcast::mode::{Light, Lighting, MODES, Mode, Window};
use hollowcast::render::{MethodChoice, SliceCount};
use hollowcast::sample::{Classification, Gradients};
use hollowcast::skip::Skip;
use hollowcast::viewer::Compare;
use hollowcast::volume::{RawLayout, Scalar, Source};

use harness::{TestWindow, app, count, drag, empty, settle, shoot, stent, window};
use offscreen::Offscreen;

/// Where the transfer function's points can be dragged.
fn editor(window: &TestWindow) -> Rect {
    window
        .get_by_label("opacity over values")
        .rect()
        .shrink2(vec2(8.0, 6.0))
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
fn the_copied_command_line_says_how_the_volume_is_read_and_what_only_a_gpu_draws() {
    let folder = tempfile::tempdir().unwrap();
    let raw = folder.path().join("voxels");
    let voxels: Vec<u8> = (0..20 * 18 * 16).map(|i| (i * 7 % 251) as u8).collect();
    std::fs::write(&raw, voxels).unwrap();
    let mut window = empty([800.0, 520.0], 1.0, Offscreen::new(), None);
    window.step();
    app(&mut window).open(Source {
        crop: Some("2:,:,1:15".parse().unwrap()),
        pad_cube: true,
        raw: Some(RawLayout::new([20, 18, 16], Scalar::U8)),
        ..Source::new(&raw.display().to_string())
    });
    settle(&mut window);
    let document = app(&mut window).document_mut().unwrap();
    document.way.classification = Classification::PreIntegrated;
    document.look.depth_cue = 0.75;
    settle(&mut window);
    assert_drawn_again(&mut window, folder.path(), "pairs.npy");

    let document = app(&mut window).document_mut().unwrap();
    document.look.depth_cue = 0.0;
    let shaded = MODES.iter().find(|row| row.name == "shaded").unwrap();
    document.look.mode = (shaded.suited_to)(&document.statistics);
    document.way.gradients = Gradients::Half;
    settle(&mut window);
    assert_drawn_again(&mut window, folder.path(), "shaded.npy");

    let document = app(&mut window).document_mut().unwrap();
    let mip = MODES.iter().find(|row| row.name == "mip").unwrap();
    document.look.mode = (mip.suited_to)(&document.statistics);
    document.way.slices = Some(SliceCount::Exactly(31));
    document.way.method = MethodChoice::Only(Skip::BeamMasks);
    settle(&mut window);
    assert_drawn_again(&mut window, folder.path(), "slices.npy");
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
    app(&mut window).open(Source::new("missing.nrrd"));
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
