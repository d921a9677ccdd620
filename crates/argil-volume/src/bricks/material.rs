//! The materials of bricks. `material.wgsl` is the twin.
//!
//! A brick of one material stores its index in the program's table. A brick of several materials, or of blends,
//! stores materials at 4³ points, from one end to the other along each axis, eight bytes each. Between them they
//! are interpolated.

use super::Bricks;
use super::store::{BrickStore, PLACES};
use crate::{BrickSampler, CellLocations, SampleFormat, Texel};
use argil_abi::{BRICK_MIXED, GpuMaterial, MATERIAL_SIDE};
use argil_field::LANES;
use glam::{Vec3, vec3};

/// The weight of a point on another surface, relative to 1.
const MIN_WEIGHT: f32 = argil_abi::MIN_WEIGHT;

/// Returns the sample at a point along a brick's side.
pub(super) fn sample_of(index: u32, brick: u32) -> u32 {
    let steps = MATERIAL_SIDE - 1;
    (2 * index * brick + steps) / (2 * steps)
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

/// Returns the base color, the roughness, the emission and the metalness of packed bytes. In plain loops, which the
/// compiler turns into SIMD.
#[inline(always)]
fn unpacked([a, b]: [u32; 2]) -> [f32; 8] {
    const BYTE: [u32; 8] = [0, 8, 16, 24, 0, 8, 16, 24];
    let mut own = [0.0; 8];
    for k in 0..8 {
        let word = if k < 4 { a } else { b };
        let share = (word >> BYTE[k] & 255) as f32 * (1.0 / 255.0);
        let left = 1.0 - share;
        let light = share
            / if left > 1.0 / 512.0 {
                left
            } else {
                1.0 / 512.0
            };
        let other = if k < 4 { share * share } else { light };
        own[k] = if k % 4 == 3 { share } else { other };
    }
    own
}

impl BrickStore {
    /// Returns the material at a position in a brick, in voxels: see [`Bricks::material`]. `range` is the band in
    /// voxels, and `side` the brick's side.
    #[inline(always)]
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
        let block = (material & !BRICK_MIXED) as usize * PLACES;
        let mixed = self.mixed.get(block..)?.first_chunk::<PLACES>()?;
        let samples = (side as usize + 1).pow(3);
        let own = brick as usize * samples..(brick as usize + 1) * samples;
        let place = (inner, range, side);
        match self.pool.bits() {
            SampleFormat::Snorm8 => {
                Some(mixture(&self.pool.of::<i8>()?[own], mixed, place, outward))
            }
            SampleFormat::Snorm16 => {
                Some(mixture(&self.pool.of::<i16>()?[own], mixed, place, outward))
            }
        }
    }
}

/// Mixes the materials around a position in a brick of `side` voxels, given its samples and its band in voxels.
#[inline(always)]
pub(crate) fn mixture<T: Texel>(
    samples: &[T],
    mixed: &[[u32; 2]; PLACES],
    (inner, range, side): (Vec3, f32, u32),
    outward: Vec3,
) -> GpuMaterial {
    let steps = (MATERIAL_SIDE - 1) as f32;
    let place = (inner * (steps / side as f32)).clamp(Vec3::ZERO, Vec3::splat(steps));
    let begin = place.floor().min(Vec3::splat(steps - 1.0));
    let share = place - begin;
    let begin = begin.as_uvec3();
    let first = (begin.x + MATERIAL_SIDE * (begin.y + MATERIAL_SIDE * begin.z)) as usize;
    let corner = |x: usize, y: usize, z: usize| {
        let side = MATERIAL_SIDE as usize;
        mixed[(first + x + side * (y + side * z)).min(PLACES - 1)]
    };
    // Most places have one material around them.
    let own = corner(0, 0, 0);
    if (1..8).all(|at| corner(at & 1, at >> 1 & 1, at >> 2) == own) {
        return material_of(unpacked(own));
    }
    let code = range / T::FORMAT.max_code() as f32;
    // Along each axis, the two points' samples, how far these are from the position, and their weights.
    let along = [0, 1, 2].map(|axis: usize| {
        [(0, 1.0 - share[axis]), (1, share[axis])].map(|(far, weight)| {
            let sample = sample_of(begin[axis] + far, side);
            (sample as usize, sample as f32 - inner[axis], weight)
        })
    });
    let (row, plane) = (side as usize + 1, (side as usize + 1).pow(2));
    let (mut total, mut sum) = ([0.0f32; 8], 0.0);
    for (z, along_z) in along[2].iter().enumerate() {
        for (y, along_y) in along[1].iter().enumerate() {
            for (x, along_x) in along[0].iter().enumerate() {
                let own = unpacked(corner(x, y, z));
                let at = along_x.0 + row * along_y.0 + plane * along_z.0;
                let d = samples[at].code() * code;
                let away = vec3(along_x.1, along_y.1, along_z.1).dot(outward);
                let beside = (1.0 - (d - away.clamp(-range, range)).abs()).max(0.0);
                let weight = along_x.2 * along_y.2 * along_z.2 * (MIN_WEIGHT + beside * beside);
                sum += weight;
                for (total, own) in total.iter_mut().zip(own) {
                    *total += weight * own;
                }
            }
        }
    }
    let scale = 1.0 / sum;
    material_of(total.map(|own| own * scale))
}

#[inline(always)]
fn material_of([r, g, b, roughness, er, eg, eb, metallic]: [f32; 8]) -> GpuMaterial {
    GpuMaterial {
        base_roughness: [r, g, b, roughness],
        emission_metallic: [er, eg, eb, metallic],
    }
}

impl<T: Texel> BrickSampler<'_, T> {
    /// Looks up the materials at points of surfaces, given these and the outward directions: see [`Bricks::material`].
    ///
    /// # Panics
    /// If there are more points than [`LANES`], or the slices differ in length.
    #[inline(always)]
    pub fn materials(
        &self,
        [points, outward]: [[&[f32]; 3]; 2],
        palette: &[GpuMaterial],
        out: &mut [Option<GpuMaterial>],
    ) {
        let n = out.len();
        assert!(n <= LANES && points.iter().chain(&outward).all(|p| p.len() == n));
        let voxel_grid = &self.layout.voxel_grid;
        let mut u = [[0.0f32; LANES]; 3];
        for axis in 0..3 {
            for (u, from) in u[axis].iter_mut().zip(points[axis]) {
                *u = (from - voxel_grid.corner[axis]) / voxel_grid.voxel_size;
            }
        }
        let mut at = CellLocations::default();
        self.locate([&u[0][..n], &u[1][..n], &u[2][..n]], &mut at);
        let range = self.layout.encoding.band_width(voxel_grid, 0) / voxel_grid.voxel_size;
        let side = self.layout.brick_size_voxels;
        for (i, out) in out.iter_mut().enumerate() {
            let inner = vec3(at.inner[0][i], at.inner[1][i], at.inner[2][i]);
            let outward = vec3(outward[0][i], outward[1][i], outward[2][i]);
            let (store, word) = (&self.bricks.store, at.word[i]);
            *out = super::is_brick(word)
                .then(|| store.material_at(word, inner, range, side, outward, palette))
                .flatten();
        }
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
        let found = material_of(unpacked(packed(&m)));
        for k in 0..4 {
            assert!((found.base_roughness[k] - m.base_roughness[k]).abs() < 0.01);
            let e = m.emission_metallic[k];
            assert!((found.emission_metallic[k] - e).abs() < 0.005 + 0.02 * e * (1.0 + e));
        }
    }
}
