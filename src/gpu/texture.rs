//! A volume resident on the device as a 3D texture.

use std::ops::Range;

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::gpu::Gpu;
use crate::volume::{Volume, Voxels};
use crate::with_voxels;

/// Voxels uploaded at a time: bounds the staging memory.
const SLAB_BYTES: usize = 16 << 20;

/// Bytes of four 16-bit floats.
const TEXEL_BYTES: usize = 8;

/// How an adapter stores voxels of a type: as the type's own numbers, where it can.
pub(crate) struct Stored {
    /// One to a texel.
    pub(crate) one: wgpu::TextureFormat,
    /// Four to a texel.
    pub(crate) four: wgpu::TextureFormat,
    /// See [`VolumeTexture::stored_per_raw`].
    per_raw: f64,
    /// See [`VolumeTexture::stored_at_zero`].
    at_zero: f64,
}

impl Stored {
    pub(crate) fn of(gpu: &Gpu, voxels: &Voxels) -> Self {
        use wgpu::TextureFormat as Format;
        let [one, four] = match voxels {
            Voxels::U8(_) | Voxels::I8(_) => [Format::R8Unorm, Format::Rgba8Unorm],
            Voxels::U16(_) | Voxels::I16(_) if has_unorm16(gpu) => {
                [Format::R16Unorm, Format::Rgba16Unorm]
            }
            Voxels::U16(_) | Voxels::I16(_) | Voxels::F32(_) => {
                [Format::R32Float, Format::Rgba32Float]
            }
        };
        let (per_raw, at_zero) = match voxels {
            _ if one == Format::R32Float => (1.0, 0.0),
            Voxels::U8(_) => (255.0, 0.0),
            Voxels::I8(_) => (255.0, -128.0),
            Voxels::U16(_) => (65535.0, 0.0),
            Voxels::I16(_) => (65535.0, -32768.0),
            Voxels::F32(_) => (1.0, 0.0),
        };
        Self {
            one,
            four,
            per_raw,
            at_zero,
        }
    }
}

/// Whether the adapter stores 16-bit numbers as such.
pub(crate) fn has_unorm16(gpu: &Gpu) -> bool {
    let features = gpu.device.features();
    features.contains(wgpu::Features::TEXTURE_FORMAT_16BIT_NORM)
}

/// Evaluates `$body` with `$voxels` as a slice and `$texel`, which makes of a voxel what [`Stored`] says of its type.
macro_rules! with_texels {
    ($gpu:expr, $all:expr, ($voxels:ident, $texel:ident) => $body:expr) => {{
        use $crate::volume::Voxels;
        let wide = $crate::gpu::texture::has_unorm16($gpu);
        match $all {
            Voxels::U8(v) => {
                let ($voxels, $texel) = (&v[..], |s: u8| s);
                $body
            }
            Voxels::I8(v) => {
                let ($voxels, $texel) = (&v[..], |s: i8| s.wrapping_add(-128).cast_unsigned());
                $body
            }
            Voxels::U16(v) if wide => {
                let ($voxels, $texel) = (&v[..], |s: u16| s);
                $body
            }
            Voxels::I16(v) if wide => {
                let ($voxels, $texel) = (&v[..], |s: i16| s.wrapping_add(-32768).cast_unsigned());
                $body
            }
            Voxels::U16(v) => {
                let ($voxels, $texel) = (&v[..], |s: u16| f32::from(s));
                $body
            }
            Voxels::I16(v) => {
                let ($voxels, $texel) = (&v[..], |s: i16| f32::from(s));
                $body
            }
            Voxels::F32(v) => {
                let ($voxels, $texel) = (&v[..], |s: f32| s);
                $body
            }
        }
    }};
}
pub(crate) use with_texels;

/// A volume's 3D texture and what its texels mean.
#[derive(Debug)]
pub struct VolumeTexture {
    /// The whole texture.
    pub view: wgpu::TextureView,
    /// Reads it between texels, where the adapter filters its format.
    pub filter: wgpu::Sampler,
    /// Whether the adapter filters its format.
    pub filterable: bool,
    /// `stored = raw * stored_per_raw + stored_at_zero`.
    pub stored_per_raw: f64,
    /// Stored number of raw 0. Signed data is uploaded biased to unsigned: snorm maps two values to one.
    pub stored_at_zero: f64,
}

impl VolumeTexture {
    /// Uploads a volume.
    ///
    /// # Errors
    /// [`Error::Limit`] where it exceeds what the adapter takes, [`Error::Gpu`] where memory ran out.
    pub fn upload(gpu: &Gpu, volume: &Volume) -> Result<Self> {
        let limit = gpu.device.limits().max_texture_dimension_3d as usize;
        let longest = volume.dims.into_iter().max().unwrap_or(1);
        if longest > limit {
            return Err(Error::Limit(format!(
                "{}: {} x {} x {} voxels exceed the {limit} per axis that {} takes (max_texture_dimension_3d); use \
                 --crop, --downsample {} or --backend cpu",
                volume.name,
                volume.dims[0],
                volume.dims[1],
                volume.dims[2],
                gpu.info.name,
                longest.div_ceil(limit),
            )));
        }
        let stored = Stored::of(gpu, &volume.voxels);
        let format = stored.one;
        let filters_f32 = gpu
            .device
            .features()
            .contains(wgpu::Features::FLOAT32_FILTERABLE);
        let texture = create(gpu, "volume", volume.dims, format);
        let texture = texture.map_err(|error| {
            Error::Limit(format!(
                "{}: no memory for {} MiB of voxels on {} ({error}); use --crop, --downsample 2 or --backend cpu",
                volume.name,
                volume.bytes() >> 20,
                gpu.info.name,
            ))
        })?;
        with_texels!(gpu, &volume.voxels, (voxels, texel) => {
            write(gpu, &texture, volume.dims, voxels, texel)?;
        });
        let filterable = format != wgpu::TextureFormat::R32Float || filters_f32;
        let mode = if filterable {
            wgpu::FilterMode::Linear
        } else {
            wgpu::FilterMode::Nearest
        };
        Ok(Self {
            view: texture.create_view(&wgpu::TextureViewDescriptor::default()),
            filter: gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("volume"),
                mag_filter: mode,
                min_filter: mode,
                ..Default::default()
            }),
            filterable,
            stored_per_raw: stored.per_raw,
            stored_at_zero: stored.at_zero,
        })
    }
}

/// The colours of a volume's voxels as a 3D texture of 16-bit floats.
///
/// Opacities of a step may be small: fixed point of 16 bits would lose half of those at 1/65535, where floats keep 11 bits
/// down to 2^-14. Those of 32 bits would take twice the memory, and not every adapter filters them.
#[derive(Debug)]
pub struct ColorTexture {
    /// The whole texture.
    pub view: wgpu::TextureView,
    /// Bytes of its texels.
    pub bytes: u64,
}

impl ColorTexture {
    /// Uploads the colours of a volume's voxels, `color` of each stored number.
    ///
    /// # Errors
    /// [`Error::Limit`] where the adapter has no memory for them.
    pub fn upload(
        gpu: &Gpu,
        volume: &Volume,
        color: impl Fn(f64) -> [f32; 4] + Sync,
    ) -> Result<Self> {
        let texel = |stored: f64| color(stored).map(|c| half::f16::from_f32(c).to_bits());
        let (texture, created) = Self::create(gpu, volume.dims).map_err(|error| {
            Error::Limit(format!(
                "{}: no memory for {} MiB of colours on {} ({error}); use --classification post, --crop or --downsample 2",
                volume.name,
                (volume.len() * TEXEL_BYTES) >> 20,
                gpu.info.name,
            ))
        })?;
        with_voxels!(&volume.voxels, voxels => {
            write(gpu, &texture, volume.dims, voxels, |s| texel(f64::from(s)))?;
        });
        Ok(created)
    }

    /// A texture of one texel, for who reads none.
    ///
    /// # Errors
    /// [`Error::Gpu`] where the adapter has no memory even for that.
    pub fn empty(gpu: &Gpu) -> Result<Self> {
        Ok(Self::create(gpu, [1; 3])?.1)
    }

    fn create(gpu: &Gpu, dims: [usize; 3]) -> Result<(wgpu::Texture, Self)> {
        let texture = create(gpu, "colors", dims, wgpu::TextureFormat::Rgba16Float)?;
        let created = Self {
            view: texture.create_view(&wgpu::TextureViewDescriptor::default()),
            bytes: (dims.iter().product::<usize>() * TEXEL_BYTES) as u64,
        };
        Ok((texture, created))
    }
}

/// A 3D texture of as many texels.
pub(crate) fn create(
    gpu: &Gpu,
    label: &str,
    dims: [usize; 3],
    format: wgpu::TextureFormat,
) -> Result<wgpu::Texture> {
    gpu.checked(|| {
        gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d {
                width: dims[0] as u32,
                height: dims[1] as u32,
                depth_or_array_layers: dims[2] as u32,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D3,
            format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        })
    })
}

/// Writes voxels as texels, some slices at a time.
pub(crate) fn write<S: Copy + Sync, T: bytemuck::Pod + Send>(
    gpu: &Gpu,
    texture: &wgpu::Texture,
    dims: [usize; 3],
    voxels: &[S],
    texel: impl Fn(S) -> T + Sync,
) -> Result<()> {
    let slice = dims[0] * dims[1];
    write_slabs(gpu, texture, dims, |slices, texels| {
        let slab = &voxels[slices.start * slice..slices.end * slice];
        let chosen = slab.par_iter().with_min_len(1 << 14).map(|&s| texel(s));
        chosen.collect_into_vec(texels);
    })
}

/// Writes a texture of these texels, some slices at a time; `fill` makes the texels of a range of them.
pub(crate) fn write_slabs<T: bytemuck::Pod>(
    gpu: &Gpu,
    texture: &wgpu::Texture,
    dims: [usize; 3],
    mut fill: impl FnMut(Range<usize>, &mut Vec<T>),
) -> Result<()> {
    let slice = dims[0] * dims[1];
    let slices = (SLAB_BYTES / (slice * size_of::<T>())).max(1);
    let mut texels = Vec::with_capacity(slice * slices.min(dims[2]));
    for first in (0..dims[2]).step_by(slices) {
        let slab = first..(first + slices).min(dims[2]);
        fill(slab.clone(), &mut texels);
        gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                texture,
                mip_level: 0,
                origin: wgpu::Origin3d {
                    x: 0,
                    y: 0,
                    z: first as u32,
                },
                aspect: wgpu::TextureAspect::All,
            },
            bytemuck::cast_slice(&texels),
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some((dims[0] * size_of::<T>()) as u32),
                rows_per_image: Some(dims[1] as u32),
            },
            wgpu::Extent3d {
                width: dims[0] as u32,
                height: dims[1] as u32,
                depth_or_array_layers: slab.len() as u32,
            },
        );
        // Sent at once, so that its staging memory is free again before the next slab needs some.
        gpu.queue.submit([]);
        gpu.wait()?;
    }
    Ok(())
}
