//! What builds and edits of bricks write besides the volume.

use crate::pass_recorder::PassRecorder;
use crate::resources::uniform_of;
use crate::storage_buffer::StorageBuffer;
use crate::{Gpu, GpuError};
use argil_abi::{BrickBuildUniform, FillUniform, PruneUniform};

/// Bytes of an indirect dispatch's size.
pub(super) const ARGUMENT_BYTES: u64 = 12;

/// The volume in which bricks are built.
pub(crate) struct BrickTargets<'a> {
    pub texture: &'a wgpu::Texture,
    pub cells: &'a StorageBuffer,
    pub materials: &'a StorageBuffer,
    pub counters: &'a StorageBuffer,
}

/// What the passes write besides the volume, and their uniforms.
#[derive(Debug)]
pub(super) struct EditScratch {
    pub lists: StorageBuffer,
    pub candidates: StorageBuffer,
    pub arguments: StorageBuffer,
    /// Indirect dispatches read another buffer than the one that is written.
    pub indirect: Option<wgpu::Buffer>,
    pub words: wgpu::Buffer,
    /// What the fill uniform is for each dispatch.
    pub fills: StorageBuffer,
    pub fill: wgpu::Buffer,
    pub prune: wgpu::Buffer,
}

impl EditScratch {
    pub(super) fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let [words, fill, prune] = gpu.with_error_scope(|| {
            [
                uniform_of::<BrickBuildUniform>(gpu, "volume"),
                uniform_of::<FillUniform>(gpu, "fill"),
                uniform_of::<PruneUniform>(gpu, "prune"),
            ]
        })?;
        Ok(Self {
            lists: StorageBuffer::new("lists"),
            candidates: StorageBuffer::new("cells near the surface"),
            arguments: StorageBuffer::new("bricks to fill"),
            indirect: None,
            words,
            fills: StorageBuffer::new("fill uniforms"),
            fill,
            prune,
        })
    }

    /// Returns the bytes on the device.
    pub(super) fn size(&self) -> u64 {
        let indirect = self.indirect.as_ref().map_or(0, wgpu::Buffer::size);
        let fills = self.fills.size();
        self.lists.size() + self.candidates.size() + self.arguments.size() + fills + indirect
    }

    /// Makes room for the candidates of some blocks: two words for each cell near the surface, and for each cell a freed brick, a
    /// freed mixed one, and its number among those near the surface.
    pub(super) fn reserve_candidates(&mut self, gpu: &Gpu, blocks: u32) -> Result<(), GpuError> {
        self.candidates.reserve(gpu, 4 * 64 * 5 * u64::from(blocks))
    }

    /// Clears the numbers of cells near the surface, which follow the freed bricks.
    pub(super) fn clear_candidates(&self, prune: &PruneUniform, recorder: &mut PassRecorder<'_>) {
        let words = 64 * u64::from(prune.count);
        let first = u64::from(prune.freed_first) + 2 * words;
        if let Some(buffer) = self.candidates.buffer() {
            recorder
                .encoder()
                .clear_buffer(buffer, 4 * first, Some(4 * words));
        }
    }

    pub(super) fn reserve_arguments(&mut self, gpu: &Gpu, chunks: u32) -> Result<(), GpuError> {
        let bytes = (ARGUMENT_BYTES * u64::from(chunks)).next_multiple_of(16);
        self.arguments.reserve_exact(gpu, bytes)?;
        if self.indirect.as_ref().is_none_or(|b| b.size() < bytes) {
            let buffer = gpu.with_error_scope(|| {
                gpu.create_buffer(&wgpu::BufferDescriptor {
                    label: Some("bricks to fill"),
                    size: bytes,
                    usage: wgpu::BufferUsages::INDIRECT | wgpu::BufferUsages::COPY_DST,
                    mapped_at_creation: false,
                })
            })?;
            self.indirect = Some(buffer);
        }
        Ok(())
    }
}

/// What edits write besides the volume, kept from one to the next.
#[derive(Debug)]
pub(super) struct BuildTables {
    pub scratch: EditScratch,
    pub instructions: StorageBuffer,
}

impl BuildTables {
    pub(super) fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        Ok(Self {
            scratch: EditScratch::new(gpu)?,
            instructions: StorageBuffer::new("instructions of lists"),
        })
    }

    /// Returns the bytes on the device.
    pub(super) fn size(&self) -> u64 {
        self.scratch.size() + self.instructions.size()
    }
}
