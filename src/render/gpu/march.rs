//! The compute pass: one pipeline per sampler, mode and permutation, shared by all methods whose segments are known
//! before the march.

use std::collections::HashMap;

use crate::error::Result;
use crate::gpu::Gpu;
use crate::gpu::shader::compose;
use crate::sample::Sampler;

/// What a compiled marcher is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct March {
    /// The file in `shaders/skip/`.
    pub(super) skip: &'static str,
    pub(super) sampler: Sampler,
    /// The file in `shaders/mode/`.
    pub(super) mode: &'static str,
    pub(super) counts: bool,
}

/// Bind group layouts and the pipelines compiled so far.
#[derive(Debug)]
pub(super) struct MarchPass {
    /// View, settings, tiles, target, progress, volume, filter, table, mode.
    pub(super) scene_layout: wgpu::BindGroupLayout,
    /// Bounds, work counters, runs, blocks.
    pub(super) skip_layout: wgpu::BindGroupLayout,
    layout: wgpu::PipelineLayout,
    pipelines: HashMap<March, wgpu::ComputePipeline>,
}

/// Distance of two march settings in their buffer: what every adapter allows as a dynamic offset.
pub(super) const SETTINGS_STRIDE: u64 = 256;

fn entry(binding: u32, ty: wgpu::BindingType) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty,
        count: None,
    }
}

fn storage(read_only: bool) -> wgpu::BindingType {
    wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Storage { read_only },
        has_dynamic_offset: false,
        min_binding_size: None,
    }
}

pub(super) fn uniform(has_dynamic_offset: bool) -> wgpu::BindingType {
    wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset,
        min_binding_size: None,
    }
}

impl MarchPass {
    /// The pass for volumes whose format the adapter filters, or not.
    pub(super) fn new(gpu: &Gpu, filterable: bool) -> Self {
        let texture = |sample_type, view_dimension| wgpu::BindingType::Texture {
            sample_type,
            view_dimension,
            multisampled: false,
        };
        let scene_layout = gpu
            .device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some("march scene"),
                entries: &[
                    entry(0, uniform(false)),
                    entry(1, uniform(true)),
                    entry(2, storage(true)),
                    entry(3, storage(false)),
                    entry(4, storage(false)),
                    entry(
                        5,
                        texture(
                            wgpu::TextureSampleType::Float { filterable },
                            wgpu::TextureViewDimension::D3,
                        ),
                    ),
                    entry(
                        6,
                        wgpu::BindingType::Sampler(if filterable {
                            wgpu::SamplerBindingType::Filtering
                        } else {
                            wgpu::SamplerBindingType::NonFiltering
                        }),
                    ),
                    entry(7, storage(true)),
                    entry(8, uniform(false)),
                ],
            });
        let skip_layout = gpu
            .device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some("march skip"),
                entries: &[
                    entry(
                        0,
                        texture(
                            wgpu::TextureSampleType::Depth,
                            wgpu::TextureViewDimension::D2Array,
                        ),
                    ),
                    entry(1, storage(false)),
                    entry(2, storage(true)),
                    entry(3, storage(true)),
                ],
            });
        let layout = gpu
            .device
            .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("march"),
                bind_group_layouts: &[Some(&scene_layout), Some(&skip_layout)],
                immediate_size: 0,
            });
        Self {
            scene_layout,
            skip_layout,
            layout,
            pipelines: HashMap::new(),
        }
    }

    /// The pipeline for `march`, compiled at first use.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where the adapter's compiler refuses it.
    pub(super) fn pipeline(&mut self, gpu: &Gpu, march: March) -> Result<&wgpu::ComputePipeline> {
        if !self.pipelines.contains_key(&march) {
            let choices = [
                ("SKIP", march.skip),
                ("SAMPLER", march.sampler.name()),
                ("MODE", march.mode),
                ("COUNT", if march.counts { "on" } else { "off" }),
            ];
            let text = compose("march", &choices)?;
            let pipeline = gpu.checked(|| {
                let module = gpu
                    .device
                    .create_shader_module(wgpu::ShaderModuleDescriptor {
                        label: Some("march"),
                        source: wgpu::ShaderSource::Wgsl(text.into()),
                    });
                gpu.device
                    .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                        label: Some("march"),
                        layout: Some(&self.layout),
                        module: &module,
                        entry_point: Some("march"),
                        compilation_options: wgpu::PipelineCompilationOptions::default(),
                        cache: None,
                    })
            })?;
            self.pipelines.insert(march, pipeline);
        }
        Ok(&self.pipelines[&march])
    }
}
