//! Timestamps around passes, where the adapter has them.

use super::Gpu;
use super::buffer::read_back;
use crate::error::Result;

/// Begin and end times of up to a fixed number of passes.
#[derive(Debug)]
pub struct PassTimer {
    queries: Option<wgpu::QuerySet>,
    resolved: Option<wgpu::Buffer>,
    passes: u32,
}

impl PassTimer {
    /// A timer of `passes` passes.
    pub fn new(gpu: &Gpu, passes: u32) -> Self {
        if !gpu
            .device
            .features()
            .contains(wgpu::Features::TIMESTAMP_QUERY)
        {
            return Self {
                queries: None,
                resolved: None,
                passes,
            };
        }
        let queries = gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("pass times"),
            ty: wgpu::QueryType::Timestamp,
            count: passes * 2,
        });
        let resolved = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("pass times"),
            size: u64::from(passes) * 16,
            usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        Self {
            queries: Some(queries),
            resolved: Some(resolved),
            passes,
        }
    }

    /// What a compute pass with this index writes.
    pub fn compute(&self, pass: u32) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        self.queries
            .as_ref()
            .map(|query_set| wgpu::ComputePassTimestampWrites {
                query_set,
                beginning_of_pass_write_index: Some(pass * 2),
                end_of_pass_write_index: Some(pass * 2 + 1),
            })
    }

    /// Puts the times where [`Self::read_ms`] finds them; to be called once at the end of a frame.
    pub fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        if let (Some(queries), Some(resolved)) = (&self.queries, &self.resolved) {
            encoder.resolve_query_set(queries, 0..self.passes * 2, resolved, 0);
        }
    }

    /// Duration of each pass in milliseconds; `None` where the adapter has no timestamps.
    ///
    /// # Errors
    /// As [`read_back`].
    pub fn read_ms(&self, gpu: &Gpu) -> Result<Option<Vec<f64>>> {
        let Some(resolved) = &self.resolved else {
            return Ok(None);
        };
        let ticks: Vec<u64> = read_back(gpu, resolved, self.passes as usize * 2)?;
        let ms_per_tick = f64::from(gpu.queue.get_timestamp_period()) * 1e-6;
        Ok(Some(
            ticks
                .chunks_exact(2)
                .map(|t| t[1].saturating_sub(t[0]) as f64 * ms_per_tick)
                .collect(),
        ))
    }
}
