//! Structs that buffers hold.

use crate::declare::shared_struct;
use crate::layout::StructLayout;
use crate::volumes::{BrickBuild, BrickVolume, CellTable, DenseVolume, OctreeVolume};

shared_struct! {
    /// One step of a field program.
    Instruction {
        /// An `OP_…`.
        op: u32,
        /// `COMBINE_…` and `FLAG_…` bits.
        flags: u32,
        /// Where its words start in the table of parameters.
        params: u32,
        /// Index into the table of materials; for `OP_NEXT`, the instruction to go back to.
        operand: u32,
    }
}

shared_struct! {
    /// What a surface looks like. Colors are linear, components in [0, 1] but for the emission.
    GpuMaterial {
        /// Base color, then roughness.
        base_roughness: [f32; 4],
        /// Emitted light, then metallic.
        emission_metallic: [f32; 4],
    }
}

shared_struct! {
    /// What tracing and shading read: one frame, one sample of each pixel. Lengths in the world's unit.
    FrameUniform {
        /// Where rays start.
        eye: [f32; 3],
        /// The reciprocal of the field's Lipschitz constant: how far a distance of 1 lets a ray go.
        inv_lipschitz: f32,
        /// The camera's x axis times the half width of the picture at distance 1.
        right: [f32; 3],
        /// A sample's offset in its pixel in x, from 0 to 1.
        jitter_x: f32,
        /// The camera's y axis times the half height of the picture at distance 1.
        up: [f32; 3],
        /// A sample's offset in its pixel in y, from 0 to 1.
        jitter_y: f32,
        /// The camera's viewing direction.
        forward: [f32; 3],
        /// Height of the ground.
        ground_y: f32,
        /// Least corner of the box outside which nothing lies.
        box_min: [f32; 3],
        /// The distance under which a ray has hit.
        epsilon: f32,
        /// Greatest corner of that box.
        box_max: [f32; 3],
        /// The offset of the normal's central differences.
        normal_bias: f32,
        /// Direction to the sun.
        sun: [f32; 3],
        /// The scene's radius.
        radius: f32,
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
        /// The first row of this dispatch.
        first_row: u32,
        /// Most steps a ray takes.
        max_steps: u32,
        /// A `SHOW_…`.
        show: u32,
        /// One over the number of samples a pixel.
        sample_weight: f32,
        /// Farthest length at which a ray may hit the ground.
        far: f32,
        /// Depth that is drawn white.
        depth_near: f32,
        /// Depth that is drawn black.
        depth_far: f32,
        /// A pixel's width at distance 1.
        pixel: f32,
        /// The first step of this dispatch: a march can be spread over several.
        first_step: u32,
        /// Most steps of this dispatch.
        step_count: u32,
        /// How far above a surface its light is gathered.
        lift: f32,
        /// A `NORMALS_…`: how bricks give normals.
        normals: u32,
        /// 1 if a ground plane lies under the scene, else 0.
        has_ground: u32,
        /// A `DESCENT_…`: where look-ups in an octree begin.
        descent: u32,
    }
}

shared_struct! {
    /// What a primary ray found.
    Hit {
        /// Unit normal towards the viewer, then the length of the ray. All zero where nothing was hit.
        normal_t: [f32; 4],
        /// A `HIT_…`.
        kind: u32,
        /// Everything that the ray looked up: samples, nodes and cells. The normal's samples are not counted.
        steps: u32,
        /// On the GPU, how much of the sun the point sees; else 0.
        sun_share: f32,
        /// On the GPU, how far that search has come, negative once it is done; else 0.
        sun_t: f32,
        /// Of the steps, nodes of a tree that were visited.
        descents: u32,
        /// Of the steps, cells of a grid that were walked through.
        cells: u32,
        /// What is shown as a color: 1 and the place of a sparse brick's word, or the Morton code of an octree's brick or of
        /// a node above bricks; else 0.
        mark: u32,
        /// Zero.
        pad0: u32,
    }
}

shared_struct! {
    /// A point to evaluate the field at.
    QueryUniform {
        /// Position, then a spare word.
        point: [f32; 4],
    }
}

shared_struct! {
    /// The field's answer at a point.
    QueryResult {
        /// Signed distance, three spare words.
        distance: [f32; 4],
        /// Base color, then roughness.
        base_roughness: [f32; 4],
        /// Emitted light, then metallic.
        emission_metallic: [f32; 4],
    }
}

shared_struct! {
    /// What one dispatch samples of a level of a volume.
    FillUniform {
        /// Center of the level's first texel, then what is taken off each distance to make it conservative.
        first_bias: [f32; 4],
        /// Between texels, then stored integers per unit of length.
        spacing_scale: [f32; 4],
        /// Texels along x.
        size_x: u32,
        /// Texels along y.
        size_y: u32,
        /// Texels along z.
        size_z: u32,
        /// The first layer of texels of each tile.
        first_layer: u32,
        /// Layers of each tile.
        layer_count: u32,
        /// Texels along a tile's side.
        tile: u32,
        /// The stored integer of 1.0.
        quanta: u32,
        /// Zero.
        pad0: u32,
    }
}

shared_struct! {
    /// Where the lists stand by which bricks are made, and in which blocks that is.
    PruneUniform {
        /// What the margin of two distances has besides the Lipschitz constant's share.
        slack: f32,
        /// Where those of blocks stand.
        blocks_first: u32,
        /// Where those of cells that the surface can be in stand.
        cells_first: u32,
        /// Where lists stand; first that of the whole program.
        arena_first: u32,
        /// Words that there are for them.
        arena_words: u32,
        /// How many cells can have a list of their own; the others have their block's.
        cells_room: u32,
        /// Blocks that are made.
        count: u32,
        /// A `MAKE_…`: blocks, or what they would need.
        make: u32,
        /// Where the slots of the blocks stand.
        blocks_at: u32,
        /// Where it stands which of their cells are to be sampled, two words each.
        dirty_first: u32,
        /// Where among the cells near the surface the bricks stand that are freed; those of mixed ones as far on again.
        freed_first: u32,
        /// Where it stands what is known of distances in each block, six words each.
        bounds_first: u32,
    }
}

shared_struct! {
    /// How the surface of a volume is cut into triangles.
    MarchingUniform {
        /// Where the first sample lies, then a voxel's edge.
        first_voxel: [f32; 4],
        /// The level of the surface, in stored integers.
        iso: f32,
        /// The length that one of those stands for.
        quantum: f32,
        /// How far to the sides the field is asked for normals.
        bias: f32,
        /// Bricks, or parts of a dense volume.
        units: u32,
        /// Cells along the side of one.
        side: u32,
        /// A `MARCH_…`.
        normals: u32,
        /// 1 where vertices go to the exact surface of the field, else 0.
        is_moved: u32,
        /// Vertices that there are.
        vertices: u32,
        /// Triangles that there are.
        triangles: u32,
        /// The first vertex that a dispatch moves.
        first_vertex: u32,
        /// Zero.
        pad1: u32,
        /// Zero.
        pad2: u32,
    }
}

shared_struct! {
    /// A node of an octree. Child `i` of a node of level `l` stands at the offset of the level below, plus
    /// `child_offset`, plus the number of bits of `valid_mask` under `i`.
    Node {
        /// The first child's place in its level.
        child_offset: u32,
        /// A bit for each child that is there.
        valid_mask: u32,
        /// A bit for each child that is a brick.
        leaf_mask: u32,
    }
}

pub(crate) const STRUCTS: &[(StructLayout, &[&str])] = &[
    (Instruction::LAYOUT, Instruction::FIELD_TYPES),
    (GpuMaterial::LAYOUT, GpuMaterial::FIELD_TYPES),
    (FrameUniform::LAYOUT, FrameUniform::FIELD_TYPES),
    (Hit::LAYOUT, Hit::FIELD_TYPES),
    (QueryUniform::LAYOUT, QueryUniform::FIELD_TYPES),
    (QueryResult::LAYOUT, QueryResult::FIELD_TYPES),
    (DenseVolume::LAYOUT, DenseVolume::FIELD_TYPES),
    (OctreeVolume::LAYOUT, OctreeVolume::FIELD_TYPES),
    (CellTable::LAYOUT, CellTable::FIELD_TYPES),
    (BrickVolume::LAYOUT, BrickVolume::FIELD_TYPES),
    (BrickBuild::LAYOUT, BrickBuild::FIELD_TYPES),
    (FillUniform::LAYOUT, FillUniform::FIELD_TYPES),
    (PruneUniform::LAYOUT, PruneUniform::FIELD_TYPES),
    (MarchingUniform::LAYOUT, MarchingUniform::FIELD_TYPES),
    (Node::LAYOUT, Node::FIELD_TYPES),
];
