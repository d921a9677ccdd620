//! Dense volumes as a kind of volume, and in files.

use crate::{
    Dense, Encoding, FilePart, FileReader, RESOLUTION_RANGE, Section, VolumeError, VolumeInfo,
    VolumeKind, VoxelGrid,
};
use glam::{IVec3, Vec3};

impl VolumeKind for Dense {
    const KIND: u32 = 1;

    fn voxel_grid(&self) -> &VoxelGrid {
        Dense::voxel_grid(self)
    }

    fn encoding(&self) -> &Encoding {
        Dense::encoding(self)
    }

    fn memory_bytes(&self) -> u64 {
        Dense::memory_bytes(self)
    }

    fn info(&self) -> VolumeInfo {
        VolumeInfo {
            levels: self.levels().len() as u32,
            ..VolumeInfo::new(*self.voxel_grid(), *self.encoding(), self.memory_bytes())
        }
    }

    fn distance_in(&self, point: Vec3) -> Option<(f32, bool)> {
        self.distance(0, point).map(|d| (d, true))
    }

    fn file_parts(&self) -> FilePart<'_> {
        let texels = (0..).zip(self.levels());
        FilePart {
            kind_parameters: [self.levels().len() as u32, 0, 0],
            sections: texels
                .map(|(level, texels)| (Section::Texels(level), texels.bytes().into()))
                .collect(),
        }
    }

    fn fits_file(voxel_grid: &VoxelGrid, _version: u32) -> bool {
        RESOLUTION_RANGE.contains(&voxel_grid.size.max_element()) && voxel_grid.begin == IVec3::ZERO
    }

    fn from_file(
        file: &FileReader<'_>,
        voxel_grid: VoxelGrid,
        encoding: Encoding,
        [levels, _, _]: [u32; 3],
    ) -> Result<Self, VolumeError> {
        let most = Dense::max_levels(&voxel_grid);
        if !(1..=most).contains(&levels) {
            let reason = format!("{levels} levels, and the volume's size makes {most} at most");
            return Err(file.fault(Section::Description, &reason));
        }
        let texels = (0..levels)
            .map(|level| file.texels(level as u8, encoding.format, voxel_grid.texel_count(level)))
            .collect::<Result<_, _>>()?;
        Dense::from_levels(voxel_grid, encoding, texels)
            .ok_or_else(|| file.fault(Section::Texels(0), "its size is another"))
    }
}
