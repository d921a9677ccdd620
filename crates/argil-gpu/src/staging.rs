//! The buffer through which the CPU reads what the device wrote.

use std::sync::{Mutex, PoisonError};

/// The largest buffer that is kept, in bytes.
const MAX_KEPT: u64 = 64 << 20;

/// A mappable buffer, kept from one read-back to the next: the memory of a new one is slow when it is first touched.
#[derive(Debug, Default)]
pub(crate) struct KeptStaging(Mutex<Option<wgpu::Buffer>>);

impl KeptStaging {
    /// Takes a buffer with room for `bytes`, or creates one. It may be larger.
    pub(crate) fn take(
        &self,
        bytes: u64,
        create: impl FnOnce(u64) -> wgpu::Buffer,
    ) -> wgpu::Buffer {
        let kept = self.0.lock().unwrap_or_else(PoisonError::into_inner).take();
        let size = match bytes {
            ..=MAX_KEPT => bytes.next_power_of_two(),
            _ => bytes,
        };
        kept.filter(|buffer| buffer.size() >= bytes)
            .unwrap_or_else(|| create(size))
    }

    /// Keeps a buffer that is not mapped, unless a larger one is kept.
    pub(crate) fn keep(&self, buffer: wgpu::Buffer) {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let is_larger = kept
            .as_ref()
            .is_none_or(|other| other.size() < buffer.size());
        if is_larger && buffer.size() <= MAX_KEPT {
            *kept = Some(buffer);
        }
    }
}
