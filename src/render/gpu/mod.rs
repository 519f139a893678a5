//! The GPU backend: resident volume, passes and targets.

mod before;
mod dispatch;
mod faces;
mod march;
mod present;
mod tiles;
mod uniforms;

use std::collections::HashMap;
use std::sync::Arc;
use std::time::Instant;

use glam::DVec3;

use self::before::{largest_piece, list_segments, ray_words};
use self::dispatch::dispatches;
use self::faces::{BoundsTexture, FaceBuffers, FacesPass};
use self::march::{Count, March, MarchPass, SETTINGS_STRIDE, uniform};
use self::present::PresentPass;
pub use self::present::Targets;
use self::tiles::{TileMask, tile_runs};
use self::uniforms::{mode_of, settings_of, view_of, viewer_of};
use crate::camera::Camera;
use crate::error::{Error, Result};
use crate::gpu::abi::MarchSettings;
use crate::gpu::buffer::{GrowBuffer, KeptBuffer, read_back};
use crate::gpu::texture::VolumeTexture;
use crate::gpu::timer::{Place, SpanTimer};
use crate::gpu::{AdapterKind, Gpu};
use crate::octree::Hull;
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
    pub(super) skip: Skip,
    pub(super) camera: &'a Camera,
    /// Near part first; empty: the bounding box, or what the masks tell.
    pub(super) parts: Vec<Part<'a>>,
    /// Tells each tile its segments.
    pub(super) masks: Option<&'a BeamMasks>,
    /// What the method's own shader reads of every block, and its name.
    pub(super) blocks: Option<(u64, &'a [u32])>,
    /// Leaf block edge in voxels.
    pub(super) block: usize,
    /// Boxes (local coordinates) outside which nothing is visible.
    pub(super) active: &'a [[DVec3; 2]],
}

impl Job<'_> {
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
    bounds: Option<BoundsTexture>,
    kept_faces: HashMap<(u64, usize), Option<FaceBuffers>>,
    views: GrowBuffer,
    settings: GrowBuffer,
    tiles: GrowBuffer,
    runs: GrowBuffer,
    blocks: KeptBuffer,
    /// What is found out of every ray before it is marched.
    rays: GrowBuffer,
    target: GrowBuffer,
    progress: GrowBuffer,
    work: GrowBuffer,
    table: GrowBuffer,
    mode: GrowBuffer,
    timer: SpanTimer,
    present: Option<PresentPass>,
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
                    ty: uniform(false),
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
            bounds: None,
            kept_faces: HashMap::new(),
            views: GrowBuffer::new("view", Usage::UNIFORM),
            settings: GrowBuffer::new("march settings", Usage::UNIFORM),
            tiles: GrowBuffer::new("tiles", Usage::STORAGE),
            runs: GrowBuffer::new("runs", Usage::STORAGE),
            blocks: KeptBuffer::new("blocks"),
            rays: GrowBuffer::new("rays", Usage::STORAGE),
            target: GrowBuffer::new("target", storage),
            progress: GrowBuffer::new("progress", Usage::STORAGE),
            work: GrowBuffer::new("work", storage),
            table: GrowBuffer::new("table", Usage::STORAGE),
            mode: GrowBuffer::new("mode", Usage::UNIFORM),
            timer: SpanTimer::new(&gpu, 2),
            view_layout,
            gpu,
            present: None,
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
        self.kept_faces.clear();
        self.blocks.clear();
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
        let mut is_new = false;
        for part in &job.parts {
            if !self.kept_faces.contains_key(&part.key) {
                let faces = self
                    .gpu
                    .checked(|| FaceBuffers::new(&self.gpu, part.hull))?;
                self.kept_faces.insert(part.key, faces);
                is_new = true;
            }
        }
        is_new |= job.blocks.is_some_and(|(id, _)| !self.blocks.holds(id));
        self.blocks.holding(&self.gpu, job.blocks);
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
        let [width, height] = job.scene.frame.size.map(|n| u64::from(n.min(largest)));
        faces.map(FaceBuffers::bytes).sum::<u64>()
            + job.blocks.map_or(0, |(_, words)| size_of_val(words) as u64)
            + width * height * 4 * u64::from(ray_words(job))
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
                    Some(ms) => {
                        times.raster_ms += if job.parts.is_empty() && job.skip != Skip::SegmentList
                        {
                            0.0
                        } else {
                            ms[RASTER as usize]
                        };
                        times.cast_ms += ms[CAST as usize];
                    }
                    None => times.cast_ms = times.frame_ms,
                }
                done(self, &piece)?;
            }
        }
        Ok(())
    }

    fn draw_piece(&mut self, job: &Job, piece: &Piece, count: Count) -> Result<()> {
        let Some(volume) = &self.volume else {
            return Err(Error::Gpu("no volume was set".to_owned()));
        };
        if job.scene.sampler == Sampler::Hardware && !volume.filterable {
            return Err(Error::setting(
                "sampler",
                format!(
                    "{} does not filter this volume's format; use exact",
                    self.gpu.info.name
                ),
            ));
        }
        let gpu = &self.gpu;
        let frame = job.scene.frame;

        // The tiles that can show anything.
        let clip_from_local = job.camera.clip_from_local(frame.size);
        let (tile_list, run_list) = if let Some(masks) = job.masks {
            tile_runs(masks, frame, piece.origin, piece.size)
        } else {
            let mut mask = TileMask::new(piece.size);
            for &[low, high] in job.active {
                mask.mark(&clip_from_local, frame.size, piece.origin, [low, high]);
            }
            (mask.list(), Vec::new())
        };

        // Uniforms.
        let view = view_of(job, piece, &clip_from_local);
        let dispatches = dispatches(job, tile_list.len() as u32, gpu.is_software());
        let settings: Vec<u8> = dispatches
            .iter()
            .flat_map(|d| {
                let settings = settings_of(job, volume, d);
                let mut bytes = bytemuck::bytes_of(&settings).to_vec();
                bytes.resize(SETTINGS_STRIDE as usize, 0);
                bytes
            })
            .collect();
        let pixels = u64::from(piece.size[0]) * u64::from(piece.size[1]);
        let views = self.views.write(gpu, &[view]);
        let settings_buffer = self.settings.write(gpu, &settings);
        let tiles = self.tiles.write(gpu, &tile_list);
        let runs = self.runs.write(gpu, &run_list);
        let target = self.target.reserve(gpu, pixels * 16);
        let resumes = dispatches.iter().any(|d| d.resume || d.store_progress);
        let progress = self
            .progress
            .reserve(gpu, if resumes { pixels * 4 } else { 0 });
        let counted = if count == Count::On { pixels * 16 } else { 0 };
        let work = self.work.reserve(gpu, counted);
        let blocks = self.blocks.holding(gpu, job.blocks);
        let ray_bytes = pixels * 4 * u64::from(ray_words(job));
        let rays = gpu.checked(|| self.rays.reserve(gpu, ray_bytes))?;
        let table = self.table.write(gpu, job.scene.table.rgba());
        let mode = self.mode.write(gpu, &[mode_of(job)]);

        let segments = job.parts.len();
        if self
            .bounds
            .as_ref()
            .is_none_or(|b| !b.serves(piece.size, segments))
        {
            self.bounds = Some(gpu.checked(|| BoundsTexture::new(gpu, piece.size, segments))?);
        }
        let bounds = self.bounds.as_ref().expect("made just above");

        // What the oracle marches is found by box.
        let is_first = count == Count::Contributing;
        let march = March {
            skip: if is_first { Skip::Box } else { job.skip }.method().shader,
            sampler: job.scene.sampler,
            mode: job.scene.mode.row().shader,
            count,
        };
        let mut encoder = gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor {
                label: Some("frame"),
            });
        encoder.clear_buffer(target, 0, Some(pixels * 16));
        if count == Count::On {
            encoder.clear_buffer(work, 0, Some(counted));
        }
        if is_first {
            encoder.clear_buffer(rays, 0, Some(ray_bytes));
        }
        if segments > 0 {
            let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("view"),
                layout: &self.view_layout,
                entries: &[wgpu::BindGroupEntry {
                    binding: 0,
                    resource: views.as_entire_binding(),
                }],
            });
            let parts: Vec<_> = job
                .parts
                .iter()
                .map(|p| self.kept_faces[&p.key].as_ref())
                .collect();
            let viewer = viewer_of(job);
            self.faces.draw(
                &mut encoder,
                bounds,
                &group,
                &parts,
                &viewer,
                (&self.timer, RASTER),
            );
            self.timer.resolve(&mut encoder, RASTER);
        }
        let scene_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("march scene"),
            layout: &self.march.scene_layout,
            entries: &[
                bind(0, views.as_entire_binding()),
                bind(
                    1,
                    wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                        buffer: settings_buffer,
                        offset: 0,
                        size: wgpu::BufferSize::new(size_of::<MarchSettings>() as u64),
                    }),
                ),
                bind(2, tiles.as_entire_binding()),
                bind(3, target.as_entire_binding()),
                bind(4, progress.as_entire_binding()),
                bind(5, wgpu::BindingResource::TextureView(&volume.view)),
                bind(6, wgpu::BindingResource::Sampler(&volume.filter)),
                bind(7, table.as_entire_binding()),
                bind(8, mode.as_entire_binding()),
            ],
        });
        let skip_group = |notes: &wgpu::Buffer, reads: &wgpu::Buffer| {
            gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("march skip"),
                layout: &self.march.skip_layout,
                entries: &[
                    bind(0, wgpu::BindingResource::TextureView(&bounds.all)),
                    bind(1, notes.as_entire_binding()),
                    bind(2, runs.as_entire_binding()),
                    bind(3, reads.as_entire_binding()),
                ],
            })
        };
        let before_march = skip_group(rays, blocks);
        let march_group = match job.skip {
            _ if is_first => before_march.clone(),
            Skip::Oracle | Skip::SegmentList => skip_group(work, rays),
            _ => skip_group(work, blocks),
        };
        let last = dispatches.len() - 1;
        if job.skip == Skip::SegmentList {
            let pipeline = self.march.segments(gpu)?;
            let groups = [&scene_group, &before_march];
            list_segments(&mut encoder, pipeline, groups, &dispatches, &self.timer);
            self.timer.resolve(&mut encoder, RASTER);
        }
        let pipeline = self.march.pipeline(gpu, march)?;
        for (i, dispatch) in dispatches.iter().enumerate() {
            let place = Place {
                span: CAST,
                first: i == 0,
                last: i == last,
            };
            {
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                    label: Some("march"),
                    timestamp_writes: self.timer.compute(place),
                });
                if dispatch.tile_count > 0 {
                    pass.set_pipeline(pipeline);
                    pass.set_bind_group(0, &scene_group, &[(i as u64 * SETTINGS_STRIDE) as u32]);
                    pass.set_bind_group(1, &march_group, &[]);
                    dispatch.launch(&mut pass);
                }
            }
            if i == last {
                self.timer.resolve(&mut encoder, CAST);
            } else if dispatch.submit {
                // Each on its own, so that a watchdog sees short work and a cancelled frame ends soon.
                gpu.queue.submit([encoder.finish()]);
                gpu.wait()?;
                if self.progress_of_job.is_cancelled() {
                    return Err(Error::Cancelled);
                }
                encoder = gpu
                    .device
                    .create_command_encoder(&wgpu::CommandEncoderDescriptor {
                        label: Some("frame, continued"),
                    });
            }
        }
        gpu.queue.submit([encoder.finish()]);
        Ok(())
    }
}

fn bind(binding: u32, resource: wgpu::BindingResource<'_>) -> wgpu::BindGroupEntry<'_> {
    wgpu::BindGroupEntry { binding, resource }
}

/// Puts a piece where it belongs in the picture.
fn place<T: Copy>(from: &[T], piece: &Piece, size: [u32; 2], to: &mut [T]) {
    let width = piece.size[0] as usize;
    for (row, pixels) in from.chunks_exact(width).enumerate() {
        let at = (piece.origin[1] as usize + row) * size[0] as usize + piece.origin[0] as usize;
        to[at..at + width].copy_from_slice(pixels);
    }
}
