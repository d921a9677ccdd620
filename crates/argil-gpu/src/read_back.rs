//! Copies what the device wrote to the CPU.

use crate::{Gpu, GpuError};

impl Gpu {
    /// Copies the first `bytes` of a buffer to the CPU.
    pub(crate) async fn read_back(
        &self,
        buffer: &wgpu::Buffer,
        bytes: u64,
    ) -> Result<Vec<u8>, GpuError> {
        let staging = self.with_error_scope(|| {
            let staging = self.staging.take(bytes, |size| {
                self.create_buffer(&wgpu::BufferDescriptor {
                    label: Some("read-back"),
                    size,
                    usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
                    mapped_at_creation: false,
                })
            });
            let mut encoder = self
                .device
                .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, bytes);
            self.submit(encoder);
            staging
        })?;
        let mut all = Vec::new();
        let look = |bytes: &[u8]| all.extend_from_slice(bytes);
        self.take_staged(staging.slice(..bytes), look).await?;
        self.staging.keep(staging);
        Ok(all)
    }

    /// Waits for a mappable buffer, and reads it.
    pub(crate) async fn take_staged(
        &self,
        staged: wgpu::BufferSlice<'_>,
        look: impl FnOnce(&[u8]),
    ) -> Result<(), GpuError> {
        let (sender, receiver) = futures_channel::oneshot::channel();
        self.with_error_scope(|| {
            staged.map_async(wgpu::MapMode::Read, move |result| {
                // The receiver waits below.
                let _ = sender.send(result);
            });
        })?;
        self.poll()?;
        let lost = |reason: String| GpuError::Lost(reason);
        receiver
            .await
            .map_err(|e| lost(e.to_string()))?
            .map_err(|e| self.fault().unwrap_or(lost(e.to_string())))?;
        self.fault().map_or(Ok(()), Err)?;
        let view = staged.get_mapped_range().map_err(|e| lost(e.to_string()))?;
        self.counters.bytes_read.add(view.len() as u64);
        look(&view);
        drop(view);
        staged.buffer().unmap();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reads go through one buffer, of which only the part that was asked for comes back.
    #[test]
    fn a_second_read_creates_no_buffer() {
        let gpu = pollster::block_on(Gpu::open()).expect("a device");
        let usage = wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
        let source = gpu.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: 4096,
            usage,
            mapped_at_creation: false,
        });
        let bytes: Vec<u8> = (0..4096).map(|i| (i % 251) as u8).collect();
        gpu.write_buffer(&source, 0, &bytes);
        let read = |count: usize| pollster::block_on(gpu.read_back(&source, count as u64));
        assert_eq!(read(4096).expect("bytes"), bytes);
        let created = gpu.counters().buffers;
        for count in [4, 1000, 4096] {
            assert_eq!(read(count).expect("bytes"), bytes[..count]);
        }
        assert_eq!(gpu.counters().buffers, created);
    }
}
