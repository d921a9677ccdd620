//! Parts of a picture.

/// Rays of a tile, about: enough that the last few do not leave batches empty, few enough for the second-level cache.
const TILE_RAYS: u32 = 8192;

/// A band of full rows. A tile's rays march together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tile {
    /// The first row.
    pub first_row: u32,
    /// Pixels in a row.
    pub width: u32,
    /// Number of rows.
    pub rows: u32,
}

impl Tile {
    /// Number of pixels.
    pub fn area(&self) -> usize {
        (self.width * self.rows) as usize
    }

    /// The picture's coordinates of the tile's pixel `i`, row by row.
    #[inline]
    pub(crate) fn pixel(&self, i: usize) -> (u32, u32) {
        (
            i as u32 % self.width,
            self.first_row + i as u32 / self.width,
        )
    }
}

/// The tiles of a picture, from the top.
pub fn tiles(width: u32, height: u32) -> impl Iterator<Item = Tile> {
    let rows = (TILE_RAYS / width.max(1)).max(1);
    (0..height)
        .step_by(rows as usize)
        .map(move |first_row| Tile {
            first_row,
            width,
            rows: rows.min(height - first_row),
        })
}
