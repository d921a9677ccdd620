#![doc = include_str!("crate.md")]

mod codec;
mod error;
mod flood;
mod grid;
mod mask;
pub mod nvdb;
mod tree;
pub mod vdb;
mod voxel;

pub use codec::Codec;
pub use error::VdbError;
pub use grid::{AnyGrid, Grid, GridClass, GridHeader, MetaValue, Metadata, Transform};
pub use mask::Mask;
pub use tree::{
    LEAF_SIZE, LOWER_SIZE, Leaf, Lower, NODE_VOXELS, RootTile, Tree, TreeStatistics, UPPER_SIZE,
    Upper,
};
pub use voxel::Voxel;
