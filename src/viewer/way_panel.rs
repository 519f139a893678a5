//! HOW a picture is drawn: technique, method, sampler and what else two pictures of a comparison may differ in.

use eframe::egui::{DragValue, Grid, Slider, Ui};

use crate::mode::Mode;
use crate::octree::BLOCKS;
use crate::render::{BackendChoice, MethodChoice, SliceCount};
use crate::sample::{Classification, Gradients, Sampler};
use crate::skip::{HalfCut, METHODS, Skip, SlabCount};

use super::look::Way;
use super::rows::{choice, row};

/// The rows of one way.
pub(super) fn show(ui: &mut Ui, salt: &str, way: &mut Way, mode: &Mode) {
    Grid::new(("way", salt)).num_columns(2).show(ui, |ui| {
        technique(ui, &mut way.slices);
        if way.slices.is_none() {
            method(ui, way);
        }
        let samplers = Sampler::ALL
            .iter()
            .map(|&s| (Some(s), s.name().to_owned(), sampler_tip(s).to_owned()));
        let suited = (
            None,
            "as suits".to_owned(),
            "hardware on a hardware adapter, else exact".to_owned(),
        );
        let shown = way.sampler.map_or("as suits", Sampler::name);
        choice(
            ui,
            ("sampler", "sampler", "HOW one sample is taken"),
            &mut way.sampler,
            shown,
            [suited].into_iter().chain(samplers),
        );
        if mode.takes_table() {
            let words = (
                "classification",
                "classified",
                "when samples get their colour",
            );
            let told = [Classification::name, classification_tip];
            named(
                ui,
                words,
                &mut way.classification,
                Classification::ALL,
                told,
            );
        }
        if mode.takes_gradients() {
            let words = (
                "gradients",
                "gradients",
                "where the gradients that light is reflected by come from",
            );
            let told = [Gradients::name, gradients_tip];
            named(ui, words, &mut way.gradients, Gradients::ALL, told);
        }
        row(
            ui,
            "step",
            "distance of samples in voxels of the smallest spacing",
            |ui| {
                ui.add(
                    DragValue::new(&mut way.step_voxels)
                        .range(0.05..=8.0)
                        .speed(0.01)
                        .max_decimals(4),
                )
            },
        );
        row(
            ui,
            "stop at",
            "opacity at which a ray stops; 1: never",
            |ui| ui.add(Slider::new(&mut way.ert, 0.5..=1.0).max_decimals(3)),
        );
        let words = ("backend", "drawn by", "what draws");
        let told = [BackendChoice::name, backend_tip];
        named(ui, words, &mut way.backend, BackendChoice::ALL, told);
    });
}

/// A choice among all there are, each by its name.
fn named<T: Copy + PartialEq>(
    ui: &mut Ui,
    words: (&str, &str, &str),
    value: &mut T,
    all: &[T],
    [name, tip]: [fn(T) -> &'static str; 2],
) {
    let shown = name(*value);
    let all = all
        .iter()
        .map(|&one| (one, name(one).to_owned(), tip(one).to_owned()));
    choice(ui, words, value, shown, all);
}

/// Rays or slices.
fn technique(ui: &mut Ui, slices: &mut Option<SliceCount>) {
    let all = [
        (None, "rays", "rays through the pixels, which skip"),
        (Some(SliceCount::PerVoxel), "slices, one per voxel", SLICES),
        (
            Some(
                slices
                    .filter(|s| *s != SliceCount::PerVoxel)
                    .unwrap_or(SliceCount::Exactly(106)),
            ),
            "slices, so many",
            SLICES,
        ),
    ];
    let shown = match slices {
        None => "rays",
        Some(SliceCount::PerVoxel) => "slices, one per voxel",
        Some(SliceCount::Exactly(_)) => "slices, so many",
    };
    let all = all.map(|(one, name, tip)| (one, name.to_owned(), tip.to_owned()));
    choice(
        ui,
        ("technique", "drawn as", "what makes the picture"),
        slices,
        shown,
        all,
    );
    if let Some(SliceCount::Exactly(count)) = slices {
        row(
            ui,
            "slices",
            "how many lie between the nearest and the farthest corner",
            |ui| ui.add(DragValue::new(count).range(1..=4096)),
        );
    }
}

const SLICES: &str = "polygons across the view, blended by the rasteriser: on a gpu, in emission-absorption, grey, mip and minip";

/// WHERE samples are taken.
fn method(ui: &mut Ui, way: &mut Way) {
    let auto =
        "the method, blocks and cuts that promise the least time for this picture on this adapter";
    let methods = METHODS.iter().map(|m| {
        let tip = format!("{}; {}", m.summary, m.known_failure);
        (MethodChoice::Only(m.skip), m.name.to_owned(), tip)
    });
    let methods = [(MethodChoice::Auto, "auto".to_owned(), auto.to_owned())]
        .into_iter()
        .chain(methods);
    let shown = way.method.name();
    choice(
        ui,
        ("method", "skip by", "WHERE samples are taken"),
        &mut way.method,
        shown,
        methods,
    );
    let reads_blocks = matches!(way.method, MethodChoice::Only(skip) if skip.reads_blocks());
    if reads_blocks {
        let blocks = BLOCKS.map(|b| {
            (
                b,
                format!("{b} voxels"),
                format!("leaf blocks of {b} x {b} x {b} voxels"),
            )
        });
        let shown = format!("{} voxels", way.block);
        choice(
            ui,
            ("block", "blocks", "edge of the octree's leaf blocks"),
            &mut way.block,
            &shown,
            blocks,
        );
    }
    if way.method == MethodChoice::Only(Skip::HalfSplit) {
        let halves = HalfCut::ALL.iter().map(|&h| {
            (
                h,
                h.name().to_owned(),
                String::from("where the volume is cut in two"),
            )
        });
        let shown = way.cuts.half.name();
        choice(
            ui,
            ("half", "cut", "where half-split cuts"),
            &mut way.cuts.half,
            shown,
            halves,
        );
    }
    if way.method == MethodChoice::Only(Skip::KCuts) {
        let counts = [SlabCount::Auto, SlabCount::Middle]
            .into_iter()
            .chain([2, 3, 4, 6, 8].map(SlabCount::AtMost));
        let counts = counts.map(|c| {
            (
                c,
                c.to_string(),
                String::from("slabs at most, as many as pay, or two halves"),
            )
        });
        let shown = way.cuts.slabs.to_string();
        choice(
            ui,
            ("slabs", "cuts", "into how many slabs k-cuts cuts"),
            &mut way.cuts.slabs,
            &shown,
            counts,
        );
    }
}

fn classification_tip(classification: Classification) -> &'static str {
    match classification {
        Classification::Post => "values are interpolated and then looked up",
        Classification::Pre => {
            "voxels are looked up and their colours interpolated: thin layers are lost"
        }
        Classification::PreIntegrated => {
            "all values between two samples count: thin layers show at long steps too"
        }
    }
}

fn gradients_tip(gradients: Gradients) -> &'static str {
    match gradients {
        Gradients::Fly => "central differences wherever one is asked for",
        Gradients::Full => "a volume of gradients, one per voxel",
        Gradients::Half => "a volume of gradients, one per two voxels an edge",
        Gradients::Quarter => "a volume of gradients, one per four voxels an edge",
    }
}

fn sampler_tip(sampler: Sampler) -> &'static str {
    match sampler {
        Sampler::Hardware => "the adapter's trilinear filter",
        Sampler::Exact => "eight loads and f32 interpolation",
        Sampler::Tricubic => "64 voxels, smooth to the second derivative, by the adapter's filter",
        Sampler::TricubicExact => "64 voxels, smooth to the second derivative, in f32",
        Sampler::Nearest => "the voxel that the sample lies in",
    }
}

fn backend_tip(backend: BackendChoice) -> &'static str {
    match backend {
        BackendChoice::Auto => "a hardware GPU if there is one, else the CPU, else a software GPU",
        BackendChoice::Gpu => "the best adapter there is, hardware or software",
        BackendChoice::Cpu => "the processor, with SIMD",
        BackendChoice::Reference => "the processor in double precision: slow",
    }
}
