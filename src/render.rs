//! The [`Renderer`]: owns the backend, the resident volume and the structures, and draws pictures.

mod auto;
mod cache;
mod gpu;
mod self_check;
mod structures;

use std::sync::Arc;
use std::time::Instant;

use crate::camera::Camera;
use crate::cpu::{self, CpuPlan};
use crate::error::{Error, Result};
use crate::gpu::{AdapterKind, Gpu};
use crate::lattice::{Clipping, RayFrame};
use crate::mode::Mode;
use crate::reference;
use crate::sample::Sampler;
use crate::scene::{CountedPicture, Picture, Progress, Scene};
use crate::skip::{Cuts, Plan, Skip};
use crate::transfer::{Domain, TABLE_SIZES, Table, TransferFunction};
use crate::volume::{Volume, statistics};

use self::auto::Chooser;
use self::gpu::{GpuBackend, Job};
use self::structures::Structures;

pub use self::auto::{BLOCKS, Choice, DEFAULT_BLOCK, MethodChoice};
pub use self::gpu::Targets;

#[cfg(feature = "viewer")]
pub(crate) use self::cache::file as cache_file;

/// Which backend to take.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum BackendChoice {
    /// A hardware GPU if there is one, else the CPU. A software adapter only when asked for by [`Self::Gpu`].
    Auto,
    /// The best adapter there is, hardware or software.
    Gpu,
    /// The CPU, with SIMD.
    Cpu,
    /// The CPU in f64: slow, and what the others are measured against.
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

/// Everything that is chosen for one picture besides the volume and its transfer function.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// WHERE samples are taken.
    pub skip: Skip,
    /// Where half-split and k-cuts cut; the others do not read it.
    pub cuts: Cuts,
    /// HOW; `None`: the backend's default.
    pub sampler: Option<Sampler>,
    /// WHAT is done with them.
    pub mode: Mode,
    /// Leaf block edge in voxels: a power of two, 2 to 64.
    pub block: usize,
    /// Distance of two samples in voxels of the smallest spacing.
    pub step_voxels: f64,
    /// Accumulated opacity at which a ray stops; 1 or more: never.
    pub ert: f32,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Where the picture is taken from.
    pub camera: Camera,
    /// What of the volume is not drawn.
    pub clipping: Clipping,
    /// Entries of the baked table: one of [`crate::transfer::TABLE_SIZES`].
    pub table_entries: usize,
}

impl Settings {
    /// The bounding box in emission and absorption, half a voxel a step, stopped at an opacity of 0.98, on 512x512 pixels
    /// and through a table of 4,096 entries: what the command takes where nothing is said, before `auto` chooses.
    pub fn new(camera: Camera) -> Self {
        Self {
            skip: Skip::Box,
            cuts: Cuts::default(),
            sampler: None,
            mode: Mode::EmissionAbsorption,
            block: DEFAULT_BLOCK,
            step_voxels: 0.5,
            ert: 0.98,
            size: [512; 2],
            camera,
            clipping: Clipping::NONE,
            table_entries: TABLE_SIZES[1],
        }
    }
}

/// What draws the pictures.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BackendInfo {
    /// `gpu` or `reference`.
    pub backend: &'static str,
    /// The adapter's name, or the processor's number of threads.
    pub adapter: String,
    /// Driver name and version.
    pub driver: String,
    /// Whether it runs on the CPU.
    pub is_software: bool,
}

/// What it took to build the structures that a frame needs.
#[derive(Debug, Clone, Copy, Default)]
pub struct Preparation {
    /// Building leaves and trees, in ms; structures that were kept report the time of their build.
    pub preprocess_ms: f64,
    /// Culling them for the table and making faces, in ms.
    pub cull_ms: f64,
    /// Bytes of trees, occupancy and vertex buffers.
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
    /// Opens a backend.
    ///
    /// # Errors
    /// [`Error::Gpu`] where an adapter was asked for and there is none.
    pub fn new(choice: BackendChoice) -> Result<Self> {
        let progress = Arc::<Progress>::default();
        match choice {
            BackendChoice::Gpu => Self::on(
                GpuBackend::open(AdapterKind::Any, Arc::clone(&progress))?,
                progress,
            ),
            BackendChoice::Auto => {
                match GpuBackend::open(AdapterKind::Hardware, Arc::clone(&progress)) {
                    Ok(backend) => Self::on(backend, progress),
                    Err(error) => {
                        tracing::info!("{error}; drawing on the CPU");
                        Self::new(BackendChoice::Cpu)
                    }
                }
            }
            BackendChoice::Cpu => Ok(Self::with_backend(
                Backend::Cpu(Box::new(Picture {
                    size: [0, 0],
                    rgba: Vec::new(),
                })),
                BackendInfo {
                    backend: "cpu",
                    adapter: format!(
                        "{} threads, {}",
                        rayon::current_num_threads(),
                        cpu::Path::best().name()
                    ),
                    driver: format!("hollowcast {}", env!("CARGO_PKG_VERSION")),
                    is_software: true,
                },
                progress,
            )),
            BackendChoice::Reference => Ok(Self::with_backend(
                Backend::Reference,
                BackendInfo {
                    backend: "reference",
                    adapter: format!("{} threads", rayon::current_num_threads()),
                    driver: format!("hollowcast {}", env!("CARGO_PKG_VERSION")),
                    is_software: true,
                },
                progress,
            )),
        }
    }

    /// Draws on a device that the caller owns; see [`Gpu::from_device`].
    ///
    /// # Errors
    /// [`Error::Gpu`] where the device cannot compile the passes.
    pub fn with_device(gpu: Gpu) -> Result<Self> {
        let progress = Arc::<Progress>::default();
        Self::on(
            GpuBackend::with_device(gpu, Arc::clone(&progress))?,
            progress,
        )
    }

    /// On this backend, less what its self-check withdraws.
    fn on(backend: GpuBackend, progress: Arc<Progress>) -> Result<Self> {
        let info = &backend.gpu().info;
        let info = BackendInfo {
            backend: "gpu",
            adapter: info.name.clone(),
            driver: format!("{} {}", info.driver, info.driver_info)
                .trim()
                .to_owned(),
            is_software: backend.gpu().is_software(),
        };
        let mut renderer = Self::with_backend(Backend::Gpu(Box::new(backend)), info, progress);
        renderer.withdrawn =
            self_check::withdrawn(&mut renderer, cache::file("self-check.json").as_deref())?;
        for skip in &renderer.withdrawn {
            tracing::warn!(
                "{} failed the self-check on this adapter: box is drawn instead",
                skip.method().name
            );
        }
        renderer.forget_volume();
        Ok(renderer)
    }

    fn with_backend(backend: Backend, info: BackendInfo, progress: Arc<Progress>) -> Self {
        Self {
            backend,
            info,
            volume: None,
            structures: Structures::default(),
            transfer: None,
            table: None,
            progress,
            withdrawn: Vec::new(),
            chooser: Chooser::default(),
        }
    }

    /// What draws the pictures.
    pub fn info(&self) -> &BackendInfo {
        &self.info
    }

    /// Whether this backend has a method.
    pub fn has(&self, skip: Skip) -> bool {
        skip.check_backend(self.info.backend).is_ok()
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
        if settings.skip == Skip::Adaptive && !settings.mode.takes_table() {
            let reason = format!(
                "adaptive follows the transfer function, of which {} makes no use",
                settings.mode.name()
            );
            return Err(Error::setting("method", reason));
        }
        let sampler = self.sampler(settings);
        let table = self.table(settings, &volume)?;
        let frame = RayFrame {
            clipping: settings.clipping,
            ..settings
                .camera
                .ray_frame(&volume, settings.size, settings.step_voxels)?
        };
        let scene = Scene {
            volume: &volume,
            table: &table,
            frame: &frame,
            sampler,
            mode: settings.mode,
            ert: settings.ert,
        };
        self.progress.restart();
        match &mut self.backend {
            Backend::Gpu(backend) => {
                let (needs, preparation) = self.structures.gpu_needs(settings, &scene, &table)?;
                let job = Job {
                    scene,
                    skip: settings.skip,
                    camera: &settings.camera,
                    parts: needs.parts,
                    masks: needs.masks,
                    blocks: needs.blocks,
                    block: settings.block,
                    active: &needs.active,
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
                let (plan, preparation) = self.structures.plan(settings, &scene, &table)?;
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
        },
    ))
}

fn ms_since(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}
