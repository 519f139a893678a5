//! The frames that tell what work costs on an adapter: small phantoms in small pictures, about a second of them for every
//! kind of work.

use std::sync::Arc;

use super::cost::kept_or;
use super::{Calibration, Choice};
use crate::camera::Orbit;
use crate::error::Result;
use crate::mode::{MODES, Mode};
use crate::render::{Renderer, Settings, cache};
use crate::sample::{Classification, Sampler};
use crate::skip::Skip;
use crate::transfer::{ControlPoint, TransferFunction};
use crate::volume::{Statistics, Volume, phantom};

/// What a calibration holds for besides the adapter: what a sample costs, and what a method makes of it, depends on these
/// more than on all that a scene has.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Kind {
    sampler: Sampler,
    classification: Classification,
    /// The name of the mode, whatever its parameters.
    mode: &'static str,
}

impl Kind {
    /// The kind of these settings' pictures, by the sampler that they lead to.
    pub(super) fn of(settings: &Settings, sampler: Sampler) -> Self {
        Self {
            sampler,
            classification: settings.classification,
            mode: settings.mode.name(),
        }
    }

    /// The mode as it suits a volume.
    fn mode_for(&self, volume: &Volume) -> Mode {
        let row = MODES.iter().find(|row| row.name == self.mode);
        (row.expect("it is a mode's name").suited_to)(&Statistics::of(volume))
    }

    fn words(&self) -> String {
        let (sampler, classification) = (self.sampler.name(), self.classification.name());
        format!("{sampler} {classification} {}", self.mode)
    }
}

/// Runs of every frame at most; the fastest counts, for nothing but disturbance makes one slower.
const ROUNDS: usize = 6;

/// Frames that have taken so long together, in ms, are not run again: what disturbs a moment disturbs long frames less.
const ENOUGH_MS: f64 = 10.0;

/// One view of a phantom.
struct Probe {
    phantom: &'static str,
    voxels: usize,
    pixels: u32,
    step_voxels: f64,
    block: usize,
    opacity: f64,
}

/// Frames that differ in everything that costs: pixels, samples, segments, faces, early termination.
const PROBES: &[Probe] = &[
    // Nothing is launched but by box.
    Probe {
        phantom: "empty",
        voxels: 32,
        pixels: 128,
        step_voxels: 1.0,
        block: 8,
        opacity: 0.3,
    },
    // Hardly a sample: rays and their steps are all that there is.
    Probe {
        phantom: "thin",
        voxels: 96,
        pixels: 128,
        step_voxels: 6.0,
        block: 4,
        opacity: 0.1,
    },
    Probe {
        phantom: "thin",
        voxels: 64,
        pixels: 160,
        step_voxels: 4.0,
        block: 16,
        opacity: 0.1,
    },
    Probe {
        phantom: "sphere",
        voxels: 64,
        pixels: 112,
        step_voxels: 0.5,
        block: 4,
        opacity: 0.05,
    },
    Probe {
        phantom: "sphere",
        voxels: 64,
        pixels: 64,
        step_voxels: 0.25,
        block: 16,
        opacity: 0.3,
    },
    Probe {
        phantom: "shells",
        voxels: 96,
        pixels: 80,
        step_voxels: 0.5,
        block: 4,
        opacity: 0.02,
    },
    Probe {
        phantom: "shells",
        voxels: 64,
        pixels: 112,
        step_voxels: 1.0,
        block: 8,
        opacity: 0.02,
    },
    Probe {
        phantom: "thin",
        voxels: 96,
        pixels: 96,
        step_voxels: 1.0,
        block: 4,
        opacity: 0.1,
    },
    Probe {
        phantom: "pot",
        voxels: 96,
        pixels: 128,
        step_voxels: 1.0,
        block: 8,
        opacity: 0.3,
    },
    Probe {
        phantom: "pot",
        voxels: 96,
        pixels: 64,
        step_voxels: 0.25,
        block: 4,
        opacity: 0.05,
    },
    Probe {
        phantom: "gyroid",
        voxels: 64,
        pixels: 80,
        step_voxels: 0.5,
        block: 4,
        opacity: 0.05,
    },
    Probe {
        phantom: "noise",
        voxels: 48,
        pixels: 64,
        step_voxels: 0.5,
        block: 8,
        opacity: 0.01,
    },
    Probe {
        phantom: "full",
        voxels: 48,
        pixels: 64,
        step_voxels: 0.5,
        block: 8,
        opacity: 0.01,
    },
    Probe {
        phantom: "full",
        voxels: 48,
        pixels: 128,
        step_voxels: 1.0,
        block: 16,
        opacity: 0.9,
    },
];

/// The adapter's calibration for a kind of work: as kept, or measured now.
///
/// # Errors
/// As [`Renderer::draw`].
pub(super) fn calibration(renderer: &mut Renderer, kind: &Kind) -> Result<Calibration> {
    let mut methods: Vec<Skip> = renderer.candidates(&[8]).iter().map(|c| c.skip).collect();
    methods.dedup();
    let names: Vec<&str> = methods.iter().map(|s| s.method().name).collect();
    let info = renderer.info();
    // A debug build has other times.
    let key = format!(
        "{} | {} | {}{} | {} | {}",
        info.backend,
        info.adapter,
        info.driver,
        if cfg!(debug_assertions) {
            " | debug"
        } else {
            ""
        },
        kind.words(),
        names.join(" "),
    );
    let path = cache::file("calibration.json");
    kept_or(path.as_deref(), &key, &methods, || {
        let (volume, transfer) = (renderer.volume.clone(), renderer.transfer.clone());
        let measured = measure(renderer, kind, &methods);
        // What was there before comes back, whatever happened.
        renderer.forget_volume();
        renderer.transfer = transfer;
        if let Some(volume) = volume {
            renderer.set_volume(volume)?;
        }
        measured
    })
}

fn measure(renderer: &mut Renderer, kind: &Kind, methods: &[Skip]) -> Result<Calibration> {
    let mut frames = vec![Vec::new(); methods.len()];
    for probe in PROBES {
        let volume = Arc::new(phantom::make(probe.phantom, [probe.voxels; 3])?);
        let extent = volume.extent();
        let mode = kind.mode_for(&volume);
        renderer.set_volume(volume)?;
        renderer.set_transfer(probe.transfer()?);
        let settings = Settings {
            sampler: Some(kind.sampler),
            classification: kind.classification,
            mode,
            step_voxels: probe.step_voxels,
            size: [probe.pixels; 2],
            table_entries: 256,
            ..Choice::BOX.in_settings(&Settings::new(Orbit::default().camera(extent)))
        };
        let mut choices = renderer.candidates(&[probe.block]);
        choices.dedup_by_key(|c| c.skip);
        let works = renderer.works(&settings, &choices)?;
        let mut least = vec![f64::INFINITY; choices.len()];
        let mut taken = vec![0.0; choices.len()];
        for round in 0..=ROUNDS {
            for (i, choice) in choices.iter().enumerate() {
                if taken[i] > ENOUGH_MS {
                    continue;
                }
                let ms = renderer.draw(&choice.in_settings(&settings))?.frame_ms;
                // The first run warms up.
                if round > 0 {
                    least[i] = f64::min(least[i], ms);
                    taken[i] += ms;
                }
            }
        }
        for ((choice, work), ms) in choices.iter().zip(works).zip(least) {
            let place = methods.iter().position(|s| *s == choice.skip);
            if let (Some(place), Some(work)) = (place, work) {
                tracing::debug!("probe {}: {:?} took {ms:.3} ms", choice.words(), work);
                frames[place].push((work, ms));
            }
        }
    }
    Ok(Calibration::fitted(methods, &frames))
}

impl Probe {
    fn transfer(&self) -> Result<TransferFunction> {
        let point = |value, opacity| ControlPoint {
            value,
            opacity,
            color: [0.9, 0.6, 0.4],
        };
        TransferFunction::new(vec![point(40.0, 0.0), point(255.0, self.opacity)], 1.0)
    }
}
