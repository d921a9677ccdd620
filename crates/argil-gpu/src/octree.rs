//! Octrees on the device: `Octree::select`, `Octree::sort`, `Octree::fill`, `Octree::build`. No step waits for the
//! CPU.

mod build;

pub(crate) use self::build::{fill_module, select_module, tree_module};

use crate::bindings::{Bind, LINEAR, NODES, STORED, TREE_WGSL, TREE_WORDS, VOLUME, VOLUME_WGSL};
use crate::resources::{read_level, read_table, texture, upload};
use crate::storage_buffer::StorageBuffer;
use crate::trace_mode::{BoundResource, TraceMode};
use crate::volume::{Upload, VolumeStorage, VolumeTables};
use crate::work::Work;
use crate::{Gpu, GpuError, GpuProgram, GpuVolume};
use argil_abi::{self as abi, FrameUniform, OctreeNode, OctreeUniform};
use argil_volume::{Octree, OctreeInfo, OctreeLayout, OctreeNodes, Volume, VolumeInfo};
use std::borrow::Cow;

/// The tables of an octree.
#[derive(Debug)]
struct OctreeTables {
    layout: OctreeLayout,
    keys: StorageBuffer,
    nodes: StorageBuffer,
    words: StorageBuffer,
    /// The uniform for shaders.
    uniform: OctreeUniform,
}

pub(super) const OCTREE_WGSL: &str = "
@group(0) @binding(BIND_VOLUME) var<uniform> volume: OctreeUniform;
";

pub(crate) static OCTREE: TraceMode = TraceMode {
    name: "octree",
    more_name: "octree with more light",
    march: argil_render::wgsl::OCTREE,
    tables: || {
        [
            OCTREE_WGSL,
            VOLUME_WGSL,
            TREE_WGSL,
            argil_math::morton_wgsl(),
        ]
        .concat()
    },
    binds: &[
        Bind::Uniform(VOLUME),
        Bind::Texture(STORED),
        Bind::Filter(LINEAR),
        Bind::Read(NODES),
        Bind::Read(TREE_WORDS),
    ],
    constants: &[],
    draws: false,
    is_exact: false,
    paths: None,
    host: None,
    has_cones: false,
    by_lists: false,
};

impl VolumeTables for OctreeTables {
    fn way(&self) -> &'static TraceMode {
        &OCTREE
    }

    fn bind(&self, bound: &mut Vec<BoundResource>) {
        bound.extend(self.nodes.bound(NODES));
        bound.extend(self.words.bound(TREE_WORDS));
    }

    fn uniform(&self, _: &FrameUniform) -> Cow<'_, [u8]> {
        bytemuck::bytes_of(&self.uniform).into()
    }

    fn memory_bytes(&self, body: &VolumeStorage) -> u64 {
        body.texture_bytes() + self.keys.size() + self.nodes.size() + self.words.size()
    }

    fn info<'a>(&'a self, info: VolumeInfo, gpu: &'a Gpu) -> Work<'a, VolumeInfo> {
        Box::pin(async move {
            let words = self.read_words(gpu).await?;
            let word = |i: u32| u64::from(words.get(i as usize).copied().unwrap_or(0));
            let mut info = info;
            info.octree = Some(OctreeInfo {
                layout: self.layout,
                bricks: word(abi::OCTREE_HEADER_BRICKS),
                nodes: word(abi::OCTREE_HEADER_NODES),
            });
            Ok(info)
        })
    }

    fn read<'a>(&'a self, body: &'a VolumeStorage, gpu: &'a Gpu) -> Work<'a, Volume> {
        Box::pin(async move {
            let tree = self.read_tree(gpu).await?;
            let measures = (&body.voxel_grid, body.encoding.format);
            let texels = read_level(gpu, &body.texture, measures, 0).await?;
            let octree = Octree::from_parts(self.layout, tree, texels);
            Ok(Volume::Octree(octree.ok_or_else(GpuError::odd_volume)?))
        })
    }
}

impl Upload for Octree {
    fn upload<'a>(&'a self, field: &'a GpuProgram) -> Work<'a, GpuVolume> {
        Box::pin(async move {
            let gpu = field.gpu();
            let layout = *self.layout();
            let texture = texture(gpu, &layout.voxel_grid, layout.encoding.format, 1)?;
            upload(gpu, &texture, &layout.voxel_grid, 0, self.texels()).await?;
            let tree = self.tree();
            let mut tables = OctreeTables::new(layout);
            let mut words = [0u32; abi::OCTREE_HEADER_WORDS as usize];
            words[abi::OCTREE_HEADER_BRICKS as usize] = tree.codes().len() as u32;
            words[abi::OCTREE_HEADER_NODES as usize] = tree.nodes().len() as u32;
            let levels = &mut words[abi::OCTREE_HEADER_LEVELS as usize..];
            for (to, from) in levels.iter_mut().zip(tree.levels()) {
                *to = *from;
            }
            tables.words.write(gpu, &words)?;
            tables.keys.write(gpu, tree.codes())?;
            tables.nodes.write(gpu, tree.nodes())?;
            let measures = (layout.voxel_grid, layout.encoding);
            GpuVolume::new(field, measures, texture, tables)
        })
    }
}

impl OctreeTables {
    fn new(layout: OctreeLayout) -> Self {
        Self {
            layout,
            keys: StorageBuffer::new("bricks' codes"),
            nodes: StorageBuffer::new("nodes"),
            words: StorageBuffer::new("tree"),
            uniform: octree_words(&layout),
        }
    }

    async fn read_words(&self, gpu: &Gpu) -> Result<Vec<u32>, GpuError> {
        let bytes = read_table(gpu, &self.words, 4 * u64::from(abi::OCTREE_HEADER_WORDS)).await?;
        Ok(bytes
            .chunks_exact(4)
            .map(bytemuck::pod_read_unaligned)
            .collect())
    }

    /// Downloads the tree.
    async fn read_tree(&self, gpu: &Gpu) -> Result<OctreeNodes, GpuError> {
        let words = self.read_words(gpu).await?;
        let word = |i: u32| words.get(i as usize).copied().unwrap_or(0);
        let (bricks, nodes) = (
            word(abi::OCTREE_HEADER_BRICKS),
            word(abi::OCTREE_HEADER_NODES),
        );
        let codes = read_table(gpu, &self.keys, 4 * u64::from(bricks))
            .await?
            .chunks_exact(4)
            .map(bytemuck::pod_read_unaligned)
            .collect();
        let nodes = read_table(
            gpu,
            &self.nodes,
            size_of::<OctreeNode>() as u64 * u64::from(nodes),
        )
        .await?
        .chunks_exact(size_of::<OctreeNode>())
        .map(bytemuck::pod_read_unaligned)
        .collect();
        let levels = (0..self.layout.depth)
            .map(|level| word(abi::OCTREE_HEADER_LEVELS + level))
            .collect();
        Ok(OctreeNodes::from_parts(codes, nodes, levels))
    }
}

/// Returns the uniform for rays, which does not depend on the program.
fn octree_words(layout: &OctreeLayout) -> OctreeUniform {
    let voxel_grid = &layout.voxel_grid;
    OctreeUniform {
        corner: voxel_grid.corner.to_array(),
        band_width: layout.encoding.band_width(voxel_grid, 0),
        extent: voxel_grid.extent().to_array(),
        voxel_size: voxel_grid.voxel_size,
        grid_x: layout.size_bricks.x,
        grid_y: layout.size_bricks.y,
        grid_z: layout.size_bricks.z,
        brick_size_voxels: layout.brick_size_voxels,
        depth: layout.depth,
        code_count: layout.code_count(),
        ..OctreeUniform::default()
    }
}
