//! Levels of detail: bricks of all sizes, resident where rays look.
//!
//! *Theory.* A ray needs voxels as large as its pixel. So voxels near the camera are small, and far ones large: each
//! level has voxels twice as long as the next finer one (GigaVoxels, Crassin et al. 2009). The number of bricks that
//! an image needs depends on its pixels, not on the size of the world.
//!
//! ```text
//!   page       a block of 4³ cells of a level, with a child for each octant of 2³ cells
//!   roots      the pages of the coarsest level; they cover everything, and stay
//!   words      one for each cell of each page, as in sparse bricks
//!   pool       the bricks of all levels
//! ```
//!
//! An octant whose cells have no brick has no finer page: its cells already tell how far the surface is. So a page's
//! place, and whether it can exist, follow from the scene alone.
//!
//! *Practice.* Each page is sampled from the field, with a program that is pruned from its parent's (`bake.rs`).
//! Never is a page made from another level's samples. A ray that finds a page too coarse for its pixel notes what it
//! lacks (`requests.rs`), and [`Levels::fill`] bakes it after the frame. Pages that no ray used for the longest time
//! make room (`fill.rs`). Edits bake resident pages again (`edit.rs`). A page that comes later is right by itself.
//!
//! Distances between samples are off by at most half of a voxel's diagonal, times the Lipschitz constant. A ray in a
//! page that is too coarse stops that far before the surface, so it never passes through one.

mod bake;
mod edit;
mod fill;
mod layout;
mod page;
mod pending;
mod requests;
mod sampler;
mod tree;
mod volume_kind;

pub use fill::FillStats;
pub use layout::LevelsLayout;
pub use page::{NO_PAGE, PAGE_VOXELS_LOG2, Page, octant_cells};
pub use pending::LevelsPendingEdits;
pub use requests::PageRequest;
pub use sampler::{LevelLanes, LevelSampler};
pub use tree::Levels;
