//! The [`Renderer`]: owns the backend, the resident volume and the structures, and draws pictures.

mod auto;
mod backend;
mod block_words;
pub(crate) mod cache;
mod classes;
mod gpu;
mod self_check;
mod settings;
mod slices;
mod structures;
mod trace;

use std::sync::Arc;
use std::time::Instant;

use crate::cpu::{self, CpuPlan};
use crate::error::{Error, Result};
use crate::mode::{DepthCue, Mode};
use crate::octree::Cells;
use crate::reference;
use crate::sample::{Classification, Sampler};
use crate::scene::{CountedPicture, Picture, Progress, Scene};
use crate::skip::{Plan, Skip};
use crate::transfer::{Domain, Table, TransferFunction};
use crate::volume::{Volume, statistics};

use self::auto::Chooser;
use self::classes::Classes;
use self::gpu::{GpuBackend, Job, JobClasses};
use self::slices::Slices;
use self::structures::Structures;

pub use self::auto::{BLOCKS, Choice, DEFAULT_BLOCK, MethodChoice};
pub use self::backend::{BackendChoice, BackendInfo};
#[cfg(feature = "viewer")]
pub(crate) use self::cache::file as cache_file;
pub use self::gpu::Targets;
pub use self::settings::Settings;
pub use self::slices::SliceCount;
pub(crate) use classes::check as check_classification;

/// What it took to build the structures that a frame needs.
#[derive(Debug, Clone, Copy, Default)]
pub struct Preparation {
    /// Building leaves, trees and a volume of gradients, in ms; structures that were kept report the time of their build.
    pub preprocess_ms: f64,
    /// Culling them for the table and making faces, in ms.
    pub cull_ms: f64,
    /// Bytes of trees, occupancy, vertex buffers and a volume of gradients.
    pub structure_bytes: u64,
}

/// What one frame took after the structures stood.
#[derive(Debug, Clone, Copy, Default)]
pub struct FrameTimes {
    /// Rasterising bounds, in ms.
    pub raster_ms: f64,
    /// Casting rays, in ms.
    pub cast_ms: f64,
    /// All of it, wall time, read-back excluded, in ms.
    pub frame_ms: f64,
    /// Both passes by the adapter's own clock, in ms; `None` where it tells no time.
    pub gpu_ms: Option<f64>,
}

/// A picture and what it took.
#[derive(Debug, Clone)]
pub struct Rendered {
    /// The picture.
    pub picture: Picture,
    /// Times of the frame.
    pub times: FrameTimes,
    /// Copying the picture from the adapter, in ms.
    pub read_back_ms: f64,
    /// The sampler that was used.
    pub sampler: Sampler,
}

/// Draws pictures of one volume after another.
pub struct Renderer {
    backend: Backend,
    info: BackendInfo,
    volume: Option<Arc<Volume>>,
    structures: Structures,
    transfer: Option<TransferFunction>,
    /// The table baked last, with what it was baked for.
    table: Option<(TableKey, Arc<Table>)>,
    classes: Classes,
    progress: Arc<Progress>,
    /// Methods that failed this adapter's self-check: drawn by box instead.
    withdrawn: Vec<Skip>,
    chooser: Chooser,
}

enum Backend {
    Gpu(Box<GpuBackend>),
    /// With the picture drawn last, whose memory is used again.
    Cpu(Box<Picture>),
    Reference,
}

/// A picture about to be drawn.
enum Drawing<'a> {
    Gpu(&'a mut GpuBackend, Job<'a>),
    Cpu(&'a mut Picture, Scene<'a>, &'a CpuPlan, &'a Progress),
    Reference(Scene<'a>, Plan<'a>, &'a Progress),
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct TableKey {
    entries: usize,
    step_voxels: f64,
}

impl Renderer {
    /// What draws the pictures.
    pub fn info(&self) -> &BackendInfo {
        &self.info
    }

    /// Whether this backend has a method.
    pub fn has(&self, skip: Skip) -> bool {
        skip.check_backend(self.info.backend).is_ok()
    }

    /// Whether what a method keeps of the volume's cells can be bound. That of blocks can, in some size.
    fn holds(&self, skip: Skip) -> bool {
        match (&self.backend, &self.volume) {
            (Backend::Gpu(gpu), Some(volume)) if skip.reads_cells() => {
                let blocks: usize = volume.dims.iter().map(|n| n.div_ceil(2)).product();
                let most = gpu.gpu().device.limits().max_storage_buffer_binding_size;
                Cells::bytes_of(volume.dims) + blocks as u64 <= most
            }
            _ => true,
        }
    }

    /// Whether this backend has a mode.
    pub fn has_mode(&self, mode: &Mode) -> bool {
        mode.check_backend(self.info.backend).is_ok()
    }

    /// Methods that failed the self-check on this adapter; box is drawn in their place.
    pub fn withdrawn(&self) -> &[Skip] {
        &self.withdrawn
    }

    /// How far the picture in work is, where the backend tells rows, and the way to stop it from another thread.
    pub fn progress(&self) -> Arc<Progress> {
        Arc::clone(&self.progress)
    }

    /// Takes a volume in place of the last; its structures are built at first use.
    ///
    /// # Errors
    /// [`Error::Limit`] where it exceeds what the adapter takes.
    pub fn set_volume(&mut self, volume: Arc<Volume>) -> Result<()> {
        self.forget_volume();
        if let Backend::Gpu(backend) = &mut self.backend {
            backend.set_volume(&volume)?;
        }
        self.structures.set_range(statistics::stored_range(&volume));
        self.volume = Some(volume);
        Ok(())
    }

    /// Drops all that was built for the volume: the next frame builds what it needs anew, as if it were the first.
    pub fn drop_structures(&mut self) {
        self.structures.clear();
        if let Backend::Gpu(backend) = &mut self.backend {
            backend.drop_gradients();
            backend.drop_bricks();
        }
    }

    fn forget_volume(&mut self) {
        self.structures.clear();
        self.chooser.forget_volume();
        self.table = None;
        self.volume = None;
    }

    /// Takes a transfer function in place of the last. Trees are kept: only culling follows.
    pub fn set_transfer(&mut self, transfer: TransferFunction) {
        if self.transfer.as_ref() != Some(&transfer) {
            self.transfer = Some(transfer);
            self.table = None;
            self.chooser.forget_transfer();
        }
    }

    /// The sampler that these settings lead to.
    pub fn sampler(&self, settings: &Settings) -> Sampler {
        settings.sampler.unwrap_or_else(|| match &self.backend {
            Backend::Gpu(backend) => backend.default_sampler(),
            Backend::Cpu(_) | Backend::Reference => Sampler::Exact,
        })
    }

    /// Builds what a frame needs and tells what that took.
    ///
    /// # Errors
    /// [`Error::Setting`] for settings out of range, [`Error::Gpu`] where memory ran out.
    pub fn prepare(&mut self, settings: &Settings) -> Result<Preparation> {
        self.with_drawing(settings, |drawing, preparation| {
            let mut preparation = *preparation;
            if let Drawing::Gpu(backend, job) = drawing {
                preparation.preprocess_ms += backend.make_gradients(job)?;
                let start = Instant::now();
                backend.prepare(job)?;
                preparation.cull_ms += ms_since(start);
                preparation.structure_bytes += backend.structure_bytes(job);
            }
            Ok(preparation)
        })
    }

    /// Draws a frame and leaves it on the adapter: what is timed.
    ///
    /// # Errors
    /// As [`Self::prepare`]; [`Error::Cancelled`].
    pub fn draw(&mut self, settings: &Settings) -> Result<FrameTimes> {
        self.with_drawing(settings, |drawing, _| match drawing {
            Drawing::Gpu(backend, job) => backend.draw(job),
            Drawing::Cpu(picture, scene, plan, progress) => {
                draw_cpu(picture, scene, plan, progress)
            }
            Drawing::Reference(scene, plan, progress) => {
                Ok(draw_reference(scene, plan, progress)?.1)
            }
        })
    }

    /// Draws a picture.
    ///
    /// # Errors
    /// As [`Self::draw`].
    pub fn render(&mut self, settings: &Settings) -> Result<Rendered> {
        let sampler = self.sampler(settings);
        self.with_drawing(settings, |drawing, _| {
            let (picture, times, read_back_ms) = match drawing {
                Drawing::Gpu(backend, job) => backend.render(job)?,
                Drawing::Cpu(picture, scene, plan, progress) => {
                    let times = draw_cpu(picture, scene, plan, progress)?;
                    (picture.clone(), times, 0.0)
                }
                Drawing::Reference(scene, plan, progress) => {
                    let (counted, times) = draw_reference(scene, plan, progress)?;
                    (counted.picture, times, 0.0)
                }
            };
            Ok(Rendered {
                picture,
                times,
                read_back_ms,
                sampler,
            })
        })
    }

    /// Draws a picture over targets of the caller's, on whose device this renderer must have been made
    /// ([`Self::with_device`]). Depth takes the marcher that counts: a little slower, and the same picture.
    ///
    /// # Errors
    /// As [`Self::draw`]; [`Error::Setting`] where this renderer does not draw on a GPU.
    pub fn render_to(&mut self, settings: &Settings, targets: &Targets) -> Result<FrameTimes> {
        self.with_drawing(settings, |drawing, _| match drawing {
            Drawing::Gpu(_, job) if job.slices.is_some() => Err(Error::setting(
                "renderer",
                "slices are drawn as pictures of their own, not over a caller's",
            )),
            Drawing::Gpu(backend, job) => backend.render_to(job, targets),
            Drawing::Cpu(..) | Drawing::Reference(..) => Err(Error::setting(
                "backend",
                "only gpu draws into a texture view",
            )),
        })
    }

    /// Draws a picture with counters: slower, and the same bits.
    ///
    /// # Errors
    /// As [`Self::draw`].
    pub fn count(&mut self, settings: &Settings) -> Result<CountedPicture> {
        self.with_drawing(settings, |drawing, _| match drawing {
            Drawing::Gpu(backend, job) => backend.count(job),
            Drawing::Cpu(_, scene, plan, progress) => {
                cpu::render_counted(scene, plan, progress.cancelled())
            }
            Drawing::Reference(scene, plan, progress) => reference::render(scene, plan, progress),
        })
    }

    /// Makes table, rays and structures for these settings and hands them to `work`.
    fn with_drawing<T>(
        &mut self,
        settings: &Settings,
        work: impl FnOnce(&mut Drawing, &Preparation) -> Result<T>,
    ) -> Result<T> {
        let fallback;
        let settings = if self.withdrawn.contains(&settings.skip) {
            fallback = Settings {
                skip: Skip::Box,
                ..*settings
            };
            &fallback
        } else {
            settings
        };
        let volume = self
            .volume
            .as_ref()
            .ok_or_else(|| Error::setting("volume", "none was set"))?;
        let volume = Arc::clone(volume);
        settings.skip.check_backend(self.info.backend)?;
        settings.mode.check_backend(self.info.backend)?;
        settings.mode.check()?;
        classes::check(settings, self.info.backend)?;
        DepthCue::check(settings.depth_cue, &settings.mode, self.info.backend)?;
        if settings.skip == Skip::Adaptive && !settings.mode.takes_table() {
            let reason = format!(
                "adaptive follows the transfer function, of which {} makes no use",
                settings.mode.name()
            );
            return Err(Error::setting("method", reason));
        }
        let slices = match settings.slices {
            Some(count) => {
                slices::check(settings, self.info.backend)?;
                let (camera, clipping) = (&settings.camera, &settings.clipping);
                Some(Slices::new(count, camera, volume.extent(), clipping))
            }
            None => None,
        };
        self.learn_cut_cost(settings)?;
        let sliced;
        let settings = if let Some(slices) = &slices {
            sliced = Settings {
                step_voxels: slices.distance,
                ..*settings
            };
            &sliced
        } else {
            settings
        };
        let sampler = self.sampler(settings);
        let table = self.table(settings, &volume)?;
        let pairs = self
            .classes
            .pairs(settings, &table, self.structures.range());
        // What says where samples show anything.
        let shown = pairs.as_ref().map_or(&table, |p| p.content.nodes());
        let frame = settings.ray_frame(&volume)?;
        let scene = settings.scene(&volume, &table, &frame, sampler);
        self.progress.restart();
        match &mut self.backend {
            Backend::Gpu(backend) => {
                let [low, high] = self.structures.range();
                let (needs, mut preparation) =
                    self.structures.gpu_needs(settings, &scene, shown)?;
                preparation.cull_ms += pairs.as_ref().map_or(0.0, |p| p.ms);
                let classes = match (&pairs, settings.classification) {
                    (Some(p), _) => JobClasses::PreIntegrated(p.id, &p.content),
                    (None, Classification::Pre) => JobClasses::Pre(&table),
                    (None, _) => JobClasses::Post,
                };
                let job = Job {
                    scene: Scene {
                        table: shown,
                        ..scene
                    },
                    classes,
                    skip: settings.skip,
                    camera: &settings.camera,
                    parts: needs.parts,
                    masks: needs.masks,
                    blocks: needs.blocks,
                    bricks: needs.bricks,
                    block: settings.block,
                    stored_span: high - low,
                    active: &needs.active,
                    slices,
                };
                work(&mut Drawing::Gpu(backend, job), &preparation)
            }
            Backend::Cpu(picture) => {
                let (plan, preparation) = self.structures.cpu_plan(settings, &scene, &table)?;
                work(
                    &mut Drawing::Cpu(picture, scene, plan, &self.progress),
                    &preparation,
                )
            }
            Backend::Reference => {
                let (plan, preparation) = self.structures.plan(settings, &scene, shown)?;
                work(
                    &mut Drawing::Reference(scene, plan, &self.progress),
                    &preparation,
                )
            }
        }
    }

    fn table(&mut self, settings: &Settings, volume: &Volume) -> Result<Arc<Table>> {
        let key = TableKey {
            entries: settings.table_entries,
            step_voxels: settings.step_voxels,
        };
        if let Some((kept, table)) = &self.table
            && *kept == key
        {
            return Ok(Arc::clone(table));
        }
        let transfer = self
            .transfer
            .as_ref()
            .ok_or_else(|| Error::setting("tf", "no transfer function was set"))?;
        let domain = Domain::new(volume, self.structures.range(), key.entries)?;
        let table = Arc::new(transfer.bake(&domain, key.step_voxels));
        self.table = Some((key, Arc::clone(&table)));
        Ok(table)
    }
}

fn draw_cpu(
    picture: &mut Picture,
    scene: &Scene,
    plan: &CpuPlan,
    progress: &Progress,
) -> Result<FrameTimes> {
    let start = Instant::now();
    cpu::render_into(scene, plan, progress.cancelled(), picture)?;
    let frame_ms = ms_since(start);
    Ok(FrameTimes {
        raster_ms: 0.0,
        cast_ms: frame_ms,
        frame_ms,
        gpu_ms: None,
    })
}

fn draw_reference(
    scene: &Scene,
    plan: &Plan,
    progress: &Progress,
) -> Result<(CountedPicture, FrameTimes)> {
    let start = Instant::now();
    let counted = reference::render(scene, plan, progress)?;
    let frame_ms = ms_since(start);
    Ok((
        counted,
        FrameTimes {
            raster_ms: 0.0,
            cast_ms: frame_ms,
            frame_ms,
            gpu_ms: None,
        },
    ))
}

fn ms_since(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}
