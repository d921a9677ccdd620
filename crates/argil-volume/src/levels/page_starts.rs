//! A table of pages by place, for points that have little to do with one another.

/// Maximum entries.
pub(super) const ENTRIES: i32 = 1 << 15;

/// The finest page in each cube of a grid over the world.
#[derive(Debug)]
pub(super) struct PageStarts {
    pub pages: Vec<u32>,
    /// The edge of a cube in voxels of level 0, as a power of two.
    pub edge_log2: u32,
    /// The first cube, and the number of cubes.
    pub first: [i32; 3],
    pub size: [i32; 3],
}
