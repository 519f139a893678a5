//! Choices that the tests of each choice do not put together: skipping changes no bit of them either, and the f64 reference
//! draws the same. These tests fail, not skip, where there is no adapter.

mod support;

use std::sync::Arc;

use glam::DVec3;
use hollowcast::lattice::Clipping;
use hollowcast::measure::metrics::metrics;
use hollowcast::measure::verify::{Verifier, View};
use hollowcast::mode::{MODES, Mode};
use hollowcast::render::{BackendChoice, Renderer, Settings};
use hollowcast::sample::{Classification, Gradients, Sampler};
use hollowcast::skip::{Cuts, Skip};
use hollowcast::volume::{Statistics, Volume, phantom};
use support::{check_bits, renderer, settings, show};

/// What is drawn with what: mode, sampler, classification, gradients, depth cue.
type Together = (&'static str, Sampler, Classification, Gradients, f64);

const TOGETHER: [Together; 6] = {
    use {Classification as C, Gradients as G, Sampler as S};
    [
        ("emission-absorption", S::Tricubic, C::Pre, G::Fly, 0.0),
        (
            "emission-absorption",
            S::Tricubic,
            C::PreIntegrated,
            G::Fly,
            0.6,
        ),
        ("shaded", S::Exact, C::Pre, G::Half, 0.6),
        ("shaded", S::Hardware, C::PreIntegrated, G::Full, 0.0),
        ("mip", S::Tricubic, C::Post, G::Fly, 0.0),
        ("phong", S::Tricubic, C::Post, G::Full, 0.0),
    ]
};

/// One of each kind: by rasterised bounds, by masks, by leaps, by cells; and by lists where that does not compile most of a second
/// longer for each.
fn methods(mode: &str) -> Vec<Skip> {
    let mut methods = vec![
        Skip::Hull,
        Skip::HalfSplit,
        Skip::BeamMasks,
        Skip::DistanceMap,
        Skip::BeamCells,
    ];
    if mode == "emission-absorption" {
        methods.push(Skip::SegmentList);
    }
    methods
}

fn mode(name: &str, volume: &Volume) -> Mode {
    let row = MODES.iter().find(|row| row.name == name);
    (row.unwrap().suited_to)(&Statistics::of(volume))
}

#[test]
fn skipping_changes_no_bit_of_choices_together() {
    let mut renderer = renderer();
    for name in ["pot", "noise"] {
        let volume = Arc::new(phantom::make(name, [30, 26, 28]).unwrap());
        let transfer = show([&mut *renderer], &volume);
        let mut half = Clipping::NONE;
        let normal = DVec3::new(1.0, 0.4, -0.3);
        half.keep(normal, normal.dot(volume.extent() * 0.4))
            .unwrap();
        for together in TOGETHER {
            let (name, sampler, classification, gradients, depth_cue) = together;
            for (view, clipping) in [(View::Outside, half), (View::Cavity, Clipping::NONE)] {
                let verifier =
                    Verifier::new(&mut renderer, &volume, &transfer, Cuts::default(), [32, 28])
                        .with_mode(mode(name, &volume))
                        .with_classification(classification)
                        .with_shading(gradients, depth_cue)
                        .with_clipping(clipping)
                        .with_methods(methods(name));
                let told = format!("{} {together:?}", volume.name);
                check_bits(verifier, view, sampler, &told);
            }
        }
    }
}

/// Colours of voxels through the B-spline: exact fetches, which the reference has too.
#[test]
fn smoothed_colours_of_voxels_are_within_60_db_of_the_reference() {
    let mut renderer = renderer();
    let mut reference = Renderer::new(BackendChoice::Reference).unwrap();
    let volume = Arc::new(phantom::make("pot", [36, 32, 40]).unwrap());
    let transfer = show([&mut *renderer, &mut reference], &volume);
    for classification in [Classification::Pre, Classification::PreIntegrated] {
        let settings = Settings {
            sampler: Some(Sampler::TricubicExact),
            classification,
            size: [40, 36],
            ..settings(
                Mode::EmissionAbsorption,
                View::Outside.camera(&volume, &transfer, false),
            )
        };
        let ours = renderer.render(&settings).unwrap().picture;
        let truth = reference.render(&settings).unwrap().picture;
        assert!(truth.rgba.iter().any(|p| p[3] > 0.1));
        let db = metrics([(&ours, &truth)]).psnr_db();
        println!("{}: {db:.1} dB", classification.name());
        assert!(db >= 60.0, "{classification:?}: {db} dB");
        // Linear interpolation draws another picture.
        let linear = Settings {
            sampler: Some(Sampler::Exact),
            ..settings
        };
        let linear = reference.render(&linear).unwrap().picture;
        assert!(metrics([(&linear, &truth)]).psnr_db() < 50.0);
    }
}
