//! What a user gets wrong, or would hardly have meant: one line that names it, or an empty picture and a warning.

#[path = "support/command.rs"]
mod command;

use std::fs;
use std::process::Command;

use command::{fails, hollowcast, path, read_npy};

/// A small picture that needs no adapter.
const SMALL: [&str; 6] = ["--size", "24x16", "--backend", "reference", "--step", "1"];

#[test]
fn bad_input_is_answered_in_one_line_that_names_it_and_with_2() {
    let folder = tempfile::tempdir().unwrap();
    let picture = path(folder.path(), "p.png");
    let nonsense = path(folder.path(), "nonsense.nrrd");
    fs::write(&nonsense, "this is no volume").unwrap();
    let empty = path(folder.path(), "empty.toml");
    fs::write(&empty, "points = []").unwrap();
    let into = |volume, more: &[&str]| -> (i32, String) {
        let mut args = vec!["render", volume, "-o", &picture, "--backend", "reference"];
        args.extend(more);
        fails(&args)
    };
    let sphere = "phantom:sphere:8";
    let mode = |name, more: &[&str]| into(sphere, &[&["--mode", name], more].concat());
    for ((code, error), named) in [
        (into("no such file.nrrd", &[]), "no such file.nrrd"),
        (into(&nonsense, &[]), "nonsense.nrrd"),
        (into("phantom:cube:8", &[]), "menger"),
        (into(sphere, &["--method", "guess"]), "half-split"),
        (into(sphere, &["--mode", "guess"]), "emission-absorption"),
        (mode("mip", &["--window", "5:5"]), "window"),
        (mode("mip", &["--window", "5"]), "LOW:HIGH"),
        (mode("mip", &["--iso", "5"]), "--iso"),
        (
            mode("phong", &["--light", "0,0,0"]),
            "light: its direction has no length",
        ),
        (
            mode("shaded", &["--light", "0,0,0"]),
            "light: its direction has no length",
        ),
        (
            mode("two-surfaces", &["--light", "0,-0,0"]),
            "light: its direction has no length",
        ),
        (mode("phong", &["--light", "inf,0,0"]), "light"),
        (mode("phong", &["--light", "up"]), "headlight"),
        (mode("phong", &["--shininess", "0"]), "shininess"),
        (mode("phong", &["--iso", "nan"]), "iso"),
        (
            mode("two-surfaces", &["--iso", "90", "--iso2", "50"]),
            "iso2",
        ),
        (
            fails(&["render", sphere, "--backend", "cpu", "--mode", "phong"]),
            "emission-absorption",
        ),
        (into(sphere, &["--clip-box", "5:4,:,:"]), "FROM below TO"),
        (into(sphere, &["--clip-plane", "1,0,0"]), "four numbers"),
        (into(sphere, &["--clip-plane", "0,0,0,5"]), "clip plane"),
        (into(sphere, &["--sampler", "guess"]), "exact"),
        (
            fails(&["render", sphere, "--backend", "guess"]),
            "reference",
        ),
        (into(sphere, &["--tf", "guess"]), "translucent"),
        (into(sphere, &["--tf", &empty]), "points"),
        (into(sphere, &["--slices", "5"]), "--renderer slices"),
        (into(sphere, &["--renderer", "slices"]), "gpu"),
        (into(sphere, &["--block", "5"]), "16"),
        (into(sphere, &["--table-size", "5"]), "4096"),
        (into(sphere, &["--step", "0"]), "--step"),
        (into(sphere, &["--camera", "tilt=3"]), "tilt"),
        (into(sphere, &["--crop", "0:9,:,:"]), "crop"),
        (into(sphere, &["--dims", "8x8x8"]), "--type"),
        (fails(&["render", sphere, "-o", "p.jpg"]), ".exr"),
        (fails(&["phantom", "sphere", "8", "-o", "p.png"]), ".nrrd"),
        (
            fails(&["compare", sphere, "--methods", "box,guess"]),
            "hull",
        ),
        (fails(&["guess"]), "guess"),
    ] {
        assert_eq!(code, 2, "{error}");
        assert!(error.contains(named), "{named:?} is not in: {error}");
        assert!(error.starts_with("error: "), "{error}");
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
}

#[test]
fn clipping_follows_voxels_and_tells_where_nothing_is_left() {
    let folder = tempfile::tempdir().unwrap();
    let picture = path(folder.path(), "p.npy");
    let draw = |more: &[&str]| {
        let mut args = vec![
            "render",
            "phantom:full:12",
            "-o",
            &picture,
            "--tf",
            "opaque",
        ];
        args.extend(["--camera", "eye=6,6,-50;target=6,6,6;up=0,1,0;ortho=16"]);
        args.extend(SMALL);
        args.extend(more);
        let output = hollowcast(&args);
        assert!(output.status.success());
        let (_, numbers) = read_npy(&picture);
        let seen = numbers.chunks_exact(4).filter(|p| p[3] > 0.0).count();
        (seen, String::from_utf8_lossy(&output.stderr).into_owned())
    };
    // 12 voxels are 12 of 16 pixels high.
    assert_eq!(draw(&[]), (144, String::new()));
    assert_eq!(draw(&["--clip-box", "3:,:6,:"]), (9 * 6, String::new()));
    let plane = ["--clip-plane", "0,-1,0,-4"];
    assert_eq!(draw(&plane), (12 * 4, String::new()));
    let (seen, errors) = draw(&["--clip-box", ":,:,:5", "--clip-plane", "0,0,1,6"]);
    assert_eq!(seen, 0);
    assert!(errors.starts_with("warning: ") && errors.lines().count() == 1);
}

/// Draws a small sphere by the reference; the pixels, and what stderr says.
fn sphere(flags: &[&str]) -> (Vec<f32>, String) {
    let folder = tempfile::tempdir().unwrap();
    let picture = path(folder.path(), "p.npy");
    let args = [
        &["render", "phantom:sphere:12", "-o", &picture],
        flags,
        &SMALL,
    ]
    .concat();
    let output = hollowcast(&args);
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{flags:?}: {errors}");
    (read_npy(&picture).1, errors)
}

fn is_one_warning(errors: &str, begin: &str) -> bool {
    errors.starts_with(&format!("warning: {begin}")) && errors.lines().count() == 1
}

#[test]
fn what_shows_nothing_is_an_empty_picture_and_a_warning() {
    let window = |mode| ["--mode", mode, "--window", "300:400"];
    let iso = |mode| ["--mode", mode, "--iso", "300"];
    let table = |mode| ["--mode", mode, "--tf", "ramp:300:400:0.5"];
    let invisible = "points = [{ value = 0, opacity = 0, color = [1, 1, 1] }]";
    for (flags, warning) in [
        (iso("normals"), "iso 300 lies above all data"),
        (iso("phong"), "iso 300 lies above all data"),
        (iso("two-surfaces"), "iso 300 lies above all data"),
        (window("grey"), "window 300:400 lies above all data"),
        (window("mip"), "window 300:400 lies above all data"),
        (window("mean"), "window 300:400 lies above all data"),
        (
            ["--mode", "minip", "--window", "-9:0"],
            "window -9:0 lies below all data",
        ),
        (table("emission-absorption"), "the transfer function"),
        (table("shaded"), "the transfer function"),
        (
            ["--mode", "emission-absorption", "--tf", invisible],
            "the transfer function",
        ),
    ] {
        let (numbers, errors) = sphere(&flags);
        assert!(is_one_warning(&errors, warning), "{flags:?}: {errors}");
        assert!(numbers.iter().all(|&n| n == 0.0), "{flags:?}");
    }
}

/// A surface below all data is the box's own.
#[test]
fn a_surface_that_holds_all_data_is_the_box_and_a_warning() {
    for mode in ["normals", "phong", "two-surfaces"] {
        let (numbers, errors) = sphere(&["--mode", mode, "--iso", "-5"]);
        assert!(
            is_one_warning(&errors, "iso -5 lies below all data"),
            "{errors}"
        );
        let seen = numbers.chunks_exact(4).filter(|p| p[3] > 0.0).count();
        assert!(seen > 100, "{mode}: {seen}");
    }
}

#[test]
fn planes_that_cut_all_away_are_an_empty_picture_and_a_warning_in_every_mode() {
    for row in hollowcast::mode::MODES {
        let cut = ["--mode", row.name, "--clip-plane", "0,0,1,99"];
        let (numbers, errors) = sphere(&cut);
        assert!(is_one_warning(&errors, "the clip planes"), "{errors}");
        assert!(numbers.iter().all(|&n| n == 0.0), "{}", row.name);
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_missing_adapter_is_a_failure_and_not_the_users_fault() {
    let folder = tempfile::tempdir().unwrap();
    let picture = path(folder.path(), "p.png");
    fs::write(&picture, "older").unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_hollowcast"))
        .args([
            "render",
            "phantom:sphere:8",
            "--backend",
            "gpu",
            "-o",
            &picture,
        ])
        .env("VK_DRIVER_FILES", "/none")
        .env("VK_ICD_FILENAMES", "/none")
        .output()
        .unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{errors}");
    assert_eq!(errors.lines().count(), 1, "{errors}");
    assert_eq!(fs::read_to_string(&picture).unwrap(), "older");
}

#[test]
fn a_picture_never_replaces_the_volume_that_it_shows() {
    let folder = tempfile::tempdir().unwrap();
    let volume = path(folder.path(), "scan.png");
    fs::copy(
        concat!(env!("CARGO_MANIFEST_DIR"), "/data/stent.nrrd"),
        &volume,
    )
    .unwrap();
    let before = fs::read(&volume).unwrap();
    let (code, error) = fails(&["render", &volume, "-o", &volume]);
    assert_eq!(code, 2);
    assert!(error.contains("the volume itself"), "{error}");
    assert_eq!(fs::read(&volume).unwrap(), before);
}
