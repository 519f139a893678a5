//! The volume of gradients on the device: filled there, once per volume and resolution.

use std::time::Instant;

use super::march::{Gradient, uniform};
use super::{GpuBackend, Job};
use crate::error::{Error, Result};
use crate::gpu::Gpu;
use crate::gpu::abi::GradientCells;
use crate::gpu::buffer::GrowBuffer;
use crate::gpu::shader::compose;
use crate::render::ms_since;
use crate::sample::Gradients;

/// Half floats: the only filterable format of three signed channels that every adapter both filters and writes, and one whose
/// error (2^-11) is relative to each gradient. 8 signed bits would be half as large, but of a gradient of a hundredth of the
/// steepest, as soft tissue has beside bone, they keep a single bit. Three channels have no format; the fourth is unused.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// Bytes of a texel.
const TEXEL_BYTES: u64 = 8;

/// Largest component that is stored: a power of two with the whole of a half float's range below it, so that the smallest
/// difference of 16-bit voxels is no subnormal number.
const LARGEST: f64 = 32_768.0;

/// Voxels that one dispatch reads at most: some ms on the slowest integrated GPUs.
const VOXELS_PER_DISPATCH: u64 = 1 << 24;

/// A volume of gradients.
#[derive(Debug)]
pub(super) struct GradientVolume {
    pub(super) gradients: Gradients,
    pub(super) view: wgpu::TextureView,
    /// What raw differences were multiplied by; a power of two.
    pub(super) scale: f64,
    pub(super) bytes: u64,
    /// Time that filling it took.
    pub(super) build_ms: f64,
}

impl Job<'_> {
    /// Edge in voxels of the cells of the volume of gradients that the mode reads, if it does.
    pub(super) fn gradient_edge(&self) -> Option<usize> {
        let reads = self.scene.mode.takes_gradients();
        self.scene.gradients.cell_edge().filter(|_| reads)
    }

    /// Where its marcher takes gradients from.
    pub(super) fn gradient(&self) -> Gradient {
        match self.gradient_edge() {
            None => Gradient::Fly,
            Some(_) if self.scene.sampler.is_filtered() => Gradient::Filter,
            Some(_) => Gradient::Exact,
        }
    }
}

impl GpuBackend {
    /// Forgets the volume of gradients.
    pub(in crate::render) fn drop_gradients(&mut self) {
        self.gradients = None;
    }

    /// Fills the volume of gradients that the job reads, unless it stands, and tells how long that took; 0 where the job
    /// reads none.
    pub(in crate::render) fn make_gradients(&mut self, job: &Job) -> Result<f64> {
        let scene = &job.scene;
        let (Some(edge), Some(volume)) = (job.gradient_edge(), &self.volume) else {
            return Ok(0.0);
        };
        if let Some(kept) = &self.gradients
            && kept.gradients == scene.gradients
        {
            return Ok(kept.build_ms);
        }
        // The old one goes first: both need not fit.
        self.gradients = None;
        let span = job.stored_span / volume.stored_per_raw;
        let dims = scene.volume.dims;
        let filled =
            GradientVolume::fill(&self.gpu, &volume.view, dims, scene.gradients, edge, span)?;
        Ok(self.gradients.insert(filled).build_ms)
    }
}

impl GradientVolume {
    /// Fills cells of `edge` voxels from a volume of `dims` voxels, of which no raw texel is more than `span` from another.
    ///
    /// # Errors
    /// [`Error::Gpu`] where the pass does not compile, [`Error::Limit`] where memory ran out.
    pub(super) fn fill(
        gpu: &Gpu,
        volume: &wgpu::TextureView,
        dims: [usize; 3],
        gradients: Gradients,
        edge: usize,
        span: f64,
    ) -> Result<Self> {
        let start = Instant::now();
        let cells = dims.map(|n| n.div_ceil(edge) as u32);
        let bytes = cells.iter().map(|&n| u64::from(n)).product::<u64>() * TEXEL_BYTES;
        let texture = gpu.checked(|| {
            gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some("gradients"),
                size: wgpu::Extent3d {
                    width: cells[0],
                    height: cells[1],
                    depth_or_array_layers: cells[2],
                },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D3,
                format: FORMAT,
                usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::STORAGE_BINDING,
                view_formats: &[],
            })
        });
        let texture = texture.map_err(|error| {
            Error::Limit(format!(
                "no memory for {} MiB of gradients on {} ({error}); use --gradients quarter or fly",
                bytes >> 20,
                gpu.info.name,
            ))
        })?;
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let scale = f64::exp2(
            (LARGEST / span.max(f64::MIN_POSITIVE))
                .log2()
                .floor()
                .clamp(-96.0, 96.0),
        );

        let (layout, pipeline) = gpu.checked(|| pipeline(gpu))??;
        let mut uniforms = GrowBuffer::new("gradient cells", wgpu::BufferUsages::UNIFORM);
        let voxels_per_layer = (dims[0] * dims[1] * edge) as u64;
        // Workgroups are four layers high.
        let layers = (VOXELS_PER_DISPATCH / voxels_per_layer).clamp(1, 1 << 16) as u32;
        let layers = layers.next_multiple_of(4);
        for first_layer in (0..cells[2]).step_by(layers as usize) {
            let settings = GradientCells {
                edge: edge as u32,
                scale: scale as f32,
                first_layer,
                pad1: 0,
            };
            let uniforms = uniforms.write(gpu, &[settings]);
            let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
            let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("gradients"),
                layout: &layout,
                entries: &[
                    entry(0, uniforms.as_entire_binding()),
                    entry(1, wgpu::BindingResource::TextureView(volume)),
                    entry(2, wgpu::BindingResource::TextureView(&view)),
                ],
            });
            let mut encoder = gpu
                .device
                .create_command_encoder(&wgpu::CommandEncoderDescriptor {
                    label: Some("gradients"),
                });
            {
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
                pass.set_pipeline(&pipeline);
                pass.set_bind_group(0, &group, &[]);
                let layers = layers.min(cells[2] - first_layer);
                let [x, y, z] = [cells[0], cells[1], layers].map(|n| n.div_ceil(4));
                pass.dispatch_workgroups(x, y, z);
            }
            gpu.queue.submit([encoder.finish()]);
            gpu.wait()?;
        }
        Ok(Self {
            gradients,
            view,
            scale,
            bytes,
            build_ms: ms_since(start),
        })
    }
}

/// The pass that fills a volume of gradients, and its bindings: cells, voxels, gradients.
fn pipeline(gpu: &Gpu) -> Result<(wgpu::BindGroupLayout, wgpu::ComputePipeline)> {
    let text = compose("gradients", &[])?;
    let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty,
        count: None,
    };
    let layout = gpu
        .device
        .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("gradients"),
            entries: &[
                entry(0, uniform()),
                entry(
                    1,
                    wgpu::BindingType::Texture {
                        sample_type: wgpu::TextureSampleType::Float { filterable: false },
                        view_dimension: wgpu::TextureViewDimension::D3,
                        multisampled: false,
                    },
                ),
                entry(
                    2,
                    wgpu::BindingType::StorageTexture {
                        access: wgpu::StorageTextureAccess::WriteOnly,
                        format: FORMAT,
                        view_dimension: wgpu::TextureViewDimension::D3,
                    },
                ),
            ],
        });
    let pipeline_layout = gpu
        .device
        .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("gradients"),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
    let module = gpu
        .device
        .create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("gradients"),
            source: wgpu::ShaderSource::Wgsl(text.into()),
        });
    let pipeline = gpu
        .device
        .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("gradients"),
            layout: Some(&pipeline_layout),
            module: &module,
            entry_point: Some("gradients"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
    Ok((layout, pipeline))
}
