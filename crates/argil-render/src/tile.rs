//! Tiles of an image.

/// Pixels along a tile's sides, multiples of a cone's: enough rays to fill batches until the end, and few enough
/// for the second-level cache.
pub(crate) const TILE_WIDTH: u32 = 128;
pub(crate) const TILE_HEIGHT: u32 = 64;

/// A rectangle of pixels, whose rays march together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tile {
    /// The first column.
    pub first_x: u32,
    /// The first row.
    pub first_row: u32,
    /// Pixels per row.
    pub width: u32,
    /// Number of rows.
    pub rows: u32,
}

impl Tile {
    /// Returns the number of pixels.
    pub fn area(&self) -> usize {
        (self.width * self.rows) as usize
    }

    /// Returns the image coordinates of the tile's pixel `i`, row by row.
    #[inline]
    pub(crate) fn pixel(&self, i: usize) -> (u32, u32) {
        (
            self.first_x + i as u32 % self.width,
            self.first_row + i as u32 / self.width,
        )
    }
}

/// Iterates over the tiles of an image, row by row from the top.
pub(crate) fn tiles(width: u32, height: u32) -> impl Iterator<Item = Tile> {
    (0..height)
        .step_by(TILE_HEIGHT as usize)
        .flat_map(move |first_row| {
            (0..width)
                .step_by(TILE_WIDTH as usize)
                .map(move |first_x| Tile {
                    first_x,
                    first_row,
                    width: TILE_WIDTH.min(width - first_x),
                    rows: TILE_HEIGHT.min(height - first_row),
                })
        })
}

/// Cuts an image of `per_pixel` values per pixel into the rows of its tiles, in the order of [`tiles`].
pub(crate) fn tile_rows<T>(picture: &mut [T], width: u32, per_pixel: usize) -> Vec<Vec<&mut [T]>> {
    let row = width as usize * per_pixel;
    let mut all = Vec::new();
    if row == 0 {
        return all;
    }
    for band in picture.chunks_mut(row * TILE_HEIGHT as usize) {
        let first = all.len();
        for row in band.chunks_mut(row) {
            for (k, part) in row.chunks_mut(TILE_WIDTH as usize * per_pixel).enumerate() {
                if all.len() <= first + k {
                    all.push(Vec::with_capacity(TILE_HEIGHT as usize));
                }
                all[first + k].push(part);
            }
        }
    }
    all
}
