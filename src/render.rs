//! The [`Renderer`]: one volume, one transfer function, and pictures of them by any choice of skip, sample and mode.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::Arc;
use std::time::Instant;

use crate::camera::Camera;
use crate::error::{Error, Result};
use crate::mode::Mode;
use crate::octree::{Accelerator, Occupancy};
use crate::reference;
use crate::sample::Sampler;
use crate::scene::{CountedPicture, Picture, Progress, Scene};
use crate::skip::{Plan, Skip};
use crate::transfer::{Domain, Table, TransferFunction};
use crate::volume::{Volume, statistics};

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
    /// Smallest and largest stored number of the volume, once asked for.
    stored_range: Option<[f64; 2]>,
    /// Leaves and trees by block size, with the milliseconds that they took.
    accelerators: HashMap<usize, (Accelerator, f64)>,
    culled: Option<Culled>,
}

/// What stands for one table and block size.
#[derive(Debug)]
struct Culled {
    /// Block, mode, entries of the table, bits of the step.
    key: (usize, Mode, usize, u64),
    table: Table,
    occupancy: Occupancy,
    cull_ms: f64,
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
                adapter: "CPU, f64".to_owned(),
                driver: String::new(),
                is_software: true,
            },
            volume: None,
            transfer: None,
            stored_range: None,
            accelerators: HashMap::new(),
            culled: None,
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
        self.stored_range = None;
        self.accelerators.clear();
        self.culled = None;
        Ok(())
    }

    /// Takes another transfer function; structures are kept and culled again.
    pub fn set_transfer(&mut self, transfer: TransferFunction) {
        self.transfer = Some(transfer);
        self.culled = None;
    }

    /// Builds what a frame with these settings needs. Times are of the build of what stands, now or earlier.
    ///
    /// # Errors
    /// [`Error::Setting`] for settings out of range or where volume or transfer function were not set.
    pub fn prepare(&mut self, settings: &Settings) -> Result<Preparation> {
        let (Some(volume), Some(transfer)) = (&self.volume, &self.transfer) else {
            return Err(Error::setting(
                "renderer",
                "volume and transfer function must be set before a picture is drawn",
            ));
        };
        let range = *self
            .stored_range
            .get_or_insert_with(|| statistics::stored_range(volume));
        let (accelerator, preprocess_ms) = match self.accelerators.entry(settings.block) {
            Entry::Occupied(entry) => entry.into_mut(),
            Entry::Vacant(entry) => {
                let start = Instant::now();
                let built = Accelerator::build(volume, settings.block, Sampler::Exact.apron())?;
                built.whole();
                entry.insert((built, milliseconds(start)))
            }
        };
        let key = (
            settings.block,
            settings.mode,
            settings.table_entries,
            settings.step_voxels.to_bits(),
        );
        if self.culled.as_ref().is_none_or(|c| c.key != key) {
            let start = Instant::now();
            let domain = Domain::new(volume, range, settings.table_entries)?;
            let table = transfer.bake(&domain, settings.step_voxels);
            let occupancy = accelerator.cull(&table, settings.mode);
            self.culled = Some(Culled {
                key,
                table,
                occupancy,
                cull_ms: milliseconds(start),
            });
        }
        Ok(match settings.skip {
            Skip::Box => Preparation::default(),
            Skip::Hull | Skip::HalfSplit => Preparation {
                preprocess_ms: *preprocess_ms,
                cull_ms: self.culled.as_ref().map_or(0.0, |c| c.cull_ms),
                structure_bytes: accelerator.structure_bytes() as u64,
            },
        })
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
        self.prepare(settings)?;
        let start = Instant::now();
        let picture = self.count(settings)?.picture;
        let frame_ms = milliseconds(start);
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
        self.prepare(settings)?;
        let (Some(volume), Some(culled)) = (&self.volume, &self.culled) else {
            unreachable!("prepare has seen to both");
        };
        let frame = settings
            .camera
            .ray_frame(volume, settings.size, settings.step_voxels)?;
        let scene = Scene {
            volume,
            table: &culled.table,
            frame: &frame,
            sampler: Sampler::Exact,
            mode: settings.mode,
            ert: settings.ert,
        };
        let plan = Plan::new(settings.skip, &culled.occupancy, settings.camera.forward());
        reference::render(&scene, &plan, &Progress::default())
    }
}

fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}
