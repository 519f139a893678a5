//! A volume resident on the device as a 3D texture.

use crate::error::{Error, Result};
use crate::gpu::Gpu;
use crate::volume::{Volume, Voxels};

/// Voxels uploaded at a time: bounds the staging memory.
const SLAB_BYTES: usize = 16 << 20;

/// A volume's 3D texture and what its texels mean.
#[derive(Debug)]
pub struct VolumeTexture {
    /// The whole texture.
    pub view: wgpu::TextureView,
    /// Whether the adapter filters its format.
    pub filterable: bool,
    /// Its filter: linear where there is one. Kept, for drivers that give little back of what a frame makes anew.
    pub filter: wgpu::Sampler,
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
        let wide = gpu
            .device
            .features()
            .contains(wgpu::Features::TEXTURE_FORMAT_16BIT_NORM);
        let filters_f32 = gpu
            .device
            .features()
            .contains(wgpu::Features::FLOAT32_FILTERABLE);
        let (unorm8, unorm16) = (wgpu::TextureFormat::R8Unorm, wgpu::TextureFormat::R16Unorm);
        let (format, stored_per_raw, stored_at_zero) = match &volume.voxels {
            Voxels::U8(_) => (unorm8, 255.0, 0.0),
            Voxels::I8(_) => (unorm8, 255.0, -128.0),
            Voxels::U16(_) if wide => (unorm16, 65535.0, 0.0),
            Voxels::I16(_) if wide => (unorm16, 65535.0, -32768.0),
            Voxels::U16(_) | Voxels::I16(_) | Voxels::F32(_) => {
                (wgpu::TextureFormat::R32Float, 1.0, 0.0)
            }
        };
        let texture = gpu.checked(|| {
            gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some("volume"),
                size: wgpu::Extent3d {
                    width: volume.dims[0] as u32,
                    height: volume.dims[1] as u32,
                    depth_or_array_layers: volume.dims[2] as u32,
                },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D3,
                format,
                usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
                view_formats: &[],
            })
        });
        let texture = texture.map_err(|error| {
            Error::Limit(format!(
                "{}: no memory for {} MiB of voxels on {} ({error}); use --crop, --downsample 2 or --backend cpu",
                volume.name,
                volume.bytes() >> 20,
                gpu.info.name,
            ))
        })?;
        match &volume.voxels {
            Voxels::U8(v) => write(gpu, &texture, volume.dims, v, |s| s)?,
            Voxels::I8(v) => write(gpu, &texture, volume.dims, v, |s| {
                s.wrapping_add(-128).cast_unsigned()
            })?,
            Voxels::U16(v) if wide => write(gpu, &texture, volume.dims, v, |s| s)?,
            Voxels::I16(v) if wide => {
                write(gpu, &texture, volume.dims, v, |s| {
                    s.wrapping_add(-32768).cast_unsigned()
                })?;
            }
            Voxels::U16(v) => write(gpu, &texture, volume.dims, v, f32::from)?,
            Voxels::I16(v) => write(gpu, &texture, volume.dims, v, f32::from)?,
            Voxels::F32(v) => write(gpu, &texture, volume.dims, v, |s| s)?,
        }
        let filterable = format != wgpu::TextureFormat::R32Float || filters_f32;
        let mode = if filterable {
            wgpu::FilterMode::Linear
        } else {
            wgpu::FilterMode::Nearest
        };
        Ok(Self {
            view: texture.create_view(&wgpu::TextureViewDescriptor::default()),
            filterable,
            filter: gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("volume"),
                mag_filter: mode,
                min_filter: mode,
                ..Default::default()
            }),
            stored_per_raw,
            stored_at_zero,
        })
    }
}

/// Writes voxels as texels, some slices at a time.
fn write<S: Copy, T: bytemuck::Pod>(
    gpu: &Gpu,
    texture: &wgpu::Texture,
    dims: [usize; 3],
    voxels: &[S],
    texel: impl Fn(S) -> T,
) -> Result<()> {
    let slice = dims[0] * dims[1];
    let slices = (SLAB_BYTES / (slice * size_of::<T>())).max(1);
    let mut texels = Vec::with_capacity(slice * slices.min(dims[2]));
    for (i, slab) in voxels.chunks(slice * slices).enumerate() {
        texels.clear();
        texels.extend(slab.iter().map(|&s| texel(s)));
        gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                texture,
                mip_level: 0,
                origin: wgpu::Origin3d {
                    x: 0,
                    y: 0,
                    z: (i * slices) as u32,
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
                depth_or_array_layers: (slab.len() / slice) as u32,
            },
        );
        // Sent at once, so that its staging memory is free again before the next slab needs some.
        gpu.queue.submit([]);
        gpu.wait()?;
    }
    Ok(())
}
