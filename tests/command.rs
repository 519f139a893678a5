//! The command as a user meets it: exit codes, messages, reports and files.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

/// Runs the command; no picture here needs a graphics adapter.
fn hollowcast(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hollowcast"))
        .args(args)
        .env_remove("RUST_LOG")
        .output()
        .expect("the command can be started")
}

fn succeeds(args: &[&str]) -> String {
    let output = hollowcast(args);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{args:?}: {errors}");
    String::from_utf8(output.stdout).expect("reports are UTF-8")
}

fn json(args: &[&str]) -> Value {
    serde_json::from_str(&succeeds(args)).expect("a JSON document")
}

/// The exit code and the one line that a failing run leaves on stderr.
fn fails(args: &[&str]) -> (i32, String) {
    let output = hollowcast(args);
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(errors.lines().count(), 1, "{args:?}: {errors}");
    assert!(output.stdout.is_empty(), "{args:?}");
    (output.status.code().expect("it was not killed"), errors)
}

fn path(folder: &Path, name: &str) -> String {
    folder.join(name).to_str().expect("UTF-8").to_owned()
}

const SMALL: [&str; 6] = ["--size", "24x16", "--backend", "reference", "--step", "1"];

fn render(volume: &str, output: &str, more: &[&str]) -> Value {
    let mut args = vec!["render", volume, "-o", output, "--json"];
    args.extend(SMALL);
    args.extend(more);
    json(&args)
}

/// Shape and numbers of an array file of f32.
fn read_npy(path: &str) -> (String, Vec<f32>) {
    let bytes = fs::read(path).unwrap();
    let start = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let header = String::from_utf8(bytes[10..start].to_vec()).unwrap();
    let numbers = bytes[start..]
        .chunks_exact(4)
        .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
        .collect();
    (header, numbers)
}

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
        (mode("phong", &["--light", "0,0,0"]), "light"),
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

#[test]
fn what_shows_nothing_is_an_empty_picture_and_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let picture = path(folder.path(), "p.npy");
    for (flags, warning) in [
        (["--mode", "phong", "--iso", "300"], "iso 300"),
        (["--mode", "mip", "--window", "300:400"], "window 300:400"),
        (["--mode", "minip", "--window", "-9:0"], "window -9:0"),
        (
            ["--mode", "shaded", "--tf", "ramp:300:400:0.5"],
            "the transfer function",
        ),
    ] {
        let mut args = vec!["render", "phantom:sphere:12", "-o", &picture];
        args.extend(flags);
        args.extend(SMALL);
        let output = hollowcast(&args);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{errors}");
        assert!(
            errors.starts_with(&format!("warning: {warning}")) && errors.lines().count() == 1,
            "{errors}"
        );
        let (_, numbers) = read_npy(&picture);
        assert!(numbers.iter().all(|&n| n == 0.0));
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
fn every_help_has_examples() {
    for args in [
        &["--help"][..],
        &["render", "--help"],
        &["compare", "--help"],
        &["info", "--help"],
        &["phantom", "--help"],
        &["tune", "--help"],
        &["demo", "--help"],
    ] {
        let help = succeeds(args);
        let examples = help.split_once("Examples:").expect("examples").1;
        assert!(examples.contains("  hollowcast "), "{args:?}");
    }
}

#[test]
fn every_method_writes_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let mut files = Vec::new();
    for method in ["box", "hull", "half-split"] {
        for extension in ["npy", "exr", "png"] {
            let file = path(folder.path(), &format!("{method}.{extension}"));
            let report = render("phantom:pot:24", &file, &["--method", method]);
            assert_eq!(report["method"], method);
            files.push(fs::read(&file).unwrap());
        }
    }
    for others in files[3..].chunks(3) {
        assert!(others == &files[..3]);
    }
    let (header, numbers) = read_npy(&path(folder.path(), "box.npy"));
    assert!(header.contains("(16, 24, 4)"), "{header}");
    assert!(numbers.iter().any(|&n| n > 0.0));
}

#[test]
fn a_png_holds_what_the_array_holds() {
    let folder = tempfile::tempdir().unwrap();
    let (array, png) = (path(folder.path(), "p.npy"), path(folder.path(), "p.png"));
    render("phantom:pot:24", &array, &[]);
    render(
        "phantom:pot:24",
        &png,
        &["--png-depth", "16", "--png-curve", "linear"],
    );
    let mut reader = png::Decoder::new(std::io::BufReader::new(fs::File::open(&png).unwrap()))
        .read_info()
        .unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut bytes).unwrap();
    let stored: Vec<f64> = bytes
        .chunks_exact(2)
        .map(|b| f64::from(u16::from_be_bytes([b[0], b[1]])) / 65535.0)
        .collect();
    let (_, linear) = read_npy(&array);
    assert_eq!(stored.len(), linear.len());
    for (stored, linear) in stored.chunks_exact(4).zip(linear.chunks_exact(4)) {
        let alpha = f64::from(linear[3]);
        assert!((stored[3] - alpha).abs() <= 0.5 / 65535.0 + 1e-9);
        for c in 0..3 {
            // Half a step of the file, of a colour that was multiplied by opacity.
            let error = (stored[c] * alpha - f64::from(linear[c])).abs();
            assert!(error <= alpha * (0.5 / 65535.0 + 1e-9));
        }
    }
}

#[test]
fn a_background_is_composited_in_linear_light() {
    let folder = tempfile::tempdir().unwrap();
    let (plain, white) = (path(folder.path(), "p.npy"), path(folder.path(), "w.npy"));
    render("phantom:pot:24", &plain, &[]);
    render("phantom:pot:24", &white, &["--background", "white"]);
    let (plain, white) = (read_npy(&plain).1, read_npy(&white).1);
    for (plain, white) in plain.chunks_exact(4).zip(white.chunks_exact(4)) {
        assert_eq!(white[3], 1.0);
        assert!((0..3).all(|c| white[c] == plain[c] + (1.0 - plain[3])));
    }
}

#[test]
fn repeated_runs_are_reported_by_their_quartiles() {
    let folder = tempfile::tempdir().unwrap();
    let file = path(folder.path(), "p.npy");
    let once = render("phantom:sphere:8", &file, &[]);
    assert!(once.get("repeat").is_none());
    assert_eq!(
        (&once["sampler"], &once["adapter"]["backend"]),
        (&"exact".into(), &"reference".into())
    );
    let repeat = &render("phantom:sphere:8", &file, &["--repeat", "4"])["repeat"];
    assert_eq!(repeat["count"], 4);
    for time in ["frame_ms", "read_back_ms", "frame_with_read_back_ms"] {
        let of = |name: &str| repeat[time][name].as_f64().expect(time);
        assert!(
            of("q1") <= of("median") && of("median") <= of("q3"),
            "{time}"
        );
    }
}

#[test]
fn volumes_are_cut_thinned_and_padded_in_that_order() {
    let folder = tempfile::tempdir().unwrap();
    let file = path(folder.path(), "p.npy");
    let dims =
        |more: &[&str]| render("phantom:noise:12x10x8", &file, more)["volume"]["dims"].clone();
    let crop = ["--crop", "2:,1:9,:"];
    assert_eq!(dims(&crop), serde_json::json!([10, 8, 8]));
    let all = [&crop[..], &["--downsample", "2", "--pad-cube"]].concat();
    assert_eq!(dims(&all), serde_json::json!([5, 5, 5]));
}

#[test]
fn a_file_is_drawn_like_the_phantom_it_was_written_from() {
    let folder = tempfile::tempdir().unwrap();
    let volume = path(folder.path(), "pot.nrrd");
    succeeds(&["phantom", "pot", "20", "-o", &volume]);
    let raw = path(folder.path(), "pot.bin");
    let bytes = fs::read(&volume).unwrap();
    fs::write(&raw, &bytes[bytes.len() - 20 * 20 * 20..]).unwrap();
    let layout = [
        "--dims",
        "20x20x20",
        "--type",
        "uint8",
        "--spacing",
        "1,1,1",
    ];
    let draw = |volume: &str, more: &[&str]| {
        let file = path(folder.path(), "p.npy");
        render(volume, &file, more);
        fs::read(file).unwrap()
    };
    let phantom = draw("phantom:pot:20", &[]);
    assert!(draw(&volume, &[]) == phantom);
    assert!(draw(&raw, &layout) == phantom);
}

#[test]
fn a_comparison_has_a_row_for_everything_that_was_asked_for() {
    let report = json(&[
        "compare",
        "phantom:pot:24",
        "--methods",
        "half-split,hull",
        "--steps",
        "1,0.05u",
        "--blocks",
        "4,8",
        "--backends",
        "reference",
        "--size",
        "20x16",
        "--views",
        "2",
        "--repeat",
        "2",
        "--reference-size",
        "12",
        "--json",
    ]);
    assert_eq!(report["adapter"]["backend"], "reference");
    assert_eq!(report["volume"]["dims"], serde_json::json!([24, 24, 24]));
    let rows = report["rows"].as_array().unwrap();
    // Box is added: nothing can be compared with it otherwise.
    assert_eq!(rows.len(), 3 * 2 * 2);
    let mut keys = [
        "backend",
        "method",
        "step",
        "block",
        "size",
        "view_count",
        "preprocess_ms",
        "cull_ms",
        "raster_ms",
        "cast_ms",
        "frame_ms",
        "frame_q1_ms",
        "frame_q3_ms",
        "gpu_ms",
        "read_back_ms",
        "speedup_vs_box",
        "samples_per_pixel",
        "contributing_samples_per_pixel",
        "skip_steps_per_pixel",
        "structure_bytes",
        "differing_pixels_vs_box",
        "max_abs_diff_vs_box",
        "max_abs_diff_vs_reference",
        "mean_abs_diff_vs_reference",
        "off_share_vs_reference",
        "psnr_vs_reference_db",
    ];
    keys.sort_unstable();
    for row in rows {
        let mut found: Vec<&str> = row
            .as_object()
            .unwrap()
            .keys()
            .map(String::as_str)
            .collect();
        found.sort_unstable();
        assert_eq!(found, keys);
        assert_eq!(row["differing_pixels_vs_box"], 0, "{row}");
        assert_eq!(row["max_abs_diff_vs_box"], 0.0, "{row}");
        assert_eq!(row["view_count"], 2);
        assert!(row["frame_ms"].as_f64().unwrap() > 0.0);
        // The reference against itself: nothing differs, which JSON has no number for.
        assert!(row["psnr_vs_reference_db"].is_null());
        let base = rows
            .iter()
            .find(|r| {
                r["method"] == "box" && r["step"] == row["step"] && r["block"] == row["block"]
            })
            .unwrap();
        let samples = |r: &Value| r["samples_per_pixel"].as_f64().unwrap();
        let contributing = &row["contributing_samples_per_pixel"];
        assert_eq!(contributing, &base["contributing_samples_per_pixel"]);
        assert!(contributing.as_f64().unwrap() <= samples(row) && samples(row) <= samples(base));
        // Larger blocks all touch so small a pot.
        if row["method"] != "box" && row["block"] == 4 {
            assert!(samples(row) < samples(base), "{row}");
        }
    }
}

#[test]
fn info_tells_emptiness_and_recommends_accordingly() {
    let info = |volume| {
        json(&[
            "info",
            volume,
            "--tf",
            "ramp:40:255:0.3",
            "--block",
            "4",
            "--json",
        ])
    };
    let sphere = info("phantom:sphere:48");
    let share = |report: &Value, name: &str| report[name].as_f64().unwrap();
    assert!(share(&sphere, "empty_voxels") > share(&sphere, "enclosed_empty_voxels"));
    assert!(share(&sphere, "enclosed_empty_voxels") > 0.1);
    assert_ne!(sphere["recommendation"]["method"], "box");
    let counts = sphere["histogram"]["counts"].as_array().unwrap();
    let voxels: u64 = counts.iter().map(|n| n.as_u64().unwrap()).sum();
    assert_eq!(voxels, 48 * 48 * 48);

    let full = info("phantom:full:16");
    assert_eq!(share(&full, "empty_voxels"), 0.0);
    assert_eq!(share(&full, "empty_blocks"), 0.0);
    assert_eq!(full["recommendation"]["method"], "box");
    assert_eq!(share(&info("phantom:empty:16"), "empty_blocks"), 1.0);
}

#[test]
fn the_demo_writes_its_pictures_and_prints_its_table() {
    let folder = tempfile::tempdir().unwrap();
    let output = path(folder.path(), "new/folder");
    let report = succeeds(&[
        "demo",
        "-o",
        &output,
        "--size",
        "40",
        "--backend",
        "reference",
    ]);
    let methods: Vec<_> = hollowcast::skip::METHODS
        .iter()
        .filter(|m| m.lossless && !m.is_limit && m.backends.contains(&"reference"))
        .map(|m| m.name)
        .collect();
    for method in &methods {
        assert!(
            report
                .lines()
                .any(|line| line.contains(&format!("  {method} "))),
            "{report}"
        );
    }
    assert!(report.contains("not one pixel differs"), "{report}");
    for name in ["methods.png", "samples.png"] {
        let file = fs::File::open(Path::new(&output).join(name)).unwrap();
        let reader = png::Decoder::new(std::io::BufReader::new(file))
            .read_info()
            .unwrap();
        // A panel of 40 pixels per method, 4 between two.
        let width = methods.len() as u32 * 44 - 4;
        assert_eq!(reader.info().width, width, "{name}");
    }
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
