//! `auto`, `tune` and profiles as a user meets them.

mod command_line;

use std::fs;
use std::path::Path;

use command_line::{json, refused, succeeds};
use serde_json::Value;

const POT: &str = "phantom:pot:32";
const SMALL: [&str; 5] = ["--size", "24x16", "--step", "1", "--json"];

fn render(folder: &Path, volume: &str, more: &[&str]) -> Value {
    let args = [&["render", volume, "-o", "p.npy"], &SMALL[..], more].concat();
    json(folder, &args)
}

fn tune(folder: &Path, more: &[&str]) -> Value {
    let rounds = ["--views", "1", "--repeat", "1"];
    let args = [&["tune", POT], &SMALL[..], &rounds, more].concat();
    json(folder, &args)
}

#[test]
fn auto_is_the_default_and_draws_the_same_bytes_as_box() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for backend in ["cpu", "reference"] {
        let on = ["--backend", backend];
        let report = render(folder, POT, &on);
        assert_eq!(report["asked_method"], "auto");
        assert_ne!(report["method"], "auto");
        for field in ["block", "cut", "cuts"] {
            assert!(!report[field].is_null(), "{field}");
        }
        let drawn = fs::read(folder.join("p.npy")).unwrap();
        let base = render(folder, POT, &[&on[..], &["--method", "box"]].concat());
        assert_eq!(base["method"], "box");
        assert!(fs::read(folder.join("p.npy")).unwrap() == drawn);
    }
    // The reference's costs are assumed; a calibration's noise could decide where nothing is to be gained.
    let full = render(folder, "phantom:full:32", &["--backend", "reference"]);
    assert_eq!(full["method"], "box");
    let words = succeeds(folder, &["render", POT, "-o", "p.npy", "--size", "8"]);
    assert!(words.contains("auto: "), "{words}");
}

#[test]
fn a_calibration_is_kept_and_a_broken_one_made_anew() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let kept = folder.join("cache/hollowcast/calibration.json");
    let read = || -> Value {
        let kept: Value = serde_json::from_str(&fs::read_to_string(&kept).unwrap()).unwrap();
        kept["found"].clone()
    };
    render(folder, POT, &["--backend", "cpu"]);
    let first = read();
    let keys: Vec<&String> = first.as_object().unwrap().keys().collect();
    assert!(keys.len() == 1 && keys[0].starts_with("cpu | "), "{keys:?}");
    render(folder, POT, &["--backend", "cpu"]);
    assert_eq!(read(), first);
    for broken in ["", "{", "[]", "{\"cpu\": 1}"] {
        fs::write(&kept, broken).unwrap();
        render(folder, POT, &["--backend", "cpu"]);
        assert_eq!(read().as_object().unwrap().len(), 1, "{broken}");
    }
    // The reference's costs are assumed.
    fs::remove_file(&kept).unwrap();
    render(folder, POT, &["--backend", "reference"]);
    assert!(!kept.exists());
}

#[test]
fn what_a_cut_costs_is_found_out_where_cuts_follow_from_it() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let kept = folder.join("cache/hollowcast/calibration.json");
    let draw = |flags: &[&str]| {
        let cut = [
            "render",
            POT,
            "-o",
            "p.npy",
            "--size",
            "8",
            "--backend",
            "gpu",
        ];
        succeeds(folder, &[&cut[..], &["--method", "k-cuts"], flags].concat());
    };
    draw(&["--cuts", "2"]);
    assert!(!kept.exists());
    draw(&[]);
    let found: Value = serde_json::from_str(&fs::read_to_string(&kept).unwrap()).unwrap();
    assert_eq!(found["found"].as_object().unwrap().len(), 1);
}

#[test]
fn what_auto_chooses_is_not_given_by_hand_too() {
    let folder = tempfile::tempdir().unwrap();
    for flag in [["--block", "4"], ["--cut", "best"], ["--cuts", "3"]] {
        let args = [&["render", POT, "--backend", "reference"], &flag[..]].concat();
        let error = refused(folder.path(), &args);
        let name = format!("{}: ", flag[0].trim_start_matches("--"));
        assert!(error.contains(&name) && error.contains("auto"), "{error}");
    }
}

#[test]
fn compare_takes_auto_and_tells_what_it_chose() {
    let folder = tempfile::tempdir().unwrap();
    let args = [
        "compare",
        POT,
        "--methods",
        "auto,hull",
        "--steps",
        "1",
        "--backends",
        "reference",
        "--size",
        "16",
        "--views",
        "2",
        "--repeat",
        "1",
        "--reference-views",
        "0",
    ];
    let report = json(folder.path(), &[&args[..], &["--json"]].concat());
    let rows = report["rows"].as_array().unwrap();
    let methods: Vec<&str> = rows.iter().map(|r| r["method"].as_str().unwrap()).collect();
    assert_eq!(methods, ["box", "auto", "hull"]);
    assert!(!rows[1]["chosen"].as_array().unwrap().is_empty());
    assert!(rows[0].get("chosen").is_none());
    assert_eq!(rows[1]["differing_pixels_vs_box"], 0);
    let table = succeeds(folder.path(), &args);
    assert!(table.contains("auto on reference at 1: "), "{table}");
}

#[test]
fn a_tuning_tries_everything_and_its_profile_draws_the_winner() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let report = tune(folder, &["--backends", "reference", "--blocks", "4,8"]);
    let rows = report["rows"].as_array().unwrap();
    for method in hollowcast::skip::METHODS {
        let is_tried =
            method.lossless && method.name != "oracle" && method.backends.contains(&"reference");
        let found = rows.iter().filter(|r| r["method"] == method.name).count();
        assert_eq!(found > 0, is_tried, "{}", method.name);
        assert!(method.name == "box" || !is_tried || found.is_multiple_of(2));
    }
    let ms = |row: &Value| row["frame_ms"].as_f64().unwrap();
    assert!(rows.is_sorted_by(|a, b| ms(a) <= ms(b)));
    assert!(rows.iter().all(|r| r["differing_pixels_vs_box"] == 0));
    assert_eq!(report["winner"], rows[0]);
    let auto = &report["auto"][0];
    assert_eq!(auto["backend"], "reference");
    assert!(auto["over_fastest"].as_f64().unwrap() >= 1.0);

    let profile = "phantom-pot-32.profile.toml";
    assert_eq!(report["profile"], profile);
    let text = fs::read_to_string(folder.join(profile)).unwrap();
    assert!(text.starts_with("# Fastest of "), "{text}");
    let drawn = render(folder, POT, &["--profile", profile]);
    assert_eq!(drawn["method"], rows[0]["method"]);
    assert_eq!(drawn["block"], rows[0]["block"]);
    assert_eq!(drawn["adapter"]["backend"], "reference");
    // Flags count instead of what the profile says.
    let other = ["--method", "hull", "--block", "16", "--cuts", "3"];
    let drawn = render(folder, POT, &[&["--profile", profile], &other[..]].concat());
    assert_eq!(
        (&drawn["method"], &drawn["block"]),
        (&"hull".into(), &16.into())
    );
    assert_eq!(drawn["cuts"], "3");
    let auto = ["--profile", profile, "--method", "auto"];
    assert_eq!(render(folder, POT, &auto)["asked_method"], "auto");
}

#[test]
fn a_bad_profile_is_named_with_its_field() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let render = ["render", POT, "--profile", "bad.toml"];
    assert!(refused(folder, &render).contains("bad.toml"));
    for (text, named) in [
        ("backend = \"cpu\"\nmethod = \"hulk\"\nblock = 8", "method"),
        ("backend = \"cpu\"\nmethod = \"hull\"\nblock = 7", "block"),
        (
            "backend = \"cpu\"\nmethod = \"hull\"\nblock = 8\nshape = 3",
            "shape",
        ),
    ] {
        fs::write(folder.join("bad.toml"), text).unwrap();
        let error = refused(folder, &render);
        assert!(
            error.contains("bad.toml") && error.contains(named),
            "{error}"
        );
    }
}

#[test]
fn a_profile_never_replaces_the_volume() {
    let folder = tempfile::tempdir().unwrap();
    let volume = folder.path().join("scan.nrrd");
    fs::copy(
        concat!(env!("CARGO_MANIFEST_DIR"), "/data/stent.nrrd"),
        &volume,
    )
    .unwrap();
    let before = fs::read(&volume).unwrap();
    let args = [
        "tune",
        "scan.nrrd",
        "-o",
        "scan.nrrd",
        "--backends",
        "reference",
    ];
    let error = refused(folder.path(), &args);
    assert!(error.contains("the volume itself"), "{error}");
    assert_eq!(fs::read(&volume).unwrap(), before);
    let chart = [
        "tune",
        "scan.nrrd",
        "--sweep",
        "block",
        "--chart",
        "scan.jpg",
    ];
    assert!(refused(folder.path(), &chart).contains(".svg"));
}

#[test]
fn a_sweep_has_a_row_for_every_size_and_draws_its_chart() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for chart in ["blocks.svg", "blocks.png"] {
        let sweep = ["--backends", "cpu", "--sweep", "block", "--chart", chart];
        let report = tune(folder, &sweep);
        let rows = report["rows"].as_array().unwrap();
        let blocks_of = |method: &str| -> Vec<u64> {
            let rows = rows.iter().filter(|r| r["method"] == method);
            rows.map(|r| r["block"].as_u64().unwrap()).collect()
        };
        assert_eq!(blocks_of("beam-masks"), [2, 4, 8, 16, 32, 64]);
        assert_eq!(blocks_of("box").len(), 1);
        for row in rows {
            assert_eq!(row["differing_pixels_vs_box"], 0, "{row}");
            assert!(row["structure_bytes"].as_u64().unwrap() > 0 || row["method"] == "box");
        }
        assert!(report.get("winner").is_none());
    }
    let svg = fs::read_to_string(folder.join("blocks.svg")).unwrap();
    for named in ["<svg", "beam-masks", "distance-map", "samples a pixel"] {
        assert!(svg.contains(named), "{named}");
    }
    let png = fs::read(folder.join("blocks.png")).unwrap();
    assert!(png.starts_with(b"\x89PNG"));
    assert!(!folder.join("phantom-pot-32.profile.toml").exists());
}
