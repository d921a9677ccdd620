use crate::trace_mode::BoundResource;
use crate::{Gpu, GpuError};
use bytemuck::Pod;
use std::sync::atomic::{AtomicU64, Ordering};

/// A storage buffer that grows when needed. Exactly what was written is bound.
#[derive(Debug)]
pub(crate) struct StorageBuffer {
    what: &'static str,
    buffer: Option<wgpu::Buffer>,
    used: AtomicU64,
    /// Usage flags besides storage.
    usage: wgpu::BufferUsages,
}

impl StorageBuffer {
    pub(crate) fn new(what: &'static str) -> Self {
        Self {
            what,
            buffer: None,
            used: AtomicU64::new(0),
            usage: wgpu::BufferUsages::empty(),
        }
    }

    /// Creates a buffer that triangles are drawn from.
    pub(crate) fn drawn(what: &'static str) -> Self {
        Self {
            usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::INDEX,
            ..Self::new(what)
        }
    }

    /// Reserves `bytes`, and more if that takes a new buffer.
    pub(crate) fn reserve(&mut self, gpu: &Gpu, bytes: u64) -> Result<(), GpuError> {
        // Some headroom, so that a scene that grows brush by brush does not need a new buffer each time.
        self.reserve_with(gpu, bytes, bytes / 2)
    }

    /// Reserves exactly `bytes`.
    pub(crate) fn reserve_exact(&mut self, gpu: &Gpu, bytes: u64) -> Result<(), GpuError> {
        self.reserve_with(gpu, bytes, 0)
    }

    fn reserve_with(&mut self, gpu: &Gpu, bytes: u64, air: u64) -> Result<(), GpuError> {
        let bytes = bytes.max(16).next_multiple_of(16);
        let limits = gpu.device.limits();
        let limit = limits
            .max_storage_buffer_binding_size
            .min(limits.max_buffer_size);
        if bytes > limit {
            let name = gpu.info.name.clone();
            return Err(GpuError::TooLarge {
                name,
                what: self.what,
                bytes,
                limit,
            });
        }
        *self.used.get_mut() = bytes;
        if self.buffer.as_ref().is_none_or(|b| b.size() < bytes) {
            let size = (bytes + air).next_multiple_of(16).min(limit);
            let usage = self.usage
                | wgpu::BufferUsages::STORAGE
                | wgpu::BufferUsages::COPY_DST
                | wgpu::BufferUsages::COPY_SRC;
            let descriptor = wgpu::BufferDescriptor {
                label: Some(self.what),
                size,
                usage,
                mapped_at_creation: false,
            };
            self.buffer = Some(gpu.with_error_scope(|| gpu.create_buffer(&descriptor))?);
        }
        Ok(())
    }

    /// Writes exactly these rows.
    pub(crate) fn write<T: Pod>(&mut self, gpu: &Gpu, rows: &[T]) -> Result<(), GpuError> {
        self.reserve(gpu, size_of_val(rows) as u64)?;
        self.rewrite(gpu, rows);
        Ok(())
    }

    /// Writes these rows if there is room for them.
    pub(crate) fn rewrite<T: Pod>(&self, gpu: &Gpu, rows: &[T]) {
        let bytes: &[u8] = bytemuck::cast_slice(rows);
        self.patch(gpu, 0, bytes);
        // The binding must not show more rows than there are.
        let used = (bytes.len() as u64).max(16);
        self.used.store(used, Ordering::Relaxed);
    }

    /// Replaces some bytes from an offset on.
    pub(crate) fn patch(&self, gpu: &Gpu, at: u64, bytes: &[u8]) {
        if let Some(buffer) = &self.buffer
            && !bytes.is_empty()
        {
            gpu.write_buffer(buffer, at, bytes);
        }
    }

    pub(crate) fn buffer(&self) -> Option<&wgpu::Buffer> {
        self.buffer.as_ref()
    }

    /// Returns the bytes that are bound.
    pub(crate) fn used(&self) -> u64 {
        self.used.load(Ordering::Relaxed)
    }

    /// Returns the bytes on the device.
    pub(crate) fn size(&self) -> u64 {
        self.buffer.as_ref().map_or(0, wgpu::Buffer::size)
    }

    /// Returns what is bound of it.
    pub(crate) fn bound(&self, at: u32) -> Option<BoundResource> {
        let buffer = self.buffer.as_ref()?;
        Some(BoundResource::Buffer(at, buffer.clone(), Some(self.used())))
    }

    pub(crate) fn binding(&self, binding: u32) -> Option<wgpu::BindGroupEntry<'_>> {
        let buffer = self.buffer.as_ref()?;
        let resource = wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer,
            offset: 0,
            size: std::num::NonZeroU64::new(self.used()),
        });
        Some(wgpu::BindGroupEntry { binding, resource })
    }
}
