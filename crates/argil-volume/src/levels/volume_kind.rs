//! Levels as a kind of volume.

use super::layout::LevelsLayout;
use super::pending::LevelsPendingEdits;
use super::tree::Levels;
use crate::{
    BrickInfo, BricksError, EditStats, Encoding, FilePart, FileReader, PendingEdits, VolumeError,
    VolumeInfo, VolumeKind, VoxelGrid,
};
use argil_field::IncrementalProgram;
use glam::Vec3;
use web_time::Instant;

impl LevelsLayout {
    /// Returns the voxel grid of the finest level.
    pub fn finest_grid(&self) -> &VoxelGrid {
        &self.finest().voxel_grid
    }
}

impl VolumeKind for Levels {
    const KIND: u32 = 4;

    fn voxel_grid(&self) -> &VoxelGrid {
        self.layout.finest_grid()
    }

    fn encoding(&self) -> &Encoding {
        &self.layout.finest().encoding
    }

    fn memory_bytes(&self) -> u64 {
        Levels::memory_bytes(self)
    }

    fn info(&self) -> VolumeInfo {
        VolumeInfo {
            levels: self.layout.count(),
            bricks: Some(BrickInfo {
                layout: self.layout.level(0),
                bricks: self.brick_count(),
            }),
            ..VolumeInfo::new(*self.voxel_grid(), *self.encoding(), self.memory_bytes())
        }
    }

    fn distance_in(&self, point: Vec3) -> Option<(f32, bool)> {
        Some(self.lookup(point))
    }

    fn edits(&self) -> Option<Box<dyn PendingEdits>> {
        Some(Box::new(LevelsPendingEdits::of(self.layout)))
    }

    fn grow(&mut self, edits: &dyn PendingEdits) {
        if let Some(edits) = LevelsPendingEdits::downcast_ref(edits) {
            self.grow_to(edits.layout);
        }
    }

    fn edit(
        &mut self,
        live: &IncrementalProgram,
        edits: &mut dyn PendingEdits,
        _: Option<u64>,
        until: Option<Instant>,
    ) -> Result<EditStats, BricksError> {
        match LevelsPendingEdits::downcast_mut(edits) {
            Some(edits) => Levels::edit(self, live, edits, until),
            _ => Ok(EditStats::default()),
        }
    }

    fn file_parts(&self) -> FilePart<'_> {
        // Which pages are resident is of no use elsewhere.
        FilePart {
            kind_parameters: [0; 3],
            sections: Vec::new(),
        }
    }

    fn fits_file(_: &VoxelGrid, _: u32) -> bool {
        false
    }

    fn from_file(
        _: &FileReader<'_>,
        _: VoxelGrid,
        _: Encoding,
        _: [u32; 3],
    ) -> Result<Self, VolumeError> {
        Err(VolumeError::NotAVolumeFile("levels".into()))
    }
}
