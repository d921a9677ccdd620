//! Pages: the nodes of the tree of levels.

use glam::IVec3;

/// No page: the parent of a page of the coarsest level, or the child of a cell that can have one.
pub const NO_PAGE: u32 = argil_abi::NO_PAGE;
/// In place of a child: finer samples would add no detail, because the cell's distances are those of a plane.
pub const FLAT_CELL: u32 = u32::MAX - 1;
/// In place of a child: it is not known yet whether finer samples would add detail.
pub const UNKNOWN_CELL: u32 = argil_abi::UNKNOWN_CELL;
/// Voxels along a page's side, as a power of two: 2 cells of 8 voxels.
pub const PAGE_VOXELS_LOG2: u32 = argil_abi::PAGE_VOXELS_LOG2;

/// A page: 2³ cells of a level, which together are one cell of the next coarser level.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Page {
    /// The minimum corner, in voxels of level 0.
    pub origin: [i32; 3],
    /// The level. 0 is the finest.
    pub level: u32,
    /// The cell that the page refines, or [`NO_PAGE`]. A cell's index is eight times its page's slot, plus its place:
    /// x is the lowest bit.
    pub parent: u32,
    /// Not used: it makes a page 32 bytes.
    pub padding: [u32; 3],
}

impl Page {
    /// Creates a page at a position in pages of its level.
    pub(super) fn new(level: u32, place: IVec3, parent: u32) -> Self {
        Self {
            origin: (place << (PAGE_VOXELS_LOG2 + level)).to_array(),
            level,
            parent,
            padding: [0; 3],
        }
    }

    /// Returns the position in pages of its level.
    pub fn place(&self) -> IVec3 {
        IVec3::from_array(self.origin) >> (PAGE_VOXELS_LOG2 + self.level)
    }
}

/// Returns the number of a place, 0 or 1 along each axis.
pub(super) fn octant_of(place: IVec3) -> u32 {
    (place.x + 2 * place.y + 4 * place.z) as u32
}

/// Returns the place of an octant, 0 or 1 along each axis.
pub(super) fn octant_place(octant: u32) -> IVec3 {
    IVec3::new(
        (octant & 1) as i32,
        (octant >> 1 & 1) as i32,
        (octant >> 2) as i32,
    )
}

/// Whether a word in place of a child is a page.
#[inline(always)]
pub fn is_page(child: u32) -> bool {
    child < UNKNOWN_CELL
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_know_their_places() {
        for place in [IVec3::new(-3, 0, 7), IVec3::ZERO, IVec3::splat(-1)] {
            let page = Page::new(4, place, NO_PAGE);
            assert_eq!(page.place(), place);
            assert_eq!(octant_place(octant_of(place & 1)), place & 1);
            assert_eq!(size_of::<Page>(), 32);
        }
    }
}
