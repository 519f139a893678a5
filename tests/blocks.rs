//! The smallest and the largest leaf blocks there are: every lossless method draws box's picture in them too.

use std::sync::Arc;

use hollowcast::measure::verify::{Case, Verifier, View};
use hollowcast::render::{BackendChoice, Renderer};
use hollowcast::sample::Sampler;
use hollowcast::skip::{Cuts, HalfCut, SlabCount};
use hollowcast::transfer::TransferFunction;
use hollowcast::volume::{Statistics, phantom};

fn check(backend: BackendChoice) {
    for spec in [
        "pot:70x66x69",
        "noise:19x33x6",
        "thin:131x40x40",
        "full:1x7x9",
    ] {
        let volume = Arc::new(phantom::from_spec(spec).unwrap());
        let table = "ramp:120:255:0.2";
        let transfer = TransferFunction::from_spec(table, &Statistics::of(&volume)).unwrap();
        let mut renderer = Renderer::new(backend).unwrap();
        renderer.set_volume(Arc::clone(&volume)).unwrap();
        renderer.set_transfer(transfer.clone());
        for cuts in [
            Cuts::default(),
            Cuts {
                half: if backend == BackendChoice::Cpu {
                    HalfCut::Middle
                } else {
                    HalfCut::Best
                },
                slabs: SlabCount::AtMost(5),
            },
        ] {
            let mut verifier = Verifier::new(&mut renderer, &volume, &transfer, cuts, [48, 40]);
            for view in View::ALL {
                for block in [2, 64] {
                    let case = Case {
                        view,
                        is_parallel: block == 64,
                        block,
                        step_edges: 0.011,
                        ert: 0.98,
                        sampler: Sampler::Exact,
                    };
                    for outcome in verifier.run(&case).unwrap() {
                        assert_eq!(outcome.differing_pixels, 0, "{spec}: {case:?}: {outcome:?}");
                    }
                }
            }
        }
    }
}

#[test]
fn blocks_of_2_and_64_on_the_cpu() {
    check(BackendChoice::Cpu);
}

#[test]
fn blocks_of_2_and_64_on_the_gpu() {
    check(BackendChoice::Gpu);
}

#[test]
fn blocks_of_2_and_64_by_the_reference() {
    check(BackendChoice::Reference);
}
