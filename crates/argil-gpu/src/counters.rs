//! Counts what a device is asked to do.

use crate::{Gpu, GpuCounters, GpuError};
use std::sync::atomic::{AtomicU64, Ordering};

/// A number that many threads count up.
#[derive(Debug, Default)]
pub(crate) struct Counter(AtomicU64);

impl Counter {
    /// Adds a number.
    pub(crate) fn add(&self, count: u64) {
        self.0.fetch_add(count, Ordering::Relaxed);
    }

    fn get(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }
}

/// The counters of a device.
#[derive(Debug, Default)]
pub(crate) struct Counters {
    pub submissions: Counter,
    pub waits: Counter,
    pub buffers: Counter,
    pub pipelines: Counter,
    pub bytes_read: Counter,
}

impl Gpu {
    /// Returns what the device has been asked to do since it was opened.
    pub fn counters(&self) -> GpuCounters {
        let own = &self.counters;
        GpuCounters {
            submissions: own.submissions.get(),
            waits: own.waits.get(),
            buffers: own.buffers.get(),
            pipelines: own.pipelines.get(),
            bytes_read: own.bytes_read.get(),
        }
    }

    /// Submits an encoder's commands.
    pub(crate) fn submit(&self, encoder: wgpu::CommandEncoder) {
        self.counters.submissions.add(1);
        self.queue.submit([encoder.finish()]);
    }

    /// Submits what was written to buffers and textures.
    pub(crate) fn flush(&self) -> Result<(), GpuError> {
        self.counters.submissions.add(1);
        self.with_error_scope(|| {
            self.queue.submit([]);
        })
    }

    /// Creates a buffer.
    pub(crate) fn create_buffer(&self, descriptor: &wgpu::BufferDescriptor<'_>) -> wgpu::Buffer {
        self.counters.buffers.add(1);
        self.device.create_buffer(descriptor)
    }
}
