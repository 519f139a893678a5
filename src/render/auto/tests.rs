use super::*;
use crate::camera::Orbit;
use crate::mode::Window;
use crate::render::BackendChoice;
use crate::transfer::TransferFunction;
use crate::volume::{Statistics, phantom};

/// A renderer that chooses by the assumed costs, with a phantom in it, and settings to draw it with.
fn ready(spec: &str) -> (Renderer, Settings) {
    let volume = Arc::new(phantom::from_spec(spec).unwrap());
    let transfer =
        TransferFunction::from_spec("ramp:40:255:0.3", &Statistics::of(&volume)).unwrap();
    let mut renderer = Renderer::new(BackendChoice::Reference).unwrap();
    let settings = Settings {
        size: [64, 48],
        table_entries: 256,
        ..Settings::new(Orbit::default().camera(volume.extent()))
    };
    renderer.set_volume(volume).unwrap();
    renderer.set_transfer(transfer);
    (renderer, settings)
}

fn turned(settings: &Settings, renderer: &Renderer, azimuth_degrees: f64) -> Settings {
    let extent = renderer.volume.as_ref().unwrap().extent();
    Settings {
        camera: Orbit {
            azimuth_degrees,
            ..Orbit::default()
        }
        .camera(extent),
        ..*settings
    }
}

#[test]
fn where_nothing_can_be_skipped_box_is_chosen() {
    for spec in [
        "phantom:full:48",
        "phantom:noise:48",
        "phantom:checkerboard:40",
    ] {
        let (mut renderer, settings) = ready(spec.trim_start_matches("phantom:"));
        assert_eq!(
            renderer.choose(&settings).unwrap().skip,
            Skip::Box,
            "{spec}"
        );
    }
}

#[test]
fn where_much_is_hollow_something_else_is() {
    for spec in ["sphere:64", "pot:64", "shells:64", "thin:64"] {
        let (mut renderer, settings) = ready(spec);
        let choice = renderer.choose(&settings).unwrap();
        assert_ne!(choice.skip, Skip::Box, "{spec}");
        assert!(BLOCKS.contains(&choice.block));
        // What is chosen can be drawn, and is the same picture.
        let chosen = renderer.render(&choice.in_settings(&settings)).unwrap();
        let base = renderer.render(&settings).unwrap();
        assert_eq!(chosen.picture.difference(&base.picture).pixels, 0, "{spec}");
    }
}

#[test]
fn a_choice_holds_until_something_changes_and_a_turning_camera_builds_nothing() {
    let (mut renderer, settings) = ready("pot:64");
    let choice = renderer.choose(&settings).unwrap();
    assert_eq!(renderer.choose(&settings).unwrap(), choice);
    // Method, block and cuts of the settings are not read.
    let other = Settings {
        skip: Skip::Hull,
        block: 32,
        ..settings
    };
    assert_eq!(renderer.choose(&other).unwrap(), choice);
    for azimuth in [31.0, 80.0, 170.0, 260.0] {
        let view = turned(&settings, &renderer, azimuth);
        let turned = renderer.choose(&view).unwrap();
        assert!(turned.skip == Skip::Box || turned.block == choice.block);
    }
    // A table that shows nothing leaves nothing to draw at all.
    let nothing = TransferFunction::from_spec(
        "ramp:254:255:0.3",
        &Statistics::of(renderer.volume.as_ref().unwrap()),
    );
    renderer.set_transfer(nothing.unwrap());
    let work = renderer.works(&settings, &[choice]).unwrap()[0].unwrap();
    assert_eq!((work.samples, work.contributing), (0.0, 0.0));
}

#[test]
fn lossy_methods_withdrawn_ones_and_the_oracle_are_no_candidates() {
    for backend in [BackendChoice::Cpu, BackendChoice::Reference] {
        let mut renderer = Renderer::new(backend).unwrap();
        let candidates = renderer.candidates(&BLOCKS);
        assert!(candidates.iter().all(|c| c.skip.method().lossless));
        assert!(!candidates.iter().any(|c| c.skip.method().is_limit));
        assert!(candidates.iter().all(|c| renderer.has(c.skip)));
        let boxes = candidates.iter().filter(|c| c.skip == Skip::Box);
        assert_eq!(boxes.count(), 1);
        renderer.withdrawn.push(Skip::Hull);
        let left = renderer.candidates(&BLOCKS);
        assert!(left.len() < candidates.len() && left.iter().all(|c| c.skip != Skip::Hull));
    }
}

/// The bundle's counts are those of the whole picture, to within what a bundle can tell.
#[test]
fn a_bundle_tells_the_work_of_the_picture() {
    let (mut renderer, settings) = ready("shells:64");
    // The second keeps the highest value, by which methods leave out more than emission and absorption would.
    let window = Window {
        low: 40.0,
        high: 400.0,
    };
    for mode in [Mode::EmissionAbsorption, Mode::Mip(window)] {
        let settings = Settings {
            mode,
            size: [160, 120],
            ..settings
        };
        check_bundle(&mut renderer, &settings);
    }
}

fn check_bundle(renderer: &mut Renderer, settings: &Settings) {
    let choices = renderer.candidates(&[4, 16]);
    let works = renderer.works(settings, &choices).unwrap();
    for (choice, work) in choices.iter().zip(works) {
        let work = work.expect("the reference's methods all have segments");
        let counted = renderer.count(&choice.in_settings(settings)).unwrap();
        for (told, counted) in [
            (work.samples, counted.counters.samples),
            (work.contributing, counted.counters.contributing),
        ] {
            let ratio = told / counted as f64;
            assert!((0.85..1.15).contains(&ratio), "{}: {ratio}", choice.words());
        }
    }
}

#[test]
fn the_simplest_of_equals_is_picked_and_box_unless_something_beats_it_clearly() {
    let choice = |skip, block| Choice {
        skip,
        block,
        ..Choice::BOX
    };
    let of = |choice, ms, samples| Promise {
        choice,
        ms,
        samples,
    };
    let promised = |ms: [f64; 4]| {
        [
            of(Choice::BOX, ms[0], 100.0),
            of(choice(Skip::Hull, 4), ms[1], 50.0),
            of(choice(Skip::Hull, 8), ms[2], 60.0),
            of(choice(Skip::BeamMasks, 8), ms[3], 40.0),
        ]
    };
    let best = |ms| pick(&promised(ms), None, true);
    assert_eq!(best([10.0, 5.0, 5.05, 5.0]), choice(Skip::Hull, 8));
    assert_eq!(best([10.0, 5.0, 5.5, 4.0]), choice(Skip::BeamMasks, 8));
    assert_eq!(best([10.0, 9.5, 9.5, 9.2]), Choice::BOX);
    assert_eq!(best([0.06, 0.02, 0.02, 0.02]), Choice::BOX);
    assert_eq!(pick(&[], None, true), Choice::BOX);
    let kept = Some(choice(Skip::Hull, 8));
    let turned = |ms| pick(&promised(ms), kept, true);
    assert_eq!(turned([10.0, 5.0, 5.0, 4.5]), choice(Skip::Hull, 8));
    assert_eq!(turned([10.0, 5.0, 5.0, 4.0]), choice(Skip::BeamMasks, 8));
    assert_eq!(turned([3.0, 5.0, 5.0, 4.0]), Choice::BOX);
    // Without samples to leave out, a little less time is noise.
    for (ms, chosen) in [(8.5, Skip::Box), (7.0, Skip::BeamMasks)] {
        let all = [
            of(Choice::BOX, 10.0, 100.0),
            of(choice(Skip::BeamMasks, 8), ms, 99.0),
        ];
        assert_eq!(pick(&all, None, true).skip, chosen);
        assert_eq!(pick(&all, None, false).skip, Skip::Box);
    }
}
