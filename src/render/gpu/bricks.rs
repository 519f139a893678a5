//! The bricks of a volume that show anything, resident on the device: the numbers of its texture, packed so that two loads give
//! the eight voxels of a cell.

use rayon::prelude::*;

use super::{GpuBackend, Job};
use crate::error::Result;
use crate::gpu::Gpu;
use crate::gpu::texture::{Stored, create, with_texels, write, write_slabs};
use crate::octree::Bricks;
use crate::octree::bricks::BRICK;
use crate::volume::Volume;

/// Slices of texels to a brick: its cells' own, and the first of the brick behind it.
const SLICES: usize = BRICK + 1;

/// Texels along an axis at most: as many as 11 bits count.
const LONGEST: usize = 2048;

/// What the shaders read where there is no brick.
const NO_BRICK: u32 = u32::MAX;

/// Bricks, and where each is.
#[derive(Debug)]
pub(super) struct BrickTextures {
    /// A texel for every brick of the volume: see `shaders/store/bricks`.
    pub(super) places: wgpu::TextureView,
    /// Four voxels to a texel: those around the edge along z on which a cell begins.
    pub(super) texels: wgpu::TextureView,
    /// Bytes of both.
    pub(super) bytes: u64,
}

impl BrickTextures {
    /// Packs and uploads a volume's bricks; `None` where the adapter has no room for them.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where the device was lost.
    fn upload(gpu: &Gpu, volume: &Volume, bricks: &Bricks) -> Result<Option<Self>> {
        let from: Vec<_> = bricks.active().collect();
        // About as many along each axis: the last layer along z may not be full.
        let edge = (from.len() as f64).cbrt().ceil().max(1.0) as usize;
        let layers = from.len().div_ceil(edge * edge).max(1);
        let limit = gpu.device.limits().max_texture_dimension_3d as usize;
        if edge.max(layers) * SLICES > LONGEST.min(limit) {
            return Ok(None);
        }
        let format = Stored::of(gpu, &volume.voxels).four;
        let dims = [edge * BRICK, edge * BRICK, layers * SLICES];
        let place_format = wgpu::TextureFormat::R32Uint;
        let created = create(gpu, "bricks", dims, format).and_then(|texels| {
            Ok((
                texels,
                create(gpu, "brick places", bricks.dims, place_format)?,
            ))
        });
        let (texture, places_texture) = match created {
            Ok(textures) => textures,
            Err(error) => {
                tracing::info!(
                    "no room for {} bricks ({error}): samples come from the volume",
                    from.len()
                );
                return Ok(None);
            }
        };
        with_texels!(gpu, &volume.voxels, (voxels, texel) => {
            write_slabs(gpu, &texture, dims, |slices, texels| {
                let row = |row: usize, texels: &mut [_]| {
                    let (y, z) = (row % dims[1], row / dims[1] + slices.start);
                    let first = (z / SLICES * edge + y / BRICK) * edge;
                    let bricks = from[first.min(from.len())..].iter();
                    for (brick, texels) in bricks.zip(texels.chunks_exact_mut(BRICK)) {
                        let at = [0, y % BRICK, z % SLICES];
                        let cell = std::array::from_fn(|a| brick[a] * BRICK + at[a]);
                        pack(voxels, volume.dims, cell, &texel, texels);
                    }
                };
                texels.clear();
                texels.resize(slices.len() * dims[0] * dims[1], [texel(voxels[0]); 4]);
                let rows = texels.par_chunks_exact_mut(dims[0]).enumerate();
                rows.with_min_len(8).for_each(|(i, texels)| row(i, texels));
            })?;
        });

        let mut places = vec![NO_BRICK; bricks.dims.iter().product()];
        for (i, [x, y, z]) in from.iter().enumerate() {
            let at = [i % edge * BRICK, i / edge % edge * BRICK, i / edge / edge];
            places[(z * bricks.dims[1] + y) * bricks.dims[0] + x] =
                (at[0] | at[1] << 11 | at[2] << 22) as u32;
        }
        write(gpu, &places_texture, bricks.dims, &places, |place| place)?;

        let texel_bytes = u64::from(format.block_copy_size(None).unwrap_or(0));
        let texels = dims.iter().product::<usize>() as u64;
        Ok(Some(Self {
            places: places_texture.create_view(&wgpu::TextureViewDescriptor::default()),
            texels: texture.create_view(&wgpu::TextureViewDescriptor::default()),
            bytes: texels * texel_bytes + size_of_val(&places[..]) as u64,
        }))
    }

    /// Textures of one texel, for who reads none.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where the adapter has no memory even for that.
    fn empty(gpu: &Gpu) -> Result<Self> {
        let one = |format| -> Result<_> {
            let texture = create(gpu, "no bricks", [1; 3], format)?;
            Ok(texture.create_view(&wgpu::TextureViewDescriptor::default()))
        };
        Ok(Self {
            places: one(wgpu::TextureFormat::R32Uint)?,
            texels: one(wgpu::TextureFormat::Rgba8Unorm)?,
            bytes: 0,
        })
    }
}

/// Packs the cells along x from `cell` on, counted from the one before the first voxel; voxels that there are not are the
/// outermost.
fn pack<S: Copy, T>(
    voxels: &[S],
    dims: [usize; 3],
    cell: [usize; 3],
    texel: &impl Fn(S) -> T,
    texels: &mut [[T; 4]],
) {
    let before = |a: usize, cell: usize| cell.saturating_sub(1).min(dims[a] - 1);
    let after = |a: usize, cell: usize| cell.min(dims[a] - 1);
    let row = |y: usize| &voxels[(before(2, cell[2]) * dims[1] + y) * dims[0]..][..dims[0]];
    let (low, high) = (row(before(1, cell[1])), row(after(1, cell[1])));
    for (x, out) in (cell[0]..).zip(texels) {
        let (left, right) = (before(0, x), after(0, x));
        *out = [low[left], low[right], high[left], high[right]].map(texel);
    }
}

impl GpuBackend {
    /// Drops the bricks, which are then made anew where they are read.
    pub(in crate::render) fn drop_bricks(&mut self) {
        self.bricks.clear();
    }
}

/// The bricks of the last job that read any.
pub(super) struct KeptBricks {
    /// By their name; none where the adapter has no room for them.
    kept: Option<(u64, Option<BrickTextures>)>,
    none: BrickTextures,
}

impl KeptBricks {
    pub(super) fn new(gpu: &Gpu) -> Result<Self> {
        Ok(Self {
            kept: None,
            none: BrickTextures::empty(gpu)?,
        })
    }

    pub(super) fn clear(&mut self) {
        self.kept = None;
    }

    /// Uploads what the job reads, unless it stands; whether it had to.
    pub(super) fn prepare(&mut self, gpu: &Gpu, job: &Job) -> Result<bool> {
        let Some((id, bricks)) = job.bricks else {
            if job.skip.reads_bricks() {
                // By another table or sampler it reads none any more; other methods may take turns with it.
                self.kept = None;
            }
            return Ok(false);
        };
        if self.kept.as_ref().is_some_and(|(kept, _)| *kept == id) {
            return Ok(false);
        }
        // The old ones go first: both need not fit.
        self.kept = None;
        let textures = BrickTextures::upload(gpu, job.scene.volume, bricks)?;
        self.kept = Some((id, textures));
        Ok(true)
    }

    /// Those that the job's samples come from, if they do not come from the volume.
    pub(super) fn of(&self, job: &Job) -> Option<&BrickTextures> {
        let (id, _) = job.bricks?;
        let (kept, textures) = self.kept.as_ref()?;
        textures.as_ref().filter(|_| *kept == id)
    }

    /// What the shaders find bound: a texel where they read none.
    pub(super) fn bound(&self, job: &Job) -> &BrickTextures {
        self.of(job).unwrap_or(&self.none)
    }
}
