//! The materials of bricks. `material.wgsl` is the twin.
//!
//! A brick of one material stores its index in the program's table. A brick of several materials, or of blends,
//! stores materials at 4³ points, from one end to the other along each axis, eight bytes each. Between them they
//! are interpolated.

use super::Bricks;
use super::store::{BrickStore, PLACES};
use crate::SampleFormat;
use argil_abi::{BRICK_MIXED, GpuMaterial, MATERIAL_SIDE};
use glam::{UVec3, Vec3};

/// The weight of a point on another surface, relative to 1.
const MIN_WEIGHT: f32 = argil_abi::MIN_WEIGHT;

/// Returns the sample at the nth point along a brick's side.
pub(super) fn sample_of(nth: u32, brick: u32) -> u32 {
    let steps = MATERIAL_SIDE - 1;
    (2 * nth * brick + steps) / (2 * steps)
}

/// Packs a material into eight bytes: the square roots of the base color, the roughness, emission e as e / (1 + e),
/// and the metalness.
pub(crate) fn packed(m: &GpuMaterial) -> [u32; 2] {
    let byte = |v: f32| (v.clamp(0.0, 1.0) * 255.0 + 0.5) as u32;
    let [r, g, b, roughness] = m.base_roughness;
    let [er, eg, eb, metallic] = m.emission_metallic;
    let root = |c: f32| byte(c.max(0.0).sqrt());
    let light = |e: f32| byte(e.max(0.0) / (1.0 + e.max(0.0)));
    [
        root(r) | root(g) << 8 | root(b) << 16 | byte(roughness) << 24,
        light(er) | light(eg) << 8 | light(eb) << 16 | byte(metallic) << 24,
    ]
}

fn unpacked([a, b]: [u32; 2]) -> GpuMaterial {
    let byte = |word: u32, at: u32| (word >> (8 * at) & 255) as f32 * (1.0 / 255.0);
    let square = |at: u32| byte(a, at) * byte(a, at);
    let light = |at: u32| byte(b, at) / (1.0 - byte(b, at)).max(1.0 / 512.0);
    GpuMaterial {
        base_roughness: [square(0), square(1), square(2), byte(a, 3)],
        emission_metallic: [light(0), light(1), light(2), byte(b, 3)],
    }
}

impl BrickStore {
    /// Returns the material at a position in a brick, in voxels: see [`Bricks::material`]. `range` is the band in
    /// voxels, and `side` the brick's side.
    pub(crate) fn material_at(
        &self,
        brick: u32,
        inner: Vec3,
        range: f32,
        side: u32,
        outward: Vec3,
        palette: &[GpuMaterial],
    ) -> Option<GpuMaterial> {
        let material = *self.materials.get(brick as usize)?;
        if material & BRICK_MIXED == 0 {
            return palette.get(material as usize).or(palette.first()).copied();
        }
        let steps = (MATERIAL_SIDE - 1) as f32;
        let place = (inner * (steps / side as f32)).clamp(Vec3::ZERO, Vec3::splat(steps));
        let begin = place.floor().min(Vec3::splat(steps - 1.0));
        let share = place - begin;
        let begin = begin.as_uvec3();
        let block = (material & !BRICK_MIXED) as usize * PLACES;
        let (mut total, mut sum) = (GpuMaterial::default(), 0.0);
        for corner in 0..8u32 {
            let far = glam::uvec3(corner & 1, corner >> 1 & 1, corner >> 2);
            let at = begin + far;
            let index = at.x + MATERIAL_SIDE * (at.y + MATERIAL_SIDE * at.z);
            let own = unpacked(*self.mixed.get(block + index as usize)?);
            let of = |axis: usize| {
                if far[axis] != 0 {
                    share[axis]
                } else {
                    1.0 - share[axis]
                }
            };
            let sample = UVec3::from_array(at.to_array().map(|nth| sample_of(nth, side)));
            let d = self.stored(brick, sample, side) * range;
            let from_plane = (sample.as_vec3() - inner).dot(outward);
            let beside = (1.0 - (d - from_plane.clamp(-range, range)).abs()).max(0.0);
            let weight = of(0) * of(1) * of(2) * (MIN_WEIGHT + beside * beside);
            sum += weight;
            for k in 0..4 {
                total.base_roughness[k] += weight * own.base_roughness[k];
                total.emission_metallic[k] += weight * own.emission_metallic[k];
            }
        }
        for k in 0..4 {
            total.base_roughness[k] /= sum;
            total.emission_metallic[k] /= sum;
        }
        Some(total)
    }

    /// Returns the stored value at a sample of a brick, where 1 is the whole band.
    fn stored(&self, brick: u32, sample: UVec3, side: u32) -> f32 {
        let side = side as usize + 1;
        let [x, y, z] = sample.to_array().map(|c| c as usize);
        let at = brick as usize * side.pow(3) + x + side * (y + side * z);
        let integer = match self.pool.bits() {
            SampleFormat::Snorm8 => self.pool.of::<i8>().map_or(0.0, |all| f32::from(all[at])),
            SampleFormat::Snorm16 => self.pool.of::<i16>().map_or(0.0, |all| f32::from(all[at])),
        };
        integer / self.pool.bits().max_code() as f32
    }
}

impl Bricks {
    /// Returns the material at a point of a surface in a brick, given the program's materials. Returns `None` if
    /// there is no brick.
    ///
    /// Only points of the same surface count: those whose distance matches that to the tangent plane, which is
    /// normal to `outward`. So a thin wall's other side does not show through.
    pub fn material(
        &self,
        point: Vec3,
        outward: Vec3,
        palette: &[GpuMaterial],
    ) -> Option<GpuMaterial> {
        let voxel_grid = &self.layout.voxel_grid;
        let end = voxel_grid.begin + voxel_grid.size.as_ivec3();
        let u = ((point - voxel_grid.corner) / voxel_grid.voxel_size)
            .clamp(voxel_grid.begin.as_vec3(), end.as_vec3());
        let side = self.layout.brick_size_voxels as f32;
        let cell = (u / side)
            .floor()
            .as_ivec3()
            .min(self.layout.end_cell() - 1);
        let word = self.store.words[self.word_index(cell)];
        if !super::is_brick(word) {
            return None;
        }
        let range = self.layout.encoding.band_width(voxel_grid, 0) / voxel_grid.voxel_size;
        let inner = u - cell.as_vec3() * side;
        self.store.material_at(
            word,
            inner,
            range,
            self.layout.brick_size_voxels,
            outward,
            palette,
        )
    }

    /// Returns each brick's material: an index in the program's table, or with the top bit set, the index of a
    /// mixed brick.
    pub fn materials(&self) -> &[u32] {
        &self.store.materials
    }

    /// Returns a brick's material: its index in the program's table, and the materials of a mixed brick at 4³
    /// points.
    ///
    /// # Panics
    /// If there is no such brick.
    pub fn brick_material(&self, brick: u32) -> (u32, &[[u32; 2]]) {
        self.store.material_of(brick)
    }

    /// Returns the materials of mixed bricks, 4³ each.
    pub fn mixed(&self) -> &[[u32; 2]] {
        &self.store.mixed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eight_bytes_hold_a_material_to_a_hundredth() {
        let m = GpuMaterial {
            base_roughness: [0.75, 0.02, 0.31, 0.4],
            emission_metallic: [0.0, 0.5, 4.0, 1.0],
        };
        let found = unpacked(packed(&m));
        for k in 0..4 {
            assert!((found.base_roughness[k] - m.base_roughness[k]).abs() < 0.01);
            let e = m.emission_metallic[k];
            assert!((found.emission_metallic[k] - e).abs() < 0.005 + 0.02 * e * (1.0 + e));
        }
    }
}
