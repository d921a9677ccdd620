//! What builds and edits of bricks write besides the volume.

use crate::resources::uniform_of;
use crate::table::Table;
use crate::{Gpu, GpuError};
use argil_abi::{BrickBuild, Fill, Prune};

/// The volume that bricks are made in.
pub(crate) struct Site<'a> {
    pub texture: &'a wgpu::Texture,
    pub cells: &'a Table,
    pub materials: &'a Table,
    pub counters: &'a Table,
}

/// What the passes write besides the volume, and their uniforms.
pub(super) struct Scratch {
    pub lists: Table,
    pub candidates: Table,
    pub arguments: Table,
    /// What is dispatched is read from another buffer than it is written to.
    pub indirect: Option<wgpu::Buffer>,
    pub words: wgpu::Buffer,
    pub fill: wgpu::Buffer,
    pub prune: wgpu::Buffer,
}

impl Scratch {
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let [words, fill, prune] = gpu.checked(|| {
            [
                uniform_of::<BrickBuild>(gpu, "volume"),
                uniform_of::<Fill>(gpu, "fill"),
                uniform_of::<Prune>(gpu, "prune"),
            ]
        })?;
        Ok(Self {
            lists: Table::new("lists"),
            candidates: Table::new("cells near the surface"),
            arguments: Table::new("bricks to fill"),
            indirect: None,
            words,
            fill,
            prune,
        })
    }

    /// Bytes on the device.
    pub fn size(&self) -> u64 {
        let indirect = self.indirect.as_ref().map_or(0, wgpu::Buffer::size);
        self.lists.size() + self.candidates.size() + self.arguments.size() + indirect
    }

    pub fn reserve_arguments(&mut self, gpu: &Gpu, chunks: u32) -> Result<(), GpuError> {
        let bytes = (24 * u64::from(chunks)).next_multiple_of(16);
        self.arguments.reserve_exact(gpu, bytes)?;
        if self.indirect.as_ref().is_none_or(|b| b.size() < bytes) {
            let buffer = gpu.checked(|| {
                gpu.device.create_buffer(&wgpu::BufferDescriptor {
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
pub(super) struct Making {
    pub scratch: Scratch,
    pub instrs: Table,
}

impl Making {
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        Ok(Self {
            scratch: Scratch::new(gpu)?,
            instrs: Table::new("instructions of lists"),
        })
    }

    /// Bytes on the device.
    pub fn size(&self) -> u64 {
        self.scratch.size() + self.instrs.size()
    }
}
