//! Sparse bricks: Argil's main representation.
//!
//! *Theory.* Only cells near the surface need samples. Elsewhere a ray needs only a step length. So a cell without
//! a brick stores a lower bound of the distance from its center to the surface, as Barbier et al. store in
//! "Lipschitz Pruning" (2025). Less half of the cell's diagonal, it is a lower bound for every point in the cell.
//! Bricks have 8³ voxels, which suits caches (Lumen; GigaVoxels, Crassin 2009).
//!
//! ```text
//!   table   which blocks of 4³ cells there are: each has a slot; what has none is far from every surface
//!   masks   one for each slot: a bit for each cell with a brick
//!   words   one for each cell, slot by slot: a brick's place, or a distance and whether the whole block is empty
//!   materials, mixed   what bricks look like, see `material.rs`
//!   pool    (brick + 1)³ samples a brick, x fastest: its cells' corners, so that interpolation never leaves it
//! ```
//!
//! *For readers in shaders of their own.* The word of a cell with a brick is the brick's number. Any other word is a signed distance
//! (see [`center_of`]): no surface is nearer to the cell's center than that. It says nothing of how far away one is: beside the
//! surface it can be near 0, and it is never more than [`BrickLayout::far_length`]. A point of the cell that is `r` from its
//! center is free for `|d| − L · r`, where L is [`Bricks::lipschitz`]. Samples of a brick are distances over its band, and
//! within it those of the field; at the band's end they are cut off. After edits, [`Bricks::take_changes`] tells what to bring over.
//!
//! Blocks are counted from the lattice's corner in all directions: where there is surface there are blocks, and a world that
//! grows keeps what it has.
//!
//! *Practice.* Samples stand at voxels' corners, `corner + voxel · (i, j, k)`; neighboring bricks have those of their
//! common side both. `build.rs` bakes on the CPU, `batch.rs` reads for rays. What differs from the literature: a brick is
//! dropped again where its own samples show that the surface cannot be in it. The tables hold the very resolution that was asked for.

mod additions;
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
mod octants;
mod parts;
mod pending;
mod plan;
mod pool;
mod read;
mod sampler;
mod table;
mod tables;
mod volume_kind;
mod voxel_samples;

pub use block_program::{BlockProgram, emptied_around};
pub use bounds::BLOCK_WORDS;
pub use brick::Brick;
pub use build::BrickTimings;
pub(crate) use cell::inner_cell;
pub use cell::{BrickCell, center_of, empty_word, is_block_empty, is_brick};
pub use cell_programs::CellPrograms;
pub use changes::BrickChanges;
pub use edit::EditStats;
pub use edit_queue::{EditBatch, EditQueue};
pub use layout::{BLOCK_SIDE, BrickLayout, BrickSettings, BricksError};
pub use pending::BrickPendingEdits;
pub use plan::BlockPlan;
pub use sampler::BrickSampler;
pub use table::{BlockTable, FAR_ENTRY, FAR_SLOTS, far_words};
pub use tables::Bricks;
pub use voxel_samples::{CellLocations, NeighborPlanes, VoxelSamples};
