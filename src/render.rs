//! The [`Renderer`]: one volume, one transfer function, and pictures of them by any choice of skip, sample and mode.

use std::sync::Arc;

use crate::camera::Camera;
use crate::error::{Error, Result};
use crate::mode::Mode;
use crate::sample::Sampler;
use crate::scene::{CountedPicture, Picture};
use crate::skip::Skip;
use crate::transfer::TransferFunction;
use crate::volume::Volume;

/// Where pictures are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum BackendChoice {
    /// A hardware GPU if there is one, else the CPU.
    Auto,
    /// The first graphics adapter, a software one included.
    Gpu,
    /// The CPU, in f32.
    Cpu,
    /// The CPU, in f64: slow, and what the others are measured against.
    Reference,
}

impl BackendChoice {
    /// All choices.
    pub const ALL: &[Self] = &[Self::Auto, Self::Gpu, Self::Cpu, Self::Reference];

    /// The name used by flags and reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Gpu => "gpu",
            Self::Cpu => "cpu",
            Self::Reference => "reference",
        }
    }
}

/// Everything that decides a picture besides volume and transfer function.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// WHERE samples are taken.
    pub skip: Skip,
    /// HOW one sample is taken; `None`: the backend's default.
    pub sampler: Option<Sampler>,
    /// WHAT is done with the samples.
    pub mode: Mode,
    /// Edge of the leaf blocks in voxels: 4, 8, 16 or 32.
    pub block: usize,
    /// Distance of samples in voxels of the smallest spacing.
    pub step_voxels: f64,
    /// Accumulated opacity at which a ray stops; 1 or more: never.
    pub ert: f32,
    /// Width and height of the picture in pixels.
    pub size: [u32; 2],
    /// Where the picture is taken from, in local coordinates.
    pub camera: Camera,
    /// Entries of the table that the transfer function is baked into.
    pub table_entries: usize,
}

/// What a renderer runs on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BackendInfo {
    /// `gpu`, `cpu` or `reference`.
    pub backend: &'static str,
    /// The adapter's name.
    pub adapter: String,
    /// The driver's name and version; empty where there is none.
    pub driver: String,
    /// Whether the adapter is the processor in disguise.
    pub is_software: bool,
}

/// What was built before a frame could be drawn.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Preparation {
    /// Building leaves and trees.
    pub preprocess_ms: f64,
    /// Classifying and culling them for the table.
    pub cull_ms: f64,
    /// Memory of all that stands besides the volume.
    pub structure_bytes: u64,
}

/// What a frame cost.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FrameTimes {
    /// Rasterising (or otherwise finding) the segments.
    pub raster_ms: f64,
    /// Marching them.
    pub cast_ms: f64,
    /// The whole frame after the structures stand, read-back excluded.
    pub frame_ms: f64,
}

/// A picture and what it cost.
#[derive(Debug, Clone)]
pub struct Rendered {
    /// The picture.
    pub picture: Picture,
    /// Times of its frame.
    pub times: FrameTimes,
    /// Copying the picture to this side.
    pub read_back_ms: f64,
    /// The sampler that was used.
    pub sampler: Sampler,
}

/// Renders one volume.
#[derive(Debug)]
pub struct Renderer {
    info: BackendInfo,
    volume: Option<Arc<Volume>>,
    transfer: Option<TransferFunction>,
}

impl Renderer {
    /// A renderer on this backend.
    ///
    /// # Errors
    /// [`Error::Gpu`] where the backend was asked for by name and is not there.
    pub fn new(backend: BackendChoice) -> Result<Self> {
        if backend == BackendChoice::Gpu {
            return Err(Error::Gpu("no adapter found".to_owned()));
        }
        Ok(Self {
            info: BackendInfo {
                backend: "reference",
                adapter: "CPU in f64".to_owned(),
                driver: String::new(),
                is_software: true,
            },
            volume: None,
            transfer: None,
        })
    }

    /// What the renderer runs on.
    pub fn info(&self) -> &BackendInfo {
        &self.info
    }

    /// Takes another volume; all structures of the last one are dropped.
    ///
    /// # Errors
    /// [`Error::Limit`] where the backend cannot hold it.
    pub fn set_volume(&mut self, volume: Arc<Volume>) -> Result<()> {
        self.volume = Some(volume);
        Ok(())
    }

    /// Takes another transfer function; structures are kept and culled again.
    pub fn set_transfer(&mut self, transfer: TransferFunction) {
        self.transfer = Some(transfer);
    }

    /// Builds what a frame with these settings needs. Times are of the build of what stands, now or earlier.
    ///
    /// # Errors
    /// [`Error::Setting`] for settings out of range.
    pub fn prepare(&mut self, settings: &Settings) -> Result<Preparation> {
        self.count(settings).map(|_| Preparation::default())
    }

    /// Draws a frame and leaves the picture where it is.
    ///
    /// # Errors
    /// Like [`Self::prepare`]; [`Error::Gpu`] where drawing failed.
    pub fn draw(&mut self, settings: &Settings) -> Result<FrameTimes> {
        self.render(settings).map(|r| r.times)
    }

    /// Draws a frame and fetches the picture.
    ///
    /// # Errors
    /// Like [`Self::draw`].
    pub fn render(&mut self, settings: &Settings) -> Result<Rendered> {
        let start = std::time::Instant::now();
        let picture = self.count(settings)?.picture;
        let frame_ms = start.elapsed().as_secs_f64() * 1e3;
        Ok(Rendered {
            picture,
            times: FrameTimes {
                raster_ms: 0.0,
                cast_ms: frame_ms,
                frame_ms,
            },
            read_back_ms: 0.0,
            sampler: Sampler::Exact,
        })
    }

    /// Draws the picture once more, bit-identically, and counts the work.
    ///
    /// # Errors
    /// Like [`Self::draw`].
    pub fn count(&mut self, settings: &Settings) -> Result<CountedPicture> {
        placeholder::count(
            self.volume.as_deref().expect("a volume was set"),
            self.transfer.as_ref().expect("a transfer function was set"),
            settings,
        )
    }
}

/// Bounding-box casting in f64, until the backends are merged.
mod placeholder {
    use super::Settings;
    use crate::error::Result;
    use crate::mode::emission_absorption::State;
    use crate::sample::{cell, trilinear};
    use crate::scene::{CountedPicture, Counters, Picture};
    use crate::transfer::{Domain, TransferFunction, lookup};
    use crate::volume::Volume;
    use crate::with_voxels;

    pub(super) fn count(
        volume: &Volume,
        transfer: &TransferFunction,
        settings: &Settings,
    ) -> Result<CountedPicture> {
        let frame = settings
            .camera
            .ray_frame(volume, settings.size, settings.step_voxels)?;
        let stored: Vec<f64> =
            with_voxels!(&volume.voxels, v => v.iter().map(|&s| f64::from(s)).collect());
        let range = stored
            .iter()
            .fold([f64::MAX, f64::MIN], |r, &s| [r[0].min(s), r[1].max(s)]);
        let domain = Domain::new(volume, range, settings.table_entries)?;
        let table = transfer.bake(&domain, settings.step_voxels);
        let basis = frame.basis::<f64>();
        let mut counters = Counters::default();
        let (mut rgba, mut samples, mut first_hit) = (Vec::new(), Vec::new(), Vec::new());
        for y in 0..settings.size[1] {
            for x in 0..settings.size[0] {
                let ray = basis.ray(f64::from(x), f64::from(y));
                let mut state = State::<f64>::init();
                let (mut taken, mut first) = (0u32, f32::INFINITY);
                let mut k = ray.k_near;
                while k < ray.k_end && !state.done(f64::from(settings.ert)) {
                    let cells = ray.at(k).map(cell);
                    let voxel = |dx: usize, dy: usize, dz: usize| {
                        let i = [dx, dy, dz];
                        let at: [usize; 3] = std::array::from_fn(|a| {
                            (cells[a].0 as i64 + i[a] as i64).clamp(0, volume.dims[a] as i64 - 1)
                                as usize
                        });
                        stored[(at[2] * volume.dims[1] + at[1]) * volume.dims[0] + at[0]]
                    };
                    let corners =
                        [0, 1].map(|dz| [0, 1].map(|dy| [0, 1].map(|dx| voxel(dx, dy, dz))));
                    let value = trilinear(corners, cells.map(|c| c.1));
                    let (lower, f) = lookup(
                        domain.x_from_stored(value),
                        domain.entries as f64,
                        domain.snap(),
                    );
                    let entry = |i: usize| table.rgba()[i.min(domain.entries - 1)].map(f64::from);
                    let (a, b) = (entry(lower as usize), entry(lower as usize + 1));
                    let sample: [f64; 4] = std::array::from_fn(|c| a[c] + f * (b[c] - a[c]));
                    if sample.iter().any(|&c| c != 0.0) {
                        counters.contributing += 1;
                        first = first.min((ray.t_box + (k + 0.5) * settings.step_voxels) as f32);
                    }
                    state.add(sample);
                    taken += 1;
                    k += 1.0;
                }
                counters.samples += u64::from(taken);
                rgba.push(state.rgba.map(|c| c as f32));
                samples.push(taken);
                first_hit.push(first);
            }
        }
        counters.skip_steps = rgba.len() as u64;
        Ok(CountedPicture {
            picture: Picture {
                size: settings.size,
                rgba,
            },
            counters,
            samples,
            first_hit,
        })
    }
}
