//! Levels of detail: bricks of all sizes, resident where rays look.
//!
//! *Theory.* A ray needs voxels as large as its pixel. So voxels near the camera are small, and far ones large: each
//! level has voxels twice as long as the next finer one (GigaVoxels, Crassin et al. 2009). The number of bricks that
//! an image needs depends on its pixels, not on the size of the world.
//!
//! ```text
//!   page       2³ cells of a level, which together are one cell of the next coarser level
//!   roots      the pages of the coarsest level; they cover everything, and stay
//!   words      one for each cell: its distance, its brick, or that its brick is missing
//!   children   one for each cell: its page, or why it has none
//!   pool       the bricks of all levels
//! ```
//!
//! A cell is refined only if a surface can pass through it, and its brick's distances are not those of a plane. So
//! which pages can exist follows from the scene alone. A ray reads the first cell on the way down that has no surface,
//! that is flat, or whose voxels are as large as its pixel.
//!
//! *Practice.* Each cell is measured and sampled from the field, with a program that is pruned from its parent's
//! (`bake.rs`). Never is a brick made from another level's samples. A ray that finds no brick fine enough for its pixel
//! notes what it lacks (`requests.rs`), and [`Levels::fill`] bakes it after the frame. What no ray used for the longest
//! time makes room (`evict.rs`): what is known of a cell stays when its brick goes. Edits bake again what is resident
//! (`edit.rs`). What comes later is right by itself.
//!
//! Distances between samples are off by at most half of a voxel's diagonal, times the Lipschitz constant. A ray in a
//! brick that is too coarse stops that far before the surface, so it never passes through one.

mod bake;
mod compare;
mod copies;
mod edit;
mod edit_affected;
mod evict;
mod fill;
mod kept_list;
mod layout;
mod leaves;
mod light;
mod light_levels;
mod lists;
mod locate;
mod page;
mod page_starts;
mod pending;
mod requests;
mod sampler;
mod source;
mod stored_pages;
mod tile;
mod tree;
mod volume_kind;

pub use fill::FillStats;
pub use kept_list::PageList;
pub use layout::LevelsLayout;
pub use leaves::LeafCell;
pub use light_levels::LightLevels;
pub use page::{FLAT_CELL, NO_PAGE, PAGE_VOXELS_LOG2, Page, UNKNOWN_CELL, is_page};
pub use pending::LevelsPendingEdits;
pub use requests::{PageAim, PageRequest};
pub use sampler::{LevelLanes, LevelSampler, NO_REQUEST, split_position};
pub use source::{TileSource, TileState};
pub use tile::{
    TIER_LEVELS, Tile, TileAddress, TileBaker, TileBrick, TileCell, TileError, TileHead, TileWorker,
};
pub use tree::Levels;
