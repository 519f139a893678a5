//! The pass that draws slices: polygons blended by the rasteriser into a picture of 32-bit floats.

use std::collections::HashMap;

use super::dispatch::dispatches;
use super::march::{Count, march_settings, uniform};
use super::piece::bind;
use super::uniforms::{mode_of, settings_of, view_of};
use super::{GpuBackend, Job, MAX_TARGET, Piece, RASTER, place};
use crate::error::{Error, Result};
use crate::gpu::Gpu;
use crate::gpu::shader::compose;
use crate::gpu::timer::Place;
use crate::render::FrameTimes;
use crate::render::slices::{Corner, Slices, are_ordered};
use crate::sample::{Classification, Sampler};
use crate::scene::{CountedPicture, Counters};

/// What is blended: 16 bits would lose what hundreds of faint slices add.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// What a compiled pipeline is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Variant {
    sampler: Sampler,
    classification: Classification,
    /// The file in `shaders/mode/`.
    mode: &'static str,
    /// Near slices before far ones; otherwise the highest fragment counts.
    is_ordered: bool,
    /// Whether fragments are counted in place of blended.
    is_counted: bool,
}

/// Layouts, pipelines and the target of one filterability.
#[derive(Debug)]
pub(super) struct SlicesPass {
    is_filterable: bool,
    /// View, settings, volume, filter, table, mode and colours, at the marcher's places.
    scene_layout: wgpu::BindGroupLayout,
    layout: wgpu::PipelineLayout,
    pipelines: HashMap<Variant, wgpu::RenderPipeline>,
}

impl SlicesPass {
    fn new(gpu: &Gpu, is_filterable: bool) -> Result<Self> {
        let features = gpu.device.features();
        if !features.contains(wgpu::Features::FLOAT32_BLENDABLE) {
            let reason = format!("{} does not blend 32-bit floats", gpu.info.name);
            return Err(Error::setting("renderer", reason));
        }
        let entry = |binding, visibility, ty| wgpu::BindGroupLayoutEntry {
            binding,
            visibility,
            ty,
            count: None,
        };
        let fragment = wgpu::ShaderStages::FRAGMENT;
        let texture = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float {
                filterable: is_filterable,
            },
            view_dimension: wgpu::TextureViewDimension::D3,
            multisampled: false,
        };
        let filter = if is_filterable {
            wgpu::SamplerBindingType::Filtering
        } else {
            wgpu::SamplerBindingType::NonFiltering
        };
        let table = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only: true },
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let scene_layout = gpu
            .device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some("slices"),
                entries: &[
                    entry(0, wgpu::ShaderStages::VERTEX_FRAGMENT, uniform()),
                    entry(1, fragment, march_settings(false)),
                    entry(5, fragment, texture),
                    entry(6, fragment, wgpu::BindingType::Sampler(filter)),
                    entry(7, fragment, table),
                    entry(8, fragment, uniform()),
                    entry(10, fragment, texture),
                ],
            });
        let layout = gpu
            .device
            .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("slices"),
                bind_group_layouts: &[Some(&scene_layout)],
                immediate_size: 0,
            });
        Ok(Self {
            is_filterable,
            scene_layout,
            layout,
            pipelines: HashMap::new(),
        })
    }

    /// The pipeline of a variant, compiled at first use.
    fn pipeline(&mut self, gpu: &Gpu, variant: Variant) -> Result<&wgpu::RenderPipeline> {
        if !self.pipelines.contains_key(&variant) {
            let pipeline = self.compile(gpu, variant)?;
            self.pipelines.insert(variant, pipeline);
        }
        Ok(&self.pipelines[&variant])
    }

    fn compile(&self, gpu: &Gpu, variant: Variant) -> Result<wgpu::RenderPipeline> {
        let text = compose(
            "slices",
            &[
                ("SAMPLER", variant.sampler.shader()),
                ("MODE", variant.mode),
                ("CUE", "off"),
                ("CLASSIFICATION", variant.classification.shader()),
                (
                    "BLEND",
                    if variant.is_ordered {
                        "under"
                    } else {
                        "highest"
                    },
                ),
            ],
        )?;
        let component = |src_factor, dst_factor, operation| wgpu::BlendComponent {
            src_factor,
            dst_factor,
            operation,
        };
        let (one, behind) = (wgpu::BlendFactor::One, wgpu::BlendFactor::OneMinusDstAlpha);
        let blend = match (variant.is_counted, variant.is_ordered) {
            (true, _) => component(one, one, wgpu::BlendOperation::Add),
            (false, true) => component(behind, one, wgpu::BlendOperation::Add),
            (false, false) => component(one, one, wgpu::BlendOperation::Max),
        };
        gpu.checked(|| {
            let module = gpu
                .device
                .create_shader_module(wgpu::ShaderModuleDescriptor {
                    label: Some("slices"),
                    source: wgpu::ShaderSource::Wgsl(text.into()),
                });
            gpu.device
                .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                    label: Some("slices"),
                    layout: Some(&self.layout),
                    vertex: wgpu::VertexState {
                        module: &module,
                        entry_point: Some("vertex"),
                        compilation_options: wgpu::PipelineCompilationOptions::default(),
                        buffers: &[Some(wgpu::VertexBufferLayout {
                            array_stride: size_of::<Corner>() as u64,
                            step_mode: wgpu::VertexStepMode::Vertex,
                            attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32],
                        })],
                    },
                    primitive: wgpu::PrimitiveState::default(),
                    depth_stencil: None,
                    multisample: wgpu::MultisampleState::default(),
                    fragment: Some(wgpu::FragmentState {
                        module: &module,
                        entry_point: Some(if variant.is_counted { "count" } else { "color" }),
                        compilation_options: wgpu::PipelineCompilationOptions::default(),
                        targets: &[Some(wgpu::ColorTargetState {
                            format: FORMAT,
                            blend: Some(wgpu::BlendState {
                                color: blend,
                                alpha: blend,
                            }),
                            write_mask: wgpu::ColorWrites::ALL,
                        })],
                    }),
                    multiview_mask: None,
                    cache: None,
                })
        })
    }
}

impl GpuBackend {
    /// Draws slices into the target buffer, or counts their fragments there.
    pub(super) fn draw_slices(
        &mut self,
        job: &Job,
        slices: &Slices,
        piece: &Piece,
        is_counted: bool,
    ) -> Result<()> {
        let volume = self.volume.as_ref().expect("checked before any piece");
        let gpu = &self.gpu;
        let pass = match self.slices.take() {
            Some(pass) if pass.is_filterable == volume.filterable => pass,
            _ => SlicesPass::new(gpu, volume.filterable)?,
        };
        let pass = self.slices.insert(pass);
        let clip_from_local = job.camera.clip_from_local(job.scene.frame.size);
        let views = self
            .views
            .write(gpu, &[view_of(job, volume, piece, &clip_from_local)]);
        let dispatch = &dispatches(job, 0, true)[0];
        let settings = self.settings.write(gpu, &[settings_of(job, dispatch)]);
        let (table, colors) = self.classes.bound(gpu, job);
        let mode = self.mode.write(gpu, &[mode_of(job, volume, None)]);
        let corners = self.corners.write(gpu, &slices.corners);
        let [width, height] = piece.size;
        let target = self
            .target
            .reserve(gpu, u64::from(width) * u64::from(height) * 16);
        let size = wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        };
        let texture = match self.picture.take() {
            Some(texture) if texture.size() == size => texture,
            _ => gpu.checked(|| picture(gpu, size))?,
        };
        let texture = &*self.picture.insert(texture);
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("slices"),
            layout: &pass.scene_layout,
            entries: &[
                bind(0, views.as_entire_binding()),
                bind(1, settings.as_entire_binding()),
                bind(5, wgpu::BindingResource::TextureView(&volume.view)),
                bind(6, wgpu::BindingResource::Sampler(&volume.filter)),
                bind(7, table.as_entire_binding()),
                bind(8, mode.as_entire_binding()),
                bind(10, wgpu::BindingResource::TextureView(colors)),
            ],
        });
        let variant = Variant {
            sampler: job.scene.sampler,
            classification: job.scene.classification,
            mode: job.scene.mode.row().shader,
            is_ordered: are_ordered(&job.scene.mode),
            is_counted,
        };
        let pipeline = pass.pipeline(gpu, variant)?;
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let mut encoder = gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor {
                label: Some("slices"),
            });
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("slices"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                        store: wgpu::StoreOp::Store,
                    },
                })],
                depth_stencil_attachment: None,
                timestamp_writes: self.timer.render(Place {
                    span: RASTER,
                    first: true,
                    last: true,
                }),
                occlusion_query_set: None,
                multiview_mask: None,
            });
            if !slices.corners.is_empty() {
                pass.set_pipeline(pipeline);
                pass.set_bind_group(0, &group, &[]);
                pass.set_vertex_buffer(0, corners.slice(..));
                pass.draw(0..slices.corners.len() as u32, 0..1);
            }
        }
        self.timer.resolve(&mut encoder, RASTER);
        copy_rows(&mut encoder, texture, target);
        gpu.queue.submit([encoder.finish()]);
        Ok(())
    }

    /// Draws a picture of slices, and once more to count their fragments.
    pub(super) fn count_slices(&mut self, job: &Job) -> Result<CountedPicture> {
        let (picture, ..) = self.render(job)?;
        let size = job.scene.frame.size;
        let mut counts = vec![[0.0_f32; 4]; picture.rgba.len()];
        self.pieces(
            job,
            Count::On,
            |backend, piece| {
                let pixels: Vec<[f32; 4]> = backend.read(&backend.target, piece)?;
                place(&pixels, piece, size, &mut counts);
                Ok(())
            },
            &mut FrameTimes::default(),
        )?;
        let sum = |channel: usize| counts.iter().map(|c| c[channel] as u64).sum();
        Ok(CountedPicture {
            picture,
            counters: Counters {
                samples: sum(0),
                contributing: sum(1),
                skip_steps: 0,
            },
            samples: counts.iter().map(|c| c[0] as u32).collect(),
            first_hit: vec![f32::INFINITY; counts.len()],
        })
    }
}

fn picture(gpu: &Gpu, size: wgpu::Extent3d) -> wgpu::Texture {
    debug_assert!(size.width <= MAX_TARGET, "pieces are bounded");
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("slices"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: FORMAT,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

/// Copies a picture to a buffer without gaps between its rows: at once where rows are as long as copies want them.
fn copy_rows(encoder: &mut wgpu::CommandEncoder, from: &wgpu::Texture, to: &wgpu::Buffer) {
    let wgpu::Extent3d { width, height, .. } = from.size();
    let row_bytes = width * 16;
    let is_aligned = row_bytes.is_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let rows = if is_aligned { height } else { 1 };
    for y in (0..height).step_by(rows as usize) {
        encoder.copy_texture_to_buffer(
            wgpu::TexelCopyTextureInfo {
                texture: from,
                mip_level: 0,
                origin: wgpu::Origin3d { x: 0, y, z: 0 },
                aspect: wgpu::TextureAspect::All,
            },
            wgpu::TexelCopyBufferInfo {
                buffer: to,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: u64::from(y) * u64::from(row_bytes),
                    bytes_per_row: is_aligned.then_some(row_bytes),
                    rows_per_image: None,
                },
            },
            wgpu::Extent3d {
                width,
                height: rows,
                depth_or_array_layers: 1,
            },
        );
    }
}
