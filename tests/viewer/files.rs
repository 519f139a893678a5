//! What is opened and written: files that are dropped, sessions, orbits; and a device that goes away.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use eframe::egui::{self, DroppedFile, Key, Pos2, vec2};
use egui_kittest::kittest::Queryable;
use hollowcast::render::{BackendChoice, MethodChoice};
use hollowcast::skip::Skip;
use hollowcast::viewer::session;
use hollowcast::volume::{Packing, Source, phantom, write_nrrd};

use crate::harness::{TestWindow, app, count, drag, empty, settle, shoot, window};
use crate::offscreen::Offscreen;

#[derive(Debug)]
struct Dropped(PathBuf);

impl DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        Err("the path is enough".to_owned())
    }
}

#[test]
fn files_that_are_dropped_are_opened_beside_each_other() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = empty([800.0, 600.0], 1.0, Offscreen::new(), None);
    window.step();
    for name in ["pot", "shells"] {
        let path = folder.path().join(format!("{name}.nrrd"));
        let volume = phantom::make(name, [24; 3]).unwrap();
        write_nrrd(&volume, &path, Packing::Gzip).unwrap();
        let file: egui::DroppedFileHandle = Arc::new(Dropped(path));
        window.input_mut().dropped_files.push(file);
        settle(&mut window);
        let document = app(&mut window).document().unwrap();
        assert_eq!(document.short_name(), format!("{name}.nrrd"));
    }
}

#[test]
fn a_session_brings_back_what_was_open_and_how_it_was_looked_at() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("session.toml");
    let mut before = window(
        [800.0, 600.0],
        1.0,
        &["phantom:pot:24", "phantom:shells:24"],
    );
    let document = app(&mut before).document_mut().unwrap();
    document.way.method = MethodChoice::Only(Skip::Hull);
    document.look.background = Some([1, 2, 3]);
    let centre = Pos2::new(560.0, 240.0);
    drag(&mut before, centre, centre + vec2(60.0, 10.0));
    settle(&mut before);
    app(&mut before).save_session(&file).unwrap();
    let expected = app(&mut before).document().unwrap().kept();

    let mut after = empty([800.0, 600.0], 1.0, Offscreen::new(), None);
    after.step();
    app(&mut after).restore(session::read(&file).unwrap());
    settle(&mut after);
    // They come in the order in which they are read.
    let name = expected
        .source
        .volume
        .rsplit('/')
        .next()
        .unwrap()
        .to_owned();
    after.get_by_label(&name).click();
    settle(&mut after);
    after.get_by_label("phantom:pot:24");
    assert_eq!(app(&mut after).document().unwrap().kept(), expected);
}

/// Waits until no job runs.
fn finish(window: &mut TestWindow) {
    let start = Instant::now();
    while !app(window).is_at_rest() && start.elapsed() < Duration::from_mins(1) {
        window.step();
        std::thread::sleep(Duration::from_millis(15));
    }
}

#[test]
fn an_orbit_is_numbered_pictures_and_can_be_stopped() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window([800.0, 600.0], 1.0, &["phantom:pot:24"]);
    let (orbit, still) = (folder.path().join("orbit"), folder.path().join("still.png"));
    app(&mut window)
        .save_orbit(orbit.clone(), [40, 30], false, 3)
        .unwrap();
    finish(&mut window);
    app(&mut window)
        .save_picture(still.clone(), [40, 30], false)
        .unwrap();
    finish(&mut window);
    let read = |path: PathBuf| std::fs::read(path).unwrap();
    let pictures = ["0000.png", "0001.png", "0002.png"].map(|name| read(orbit.join(name)));
    // It begins with what is on the screen.
    assert!(pictures[0] == read(still) && pictures[0] != pictures[1]);
    assert!(!orbit.join("0003.png").exists());
    let said = &app(&mut window).messages()[0].text;
    assert!(
        said.contains("ffmpeg -framerate 30 -i") && said.contains("%04d.png"),
        "{said}"
    );

    let stopped = folder.path().join("stopped");
    app(&mut window)
        .save_orbit(stopped.clone(), [64, 48], false, 3600)
        .unwrap();
    while !stopped.join("0002.png").exists() {
        window.step();
    }
    window.key_press(Key::Escape);
    finish(&mut window);
    let written = std::fs::read_dir(stopped).unwrap().count();
    assert!(written < 3600, "{written}");
    assert!(!app(&mut window).messages().iter().any(|m| m.is_error));
}

#[test]
fn pictures_are_drawn_on_the_windows_device_and_on_another_when_it_is_lost() {
    let offscreen = Offscreen::new();
    let gpu = offscreen.window();
    let device = gpu.gpu.device.clone();
    let mut window = empty([1280.0, 720.0], 1.0, offscreen, Some(gpu));
    window.step();
    app(&mut window).open(Source::new("phantom:pot:32"));
    settle(&mut window);
    assert_eq!(app(&mut window).drawn_by(), Some(("gpu", true)));
    // What was drawn straight into the window's texture is what is sent to it else.
    let warm = |p: [u8; 4]| p[0] > p[2].saturating_add(20);
    let direct = shoot(&mut window, "direct.png");
    assert!(count(&direct, 1.0, warm) > 30);
    let document = app(&mut window).document_mut().unwrap();
    document.way.method = MethodChoice::Only(Skip::Box);
    document.way.backend = BackendChoice::Cpu;
    settle(&mut window);
    let sent = shoot(&mut window, "sent.png");
    let far =
        |(a, b): &(&image::Rgba<u8>, &image::Rgba<u8>)| (0..3).any(|c| a.0[c].abs_diff(b.0[c]) > 3);
    let canvas =
        |image: &image::RgbaImage| image::imageops::crop_imm(image, 420, 60, 600, 400).to_image();
    let (direct, sent) = (canvas(&direct), canvas(&sent));
    let apart = direct.pixels().zip(sent.pixels()).filter(far).count();
    assert!(apart < 50, "{apart} pixels");

    device.destroy();
    app(&mut window).document_mut().unwrap().way.backend = BackendChoice::Gpu;
    let document = app(&mut window).document_mut().unwrap();
    document.view.zoom(0.9, document.volume.voxel_size());
    settle(&mut window);
    assert_eq!(app(&mut window).drawn_by(), Some(("gpu", false)));
}
