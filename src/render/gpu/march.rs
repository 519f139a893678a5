//! The compute pass: one pipeline per sampler, mode and permutation, shared by all methods whose segments are known
//! before the march.

use std::collections::HashMap;

use super::before::Listing;
use crate::error::Result;
use crate::gpu::Gpu;
use crate::gpu::shader::compose;
use crate::sample::{Classification, Sampler};

/// What a compiled marcher is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct March {
    /// The file in `shaders/skip/`.
    pub(super) skip: &'static str,
    pub(super) sampler: Sampler,
    pub(super) classification: Classification,
    /// The file in `shaders/mode/`.
    pub(super) mode: &'static str,
    /// Whether blocks are held against what the ray has seen.
    pub(super) is_bounded: bool,
    pub(super) count: Count,
    pub(super) gradient: Gradient,
    /// Whether colours fade with depth.
    pub(super) is_cued: bool,
    /// Whether values come from bricks, in place of the volume.
    pub(super) reads_bricks: bool,
}

/// Where a marcher takes gradients from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Gradient {
    /// The field, on the fly.
    Fly,
    /// The volume of them, by computed interpolation.
    Exact,
    /// The volume of them, by the adapter's filter.
    Filter,
}

impl Gradient {
    /// The file in `shaders/gradient/`.
    fn shader(self) -> &'static str {
        match self {
            Self::Fly => "fly",
            Self::Exact => "exact",
            Self::Filter => "filter",
        }
    }
}

/// What a march notes besides its picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Count {
    /// Nothing: what is timed.
    Off,
    /// Counters per pixel.
    On,
    /// Which samples contribute: what the oracle then marches.
    Contributing,
}

impl Count {
    /// The file in `shaders/count/`.
    fn shader(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::On => "on",
            Self::Contributing => "contributing",
        }
    }
}

/// Bind group layouts and the pipelines compiled so far.
#[derive(Debug)]
pub(super) struct MarchPass {
    /// View, settings, tiles, target, progress, volume, filter, table, mode, gradients, colours of voxels.
    pub(super) scene_layout: wgpu::BindGroupLayout,
    /// Bounds, what a pass notes (work counters, or what the next one reads), runs of tiles (of the processor, or as the last pass
    /// noted them), blocks or what the last pass noted of rays, bricks' places, bricks.
    pub(super) skip_layout: wgpu::BindGroupLayout,
    layout: wgpu::PipelineLayout,
    pipelines: HashMap<March, wgpu::ComputePipeline>,
    /// What is listed before the march.
    listings: HashMap<Listing, wgpu::ComputePipeline>,
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

/// Where march settings are bound: see `shaders/shared/march_settings`.
pub(super) fn march_settings(has_dynamic_offset: bool) -> wgpu::BindingType {
    wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Storage { read_only: true },
        has_dynamic_offset,
        min_binding_size: None,
    }
}

pub(super) fn uniform() -> wgpu::BindingType {
    wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset: false,
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
                    entry(0, uniform()),
                    entry(1, march_settings(true)),
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
                    entry(8, uniform()),
                    entry(
                        9,
                        texture(
                            wgpu::TextureSampleType::Float { filterable },
                            wgpu::TextureViewDimension::D3,
                        ),
                    ),
                    entry(
                        10,
                        texture(
                            wgpu::TextureSampleType::Float { filterable },
                            wgpu::TextureViewDimension::D3,
                        ),
                    ),
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
                    entry(
                        4,
                        texture(
                            wgpu::TextureSampleType::Uint,
                            wgpu::TextureViewDimension::D3,
                        ),
                    ),
                    entry(
                        5,
                        texture(
                            wgpu::TextureSampleType::Float { filterable: false },
                            wgpu::TextureViewDimension::D3,
                        ),
                    ),
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
            listings: HashMap::new(),
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
                ("SAMPLER", march.sampler.shader()),
                ("CLASSIFICATION", march.classification.shader()),
                ("MODE", march.mode),
                ("BOUND", if march.is_bounded { "highest" } else { "none" }),
                ("COUNT", march.count.shader()),
                ("GRADIENT", march.gradient.shader()),
                ("CUE", if march.is_cued { "on" } else { "off" }),
                (
                    "STORE",
                    if march.reads_bricks {
                        "bricks"
                    } else {
                        "volume"
                    },
                ),
            ];
            let pipeline = self.compile(gpu, "march", &choices)?;
            self.pipelines.insert(march, pipeline);
        }
        Ok(&self.pipelines[&march])
    }

    /// The pipeline of a pass before the march, compiled at first use.
    ///
    /// # Errors
    /// As [`Self::pipeline`].
    pub(super) fn listing(
        &mut self,
        gpu: &Gpu,
        listing: Listing,
    ) -> Result<&wgpu::ComputePipeline> {
        if !self.listings.contains_key(&listing) {
            let pipeline = self.compile(gpu, listing.shader(), &[("BOUND", "none")])?;
            self.listings.insert(listing, pipeline);
        }
        Ok(&self.listings[&listing])
    }

    /// Compiles the pass of this name, whose entry point has it too.
    fn compile(
        &self,
        gpu: &Gpu,
        name: &'static str,
        choices: &[(&str, &str)],
    ) -> Result<wgpu::ComputePipeline> {
        let text = compose(name, choices)?;
        gpu.checked(|| {
            let module = gpu
                .device
                .create_shader_module(wgpu::ShaderModuleDescriptor {
                    label: Some(name),
                    source: wgpu::ShaderSource::Wgsl(text.into()),
                });
            gpu.device
                .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                    label: Some(name),
                    layout: Some(&self.layout),
                    module: &module,
                    entry_point: Some(name),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    cache: None,
                })
        })
    }
}
