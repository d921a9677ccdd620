//! What a tile has of one cell, for programs that read tiles without levels.

use super::codec::BRICK_SAMPLES;
use super::{CellKind, Tile, order_of};
use crate::bricks::{PLACES, mixture};
use crate::{Encoding, SampleFormat};
use argil_abi::{BRICK_MIXED, GpuMaterial};
use glam::{IVec3, Vec3};

/// What a tile has of a cell of 8³ voxels.
#[derive(Clone, Copy, Debug)]
pub enum TileCell<'a> {
    /// No surface passes through it.
    Away,
    /// A brick.
    Brick(TileBrick<'a>),
}

/// The samples and materials of a cell.
#[derive(Clone, Copy, Debug)]
pub struct TileBrick<'a> {
    format: SampleFormat,
    codes: &'a [i16],
    material: u32,
    mixed: Option<&'a [[u32; 2]; PLACES]>,
    is_flat: bool,
}

impl Tile {
    /// Returns what the tile has of a cell of a level, counted in cells of that level. `None` if its page does not exist: a coarser
    /// cell has no surface, or is flat.
    pub fn cell(&self, level: u32, cell: [i32; 3]) -> Option<TileCell<'_>> {
        let cell = IVec3::from_array(cell);
        let place = cell >> 1;
        let wanted = order_of(level, place);
        let found = self
            .pages
            .binary_search_by_key(&wanted, |own| order_of(own.level, own.place.into()));
        let page = &self.pages[found.ok()?];
        if page.place != place.to_array() {
            return None;
        }
        let index = crate::levels::page::octant_of(cell & 1) as usize;
        if !page.kinds[index].has_brick() {
            return Some(TileCell::Away);
        }
        let before = page.kinds[..index].iter().filter(|kind| kind.has_brick());
        let first = page.first_brick as usize;
        let brick = first + before.count();
        let material = self.materials[brick];
        let is_mixed = |own: &&u32| **own & BRICK_MIXED != 0;
        let mixed_before = self.materials[first..brick].iter().filter(is_mixed).count();
        let block = PLACES * (page.first_mixed as usize + mixed_before);
        let mixed = (material & BRICK_MIXED != 0)
            .then(|| self.mixed.get(block..)?.first_chunk())
            .flatten();
        Some(TileCell::Brick(TileBrick {
            format: self.format,
            codes: &self.texels[brick * BRICK_SAMPLES..(brick + 1) * BRICK_SAMPLES],
            material,
            mixed,
            is_flat: page.kinds[index] == CellKind::Flat,
        }))
    }
}

impl TileBrick<'_> {
    /// Whether the distances are those of a plane, so that no finer page refines the cell.
    pub fn is_flat(&self) -> bool {
        self.is_flat
    }

    /// Returns the 9³ distances in voxels, x fastest: at the corners of the cell's voxels. Those beyond the band are its width.
    pub fn distances(&self, encoding: &Encoding) -> impl Iterator<Item = f32> {
        let step = encoding.band.voxels() / self.format.max_code() as f32;
        self.codes.iter().map(move |&code| f32::from(code) * step)
    }

    /// Returns the material at a position in the brick, in voxels, where the surface's normal is `outward`.
    pub fn material(
        &self,
        inner: Vec3,
        outward: Vec3,
        encoding: &Encoding,
        palette: &[GpuMaterial],
    ) -> Option<GpuMaterial> {
        let Some(mixed) = self.mixed else {
            return palette
                .get(self.material as usize)
                .or(palette.first())
                .copied();
        };
        let place = (inner, encoding.band.voxels(), 8);
        Some(match self.format {
            SampleFormat::Snorm8 => {
                let codes: Vec<i8> = self.codes.iter().map(|&code| code as i8).collect();
                mixture(&codes, mixed, place, outward)
            }
            SampleFormat::Snorm16 => mixture(self.codes, mixed, place, outward),
        })
    }
}
