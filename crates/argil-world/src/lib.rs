#![doc = include_str!("crate.md")]

mod delta;
mod error;
mod limits;
mod manifest;
mod plan;
mod redact;
mod tile_cache;

#[cfg(feature = "store")]
mod export;
#[cfg(feature = "store")]
mod finish;
#[cfg(feature = "store")]
mod reader;
#[cfg(feature = "store")]
mod shard;
#[cfg(feature = "store")]
mod store;
#[cfg(feature = "store")]
mod stored_tiles;
#[cfg(feature = "store")]
mod tile_cache_options;
#[cfg(feature = "store")]
mod tile_folder;
#[cfg(feature = "store")]
mod transfer;
#[cfg(feature = "store")]
mod work;

pub use delta::{MOST_DELTAS, apply_delta, delta_name, is_delta};
pub use error::WorldError;
pub use limits::{MAX_MESH_BYTES, MAX_TEXT_BYTES, MAX_TILE_BYTES};
pub use manifest::Manifest;
pub use plan::{PlanOptions, WorldPlan};
pub use redact::redacted;
pub use tile_cache::{TileCache, tile_name};

#[cfg(feature = "store")]
pub use export::WorldExportReport;
#[cfg(feature = "store")]
pub use finish::{WorldStatus, finish, status};
#[cfg(feature = "store")]
pub use reader::{ReadMode, StoredWorld};
#[cfg(feature = "store")]
pub use shard::Shard;
#[cfg(feature = "store")]
pub use store::Store;
#[cfg(feature = "store")]
pub use tile_cache_options::TileCacheOptions;
#[cfg(feature = "store")]
pub use work::{BakeReport, bake};
