//! The GPU backend: resident volume, passes and targets.

mod before;
mod bricks;
mod classes;
mod dispatch;
mod faces;
mod gradients;
mod march;
mod piece;
mod present;
mod slices;
mod tiles;
mod uniforms;

use std::collections::HashMap;
use std::sync::Arc;
use std::time::Instant;

use glam::DVec3;

use self::before::{Listing, largest_piece, ray_bytes};
use self::bricks::KeptBricks;
use self::classes::ClassBuffers;
pub(super) use self::classes::JobClasses;
use self::faces::{BoundsTexture, FaceBuffers, FacesPass};
use self::gradients::GradientVolume;
use self::march::{Count, MarchPass, uniform};
use self::present::PresentPass;
pub use self::present::Targets;
use self::slices::SlicesPass;
use crate::camera::Camera;
use crate::error::{Error, Result};
use crate::gpu::buffer::{GrowBuffer, KeptBuffer, read_back};
use crate::gpu::texture::VolumeTexture;
use crate::gpu::timer::SpanTimer;
use crate::gpu::{AdapterKind, Gpu};
use crate::octree::{Bricks, Hull};
use crate::render::block_words::BlockWords;
use crate::render::slices::Slices;
use crate::render::{FrameTimes, ms_since};
use crate::sample::Sampler;
use crate::scene::{CountedPicture, Counters, Picture, Progress, Scene};
use crate::skip::Skip;
use crate::skip::beam_masks::BeamMasks;
use crate::volume::Volume;

/// Largest edge of a target; larger pictures are drawn in pieces. 2,048 squared times 16 bytes is half of the 128 MiB
/// that every adapter binds.
const MAX_TARGET: u32 = 2048;

/// Part of a volume whose bounds are rasterised: one segment of each ray.
pub(super) struct Part<'a> {
    /// Names the part within its structure, for keeping its buffers.
    pub(super) key: (u64, usize),
    /// Its faces.
    pub(super) hull: &'a Hull,
    /// Whether an active block of it lies where rays start, so that its segment starts there.
    pub(super) starts_near: bool,
}

/// One picture to draw.
pub(super) struct Job<'a> {
    pub(super) scene: Scene<'a>,
    pub(super) classes: JobClasses<'a>,
    pub(super) skip: Skip,
    pub(super) camera: &'a Camera,
    /// Near part first; empty: the bounding box, or what the masks tell.
    pub(super) parts: Vec<Part<'a>>,
    /// Tells each tile its segments.
    pub(super) masks: Option<&'a BeamMasks>,
    /// What the method's own shader reads of every block.
    pub(super) blocks: Option<&'a BlockWords>,
    /// What its samples come from in place of the volume, and the name of that.
    pub(super) bricks: Option<(u64, &'a Bricks)>,
    /// Leaf block edge in voxels.
    pub(super) block: usize,
    /// How far two stored numbers of the volume can lie apart.
    pub(super) stored_span: f64,
    /// Boxes (local coordinates) outside which nothing is visible.
    pub(super) active: &'a [[DVec3; 2]],
    /// What is drawn in place of rays, where anything is.
    pub(super) slices: Option<Slices>,
}

impl Job<'_> {
    /// What the method's own shader reads of every block, after its name.
    fn block_words(&self) -> Option<(u64, &[u32])> {
        self.blocks.map(|words| (words.id, &words.content[..]))
    }

    /// Leaf blocks along x, y, z.
    fn block_dims(&self) -> [u32; 3] {
        let dims = self.scene.volume.dims;
        dims.map(|n| n.div_ceil(self.block) as u32)
    }
}

/// Device, resident volume, passes and targets.
pub(super) struct GpuBackend {
    gpu: Gpu,
    view_layout: wgpu::BindGroupLayout,
    faces: FacesPass,
    march: MarchPass,
    march_filterable: bool,
    volume: Option<VolumeTexture>,
    gradients: Option<GradientVolume>,
    bounds: Option<BoundsTexture>,
    kept_faces: HashMap<(u64, usize), Option<FaceBuffers>>,
    views: GrowBuffer,
    settings: GrowBuffer,
    tiles: GrowBuffer,
    runs: GrowBuffer,
    blocks: KeptBuffer,
    bricks: KeptBricks,
    /// What is found out of every ray before it is marched.
    rays: GrowBuffer,
    target: GrowBuffer,
    progress: GrowBuffer,
    work: GrowBuffer,
    classes: ClassBuffers,
    mode: GrowBuffer,
    timer: SpanTimer,
    present: Option<PresentPass>,
    slices: Option<SlicesPass>,
    corners: GrowBuffer,
    /// What slices are blended into.
    picture: Option<wgpu::Texture>,
    progress_of_job: Arc<Progress>,
}

/// Spans of the timer.
const RASTER: u32 = 0;
const CAST: u32 = 1;

/// What a drawn piece of a picture left on the device.
struct Piece {
    origin: [u32; 2],
    size: [u32; 2],
}

impl GpuBackend {
    /// A backend on the best adapter of a kind.
    pub(super) fn open(kind: AdapterKind, progress: Arc<Progress>) -> Result<Self> {
        Self::with_device(Gpu::open(kind)?, progress)
    }

    /// A backend on this device.
    pub(super) fn with_device(gpu: Gpu, progress: Arc<Progress>) -> Result<Self> {
        use wgpu::BufferUsages as Usage;
        let view_layout = gpu
            .device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some("view"),
                entries: &[wgpu::BindGroupLayoutEntry {
                    binding: 0,
                    visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
                    ty: uniform(),
                    count: None,
                }],
            });
        let storage = Usage::STORAGE | Usage::COPY_SRC;
        let faces = gpu.checked(|| FacesPass::new(&gpu, &view_layout))??;
        Ok(Self {
            faces,
            march: MarchPass::new(&gpu, true),
            march_filterable: true,
            volume: None,
            gradients: None,
            bounds: None,
            kept_faces: HashMap::new(),
            views: GrowBuffer::new("view", Usage::UNIFORM),
            settings: GrowBuffer::new("march settings", Usage::STORAGE),
            tiles: GrowBuffer::new("tiles", Usage::STORAGE),
            runs: GrowBuffer::new("runs", Usage::STORAGE),
            blocks: KeptBuffer::new("blocks"),
            bricks: KeptBricks::new(&gpu)?,
            rays: GrowBuffer::new("rays", Usage::STORAGE),
            target: GrowBuffer::new("target", storage),
            progress: GrowBuffer::new("progress", Usage::STORAGE),
            work: GrowBuffer::new("work", storage),
            classes: gpu.checked(|| ClassBuffers::new(&gpu))??,
            mode: GrowBuffer::new("mode", Usage::UNIFORM),
            timer: SpanTimer::new(&gpu, 2),
            view_layout,
            gpu,
            present: None,
            slices: None,
            corners: GrowBuffer::new("slices", Usage::VERTEX),
            picture: None,
            progress_of_job: progress,
        })
    }

    pub(super) fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Uploads a volume in place of the last.
    pub(super) fn set_volume(&mut self, volume: &Volume) -> Result<()> {
        // The old texture goes first: both need not fit.
        self.volume = None;
        self.gradients = None;
        self.kept_faces.clear();
        self.blocks.clear();
        self.bricks.clear();
        self.classes.forget_volume();
        let resident = VolumeTexture::upload(&self.gpu, volume)?;
        if resident.filterable != self.march_filterable {
            self.march = MarchPass::new(&self.gpu, resident.filterable);
            self.march_filterable = resident.filterable;
        }
        self.volume = Some(resident);
        Ok(())
    }

    /// The sampler to take where none was asked for: the filter on hardware, exact on software (whose filter returns
    /// 256 distinct values) and where the adapter cannot filter the volume's format.
    pub(super) fn default_sampler(&self) -> Sampler {
        let filterable = self.volume.as_ref().is_none_or(|v| v.filterable);
        if filterable && !self.gpu.is_software() {
            Sampler::Hardware
        } else {
            Sampler::Exact
        }
    }

    /// Uploads what the job's parts need and is not there yet; buffers of other structures are dropped.
    pub(super) fn prepare(&mut self, job: &Job) -> Result<()> {
        if let Some(structure) = job.parts.first().map(|p| p.key.0) {
            self.kept_faces.retain(|key, _| key.0 == structure);
        }
        let mut is_new = self.classes.prepare(&self.gpu, job)?;
        for part in &job.parts {
            if !self.kept_faces.contains_key(&part.key) {
                let faces = self
                    .gpu
                    .checked(|| FaceBuffers::new(&self.gpu, part.hull))?;
                self.kept_faces.insert(part.key, faces);
                is_new = true;
            }
        }
        let blocks = job.block_words();
        if let Some((_, words)) = blocks {
            let (bytes, most) = (
                size_of_val(words) as u64,
                self.gpu.device.limits().max_storage_buffer_binding_size,
            );
            if bytes > most {
                return Err(Error::Limit(format!(
                    "what {} keeps of blocks takes {bytes} bytes, and {} binds {most} (max_storage_buffer_binding_size): {}",
                    job.skip.method().name,
                    self.gpu.info.name,
                    if job.skip.reads_cells() {
                        "methods without cells take less"
                    } else {
                        "larger blocks take less (--block)"
                    },
                )));
            }
        }
        is_new |= blocks.is_some_and(|(id, _)| !self.blocks.holds(id));
        self.blocks.holding(&self.gpu, blocks);
        is_new |= self.bricks.prepare(&self.gpu, job)?;
        self.make_gradients(job)?;
        if is_new {
            // Else the copies would wait for the frame's submission, and count as part of it.
            self.gpu.queue.submit([]);
            self.gpu.wait()?;
        }
        Ok(())
    }

    /// Bytes on the device of what the job's method keeps from frame to frame besides the volume.
    pub(super) fn structure_bytes(&self, job: &Job) -> u64 {
        let parts = job.parts.iter();
        let faces = parts.filter_map(|p| self.kept_faces.get(&p.key)?.as_ref());
        let largest = largest_piece(job, &self.gpu.device.limits());
        let piece = job.scene.frame.size.map(|n| n.min(largest));
        faces.map(FaceBuffers::bytes).sum::<u64>()
            + job
                .block_words()
                .map_or(0, |(_, words)| size_of_val(words) as u64)
            + self.bricks.of(job).map_or(0, |bricks| bricks.bytes)
            + self.classes.bytes(job)
            + ray_bytes(job, piece)
            + job
                .gradient_edge()
                .and(self.gradients.as_ref())
                .map_or(0, |g| g.bytes)
    }

    /// Draws a picture and leaves it on the device: what is timed.
    pub(super) fn draw(&mut self, job: &Job) -> Result<FrameTimes> {
        let mut times = FrameTimes::default();
        self.pieces(job, Count::Off, |_, _| Ok(()), &mut times)?;
        Ok(times)
    }

    /// Draws a picture and reads it back; the last number is the time that reading took, in ms.
    pub(super) fn render(&mut self, job: &Job) -> Result<(Picture, FrameTimes, f64)> {
        let size = job.scene.frame.size;
        let mut times = FrameTimes::default();
        let mut rgba = vec![[0.0; 4]; size[0] as usize * size[1] as usize];
        let mut read_back_ms = 0.0;
        self.pieces(
            job,
            Count::Off,
            |backend, piece| {
                let start = Instant::now();
                let pixels: Vec<[f32; 4]> = backend.read(&backend.target, piece)?;
                place(&pixels, piece, size, &mut rgba);
                read_back_ms += ms_since(start);
                Ok(())
            },
            &mut times,
        )?;
        Ok((Picture { size, rgba }, times, read_back_ms))
    }

    /// Draws a picture with counters: the same bits.
    pub(super) fn count(&mut self, job: &Job) -> Result<CountedPicture> {
        if job.slices.is_some() {
            return self.count_slices(job);
        }
        let size = job.scene.frame.size;
        let pixels = size[0] as usize * size[1] as usize;
        let mut rgba = vec![[0.0; 4]; pixels];
        let mut work = vec![[0_u32; 4]; pixels];
        self.pieces(
            job,
            Count::On,
            |backend, piece| {
                let colors: Vec<[f32; 4]> = backend.read(&backend.target, piece)?;
                place(&colors, piece, size, &mut rgba);
                let counts: Vec<[u32; 4]> = backend.read(&backend.work, piece)?;
                place(&counts, piece, size, &mut work);
                Ok(())
            },
            &mut FrameTimes::default(),
        )?;
        let sum = |i: usize| work.iter().map(|w| u64::from(w[i])).sum();
        let hit = |w: &[u32; 4]| {
            if w[1] == 0 {
                f32::INFINITY
            } else {
                f32::from_bits(w[3])
            }
        };
        Ok(CountedPicture {
            picture: Picture { size, rgba },
            counters: Counters {
                samples: sum(0),
                contributing: sum(1),
                skip_steps: sum(2),
            },
            samples: work.iter().map(|w| w[0]).collect(),
            first_hit: work.iter().map(hit).collect(),
        })
    }

    /// Draws a picture over targets of the caller's.
    pub(super) fn render_to(&mut self, job: &Job, targets: &Targets) -> Result<FrameTimes> {
        let kind = targets.kind();
        if self.present.as_ref().is_none_or(|p| p.kind != kind) {
            self.present = Some(self.gpu.checked(|| PresentPass::new(&self.gpu, kind))??);
        }
        let mut times = FrameTimes::default();
        let count = if targets.depth.is_some() {
            Count::On
        } else {
            Count::Off
        };
        self.pieces(
            job,
            count,
            |backend, piece| {
                let present = backend.present.as_ref().expect("made just above");
                let buffers = [&backend.views, &backend.target, &backend.work].map(GrowBuffer::get);
                backend.gpu.checked(|| {
                    present.draw(&backend.gpu, targets, buffers, piece.origin, piece.size);
                })
            },
            &mut times,
        )?;
        Ok(times)
    }

    fn read<T: bytemuck::Pod>(&self, buffer: &GrowBuffer, piece: &Piece) -> Result<Vec<T>> {
        let len = piece.size[0] as usize * piece.size[1] as usize;
        read_back(&self.gpu, buffer.get(), len)
    }

    /// Draws the picture piece by piece, hands each to `done` and adds up the times.
    fn pieces(
        &mut self,
        job: &Job,
        count: Count,
        mut done: impl FnMut(&mut Self, &Piece) -> Result<()>,
        times: &mut FrameTimes,
    ) -> Result<()> {
        self.prepare(job)?;
        let [width, height] = job.scene.frame.size;
        let largest = largest_piece(job, &self.gpu.device.limits());
        for y in (0..height).step_by(largest as usize) {
            for x in (0..width).step_by(largest as usize) {
                let size = [largest.min(width - x), largest.min(height - y)];
                let piece = Piece {
                    origin: [x, y],
                    size,
                };
                if job.skip == Skip::Oracle {
                    // What makes it no method: all that box takes, to know what to take.
                    self.draw_piece(job, &piece, Count::Contributing)?;
                    self.gpu.wait()?;
                }
                let start = Instant::now();
                self.draw_piece(job, &piece, count)?;
                self.gpu.wait()?;
                times.frame_ms += ms_since(start);
                match self.timer.read_ms(&self.gpu)? {
                    Some(ms) if job.slices.is_some() => times.raster_ms += ms[RASTER as usize],
                    Some(ms) => {
                        let raster_ms = if job.parts.is_empty() && Listing::of(job.skip).is_none() {
                            0.0
                        } else {
                            ms[RASTER as usize]
                        };
                        times.raster_ms += raster_ms;
                        times.cast_ms += ms[CAST as usize];
                        *times.gpu_ms.get_or_insert(0.0) += raster_ms + ms[CAST as usize];
                    }
                    None => times.cast_ms = times.frame_ms,
                }
                done(self, &piece)?;
            }
        }
        Ok(())
    }
}

/// Puts a piece where it belongs in the picture.
fn place<T: Copy>(from: &[T], piece: &Piece, size: [u32; 2], to: &mut [T]) {
    let width = piece.size[0] as usize;
    for (row, pixels) in from.chunks_exact(width).enumerate() {
        let at = (piece.origin[1] as usize + row) * size[0] as usize + piece.origin[0] as usize;
        to[at..at + width].copy_from_slice(pixels);
    }
}
