//! Timestamps around spans of passes, where the adapter has them.

use super::Gpu;
use super::buffer::read_back;
use crate::error::Result;

/// Distance of two spans' times in their buffer: what resolving aligns to.
const STRIDE: u64 = wgpu::QUERY_RESOLVE_BUFFER_ALIGNMENT;

/// Begin and end times of a fixed number of spans, each of one or more passes.
#[derive(Debug)]
pub struct SpanTimer {
    queries: Option<(wgpu::QuerySet, wgpu::Buffer)>,
    spans: u32,
}

/// Which pass of a span this is: the first begins it, the last ends it.
#[derive(Debug, Clone, Copy)]
pub struct Place {
    /// The span's index.
    pub span: u32,
    /// Whether this pass is its first.
    pub first: bool,
    /// Whether this pass is its last.
    pub last: bool,
}

impl Place {
    fn indices(self) -> (Option<u32>, Option<u32>) {
        (
            self.first.then_some(self.span * 2),
            self.last.then_some(self.span * 2 + 1),
        )
    }
}

impl SpanTimer {
    /// A timer of `spans` spans.
    pub fn new(gpu: &Gpu, spans: u32) -> Self {
        let queries = gpu
            .device
            .features()
            .contains(wgpu::Features::TIMESTAMP_QUERY)
            .then(|| {
                let queries = gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                    label: Some("times"),
                    ty: wgpu::QueryType::Timestamp,
                    count: spans * 2,
                });
                let resolved = gpu.device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some("times"),
                    size: u64::from(spans) * STRIDE,
                    usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
                    mapped_at_creation: false,
                });
                (queries, resolved)
            });
        Self { queries, spans }
    }

    /// What a compute pass at this place writes.
    pub fn compute(&self, place: Place) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        let (begin, end) = place.indices();
        let (query_set, _) = self.queries.as_ref().filter(|_| begin.or(end).is_some())?;
        Some(wgpu::ComputePassTimestampWrites {
            query_set,
            beginning_of_pass_write_index: begin,
            end_of_pass_write_index: end,
        })
    }

    /// What a render pass at this place writes.
    pub fn render(&self, place: Place) -> Option<wgpu::RenderPassTimestampWrites<'_>> {
        let (begin, end) = place.indices();
        let (query_set, _) = self.queries.as_ref().filter(|_| begin.or(end).is_some())?;
        Some(wgpu::RenderPassTimestampWrites {
            query_set,
            beginning_of_pass_write_index: begin,
            end_of_pass_write_index: end,
        })
    }

    /// Copies the times of a span whose passes were encoded to where [`Self::read_ms`] finds them.
    pub fn resolve(&self, encoder: &mut wgpu::CommandEncoder, span: u32) {
        if let Some((queries, resolved)) = &self.queries {
            encoder.resolve_query_set(
                queries,
                span * 2..span * 2 + 2,
                resolved,
                u64::from(span) * STRIDE,
            );
        }
    }

    /// Duration of each span in milliseconds, as of its last use; `None` where the adapter has no timestamps.
    ///
    /// # Errors
    /// As [`read_back`].
    pub fn read_ms(&self, gpu: &Gpu) -> Result<Option<Vec<f64>>> {
        let Some((_, resolved)) = &self.queries else {
            return Ok(None);
        };
        let per_span = STRIDE as usize / size_of::<u64>();
        let ticks: Vec<u64> = read_back(gpu, resolved, self.spans as usize * per_span)?;
        let ms_per_tick = f64::from(gpu.queue.get_timestamp_period()) * 1e-6;
        Ok(Some(
            ticks
                .chunks_exact(per_span)
                .map(|t| t[1].saturating_sub(t[0]) as f64 * ms_per_tick)
                .collect(),
        ))
    }
}
