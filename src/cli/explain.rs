//! What a picture took and how far off it can be, in plain words: `render --explain`.

use hollowcast::Result;
use hollowcast::measure::bounds::{ErtBound, StepEstimate, ert_bound, step_estimate};
use hollowcast::render::{Choice, Preparation, Renderer, Settings};
use hollowcast::sample::Sampler;
use hollowcast::scene::Counters;
use hollowcast::skip::Skip;
use hollowcast::transfer::TransferFunction;
use serde_json::{Value, json};

use super::report;

/// All that is told.
pub(super) struct Explained {
    settings: Settings,
    sampler: Sampler,
    structure_bytes: u64,
    counters: Counters,
    ert: Option<ErtBound>,
    step: Option<StepEstimate>,
}

impl Explained {
    /// Draws once more with counters, and smaller pictures to estimate the step's error by.
    pub(super) fn of(
        renderer: &mut Renderer,
        transfer: &TransferFunction,
        settings: &Settings,
        preparation: &Preparation,
    ) -> Result<Self> {
        Ok(Self {
            settings: *settings,
            sampler: renderer.sampler(settings),
            structure_bytes: preparation.structure_bytes,
            counters: renderer.count(settings)?.counters,
            ert: ert_bound(transfer, settings),
            step: step_estimate(renderer, settings)?,
        })
    }

    pub(super) fn json(&self) -> Value {
        json!({
            "samples": self.counters.samples,
            "contributing_samples": self.counters.contributing,
            "skip_steps": self.counters.skip_steps,
            "ert_bound": self.ert,
            "step_estimate": self.step,
        })
    }

    pub(super) fn words(&self) -> String {
        let Self {
            settings,
            counters,
            step,
            ..
        } = self;
        let [width, height] = settings.size;
        let pixels = f64::from(width) * f64::from(height);
        let per_pixel = |n: u64| n as f64 / pixels;
        let method = settings.skip.method();
        let how = match settings.slices {
            Some(count) => format!("renderer: slices ({count}), which skip nothing"),
            None => format!(
                "method: {}: {}",
                Choice::of(settings).words(),
                method.summary
            ),
        };
        let mut lines = vec![String::new(), how];
        if settings.skip != Skip::Box {
            lines.push(format!(
                "  its structures take {} KiB{}",
                self.structure_bytes.div_ceil(1024),
                if method.lossless {
                    ", and it changes no bit of the picture"
                } else {
                    "; it is lossy: the picture is not box's"
                },
            ));
        }
        let used = counters.contributing as f64 / counters.samples.max(1) as f64;
        lines.push(format!(
            "work: {:.1} samples a pixel, of which {:.0} % add something; {:.1} steps a pixel to find them",
            per_pixel(counters.samples),
            100.0 * used,
            per_pixel(counters.skip_steps),
        ));
        lines.push(format!(
            "sampler: {}, classification {}, in mode {}",
            self.sampler.name(),
            settings.classification.name(),
            settings.mode.name()
        ));
        lines.push(match &self.ert {
            Some(bound) if bound.remaining == 0.0 => "early termination: off, no error".to_owned(),
            Some(bound) => format!(
                "early termination at an opacity of {}: no channel is off by more than {:.4} (proven: what is left, {:.4}, times the largest radiance, {:.3})",
                report::decimal(settings.ert),
                bound.error,
                bound.remaining,
                bound.radiance,
            ),
            None => "early termination: without error in this mode".to_owned(),
        });
        let length = match settings.slices {
            Some(_) => "distance of the slices".to_owned(),
            None => format!("step of {} voxels", settings.step_voxels),
        };
        lines.push(match step {
            Some(step) => format!(
                "{length}: off by about {:.4} where it is worst, {:.5} on the root of the mean square (estimated: twice what half of it changes, {}x{} pixels, no early termination)",
                step.max_abs, step.rms, step.size[0], step.size[1],
            ),
            None => format!("{length}: not estimated where they are one per voxel"),
        });
        lines.join("\n") + "\n"
    }
}
