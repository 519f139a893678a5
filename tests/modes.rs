//! Every mode on the GPU: near the f64 reference, and not changed in any bit by skipping. These tests fail, not skip, where
//! there is no adapter.

mod support;

use std::sync::Arc;

use hollowcast::camera::Orbit;
use hollowcast::measure::metrics::metrics;
use hollowcast::measure::verify::{Case, Verifier, View};
use hollowcast::mode::Mode;
use hollowcast::render::{BackendChoice, Renderer, Settings};
use hollowcast::sample::Sampler;
use hollowcast::scene::Picture;
use hollowcast::skip::{Cuts, Skip};
use hollowcast::volume::{Statistics, Volume};
use support::{made, modes, of_data_folder, renderer, settings, shipped, show, turned_round};

/// The data values of the surfaces that a mode looks for.
fn surfaces(mode: &Mode) -> Vec<f64> {
    match *mode {
        Mode::Normals { iso } | Mode::Phong { iso, .. } => vec![iso],
        Mode::TwoSurfaces { outer, iso, .. } => vec![outer.iso, iso],
        _ => Vec::new(),
    }
}

/// Pixels whose ray meets another surface, or none, if the surface lies 1e-4 of the data's range higher or lower: where its
/// first hit jumps by more than the sample that a crossing is looked for behind, or to the ray's first sample, before which no
/// crossing is looked for.
fn undecided(reference: &mut Renderer, volume: &Volume, settings: &Settings) -> Vec<bool> {
    let [low, high] = Statistics::of(volume).value_range();
    let margin = 1e-4 * (high - low);
    let mut undecided = vec![false; (settings.size[0] * settings.size[1]) as usize];
    for iso in surfaces(&settings.mode) {
        let [below, above] = [iso - margin, iso + margin].map(|iso| {
            let counted = reference.count(&Settings {
                mode: Mode::Normals { iso },
                skip: Skip::Box,
                ..*settings
            });
            counted.unwrap()
        });
        for (i, undecided) in undecided.iter_mut().enumerate() {
            let [a, b] = [below.first_hit[i], above.first_hit[i]].map(f64::from);
            let is_near = (a - b).abs() < 1.5 * settings.step_voxels;
            let begins_inside = below.samples[i].min(above.samples[i]) == 1;
            *undecided |= a != b && (!is_near || begins_inside);
        }
    }
    undecided
}

fn without(picture: &Picture, masked: &[bool]) -> Picture {
    let mut picture = picture.clone();
    for (pixel, _) in picture.rgba.iter_mut().zip(masked).filter(|(_, m)| **m) {
        *pixel = [0.0; 4];
    }
    picture
}

fn check_against_reference(volumes: &[Arc<Volume>]) {
    let mut renderer = renderer();
    let mut cpu = Renderer::new(BackendChoice::Cpu).unwrap();
    let mut reference = Renderer::new(BackendChoice::Reference).unwrap();
    let (mut pixels, mut masked_pixels) = (0, 0);
    for volume in volumes {
        let transfer = show([&mut *renderer, &mut cpu, &mut reference], volume);
        for mode in modes(volume) {
            for view in [View::Outside, View::Cavity] {
                let settings = settings(mode, view.camera(volume, &transfer, false));
                let truth = reference.render(&settings).unwrap().picture;
                assert!(
                    matches!(mode, Mode::Minip(_)) || truth.rgba.iter().any(|p| p[3] > 0.0),
                    "{} {mode:?} {view:?} shows nothing",
                    volume.name
                );
                let masked = undecided(&mut reference, volume, &settings);
                if !surfaces(&mode).is_empty() {
                    let count = masked.iter().filter(|m| **m).count();
                    println!("{} {view:?}: {count} pixels masked", mode.name());
                    pixels += masked.len();
                    masked_pixels += count;
                }
                for renderer in [&mut *renderer, &mut cpu] {
                    if !renderer.has_mode(&mode) {
                        continue;
                    }
                    let ours = renderer.render(&settings).unwrap().picture;
                    let [ours, truth] = [&ours, &truth].map(|p| without(p, &masked));
                    let error = metrics([(&ours, &truth)]);
                    let told = format!(
                        "{} {} {} {view:?}: {:.1} dB, at most {:.2e}",
                        renderer.info().backend,
                        volume.name,
                        mode.name(),
                        error.psnr_db(),
                        error.max_abs
                    );
                    println!("{told}");
                    assert!(error.psnr_db() >= 60.0, "{told}");
                }
            }
        }
    }
    println!("{masked_pixels} of {pixels} pixels masked");
    assert!(
        masked_pixels * 1000 <= pixels,
        "{masked_pixels} of {pixels}"
    );
}

#[test]
fn every_mode_of_phantoms_is_within_60_db_of_the_reference() {
    let turned = turned_round(&made("pot"));
    check_against_reference(&[made("pot"), made("capsules"), made("gyroid"), turned]);
}

#[test]
fn every_mode_of_the_shell_is_within_60_db_of_the_reference() {
    check_against_reference(&[shipped("qim3d_shell.nrrd")]);
}

#[test]
fn every_mode_of_the_stent_is_within_60_db_of_the_reference() {
    check_against_reference(&[shipped("stent.nrrd")]);
}

#[test]
#[ignore = "reads HOLLOWCAST_DATA"]
fn every_mode_of_more_scans_is_within_60_db_of_the_reference() {
    let scans = ["aneurism", "boston_teapot", "tooth"];
    check_against_reference(&scans.map(|name| of_data_folder(&format!("{name}.nrrd"))));
}

#[test]
fn skipping_changes_no_bit_in_any_mode() {
    let mut renderer = renderer();
    let mut cpu = Renderer::new(BackendChoice::Cpu).unwrap();
    let mut reference = Renderer::new(BackendChoice::Reference).unwrap();
    let volumes = [
        made("pot"),
        made("noise"),
        turned_round(&made("shells")),
        shipped("qim3d_shell.nrrd"),
        shipped("stent.nrrd"),
    ];
    for volume in &volumes {
        let transfer = show([&mut *renderer, &mut cpu, &mut reference], volume);
        for mode in modes(volume) {
            for (view, sampler) in [
                (View::Outside, Sampler::Exact),
                (View::Cavity, Sampler::Hardware),
                (View::Wall, Sampler::Nearest),
            ] {
                let case = Case {
                    view,
                    is_parallel: view == View::Outside,
                    block: 4,
                    step_edges: 0.02,
                    ert: 0.98,
                    sampler,
                };
                for (renderer, sampler) in [
                    (&mut *renderer, sampler),
                    (&mut cpu, Sampler::Exact),
                    (&mut reference, Sampler::Exact),
                ] {
                    if !renderer.has_mode(&mode) {
                        continue;
                    }
                    let outcomes =
                        Verifier::new(renderer, volume, &transfer, Cuts::default(), [48, 40])
                            .with_mode(mode)
                            .run(&Case { sampler, ..case })
                            .unwrap();
                    for outcome in outcomes {
                        assert_eq!(
                            outcome.differing_pixels, 0,
                            "{} {mode:?}: {case:?}: {outcome:?}",
                            volume.name
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn each_mode_skips_what_it_can() {
    let mut renderer = renderer();
    let mut reference = Renderer::new(BackendChoice::Reference).unwrap();
    let volume = made("pot");
    show([&mut *renderer, &mut reference], &volume);
    let camera = Orbit::default().camera(volume.extent());
    for mode in modes(&volume) {
        let [all, few] = [Skip::Box, Skip::HalfSplit].map(|skip| {
            let settings = Settings {
                skip,
                ..settings(mode, camera)
            };
            renderer.count(&settings).unwrap().counters
        });
        assert_eq!(all.contributing, few.contributing, "{mode:?}");
        // The background is the lowest value: all of it matters to minip.
        if !matches!(mode, Mode::Minip(_)) {
            assert!(
                few.samples * 2 < all.samples,
                "{mode:?}: {} of {}",
                few.samples,
                all.samples
            );
        }
    }
}
