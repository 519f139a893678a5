//! Presets on real scans.
//!
//! The volumes lie in the folder that `HOLLOWCAST_DATA` names; without it these tests say that they were not run.

use std::io::Write as _;
use std::path::PathBuf;

use hollowcast::transfer::{PRESETS, threshold};
use hollowcast::volume::{Statistics, empty_share, open};
use serde_json::Value;

#[test]
fn presets_hide_a_scans_background_about_where_people_do() {
    let Some(folder) = std::env::var_os("HOLLOWCAST_DATA").map(PathBuf::from) else {
        // Past the capture of passing tests' output: who reads it must know.
        let _ = writeln!(std::io::stderr(), "not run: HOLLOWCAST_DATA is unset");
        return;
    };
    let manifest = std::fs::read(folder.join("MANIFEST.json")).expect("MANIFEST.json");
    let manifest: Vec<Value> = serde_json::from_slice(&manifest).expect("valid JSON");
    for entry in &manifest {
        let name = entry["file"].as_str().unwrap();
        let volume = open(&folder.join(name), None).unwrap_or_else(|e| panic!("{e}"));
        let statistics = Statistics::of(&volume);
        let guide = entry["threshold"].as_f64().unwrap();
        let chosen = threshold(&statistics);
        let empty = empty_share(&volume, |v| v <= chosen);
        println!(
            "{name:22} threshold {chosen:4} (by eye {guide:4}), empty {:5.2} %",
            empty * 100.0
        );
        assert!(
            (0.6..=1.6).contains(&(chosen / guide)),
            "{name}: {chosen} for {guide}"
        );
        for preset in PRESETS {
            let tf = preset.transfer_function(&statistics).unwrap();
            assert_eq!(tf.at(chosen).1, 0.0, "{name} {}", preset.name);
            assert!(
                tf.at(statistics.value_range()[1]).1 >= 0.3,
                "{name} {}",
                preset.name
            );
        }
    }
}
