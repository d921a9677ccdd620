//! Counts what a device is asked to do.

use crate::GpuCounters;
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

impl Counters {
    /// Returns the numbers.
    pub(crate) fn read(&self) -> GpuCounters {
        GpuCounters {
            submissions: self.submissions.get(),
            waits: self.waits.get(),
            buffers: self.buffers.get(),
            pipelines: self.pipelines.get(),
            bytes_read: self.bytes_read.get(),
        }
    }
}
