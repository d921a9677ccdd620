//! Pages: the nodes of the tree of levels.

use glam::IVec3;

/// The parent of a page of the coarsest level, and a missing page.
pub const NO_PAGE: u32 = u32::MAX;
/// Finest voxels along a page of level 0, as a power of two: 4 cells of 8 voxels.
pub const PAGE_VOXELS_LOG2: u32 = 5;

/// A page: one block of a level, and its place in the tree.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Page {
    /// The minimum corner, in voxels of level 0.
    pub origin: [i32; 3],
    /// The level. 0 is the finest.
    pub level: u32,
    /// The pages of the octants, or [`NO_PAGE`]. x is the lowest bit of an octant's number.
    pub children: [u32; 8],
    /// The page of the next coarser level that contains this one, or [`NO_PAGE`].
    pub parent: u32,
    /// Not used: it makes a page 64 bytes.
    pub padding: [u32; 3],
}

impl Page {
    pub(super) fn new(level: u32, block: IVec3, parent: u32) -> Self {
        Self {
            origin: (block << (PAGE_VOXELS_LOG2 + level)).to_array(),
            level,
            children: [NO_PAGE; 8],
            parent,
            padding: [0; 3],
        }
    }

    /// Returns the block in blocks of its level.
    pub fn block(&self) -> IVec3 {
        IVec3::from_array(self.origin) >> (PAGE_VOXELS_LOG2 + self.level)
    }

    pub(super) fn has_children(&self) -> bool {
        self.children.iter().any(|&child| child != NO_PAGE)
    }
}

/// Returns the cells of a block's octant, one bit each.
#[inline(always)]
pub fn octant_cells(octant: u32) -> u64 {
    // Cells 0 and 1 along each axis; an octant is two cells further.
    const FIRST: u64 = 0x0033_0033;
    FIRST << (2 * (octant & 1) + 8 * (octant >> 1 & 1) + 32 * (octant >> 2))
}

/// Returns the position of an octant: 0 or 1 along each axis.
pub(super) fn octant_place(octant: u32) -> IVec3 {
    IVec3::new(
        (octant & 1) as i32,
        (octant >> 1 & 1) as i32,
        (octant >> 2) as i32,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bricks::inner_cell;

    #[test]
    fn octants_are_eight_cells_each_and_all_cells_together() {
        let mut all = 0u64;
        for octant in 0..8 {
            let cells = octant_cells(octant);
            assert_eq!(cells.count_ones(), 8);
            assert_eq!(all & cells, 0);
            all |= cells;
            for i in (0..64).filter(|i| cells >> i & 1 != 0) {
                assert_eq!(inner_cell(i) / 2, octant_place(octant));
            }
        }
        assert_eq!(all, u64::MAX);
        assert_eq!(size_of::<Page>(), 64);
    }

    #[test]
    fn pages_know_their_blocks() {
        for block in [IVec3::new(-3, 0, 7), IVec3::ZERO, IVec3::splat(-1)] {
            assert_eq!(Page::new(4, block, NO_PAGE).block(), block);
        }
    }
}
