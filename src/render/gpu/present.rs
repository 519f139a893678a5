//! Laying a picture over targets that belong to the caller.

use crate::error::Result;
use crate::gpu::Gpu;
use crate::gpu::shader::compose;

/// Where a picture is to be drawn: views of the caller's, both of the picture's size.
#[derive(Debug, Clone, Copy)]
pub struct Targets<'a> {
    /// Receives the picture over what it holds, in linear light (an sRGB format encodes by itself).
    pub color: &'a wgpu::TextureView,
    /// Its format.
    pub color_format: wgpu::TextureFormat,
    /// Receives, as `R32Float`, the depth along the view from the eye (local units: the smallest voxel spacing) of the
    /// first sample that contributes; `f32::MAX` where there is none.
    pub depth: Option<&'a wgpu::TextureView>,
}

/// What a pipeline depends on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Kind {
    format: wgpu::TextureFormat,
    has_depth: bool,
}

impl Targets<'_> {
    pub(super) fn kind(&self) -> Kind {
        Kind {
            format: self.color_format,
            has_depth: self.depth.is_some(),
        }
    }
}

/// The pass and what it is compiled for.
#[derive(Debug)]
pub(super) struct PresentPass {
    pub(super) kind: Kind,
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::RenderPipeline,
}

impl PresentPass {
    pub(super) fn new(gpu: &Gpu, kind: Kind) -> Result<Self> {
        let buffer = |binding, ty| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty: wgpu::BindingType::Buffer {
                ty,
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        };
        let read = wgpu::BufferBindingType::Storage { read_only: true };
        let layout = gpu
            .device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some("present"),
                entries: &[
                    buffer(0, wgpu::BufferBindingType::Uniform),
                    buffer(1, read),
                    buffer(2, read),
                ],
            });
        let pipeline_layout = gpu
            .device
            .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("present"),
                bind_group_layouts: &[Some(&layout)],
                immediate_size: 0,
            });
        let module = gpu
            .device
            .create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some("present"),
                source: wgpu::ShaderSource::Wgsl(compose("present", &[])?.into()),
            });
        let color = Some(wgpu::ColorTargetState {
            format: kind.format,
            blend: Some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING),
            write_mask: wgpu::ColorWrites::ALL,
        });
        let depth = Some(wgpu::ColorTargetState {
            format: wgpu::TextureFormat::R32Float,
            blend: None,
            write_mask: wgpu::ColorWrites::ALL,
        });
        let targets = [color, depth];
        let pipeline = gpu
            .device
            .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("present"),
                layout: Some(&pipeline_layout),
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some("vertex"),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    buffers: &[],
                },
                primitive: wgpu::PrimitiveState::default(),
                depth_stencil: None,
                multisample: wgpu::MultisampleState::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &module,
                    entry_point: Some(if kind.has_depth {
                        "color_and_depth"
                    } else {
                        "color"
                    }),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    targets: &targets[..=usize::from(kind.has_depth)],
                }),
                multiview_mask: None,
                cache: None,
            });
        Ok(Self {
            kind,
            layout,
            pipeline,
        })
    }

    /// Draws a piece of the picture where it belongs. `buffers`: view, target, work.
    pub(super) fn draw(
        &self,
        gpu: &Gpu,
        targets: &Targets,
        buffers: [&wgpu::Buffer; 3],
        origin: [u32; 2],
        size: [u32; 2],
    ) {
        let entries: Vec<_> = (0..)
            .zip(buffers)
            .map(|(binding, buffer)| wgpu::BindGroupEntry {
                binding,
                resource: buffer.as_entire_binding(),
            })
            .collect();
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("present"),
            layout: &self.layout,
            entries: &entries,
        });
        let attach = |view| {
            Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Load,
                    store: wgpu::StoreOp::Store,
                },
            })
        };
        let attachments: Vec<_> = std::iter::once(targets.color)
            .chain(targets.depth)
            .map(attach)
            .collect();
        let mut encoder = gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor {
                label: Some("present"),
            });
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("present"),
                color_attachments: &attachments,
                ..Default::default()
            });
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.set_scissor_rect(origin[0], origin[1], size[0], size[1]);
            pass.draw(0..3, 0..1);
        }
        gpu.queue.submit([encoder.finish()]);
    }
}
