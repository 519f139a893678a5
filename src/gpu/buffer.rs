//! Buffers that keep their memory from frame to frame, and reading them back.

use bytemuck::Pod;

use super::Gpu;
use crate::error::{Error, Result};

/// A device buffer that grows when it must and is kept otherwise.
#[derive(Debug)]
pub struct GrowBuffer {
    label: &'static str,
    usage: wgpu::BufferUsages,
    buffer: Option<wgpu::Buffer>,
}

impl GrowBuffer {
    /// An empty buffer; memory comes with its first use.
    pub fn new(label: &'static str, usage: wgpu::BufferUsages) -> Self {
        Self {
            label,
            usage: usage | wgpu::BufferUsages::COPY_DST,
            buffer: None,
        }
    }

    /// The buffer with room for at least `bytes`. Contents are lost where it had to grow.
    ///
    /// # Panics
    /// Never: the buffer is made where there is none.
    pub fn reserve(&mut self, gpu: &Gpu, bytes: u64) -> &wgpu::Buffer {
        let fits = self
            .buffer
            .as_ref()
            .is_some_and(|b| b.size() >= bytes.max(16));
        if !fits {
            // Bindings and copies want multiples of 4; an empty binding is not allowed.
            let size = bytes.max(16).next_multiple_of(16);
            self.buffer = Some(gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(self.label),
                size,
                usage: self.usage,
                mapped_at_creation: false,
            }));
        }
        self.buffer.as_ref().expect("made just above")
    }

    /// Writes `data` at the buffer's start.
    pub fn write<T: Pod>(&mut self, gpu: &Gpu, data: &[T]) -> &wgpu::Buffer {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        let buffer = self.reserve(gpu, bytes.len() as u64);
        if !bytes.is_empty() {
            gpu.queue.write_buffer(buffer, 0, bytes);
        }
        buffer
    }

    /// The buffer.
    ///
    /// # Panics
    /// Where it was never reserved or written.
    pub fn get(&self) -> &wgpu::Buffer {
        self.buffer
            .as_ref()
            .expect("a buffer is read after it was written")
    }

    /// Bytes held.
    pub fn bytes(&self) -> u64 {
        self.buffer.as_ref().map_or(0, wgpu::Buffer::size)
    }
}

/// A device buffer for what stays the same over many frames: written only where it holds something else.
#[derive(Debug)]
pub struct KeptBuffer {
    buffer: GrowBuffer,
    holds: Option<u64>,
}

impl KeptBuffer {
    /// An empty storage buffer.
    pub fn new(label: &'static str) -> Self {
        Self {
            buffer: GrowBuffer::new(label, wgpu::BufferUsages::STORAGE),
            holds: None,
        }
    }

    /// Whether it holds the data of this name.
    pub fn holds(&self, id: u64) -> bool {
        self.holds == Some(id)
    }

    /// The buffer with `data` in it, whose name is `id`; a buffer of any content for `None`.
    pub fn holding(&mut self, gpu: &Gpu, data: Option<(u64, &[u32])>) -> &wgpu::Buffer {
        match data {
            Some((id, data)) if self.holds != Some(id) => {
                self.holds = Some(id);
                self.buffer.write(gpu, data)
            }
            Some(_) => self.buffer.get(),
            None => {
                let room = self.buffer.bytes();
                self.buffer.reserve(gpu, room)
            }
        }
    }

    /// Forgets what it holds and frees its memory.
    pub fn clear(&mut self) {
        (self.holds, self.buffer.buffer) = (None, None);
    }

    /// Bytes held.
    pub fn bytes(&self) -> u64 {
        self.buffer.bytes()
    }
}

/// Copies the first `len` elements of `source` to the host; waits for all that was submitted.
///
/// # Errors
/// [`Error::Gpu`] where the device was lost or cannot map memory.
pub fn read_back<T: Pod>(gpu: &Gpu, source: &wgpu::Buffer, len: usize) -> Result<Vec<T>> {
    let size = (len * size_of::<T>()) as u64;
    // Of a device that is gone, nothing can be mapped.
    let staging = gpu.checked(|| {
        let staging = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("read back"),
            size,
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor {
                label: Some("read back"),
            });
        encoder.copy_buffer_to_buffer(source, 0, &staging, 0, size);
        gpu.queue.submit([encoder.finish()]);
        staging.map_async(wgpu::MapMode::Read, .., |_| {});
        staging
    })?;
    gpu.wait()?;
    let view = staging
        .get_mapped_range(..)
        .map_err(|error| Error::Gpu(format!("read back: {error}")))?;
    let mut out = vec![T::zeroed(); len];
    bytemuck::cast_slice_mut::<T, u8>(&mut out).copy_from_slice(&view);
    Ok(out)
}
