//! How long objects of a world can be. Whoever reads them from a network asks for no more.

/// The longest manifest, plan or file of edits, in bytes.
pub const MAX_TEXT_BYTES: u64 = 256 << 20;
/// The longest object with the samples of a mesh, in bytes.
pub const MAX_MESH_BYTES: u64 = 2 << 30;
/// The longest tile, in bytes. All bricks of its five levels take less.
pub const MAX_TILE_BYTES: u64 = 512 << 20;
