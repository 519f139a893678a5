//! Clip planes in every method and backend. These tests fail, not skip, where there is no adapter.

mod support;

use glam::DVec3;
use hollowcast::lattice::Clipping;
use hollowcast::measure::metrics::metrics;
use hollowcast::measure::verify::View;
use hollowcast::mode::{Mode, Window};
use hollowcast::render::{BackendChoice, Renderer, Settings};
use hollowcast::skip::{METHODS, Skip};
use hollowcast::volume::Statistics;
use support::{made, renderer, settings, show};

#[test]
fn clipping_is_the_same_for_every_method_and_backend() {
    let mut renderer = renderer();
    let mut cpu = Renderer::new(BackendChoice::Cpu).unwrap();
    let mut reference = Renderer::new(BackendChoice::Reference).unwrap();
    let volume = made("pot");
    let transfer = show([&mut *renderer, &mut cpu, &mut reference], &volume);
    let middle = volume.extent() * 0.5;
    let mut clipping = Clipping::NONE;
    for (normal, at) in [
        (DVec3::new(-1.0, 0.3, 0.2), middle),
        (DVec3::Z, middle * 0.5),
        (-DVec3::Z, middle * 1.6),
    ] {
        clipping.keep(normal, normal.dot(at)).unwrap();
    }
    let statistics = Statistics::of(&volume);
    let mean = Mode::Mean(Window::above_background(&statistics));
    for mode in [Mode::EmissionAbsorption, mean] {
        for view in View::ALL {
            let settings = Settings {
                clipping,
                ..settings(mode, view.camera(&volume, &transfer, false))
            };
            let truth = reference.render(&settings).unwrap().picture;
            for renderer in [&mut *renderer, &mut cpu, &mut reference] {
                let by_box = renderer.render(&Settings {
                    skip: Skip::Box,
                    ..settings
                });
                let by_box = by_box.unwrap().picture;
                let error = metrics([(&by_box, &truth)]);
                assert!(
                    error.psnr_db() >= 60.0,
                    "{} {view:?}: {} dB",
                    renderer.info().backend,
                    error.psnr_db()
                );
                for method in METHODS.iter().filter(|m| m.lossless) {
                    if !renderer.has(method.skip) {
                        continue;
                    }
                    let picture = renderer.render(&Settings {
                        skip: method.skip,
                        ..settings
                    });
                    assert_eq!(
                        picture.unwrap().picture.difference(&by_box).pixels,
                        0,
                        "{} {} {view:?}",
                        renderer.info().backend,
                        method.name
                    );
                }
            }
            let whole = Settings {
                clipping: Clipping::NONE,
                ..settings
            };
            let whole = reference.render(&whole).unwrap().picture;
            assert!(whole.difference(&truth).pixels > 0, "{view:?}");
        }
    }
}
