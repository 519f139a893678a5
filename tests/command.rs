//! The command as a user meets it: exit codes, messages, reports and files.

#[path = "support/command.rs"]
mod command;

use std::fs;
use std::path::Path;

use command::{hollowcast, json, path, read_npy, succeeds};
use serde_json::Value;

const SMALL: [&str; 6] = ["--size", "24x16", "--backend", "reference", "--step", "1"];

fn render(volume: &str, output: &str, more: &[&str]) -> Value {
    let mut args = vec!["render", volume, "-o", output, "--json"];
    args.extend(SMALL);
    args.extend(more);
    json(&args)
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
        "ssim_vs_reference",
        "flip_vs_reference",
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
fn a_table_of_speeds_has_the_modes_that_a_backend_has_and_tells_of_the_others() {
    let args = "compare phantom:capsules:32 --modes all --methods box,distance-map --backends cpu --size 32 --views 1 \
                --blocks 4 --repeat 1 --steps 0.5 --reference-views 0 --json";
    let output = hollowcast(&args.split_whitespace().collect::<Vec<_>>());
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{told}");
    assert!(
        told.starts_with("note: shaded, grey, normals, phong"),
        "{told}"
    );
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let modes = report["modes"].as_array().unwrap();
    let names: Vec<_> = modes.iter().map(|m| m["mode"].as_str().unwrap()).collect();
    assert_eq!(names, ["emission-absorption", "mip", "minip", "mean"]);
    for mode in modes {
        assert_eq!(mode["speeds"][0]["differing_pixels_vs_box"], 0, "{mode}");
    }
    let samples = |mode: &Value| mode["rows"][1]["samples_per_pixel"].as_f64().unwrap();
    // The same window as the mean's, and what the ray has seen.
    assert!(samples(&modes[1]) < samples(&modes[3]));
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
