//! Structs of buffers.

use crate::declare::shared_struct;
use crate::layout::StructLayout;
use crate::paths::LAMP_ROWS;
use crate::paths::{PathPixel, PathState, PathUniform};
use crate::volumes::{
    BrickBuildUniform, BrickUniform, CellTable, DenseUniform, LevelsUniform, OctreeUniform,
};

shared_struct! {
    /// One step of a program.
    Instruction {
        /// An `OP_…`.
        op: u32,
        /// `COMBINE_…` and `FLAG_…` bits.
        flags: u32,
        /// Index of its first word in the table of parameters.
        params: u32,
        /// Index into the table of materials; for `OP_NEXT`, the instruction to return to.
        operand: u32,
    }
}

shared_struct! {
    /// A material. Colors are linear, with components in [0, 1] except for the emission.
    GpuMaterial {
        /// Base color, then roughness.
        base_roughness: [f32; 4],
        /// Emitted light, then metalness.
        emission_metallic: [f32; 4],
    }
}

shared_struct! {
    /// What tracing and shading read: one frame, with one sample per pixel. Lengths are in the scene's unit.
    FrameUniform {
        /// Start of rays.
        eye: [f32; 3],
        /// Reciprocal of the field's Lipschitz constant: how far a distance of 1 lets a ray advance.
        inv_lipschitz: f32,
        /// The camera's x axis times the half width of the image at distance 1.
        right: [f32; 3],
        /// A sample's offset in its pixel in x, from 0 to 1.
        jitter_x: f32,
        /// The camera's y axis times the half height of the image at distance 1.
        up: [f32; 3],
        /// A sample's offset in its pixel in y, from 0 to 1.
        jitter_y: f32,
        /// The camera's viewing direction.
        forward: [f32; 3],
        /// Height of the ground.
        ground_y: f32,
        /// Minimum corner of the box that contains the solid.
        box_min: [f32; 3],
        /// The distance below which a ray hits.
        epsilon: f32,
        /// Maximum corner of that box.
        box_max: [f32; 3],
        /// Half the step of the normal's central differences.
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
        /// Maximum steps of a ray.
        max_steps: u32,
        /// A `MODE_…`.
        mode: u32,
        /// Reciprocal of the number of samples per pixel.
        sample_weight: f32,
        /// Maximum length at which a ray may hit the ground.
        far: f32,
        /// Depth that is rendered white.
        depth_near: f32,
        /// Depth that is rendered black. In the mode of heat, steps that are rendered red.
        depth_far: f32,
        /// Width of a pixel at distance 1.
        pixel_width: f32,
        /// The first step of this dispatch, because a march can take several.
        first_step: u32,
        /// Maximum steps of this dispatch.
        step_count: u32,
        /// Height above a surface at which light is gathered.
        light_offset: f32,
        /// A `NORMALS_…`: the source of bricks' normals.
        normals: u32,
        /// 1 if there is a ground plane under the scene, else 0.
        has_ground: u32,
        /// A `DESCENT_…`: where look-ups in an octree start.
        descent: u32,
        /// From the beginning of the middle ray to that at the image's right side: zero if all rays begin in the eye.
        eye_right: [f32; 3],
        /// The distance below which a ray through the field hits after `EXACT_STEPS`, per length of the ray, if that is more than
        /// `epsilon`.
        close_slope: f32,
        /// The same to the image's top.
        eye_up: [f32; 3],
        /// `RECORD_…` bits: what of the rays is stored.
        records: u32,
        /// The sun's light: irradiance divided by π / 2.
        sun_light: [f32; 3],
        /// The factor of all light.
        exposure: f32,
        /// The light from above.
        zenith: [f32; 3],
        /// A `TONE_…`.
        tone: u32,
        /// The light from the horizon.
        horizon: [f32; 3],
        /// How much the sky shines around the sun.
        glow: f32,
        /// The light from below.
        nadir: [f32; 3],
        /// Number of lamps: lights besides the sun.
        lamp_count: u32,
        /// Share of light that fog scatters.
        fog_albedo: [f32; 3],
        /// What fog takes away per unit of length at its height. 0 if there is none.
        fog_density: f32,
        /// How fast it thins out upward.
        fog_falloff: f32,
        /// The height of that density.
        fog_height: f32,
        /// Henyey and Greenstein's g.
        fog_anisotropy: f32,
        /// 1 if occlusion finds bent normals, else 0.
        has_bent_normals: u32,
        /// A host's near plane: its normal, and how far it is from the eye along that. Zero if there is none.
        near_plane: [f32; 4],
        /// Four rows for each lamp, as those of `LIGHT_…`.
        lamps: [[f32; 4]; LAMP_ROWS],
    }
}

shared_struct! {
    /// A point at which to evaluate the field.
    QueryPoint {
        /// Position, then a spare word.
        point: [f32; 4],
    }
}

shared_struct! {
    /// The field's values at a point.
    QueryResult {
        /// Signed distance, three spare words.
        distance: [f32; 4],
        /// Base color, then roughness.
        base_roughness: [f32; 4],
        /// Emitted light, then metalness.
        emission_metallic: [f32; 4],
    }
}

shared_struct! {
    /// What one dispatch samples of a level of a volume.
    FillUniform {
        /// Center of the level's first sample, then the bias that makes distances conservative.
        first_bias: [f32; 4],
        /// Distances between samples, then codes per unit of length.
        spacing_scale: [f32; 4],
        /// Samples along x.
        size_x: u32,
        /// Samples along y.
        size_y: u32,
        /// Samples along z.
        size_z: u32,
        /// The first layer of samples of each tile.
        first_layer: u32,
        /// Layers of each tile.
        layer_count: u32,
        /// Samples along a tile's side.
        tile: u32,
        /// The code of 1.0.
        max_code: u32,
        /// Zero.
        pad0: u32,
    }
}

shared_struct! {
    /// A grid whose parts have lists of instructions. They come in blocks of 4x4x4.
    NearUniform {
        /// The grid's corner.
        corner: [f32; 3],
        /// Reciprocal of a part's edge.
        inv_edge: f32,
        /// Blocks along x.
        blocks_x: u32,
        /// Blocks along y.
        blocks_y: u32,
        /// Blocks along z.
        blocks_z: u32,
        /// Index of the lists themselves, beginning with the whole program's.
        arena_first: u32,
        /// Words available for lists.
        arena_words: u32,
        /// How much farther an operand must be than another at a block's center, so that it does not matter in the block.
        block_margin: f32,
        /// The same for a part.
        part_margin: f32,
        /// Zero.
        pad0: u32,
    }
}

shared_struct! {
    /// The lists for building bricks, and the blocks to build.
    PruneUniform {
        /// The margin of two distances, besides the Lipschitz constant's share.
        slack: f32,
        /// Index of the blocks' lists.
        blocks_first: u32,
        /// Index of the lists of cells that the surface can pass through.
        cells_first: u32,
        /// Index of the lists themselves, beginning with the whole program's.
        arena_first: u32,
        /// Words available for lists.
        arena_words: u32,
        /// Maximum cells with a list of their own; the others use their block's.
        cells_room: u32,
        /// Number of blocks to build.
        count: u32,
        /// A `BUILD_…`: whether to build blocks or to count what they need.
        build_mode: u32,
        /// Index of the blocks' slots.
        blocks_at: u32,
        /// Index of the masks of cells to sample, two words per block.
        dirty_first: u32,
        /// Index of freed bricks among the cells near the surface; mixed ones follow at the same distance.
        freed_first: u32,
        /// Index of each block's bounds of distances, six words each.
        bounds_first: u32,
    }
}

shared_struct! {
    /// Parameters of marching cubes.
    MarchingUniform {
        /// Position of the first sample, then the edge of a voxel.
        first_voxel: [f32; 4],
        /// The surface's level, in codes.
        iso: f32,
        /// The distance that one code step means.
        quantum: f32,
        /// Half the step of the differences for the field's normals.
        bias: f32,
        /// Bricks, or parts of a dense volume.
        units: u32,
        /// Cells along the side of a unit.
        side: u32,
        /// A `MARCH_…`.
        normals: u32,
        /// 1 if vertices move to the exact surface of the field, else 0.
        is_moved: u32,
        /// Number of vertices.
        vertices: u32,
        /// Number of triangles.
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
    /// A node of an octree. Child `i` of a node of level `l` is at the offset of the level below, plus
    /// `child_offset`, plus the number of bits of `valid_mask` below `i`.
    OctreeNode {
        /// The first child's index in its level.
        child_offset: u32,
        /// A bit for each existing child.
        valid_mask: u32,
        /// A bit for each child that is a brick.
        leaf_mask: u32,
    }
}

pub(crate) const STRUCTS: &[(StructLayout, &[&str])] = &[
    (Instruction::LAYOUT, Instruction::FIELD_TYPES),
    (GpuMaterial::LAYOUT, GpuMaterial::FIELD_TYPES),
    (FrameUniform::LAYOUT, FrameUniform::FIELD_TYPES),
    (QueryPoint::LAYOUT, QueryPoint::FIELD_TYPES),
    (QueryResult::LAYOUT, QueryResult::FIELD_TYPES),
    (DenseUniform::LAYOUT, DenseUniform::FIELD_TYPES),
    (OctreeUniform::LAYOUT, OctreeUniform::FIELD_TYPES),
    (CellTable::LAYOUT, CellTable::FIELD_TYPES),
    (BrickUniform::LAYOUT, BrickUniform::FIELD_TYPES),
    (LevelsUniform::LAYOUT, LevelsUniform::FIELD_TYPES),
    (BrickBuildUniform::LAYOUT, BrickBuildUniform::FIELD_TYPES),
    (FillUniform::LAYOUT, FillUniform::FIELD_TYPES),
    (PruneUniform::LAYOUT, PruneUniform::FIELD_TYPES),
    (NearUniform::LAYOUT, NearUniform::FIELD_TYPES),
    (MarchingUniform::LAYOUT, MarchingUniform::FIELD_TYPES),
    (OctreeNode::LAYOUT, OctreeNode::FIELD_TYPES),
    (PathUniform::LAYOUT, PathUniform::FIELD_TYPES),
    (PathState::LAYOUT, PathState::FIELD_TYPES),
    (PathPixel::LAYOUT, PathPixel::FIELD_TYPES),
];
