//! The GPU backend: bit-identity of skipping, nearness to the f64 reference, and the paths that large pictures and
//! small steps take. These tests fail, not skip, where there is no adapter.

mod support;

use std::sync::Arc;

use hollowcast::camera::{Camera, Orbit, Projection};
use hollowcast::measure::verify::{self, Verifier, View};
use hollowcast::render::{BackendChoice, Renderer, Settings};
use hollowcast::sample::Sampler;
use hollowcast::skip::{Cuts, HalfCut, METHODS, Skip, SlabCount};
use hollowcast::transfer::{ControlPoint, TransferFunction};
use hollowcast::volume::{Volume, Voxels, phantom};
use support::{nearness, outside, ramp, renderer};

/// The lossless methods of the GPU.
fn lossless() -> impl Iterator<Item = Skip> {
    let methods = METHODS.iter();
    methods
        .filter(|m| m.lossless && m.backends.contains(&"gpu"))
        .map(|m| m.skip)
}

#[test]
fn skipping_changes_no_bit_of_any_phantom_in_any_pair_of_settings() {
    let mut renderer = renderer();
    let transfer = ramp(40.0, 255.0, 0.3);
    for (name, _) in phantom::NAMES {
        let volume = Arc::new(phantom::make(name, [41, 37, 48]).unwrap());
        renderer.set_volume(Arc::clone(&volume)).unwrap();
        renderer.set_transfer(transfer.clone());
        let mut verifier =
            Verifier::new(&mut renderer, &volume, &transfer, Cuts::default(), [96, 96]);
        for case in verify::pairwise() {
            for outcome in verifier.run(&case).unwrap() {
                assert_eq!(outcome.differing_pixels, 0, "{name}: {case:?}: {outcome:?}");
            }
        }
    }
}

#[test]
fn cutting_elsewhere_and_often_changes_no_bit() {
    let mut renderer = renderer();
    let transfer = ramp(40.0, 255.0, 0.3);
    let cuts = [
        SlabCount::Middle,
        SlabCount::AtMost(3),
        SlabCount::AtMost(8),
    ]
    .map(|slabs| Cuts {
        half: HalfCut::Best,
        slabs,
    });
    for name in ["pot", "shells", "gyroid"] {
        let volume = Arc::new(phantom::make(name, [41, 37, 48]).unwrap());
        renderer.set_volume(Arc::clone(&volume)).unwrap();
        renderer.set_transfer(transfer.clone());
        for cuts in cuts {
            for case in verify::pairwise() {
                for outcome in Verifier::new(&mut renderer, &volume, &transfer, cuts, [64, 64])
                    .run(&case)
                    .unwrap()
                {
                    assert_eq!(
                        outcome.differing_pixels, 0,
                        "{name}: {cuts:?}, {case:?}: {outcome:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn skipping_changes_no_bit_of_flat_thin_or_stretched_volumes() {
    let mut renderer = renderer();
    let transfer = ramp(40.0, 255.0, 0.3);
    // No block size divides these; one is flat, one a single voxel thick, one of slices ten times as far apart.
    let shapes = [
        ([257, 255, 63], 1.0),
        ([65, 63, 17], 1.0),
        ([1, 40, 40], 1.0),
        ([40, 37, 9], 10.0),
    ];
    for (dims, z_spacing) in shapes {
        let volume = Arc::new(Volume {
            spacing: glam::DVec3::new(1.0, 1.0, z_spacing),
            ..phantom::make("shells", dims).unwrap()
        });
        renderer.set_volume(Arc::clone(&volume)).unwrap();
        renderer.set_transfer(transfer.clone());
        let mut verifier =
            Verifier::new(&mut renderer, &volume, &transfer, Cuts::default(), [48, 48]);
        for case in verify::pairwise() {
            for outcome in verifier.run(&case).unwrap() {
                assert_eq!(
                    outcome.differing_pixels, 0,
                    "{dims:?}: {case:?}: {outcome:?}"
                );
            }
        }
    }
}

#[test]
fn a_segment_list_that_overflows_marches_to_the_last_exit() {
    let mut renderer = renderer();
    // Thirty walls, 12 voxels apart, and emptiness behind them.
    let [nx, ny, nz] = [400, 12, 12];
    let is_wall = |x: usize| x % 12 < 2 && x < 360;
    let voxels: Vec<u8> = (0..nx * ny * nz)
        .map(|i| if is_wall(i % nx) { 200 } else { 0 })
        .collect();
    let volume = Arc::new(Volume {
        voxels: Voxels::U8(voxels.into()),
        ..phantom::make("empty", [nx, ny, nz]).unwrap()
    });
    renderer.set_volume(Arc::clone(&volume)).unwrap();
    renderer.set_transfer(ramp(40.0, 255.0, 0.01));
    let mut settings = outside(&volume, Skip::Box, Sampler::Exact);
    settings.block = 2;
    settings.size = [16, 16];
    settings.camera = Camera {
        eye: volume.extent() * 0.5 - glam::DVec3::X * 1000.0,
        target: volume.extent() * 0.5,
        up: glam::DVec3::Z,
        projection: Projection::Orthographic { height: 10.0 },
    };
    let [by_box, by_walk, by_list] = [Skip::Box, Skip::GridDda, Skip::SegmentList].map(|skip| {
        settings.skip = skip;
        renderer.count(&settings).unwrap()
    });
    assert_eq!(by_list.picture.difference(&by_box.picture).pixels, 0);
    let [whole, walk, list] = [by_box, by_walk, by_list].map(|c| c.samples[120]);
    // Fifteen gaps of its own, then all up to the last wall and nothing of what lies behind it.
    assert!(walk < list && list < whole - 60, "{walk}, {list}, {whole}");
    assert!(list < walk + (whole - walk) * 3 / 5);
}

#[test]
fn lossy_methods_lose_thin_walls_and_little_of_smooth_ones() {
    let mut renderer = renderer();
    let mut reference = Renderer::new(BackendChoice::Reference).unwrap();
    let mut worst = |name: &str, skip, step_voxels| {
        let volume = Arc::new(phantom::make(name, [48; 3]).unwrap());
        for r in [&mut *renderer, &mut reference] {
            r.set_volume(Arc::clone(&volume)).unwrap();
            r.set_transfer(ramp(40.0, 255.0, 0.3));
        }
        let mut settings = outside(&volume, Skip::Box, Sampler::Exact);
        settings.step_voxels = step_voxels;
        settings.size = [48, 48];
        let by_box = renderer.render(&settings).unwrap().picture;
        settings.skip = skip;
        let lossy = renderer.render(&settings).unwrap().picture;
        // The reference loses the same.
        let (db, _) = nearness(&lossy, &reference.render(&settings).unwrap().picture);
        assert!(db > 50.0, "{name}, {skip:?}: {db} dB");
        nearness(&lossy, &by_box)
    };
    let thin = worst("thin", Skip::TwoStep, 0.5);
    let smooth = worst("capsules", Skip::TwoStep, 0.2);
    let strided = worst("capsules", Skip::Adaptive, 0.1);
    assert!(thin.1 > 0.05, "{thin:?}");
    assert!(smooth.0 > 40.0, "{smooth:?}");
    assert!(strided.1 > 0.0 && strided.0 > 40.0, "{strided:?}");
}

#[test]
fn better_cuts_take_fewer_samples_of_cavities_off_centre() {
    let mut renderer = renderer();
    let n = 64;
    // Two cavities in z, neither of them at the middle.
    let is_cavity = |z: usize| (8..24).contains(&z) || (44..56).contains(&z);
    let voxels: Vec<u8> = (0..n * n * n)
        .map(|i| if is_cavity(i / n / n) { 0 } else { 200 })
        .collect();
    let volume = Arc::new(Volume {
        voxels: Voxels::U8(voxels.into()),
        ..phantom::make("empty", [n; 3]).unwrap()
    });
    renderer.set_volume(Arc::clone(&volume)).unwrap();
    renderer.set_transfer(ramp(40.0, 255.0, 0.3));
    let mut samples = |skip, half| {
        let mut settings = outside(&volume, skip, Sampler::Exact);
        settings.block = 4;
        settings.cuts.half = half;
        settings.camera = Orbit {
            elevation_degrees: 80.0,
            ..Orbit::default()
        }
        .camera(volume.extent());
        renderer.count(&settings).unwrap().counters.samples
    };
    let middle = samples(Skip::HalfSplit, HalfCut::Middle);
    let best = samples(Skip::HalfSplit, HalfCut::Best);
    let several = samples(Skip::KCuts, HalfCut::Middle);
    assert!(
        several < best && best < middle,
        "{several}, {best}, {middle}"
    );
}

#[test]
fn exact_sampling_is_within_two_255ths_and_60_db_of_the_reference() {
    let mut renderer = renderer();
    let mut reference = Renderer::new(BackendChoice::Reference).unwrap();
    let transfer = ramp(40.0, 255.0, 0.3);
    for (name, _) in phantom::NAMES {
        let volume = Arc::new(phantom::make(name, [64, 48, 56]).unwrap());
        for r in [&mut *renderer, &mut reference] {
            r.set_volume(Arc::clone(&volume)).unwrap();
            r.set_transfer(transfer.clone());
        }
        for view in View::ALL {
            let mut settings = outside(&volume, Skip::HalfSplit, Sampler::Exact);
            settings.camera = view.camera(&volume, &transfer, false);
            let ours = renderer.render(&settings).unwrap().picture;
            let truth = reference.render(&settings).unwrap().picture;
            let (db, max_abs) = nearness(&ours, &truth);
            assert!(
                db >= 60.0 && max_abs <= 2.0 / 255.0,
                "{name} {view:?}: {db} dB, {max_abs}"
            );
        }
    }
}

#[test]
fn counting_changes_no_bit_and_counts_what_the_reference_counts() {
    let mut renderer = renderer();
    let mut reference = Renderer::new(BackendChoice::Reference).unwrap();
    let volume = Arc::new(phantom::make("pot", [48; 3]).unwrap());
    for r in [&mut *renderer, &mut reference] {
        r.set_volume(Arc::clone(&volume)).unwrap();
        r.set_transfer(ramp(40.0, 255.0, 0.3));
    }
    for method in METHODS.iter().filter(|m| m.backends.contains(&"gpu")) {
        let settings = outside(&volume, method.skip, Sampler::Exact);
        let drawn = renderer.render(&settings).unwrap().picture;
        let counted = renderer.count(&settings).unwrap();
        assert_eq!(
            drawn.difference(&counted.picture).pixels,
            0,
            "{}",
            method.name
        );
        if !method.lossless {
            continue;
        }
        // What contributes depends on no lossless method.
        let truth = reference
            .count(&Settings {
                skip: Skip::Box,
                ..settings
            })
            .unwrap();
        // The same samples contribute, but for the few whose table coordinate rounds across zero.
        let (a, b) = (
            counted.counters.contributing as f64,
            truth.counters.contributing as f64,
        );
        assert!(
            (a / b - 1.0).abs() < 1e-3,
            "{}: {a} against {b}",
            method.name
        );
        assert!(counted.counters.samples >= counted.counters.contributing);
        assert!(!method.is_limit || counted.counters.samples == counted.counters.contributing);
        let hits = counted.first_hit.iter().zip(&truth.first_hit);
        let far_off = hits
            .filter(|(a, b)| a.is_finite() && b.is_finite() && (**a - **b).abs() > 0.6)
            .count();
        assert!(
            far_off * 100 <= counted.first_hit.len(),
            "{far_off} first hits are off by a sample or more"
        );
    }
}

#[test]
fn a_picture_in_many_dispatches_is_that_of_one() {
    // Steps so small that rays take over 16,384 samples: the march stops, stores its state and goes on. With homogeneous
    // matter the answer is known: opacity of the chord, whatever the step.
    let mut renderer = renderer();
    let volume = Arc::new(phantom::make("full", [24; 3]).unwrap());
    renderer.set_volume(Arc::clone(&volume)).unwrap();
    renderer.set_transfer(
        TransferFunction::new(
            vec![ControlPoint {
                value: 0.0,
                opacity: 0.05,
                color: [1.0, 0.5, 0.25],
            }],
            1.0,
        )
        .unwrap(),
    );
    let mut settings = outside(&volume, Skip::Box, Sampler::Exact);
    settings.size = [8, 8];
    settings.camera = Camera {
        eye: volume.extent() * 0.5 - glam::DVec3::X * 100.0,
        target: volume.extent() * 0.5,
        up: glam::DVec3::Z,
        projection: Projection::Orthographic { height: 16.0 },
    };
    settings.step_voxels = 24.0 / 60_000.0;
    let expected = 1.0 - 0.95_f64.powi(24);
    for skip in lossless() {
        settings.skip = skip;
        let counted = renderer.count(&settings).unwrap();
        assert_eq!(counted.samples[27], 60_000, "{skip:?}");
        for pixel in &counted.picture.rgba {
            // 60,000 roundings in f32.
            assert!(
                (f64::from(pixel[3]) - expected).abs() < 2e-3,
                "{skip:?}: {pixel:?}"
            );
        }
        assert_eq!(
            counted
                .picture
                .difference(&renderer.render(&settings).unwrap().picture)
                .pixels,
            0
        );
    }
}

#[test]
fn a_picture_in_pieces_is_bit_identical_for_every_method() {
    let mut renderer = renderer();
    let volume = Arc::new(phantom::make("shells", [32; 3]).unwrap());
    renderer.set_volume(Arc::clone(&volume)).unwrap();
    renderer.set_transfer(ramp(40.0, 255.0, 0.3));
    let mut settings = outside(&volume, Skip::Box, Sampler::Hardware);
    settings.size = [2100, 40];
    settings.step_voxels = 2.0;
    let wide = renderer.render(&settings).unwrap().picture;
    assert!(wide.rgba.iter().any(|p| p[3] > 0.1));
    settings.cuts.slabs = SlabCount::AtMost(8);
    for skip in lossless() {
        settings.skip = skip;
        assert_eq!(
            renderer
                .render(&settings)
                .unwrap()
                .picture
                .difference(&wide)
                .pixels,
            0,
            "{skip:?}"
        );
    }
}
