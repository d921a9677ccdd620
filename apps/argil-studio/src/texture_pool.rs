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
            .retain(|textures| textures.size() == size || Arc::strong_count(textures) > 1);
        let mut unused = self
            .kept
            .iter()
            .filter(|textures| Arc::strong_count(textures) == 1);
        if let Some(textures) = unused.find(|textures| textures.size() == size) {
            return Ok(textures.clone());
        }
        let textures = Arc::new(ImageTextures::new(&self.device, size)?);
        self.kept.push(textures.clone());
        Ok(textures)
    }
}
