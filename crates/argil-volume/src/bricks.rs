//! Sparse bricks: Argil's main representation.
//!
//! *Theory.* Only cells near the surface need samples. Elsewhere a ray needs only a step length. So a cell without
//! a brick stores a lower bound of the distance from its center to the surface, as Barbier et al. store in
//! "Lipschitz Pruning" (2025). Less half of the cell's diagonal, it is a lower bound for every point in the cell.
//! Bricks have 8³ voxels, which suits caches (Lumen; GigaVoxels, Crassin 2009).
//!
//! ```text
//!   table      one entry for each block of 4³ cells: its slot, or that the block is far from every surface
//!   masks      one for each slot: a bit for each cell with a brick
//!   words      one for each cell, slot by slot: the index of its brick, or a distance
//!   materials  one for each brick, see `material.rs`; a mixed brick has a grid of them
//!   pool       (brick size + 1)³ samples for each brick, x fastest, so that interpolation stays within a brick
//! ```
//!
//! *For readers in shaders of their own.* The word of a cell with a brick is the index of the brick. Any other word is a signed
//! distance `d` (see [`center_of`]), a bound: no surface is nearer to the cell's center than `|d|`. Near a surface it can be close
//! to 0, and it never exceeds [`BrickLayout::far_length`]. A ray at a point of the cell that is `r` from the center can advance by
//! `|d| − L · r`, where L is [`Bricks::lipschitz`]. Samples of a brick are the field's distances, clamped to the band. After edits,
//! [`Bricks::take_changes`] lists the words and bricks that changed.
//!
//! Blocks are counted from the grid's corner in both directions. Edits allocate blocks where they put a surface, so a growing
//! world keeps its bricks.
//!
//! *Practice.* Samples are at the corners of voxels, `corner + voxel_size · (i, j, k)`. Neighboring bricks both store the samples
//! on their common side. `build.rs` bakes on the CPU, and `sampler.rs` reads samples for rays. Unlike the literature, a build drops
//! a brick whose samples show that the surface cannot be in it, and each table has exactly the resolution that the caller requested.

mod additions;
mod block_baker;
mod block_editor;
mod block_program;
mod bounds;
mod brick;
mod brick_baker;
mod build;
mod candidates;
mod cell;
mod cell_programs;
mod changes;
mod edit;
mod edit_queue;
mod estimates;
mod layout;
mod material;
pub(crate) use material::mixture;
mod octants;
mod parts;
mod pending;
mod plan;
mod pool;
mod read;
mod sample_offsets;
mod sampler;
mod store;
mod table;
mod tables;
mod unchanged;
mod volume_kind;
mod voxel_samples;

pub(crate) use block_baker::{CellContext, CellNearness, REGION_VOXELS_LOG2};
pub use block_program::{BlockProgram, emptied_around};
pub use bounds::BLOCK_WORDS;
pub use brick::Brick;
pub(crate) use brick_baker::{BrickBaker, PartPruner};
pub use build::BrickTimings;
pub(crate) use cell::inner_cell;
pub use cell::{BrickCell, MISSING_BRICK, center_of, empty_word, is_block_empty, is_brick};
pub use cell_programs::CellPrograms;
pub use changes::BrickChanges;
pub use edit::EditStats;
pub use edit_queue::{EditBatch, EditQueue};
pub use estimates::EstimateLanes;
pub use layout::{BLOCK_SIDE, BrickLayout, BrickSettings, BricksError};
pub use pending::BrickPendingEdits;
pub use plan::BlockPlan;
pub(crate) use pool::Pool;
pub use sampler::BrickSampler;
pub(crate) use sampler::{load_planes, load_voxels};
pub(crate) use store::{BrickStore, PLACES};
pub(crate) use table::places;
pub use table::{BlockTable, FAR_ENTRY, FAR_SLOTS, far_words};
pub use tables::Bricks;
pub use voxel_samples::{CellLocations, NeighborPlanes, VoxelSamples};
