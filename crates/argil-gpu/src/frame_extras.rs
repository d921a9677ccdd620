//! What only some representations need of a frame, and what a frame returns.

use crate::storage_buffer::StorageBuffer;
use crate::timing::Timing;
use crate::{Gpu, ImageOutput, ImageTextures};
use argil_render::RenderOutput;

/// Triangles that a sample begins with.
pub(crate) trait Drawing: Sync {
    /// Draws them with a frame at an offset of a buffer of frames.
    fn draw(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        frames: (&wgpu::Buffer, u32),
        timing: Option<&mut Timing>,
    );
}

/// What only some representations need of a frame.
#[derive(Clone, Copy)]
pub(crate) struct FrameExtras<'a> {
    /// Triangles that each sample begins with.
    pub drawing: Option<&'a dyn Drawing>,
    /// A table that rays mark. It is cleared before, and downloaded with the picture.
    pub marks: Option<&'a StorageBuffer>,
    /// Where the image goes.
    pub output: ImageOutput<'a>,
}

impl<'a> FrameExtras<'a> {
    /// Returns an image without triangles and marks.
    pub(crate) fn of(output: ImageOutput<'a>) -> Self {
        Self {
            drawing: None,
            marks: None,
            output,
        }
    }

    /// Returns the textures that the image goes to.
    pub(crate) fn textures(&self) -> Option<&'a ImageTextures> {
        match self.output {
            ImageOutput::Textures(textures) => Some(textures),
            _ => None,
        }
    }
}

/// A frame that was downloaded.
pub(crate) struct DrawnFrame {
    pub picture: RenderOutput,
    /// The duration of its passes.
    pub duration_ms: f64,
    /// What rays marked.
    pub marks: Vec<u8>,
}
