//! The arrays of sparse bricks, without the blocks that they belong to.

use super::changes::ChangeLog;
use crate::{SampleFormat, Texels};
use argil_abi::{BRICK_MIXED, MATERIAL_SIDE};
use glam::Vec3;

/// Number of points of a mixed brick.
pub(crate) const PLACES: usize = MATERIAL_SIDE.pow(3) as usize;

/// Words of cells, and the bricks that they name.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct BrickStore {
    /// The word of each cell, slot by slot.
    pub words: Vec<u32>,
    /// The owner of each brick: the index of its cell's word.
    pub cell_of_brick: Vec<u32>,
    /// The material of each brick.
    pub materials: Vec<u32>,
    /// The materials of mixed bricks.
    pub mixed: Vec<[u32; 2]>,
    /// The brick of each mixed brick's materials.
    pub brick_of_mixed: Vec<u32>,
    /// The samples, brick by brick. Without bricks, one brick of zeros.
    pub pool: Texels,
    /// What changed since a copy was updated.
    pub changes: ChangeLog,
}

impl BrickStore {
    /// Returns the bytes of everything.
    pub(crate) fn memory_bytes(&self) -> u64 {
        let tables = size_of_val(&self.words[..])
            + size_of_val(&self.cell_of_brick[..])
            + size_of_val(&self.materials[..])
            + size_of_val(&self.mixed[..])
            + size_of_val(&self.brick_of_mixed[..]);
        tables as u64 + self.pool.bytes().len() as u64
    }

    /// Creates a store without bricks. `pool` holds one brick of zeros.
    pub(crate) fn of(pool: Texels) -> Self {
        Self {
            words: Vec::new(),
            cell_of_brick: Vec::new(),
            materials: Vec::new(),
            mixed: Vec::new(),
            brick_of_mixed: Vec::new(),
            pool,
            changes: ChangeLog::default(),
        }
    }

    /// Returns a brick's material: see [`super::Bricks::brick_material`].
    pub(crate) fn material_of(&self, brick: u32) -> (u32, &[[u32; 2]]) {
        let material = self.materials[brick as usize];
        if material & BRICK_MIXED == 0 {
            return (material, &[]);
        }
        let from = (material & !BRICK_MIXED) as usize * PLACES;
        (BRICK_MIXED, &self.mixed[from..from + PLACES])
    }

    /// Returns the interpolated code of a brick of 8³ voxels at a position in voxels.
    pub(crate) fn interpolated(&self, brick: u32, place: Vec3) -> f32 {
        let low = place.clamp(Vec3::ZERO, Vec3::splat(7.0)).floor();
        let part = (place - low).clamp(Vec3::ZERO, Vec3::ONE);
        let low = low.as_uvec3();
        let code = |x: u32, y: u32, z: u32| {
            let at = low + glam::uvec3(x, y, z);
            let at = (brick * 729 + at.x + 9 * (at.y + 9 * at.z)) as usize;
            match self.pool.bits() {
                SampleFormat::Snorm8 => self.pool.of::<i8>().map_or(0.0, |all| f32::from(all[at])),
                SampleFormat::Snorm16 => {
                    self.pool.of::<i16>().map_or(0.0, |all| f32::from(all[at]))
                }
            }
        };
        let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
        let row = |y: u32, z: u32| mix(code(0, y, z), code(1, y, z), part.x);
        let plane = |z: u32| mix(row(0, z), row(1, z), part.y);
        mix(plane(0), plane(1), part.z)
    }
}
