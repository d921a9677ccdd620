//! Octrees as a kind of volume, and in files.

use crate::{
    BrickTest, Encoding, FilePart, FileReader, Octree, OctreeInfo, OctreeLayout, OctreeNodes,
    OctreeSettings, RESOLUTION_RANGE, Section, VolumeError, VolumeInfo, VolumeKind, VoxelGrid,
};
use glam::{IVec3, Vec3};

impl VolumeKind for Octree {
    const KIND: u32 = 2;

    fn voxel_grid(&self) -> &VoxelGrid {
        &self.layout().voxel_grid
    }

    fn encoding(&self) -> &Encoding {
        &self.layout().encoding
    }

    fn memory_bytes(&self) -> u64 {
        Octree::memory_bytes(self)
    }

    fn info(&self) -> VolumeInfo {
        VolumeInfo {
            octree: Some(OctreeInfo {
                layout: *self.layout(),
                bricks: self.tree().codes().len() as u64,
                nodes: self.tree().nodes().len() as u64,
            }),
            ..VolumeInfo::new(*self.voxel_grid(), *self.encoding(), self.memory_bytes())
        }
    }

    fn distance_in(&self, _: Vec3) -> Option<(f32, bool)> {
        // A vacant cell stores a lower bound for all its samples, but no distance at a point.
        None
    }

    fn file_parts(&self) -> FilePart<'_> {
        let (layout, tree) = (self.layout(), self.tree());
        let numbers = |words| bytemuck::cast_slice::<u32, u8>(words).into();
        FilePart {
            kind_parameters: [1, layout.brick_size_voxels, layout.depth],
            sections: vec![
                (Section::Codes, numbers(tree.codes())),
                (Section::Nodes, bytemuck::cast_slice(tree.nodes()).into()),
                (Section::Levels, numbers(tree.levels())),
                (Section::Texels(0), self.texels().bytes().into()),
            ],
        }
    }

    fn fits_file(voxel_grid: &VoxelGrid, _version: u32) -> bool {
        RESOLUTION_RANGE.contains(&voxel_grid.size.max_element()) && voxel_grid.begin == IVec3::ZERO
    }

    fn from_file(
        file: &FileReader<'_>,
        voxel_grid: VoxelGrid,
        encoding: Encoding,
        [_, brick, depth]: [u32; 3],
    ) -> Result<Self, VolumeError> {
        let settings = OctreeSettings {
            encoding,
            brick_size_voxels: brick,
            depth: Some(depth),
            brick_test: BrickTest::Conservative,
        };
        let layout = OctreeLayout::new(voxel_grid, &settings)
            .map_err(|e| file.fault(Section::Description, &e.to_string()))?;
        let nodes = file.bytes(Section::Nodes)?;
        if !nodes
            .len()
            .is_multiple_of(size_of::<argil_abi::OctreeNode>())
        {
            return Err(file.fault(Section::Nodes, "its length is not a multiple of a node"));
        }
        let nodes = nodes
            .chunks_exact(size_of::<argil_abi::OctreeNode>())
            .map(bytemuck::pod_read_unaligned)
            .collect();
        let tree = OctreeNodes::from_parts(
            file.words(Section::Codes)?,
            nodes,
            file.words(Section::Levels)?,
        );
        if let Some(reason) = tree.check(&layout) {
            return Err(file.fault(Section::Nodes, reason));
        }
        let texels = file.texels(0, encoding.format, voxel_grid.texel_count(0))?;
        Octree::from_parts(layout, tree, texels)
            .ok_or_else(|| file.fault(Section::Texels(0), "its size is another"))
    }
}
