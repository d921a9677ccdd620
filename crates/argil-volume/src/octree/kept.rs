//! An octree as a representation, and in a volume file.

use crate::{
    Encoding, FilePart, FileReader, Keep, Lattice, Layout, Octree, OctreeSettings, RESOLUTIONS,
    Representation, Section, Tree, TreeInfo, VolumeError, VolumeInfo,
};
use glam::{IVec3, Vec3};

impl Representation for Octree {
    const KIND: u32 = 2;

    fn lattice(&self) -> &Lattice {
        &self.layout().lattice
    }

    fn encoding(&self) -> &Encoding {
        &self.layout().encoding
    }

    fn memory_bytes(&self) -> u64 {
        Octree::memory_bytes(self)
    }

    fn info(&self) -> VolumeInfo {
        VolumeInfo {
            tree: Some(TreeInfo {
                layout: *self.layout(),
                bricks: self.tree().codes().len() as u64,
                nodes: self.tree().nodes().len() as u64,
            }),
            ..VolumeInfo::new(*self.lattice(), *self.encoding(), self.memory_bytes())
        }
    }

    fn distance_in(&self, _: Vec3) -> Option<(f32, bool)> {
        // A cell without a brick knows what none of its texels falls short of, but not where between them.
        None
    }

    fn file_parts(&self) -> FilePart<'_> {
        let (layout, tree) = (self.layout(), self.tree());
        let numbers = |words| bytemuck::cast_slice::<u32, u8>(words).into();
        FilePart {
            own: [1, layout.brick, layout.depth],
            sections: vec![
                (Section::Codes, numbers(tree.codes())),
                (Section::Nodes, bytemuck::cast_slice(tree.nodes()).into()),
                (Section::Levels, numbers(tree.levels())),
                (Section::Texels(0), self.texels().bytes().into()),
            ],
        }
    }

    fn fits_file(lattice: &Lattice, _version: u32) -> bool {
        RESOLUTIONS.contains(&lattice.size.max_element()) && lattice.begin == IVec3::ZERO
    }

    fn from_file(
        file: &FileReader<'_>,
        lattice: Lattice,
        encoding: Encoding,
        [_, brick, depth]: [u32; 3],
    ) -> Result<Self, VolumeError> {
        let settings = OctreeSettings {
            encoding,
            brick,
            depth: Some(depth),
            keep: Keep::Conservative,
        };
        let layout = Layout::new(lattice, &settings)
            .map_err(|e| file.fault(Section::Description, &e.to_string()))?;
        let nodes = file.bytes(Section::Nodes)?;
        if !nodes.len().is_multiple_of(size_of::<argil_abi::Node>()) {
            return Err(file.fault(Section::Nodes, "half a node is left"));
        }
        let nodes = nodes
            .chunks_exact(size_of::<argil_abi::Node>())
            .map(bytemuck::pod_read_unaligned)
            .collect();
        let tree = Tree::from_parts(
            file.words(Section::Codes)?,
            nodes,
            file.words(Section::Levels)?,
        );
        if let Some(reason) = tree.check(&layout) {
            return Err(file.fault(Section::Nodes, reason));
        }
        let texels = file.texels(0, encoding.bits, lattice.texel_count(0))?;
        Octree::from_parts(layout, tree, texels)
            .ok_or_else(|| file.fault(Section::Texels(0), "its size is another"))
    }
}
