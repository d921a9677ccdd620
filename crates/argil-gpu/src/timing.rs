use crate::{Gpu, GpuError};

/// Timestamps at the beginning and end of each pass of a frame.
#[derive(Debug)]
pub(crate) struct Timing {
    set: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    capacity: u32,
    used: u32,
}

impl Timing {
    /// Creates timestamps for `passes` passes. Returns `None` if the device has none, or not enough in one set.
    pub(crate) fn new(gpu: &Gpu, passes: u32) -> Result<Option<Self>, GpuError> {
        let capacity = passes.saturating_mul(2);
        if !gpu.has_timestamps || !(2..=wgpu::QUERY_SET_MAX_QUERIES).contains(&capacity) {
            return Ok(None);
        }
        gpu.with_error_scope(|| {
            let set = gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("Timing"),
                ty: wgpu::QueryType::Timestamp,
                count: capacity,
            });
            let resolved = gpu.create_buffer(&wgpu::BufferDescriptor {
                label: Some("Timing::resolved"),
                size: u64::from(capacity) * 8,
                usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            });
            Some(Self {
                set,
                resolved,
                capacity,
                used: 0,
            })
        })
    }

    /// Returns the timestamps of the next compute pass, or `None` once the set is full.
    pub(crate) fn next(&mut self) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        let begin = self.used;
        if begin + 2 > self.capacity {
            return None;
        }
        self.used += 2;
        Some(wgpu::ComputePassTimestampWrites {
            query_set: &self.set,
            beginning_of_pass_write_index: Some(begin),
            end_of_pass_write_index: Some(begin + 1),
        })
    }

    /// Returns the timestamps of the next render pass, or `None` once the set is full.
    pub(crate) fn next_render(&mut self) -> Option<wgpu::RenderPassTimestampWrites<'_>> {
        let compute = self.next()?;
        Some(wgpu::RenderPassTimestampWrites {
            query_set: compute.query_set,
            beginning_of_pass_write_index: compute.beginning_of_pass_write_index,
            end_of_pass_write_index: compute.end_of_pass_write_index,
        })
    }

    /// Whether no timestamps are left.
    pub(crate) fn is_full(&self) -> bool {
        self.used + 2 > self.capacity
    }

    /// Uses the timestamps from the start again.
    pub(crate) fn restart(&mut self) {
        self.used = 0;
    }

    /// Returns the duration of each pass, in order.
    pub(crate) async fn durations_ms(&self, gpu: &Gpu) -> Result<Vec<f64>, GpuError> {
        if self.used == 0 {
            return Ok(Vec::new());
        }
        let mut encoder = gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.resolve_query_set(&self.set, 0..self.used, &self.resolved, 0);
        gpu.submit(encoder);
        let bytes = gpu
            .read_back(&self.resolved, u64::from(self.used) * 8)
            .await?;
        let stamps: Vec<u64> = bytes
            .chunks_exact(8)
            .map(bytemuck::pod_read_unaligned)
            .collect();
        let tick_ms = f64::from(gpu.queue.get_timestamp_period()) * 1e-6;
        Ok(stamps
            .chunks_exact(2)
            .map(|pair| pair[1].saturating_sub(pair[0]) as f64 * tick_ms)
            .collect())
    }
}
