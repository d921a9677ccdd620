#![doc = include_str!("crate.md")]
#![cfg_attr(doc, doc = include_str!("pictures/page.md"))]

mod bake_level;
mod bricks;
mod dense;
mod encoding;
mod file;
mod level_set;
mod levels;
mod mip_sampler;
mod octree;
mod pending_edits;
mod representation;
mod sampler;
mod texels;
mod voxel_grid;

pub use bricks::{
    BLOCK_SIDE, BLOCK_WORDS, BlockPlan, BlockProgram, BlockTable, Brick, BrickCell, BrickChanges,
    BrickLayout, BrickPendingEdits, BrickSampler, BrickSettings, BrickTimings, Bricks, BricksError,
    CellLocations, CellPrograms, EditBatch, EditQueue, EditStats, EstimateLanes, FAR_ENTRY,
    FAR_SLOTS, MISSING_BRICK, NeighborPlanes, VoxelSamples, center_of, emptied_around, empty_word,
    far_words, is_block_empty, is_brick,
};
pub use dense::{Dense, DenseFill};
pub use encoding::{Band, Encoding, SampleFormat, Texel};
pub use file::{FilePart, FileReader, Section, StoredMesh, VolumeError, VolumeFile};
pub use level_set::{LevelSetBaker, LevelSetLayout, LevelSetLeaf};
pub use levels::{
    FLAT_CELL, FillStats, LeafCell, LevelLanes, LevelSampler, Levels, LevelsLayout,
    LevelsPendingEdits, LightLevels, NO_PAGE, NO_REQUEST, PAGE_VOXELS_LOG2, Page, PageAim,
    PageList, PageRequest, TIER_LEVELS, Tile, TileAddress, TileBaker, TileBrick, TileCell,
    TileError, TileHead, TileSource, TileState, TileWorker, UNKNOWN_CELL, is_page, split_position,
};
pub use mip_sampler::MipSampler;
pub use octree::{
    BrickOrdering, BrickSelection, BrickTest, DescentPath, Lookup, Octree, OctreeError,
    OctreeLayout, OctreeNodes, OctreeSettings, OctreeTimings,
};
pub use pending_edits::PendingEdits;
pub use representation::{BrickInfo, OctreeInfo, Volume, VolumeInfo, VolumeKind};
pub use sampler::Sampler;
pub use texels::Texels;
pub use voxel_grid::{
    MAX_SPARSE_RESOLUTION, MAX_VOXEL_INDEX, RESOLUTION_RANGE, ResolutionError, TooFarError,
    VoxelGrid, VoxelSizeError,
};

/// The WGSL twins of the passes that build a volume.
pub mod wgsl {
    /// Samples a level of a texture: `fill_naive` and `fill_tiled`.
    pub const BAKE_LEVEL: &str = concat!(
        include_str!("encode.wgsl"),
        include_str!("fill.wgsl"),
        include_str!("fill_tiles.wgsl")
    );
    /// Samples a level of a texture three texels at a time, for a program of common instructions: `fill_tiled`.
    pub const BAKE_LEVEL_BY_COLUMNS: &str = concat!(
        include_str!("encode.wgsl"),
        include_str!("fill_by_columns.wgsl"),
        include_str!("fill_tiles.wgsl")
    );
    /// Selects bricks of an octree: `select_bits` and `select_list`.
    pub const OCTREE_SELECT: &str = include_str!("octree/select.wgsl");
    /// Lists bricks in ascending order (`compact`, `rank`), and builds the tree above them (`build`).
    pub const OCTREE_BUILD: &str = concat!(
        include_str!("octree/sort.wgsl"),
        include_str!("octree/tree.wgsl")
    );
    /// Decodes the cells of sparse bricks.
    pub const BRICK_CELLS: &str = include_str!("bricks/cell.wgsl");
    /// Reads the materials of sparse bricks.
    pub const BRICK_MATERIALS: &str = include_str!("bricks/material.wgsl");
    /// Builds sparse bricks: lists, `measure`, `fill_bricks`, `fill_materials`, `mark_empty_blocks` and `release_freed`.
    pub const BRICK_BUILD: &str = concat!(
        include_str!("encode.wgsl"),
        include_str!("bricks/build.wgsl"),
        include_str!("bricks/lists.wgsl"),
        include_str!("bricks/measure.wgsl"),
        include_str!("bricks/settle.wgsl"),
        include_str!("bricks/fill.wgsl"),
        include_str!("bricks/material_bake.wgsl"),
        include_str!("bricks/release.wgsl")
    );
    /// Samples sparse bricks by columns of samples: `fill_columns`.
    pub const BRICK_COLUMNS: &str = concat!(
        include_str!("encode.wgsl"),
        include_str!("bricks/build.wgsl"),
        include_str!("bricks/settle.wgsl"),
        include_str!("bricks/fill_columns.wgsl")
    );
    /// Plans the dispatches of a build of sparse bricks: `plan`.
    pub const BRICK_PLAN: &str = include_str!("bricks/dispatches.wgsl");
    /// Moves sparse bricks to another pool: `repack`.
    pub const BRICK_REPACK: &str = include_str!("bricks/repack.wgsl");
    /// Fills an octree's bricks and vacant cells: `fill_bricks` and `fill_vacant`.
    pub const OCTREE_FILL: &str = include_str!("octree/fill.wgsl");
}
