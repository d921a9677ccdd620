//! Textures that are used again once nothing shows them any more.

use argil::gpu::{GpuError, ImageTextures, wgpu};
use std::sync::Arc;

/// Textures on a device.
pub(crate) struct TexturePool {
    device: wgpu::Device,
    kept: Vec<Arc<ImageTextures>>,
}

impl TexturePool {
    /// Creates an empty pool.
    pub(crate) fn new(device: wgpu::Device) -> Self {
        Self {
            device,
            kept: Vec::new(),
        }
    }

    /// Returns textures of a size that nothing shows. Unused ones of other sizes are freed.
    ///
    /// # Errors
    /// If a side is zero, or exceeds the largest texture of the device.
    pub(crate) fn take(&mut self, size: [u32; 2]) -> Result<Arc<ImageTextures>, GpuError> {
        self.kept
            .retain(|own| own.size() == size || Arc::strong_count(own) > 1);
        let mut unused = self.kept.iter().filter(|own| Arc::strong_count(own) == 1);
        if let Some(own) = unused.find(|own| own.size() == size) {
            return Ok(own.clone());
        }
        let own = Arc::new(ImageTextures::new(&self.device, size)?);
        self.kept.push(own.clone());
        Ok(own)
    }
}
