//! What samples get their colour from, on the device: the table, its pre-integrated pairs, or the voxels' own colours.

use std::sync::Arc;

use super::Job;
use crate::error::Result;
use crate::gpu::Gpu;
use crate::gpu::buffer::{GrowBuffer, KeptBuffer};
use crate::gpu::texture::ColorTexture;
use crate::sample::PreIntegrated;
use crate::transfer::{Table, lookup};

/// What a job's classification reads.
pub(in crate::render) enum JobClasses<'a> {
    /// The scene's table.
    Post,
    /// The voxels' colours by this table.
    Pre(&'a Arc<Table>),
    /// These pairs, by their name.
    PreIntegrated(u64, &'a PreIntegrated),
}

/// Buffers and textures of all classifications; only what the last job reads is kept.
pub(super) struct ClassBuffers {
    table: GrowBuffer,
    pairs: KeptBuffer,
    colors: Option<(Arc<Table>, ColorTexture)>,
    no_colors: ColorTexture,
}

impl ClassBuffers {
    pub(super) fn new(gpu: &Gpu) -> Result<Self> {
        Ok(Self {
            table: GrowBuffer::new("table", wgpu::BufferUsages::STORAGE),
            pairs: KeptBuffer::new("pairs"),
            colors: None,
            no_colors: ColorTexture::empty(gpu)?,
        })
    }

    /// Forgets what was made for a volume.
    pub(super) fn forget_volume(&mut self) {
        self.colors = None;
        self.pairs.clear();
    }

    /// Makes what the job reads, unless it stands; whether it had to.
    pub(super) fn prepare(&mut self, gpu: &Gpu, job: &Job) -> Result<bool> {
        match &job.classes {
            JobClasses::Post => {
                self.forget_volume();
                Ok(false)
            }
            JobClasses::Pre(table) => {
                self.pairs.clear();
                let is_current = |(kept, _): &(Arc<Table>, _)| Arc::ptr_eq(kept, table);
                if self.colors.as_ref().is_some_and(is_current) {
                    return Ok(false);
                }
                // The old one goes first: both need not fit.
                self.colors = None;
                let texture = ColorTexture::upload(gpu, job.scene.volume, |v| color_of(table, v))?;
                self.colors = Some((Arc::clone(table), texture));
                Ok(true)
            }
            JobClasses::PreIntegrated(id, content) => {
                self.colors = None;
                let is_new = !self.pairs.holds(*id);
                let words = bytemuck::cast_slice(content.pairs());
                gpu.checked(|| {
                    self.pairs.holding(gpu, Some((*id, words)));
                })?;
                Ok(is_new)
            }
        }
    }

    /// Bytes of what the job reads besides the table.
    pub(super) fn bytes(&self, job: &Job) -> u64 {
        match &job.classes {
            JobClasses::Post => 0,
            JobClasses::Pre(_) => self.colors.as_ref().map_or(0, |(_, t)| t.bytes),
            JobClasses::PreIntegrated(_, content) => size_of_val(content.pairs()) as u64,
        }
    }

    /// What the shaders call `table`, of the job that was prepared last, and the voxels' colours (where they have none, a
    /// texture of one texel).
    pub(super) fn bound(&mut self, gpu: &Gpu, job: &Job) -> (&wgpu::Buffer, &wgpu::TextureView) {
        let table = match &job.classes {
            JobClasses::PreIntegrated(..) => self.pairs.holding(gpu, None),
            JobClasses::Post | JobClasses::Pre(_) => self.table.write(gpu, job.scene.table.rgba()),
        };
        let colors = self.colors.as_ref().map_or(&self.no_colors, |(_, t)| t);
        (table, &colors.view)
    }
}

/// Premultiplied colour and opacity of a stored number.
fn color_of(table: &Table, stored: f64) -> [f32; 4] {
    let domain = table.domain();
    let x = domain.x_from_stored(stored);
    let (lower, f) = lookup(x, domain.entries as f64, domain.snap());
    let rgba = table.rgba();
    let lower = lower as usize;
    let (a, b) = (rgba[lower], rgba[(lower + 1).min(rgba.len() - 1)]);
    std::array::from_fn(|c| a[c] + f as f32 * (b[c] - a[c]))
}
