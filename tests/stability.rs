//! A selection of the hazards, drawn by every method on the CPU and on an adapter. These tests fail, not skip, where there
//! is no adapter.

use std::collections::BTreeSet;

use hollowcast::measure::stability::{Atlas, Contestant, GROUPS, Verdict, hazards};
use hollowcast::render::{BackendChoice, Renderer};
use hollowcast::skip::METHODS;

/// Hazards in which something broke once, or nearly; those that are timed and the largest are left to the command.
const CHOSEN: &[&str] = &[
    "eye-on-block-corner",
    "eye-far-thin-wall",
    "almost-parallel",
    "along-block-faces",
    "orbit-around-the-corner",
    "tiny-movements-across-the-cut",
    "wall-of-a-voxel",
    "jumping-table",
    "one-voxel-per-block",
    "cavity-just-missed-by-the-cut",
    "float-huge",
    "float-denormal",
    "float-not-finite",
    "spacing-1000-1",
    "thresholds",
    "odd-sizes",
    "table-between-frames",
];

#[test]
fn hazards_have_names_of_their_own_and_frames_of_their_kind() {
    let mut names = BTreeSet::new();
    let mut groups = BTreeSet::new();
    for hazard in hazards() {
        assert!(names.insert(hazard.name), "{} twice", hazard.name);
        assert!((1..=GROUPS.len()).contains(&usize::from(hazard.group)));
        groups.insert(hazard.group);
        let scenery = (hazard.make)().unwrap_or_else(|e| panic!("{}: {e}", hazard.name));
        assert!(!scenery.frames.is_empty(), "{}", hazard.name);
        assert_eq!(
            scenery.volume.as_ref().len(),
            scenery.volume.bytes() / scenery.volume.voxels.voxel_type().bytes()
        );
    }
    // The tenth is no scene of its own: two backends draw those of the others.
    assert_eq!(groups.len(), GROUPS.len() - 1);
    assert!(CHOSEN.iter().all(|name| names.contains(name)));
}

#[test]
fn no_lossless_method_is_wrong_in_the_chosen_hazards() {
    let renderers = [BackendChoice::Gpu, BackendChoice::Cpu]
        .map(|choice| Renderer::new(choice).expect("these tests need an adapter"));
    let lossless: Vec<Contestant> = METHODS
        .iter()
        .filter(|m| m.lossless && !m.is_limit)
        .map(|m| Contestant::Method(m.skip))
        .collect();
    let mut atlas = Atlas::new(renderers.into(), &lossless).unwrap();
    for hazard in hazards().filter(|h| CHOSEN.contains(&h.name)) {
        for row in atlas.run(hazard).unwrap().rows {
            assert_eq!(row.verdict, Verdict::Ok, "{row:?}");
        }
    }
}

#[test]
fn what_others_lose_is_found_and_shown() {
    let renderers = [BackendChoice::Gpu, BackendChoice::Cpu]
        .map(|choice| Renderer::new(choice).expect("these tests need an adapter"));
    let others: Vec<Contestant> = ["two-step", "hardware-filter", "f32-from-eye"]
        .iter()
        .map(|name| Contestant::all().find(|c| c.name() == *name).unwrap())
        .collect();
    let mut atlas = Atlas::new(renderers.into(), &others).unwrap();
    for (hazard, method) in [
        ("wall-of-a-voxel", "two-step"),
        ("magnified-smooth-data", "hardware-filter"),
        ("eye-far", "f32-from-eye"),
    ] {
        let hazard = hazards().find(|h| h.name == hazard).unwrap();
        let found = atlas.run(hazard).unwrap();
        let row = found.rows.iter().find(|r| r.method == method).unwrap();
        assert_eq!(row.verdict, Verdict::Wrong, "{row:?}");
        let worst = found.worst.expect("a wrong picture is kept");
        assert!(worst.max_abs > 0.0 && worst.picture.size == worst.expected.size);
    }
}
