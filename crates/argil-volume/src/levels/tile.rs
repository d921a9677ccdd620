//! Tiles: parts of levels that machines bake and store by themselves.
//!
//! *Theory.* Which pages exist follows from the scene alone, and each is sampled from the field. So a tile needs nothing of
//! its neighbors, nor of what is coarser but the one page above: any worker makes the same bytes. Five levels of pages
//! lie in a tile, from one page down to 16³, so that it is neither too small to be put into a store nor too large to be fetched.
//!
//! ```text
//!   tier    five levels: tier 0 has levels 0 to 4, whose tiles are cubes of 256 voxels of level 0
//!   tile    a page of a tier's coarsest level, and all pages of the tier below it
//! ```
//!
//! *Practice.* [`TileBaker::candidates`] walks down from the root and measures, but samples nothing: it finds all places that
//! bounds do not rule out. [`TileBaker::bake`] samples one tile. If its page does not exist after all, the tile is empty.

mod bake;
mod cell;
mod codec;
mod format;

pub use bake::{TileBaker, TileWorker};
pub use cell::{TileBrick, TileCell};
pub use format::{TileError, TileHead};

use super::layout::LevelsLayout;
use super::page::Page;
use crate::SampleFormat;
use glam::IVec3;

/// Levels of a tier.
pub const TIER_LEVELS: u32 = 5;

/// The place of a tile.
///
/// ```
/// use argil_volume::TileAddress;
/// // The tile of level 0 that contains the voxel at 300 along each axis.
/// let address = TileAddress::of_page(0, [300 / 16; 3].into());
/// assert_eq!(address, TileAddress { tier: 0, place: [1; 3] });
/// assert_eq!(address.to_string(), "0/1_1_1");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TileAddress {
    /// Five levels of pages. 0 has the finest.
    pub tier: u32,
    /// The position, in tiles of the tier.
    pub place: [i32; 3],
}

impl TileAddress {
    /// Returns the tile that contains a page, given its level and its position in pages of that level.
    pub fn of_page(level: u32, place: IVec3) -> Self {
        let tier = level / TIER_LEVELS;
        let above = TIER_LEVELS * tier + TIER_LEVELS - 1 - level;
        Self {
            tier,
            place: (place >> above).to_array(),
        }
    }

    /// Returns the tile above, whose finest pages this one refines. A tile of a coarsest tier gets one that does not exist.
    pub fn coarser(&self) -> Option<Self> {
        let level = TIER_LEVELS.checked_mul(self.tier.checked_add(1)?)?;
        Some(Self::of_page(level, IVec3::from_array(self.place) >> 1))
    }

    /// Returns the finest level of the tier.
    pub fn finest_level(&self) -> u32 {
        TIER_LEVELS.saturating_mul(self.tier)
    }

    /// Returns the coarsest level that a tier has in a layout.
    pub fn top_level(&self, layout: &LevelsLayout) -> u32 {
        self.finest_level()
            .saturating_add(TIER_LEVELS - 1)
            .min(layout.root())
    }

    /// Whether a layout can have the tile: its levels exist, and the positions of its cells can be counted.
    pub(super) fn can_be_in(&self, layout: &LevelsLayout) -> bool {
        let max = i32::MAX as u32 >> (TIER_LEVELS + 1);
        self.finest_level() <= layout.root() && self.place.iter().all(|c| c.unsigned_abs() <= max)
    }
}

impl std::fmt::Display for TileAddress {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [x, y, z] = self.place;
        write!(f, "{}/{x}_{y}_{z}", self.tier)
    }
}

impl std::str::FromStr for TileAddress {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parse = || {
            let (tier, place) = text.split_once('/')?;
            let mut axes = place.split('_').map(|axis| axis.parse().ok());
            let place = [axes.next()??, axes.next()??, axes.next()??];
            axes.next().is_none().then_some(Self {
                tier: tier.parse().ok()?,
                place,
            })
        };
        parse().ok_or_else(|| format!("{text:?} is no tile: expected TIER/X_Y_Z"))
    }
}

/// What a tile knows of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum CellKind {
    /// No surface passes through it: its center is too far away.
    Clear = 0,
    /// Its samples show that no surface passes through it.
    Cleared = 1,
    /// It has a brick, which is a plane.
    Flat = 2,
    /// It has a brick. A page refines it, unless its level is 0.
    Brick = 3,
}

impl CellKind {
    fn of_code(code: u8) -> Option<Self> {
        Some(match code {
            0 => Self::Clear,
            1 => Self::Cleared,
            2 => Self::Flat,
            3 => Self::Brick,
            _ => return None,
        })
    }

    /// Whether it has a brick.
    pub(super) fn has_brick(self) -> bool {
        matches!(self, Self::Flat | Self::Brick)
    }
}

/// A page of a tile.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct TilePage {
    pub level: u32,
    /// In pages of the level.
    pub place: [i32; 3],
    pub kinds: [CellKind; 8],
    /// The words of cells without a brick.
    pub words: [u32; 8],
    /// The first of its bricks, which are in the order of cells, and the first of its mixed ones.
    pub first_brick: u32,
    pub first_mixed: u32,
}

impl TilePage {
    fn brick_count(&self) -> usize {
        self.kinds.iter().filter(|kind| kind.has_brick()).count()
    }
}

/// A part of levels: a page, and all pages below it within five levels.
#[derive(Clone, Debug, PartialEq)]
pub struct Tile {
    address: TileAddress,
    format: SampleFormat,
    /// The finest level that was read. Coarser ones were, too.
    finest_held: u32,
    /// Level by level from the coarsest on, and in the order of the cells above.
    pages: Vec<TilePage>,
    /// Of each brick.
    materials: Vec<u32>,
    mixed: Vec<[u32; 2]>,
    /// The codes of all bricks' samples.
    texels: Vec<i16>,
}

impl Tile {
    /// Returns the place.
    pub fn address(&self) -> TileAddress {
        self.address
    }

    /// Returns the finest level that was read or baked. Coarser ones were, too.
    pub fn finest_held(&self) -> u32 {
        self.finest_held
    }

    /// Whether a level was read, or baked.
    pub fn holds(&self, level: u32) -> bool {
        level >= self.finest_held
    }

    /// Returns the number of pages. It is 0 if no surface passes through the tile.
    pub fn page_count(&self) -> usize {
        self.pages.len()
    }

    /// Returns the number of bricks.
    pub fn brick_count(&self) -> usize {
        self.materials.len()
    }

    /// Whether all materials are among a number of them.
    pub fn fits(&self, materials: usize) -> bool {
        let is_known = |&&material: &&u32| {
            material & argil_abi::BRICK_MIXED != 0 || (material as usize) < materials.max(1)
        };
        self.materials.iter().all(|material| is_known(&material))
    }

    /// Returns the bytes in memory.
    pub fn memory_bytes(&self) -> u64 {
        let own = size_of_val(&self.pages[..])
            + size_of_val(&self.materials[..])
            + size_of_val(&self.mixed[..])
            + size_of_val(&self.texels[..]);
        own as u64
    }

    /// Returns the addresses of the finer tiles that refine the tile's cells.
    pub fn finer_tiles(&self) -> Vec<TileAddress> {
        let Some(tier) = self.address.tier.checked_sub(1) else {
            return Vec::new();
        };
        let finest = self.address.finest_level();
        let pages = self.pages.iter().filter(|page| page.level == finest);
        let cells = pages.flat_map(|page| {
            let refined = (0u32..8).filter(|&i| page.kinds[i as usize] == CellKind::Brick);
            refined.map(|i| 2 * IVec3::from_array(page.place) + super::page::octant_place(i))
        });
        cells
            .map(|cell| TileAddress {
                tier,
                place: cell.to_array(),
            })
            .collect()
    }

    /// Returns a page, given its level and its position.
    pub(super) fn page(&self, page: &Page) -> Option<&TilePage> {
        let place = page.place();
        let wanted = order_of(page.level, place);
        let found = self
            .pages
            .binary_search_by_key(&wanted, |own| order_of(own.level, own.place.into()));
        let found = &self.pages[found.ok()?];
        (found.place == place.to_array()).then_some(found)
    }
}

/// Returns a page's position in the order of a tile: the coarsest level first, and along the Morton curve.
fn order_of(level: u32, place: IVec3) -> (std::cmp::Reverse<u32>, u32) {
    // Pages of a tile differ in these bits only.
    let within = (place & ((1 << (TIER_LEVELS - 1)) - 1)).as_uvec3();
    (std::cmp::Reverse(level), argil_math::morton(within))
}
