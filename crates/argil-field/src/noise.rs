//! Seeded value noise. `noise.wgsl` is the twin.

use crate::scalar::Real;

/// Hashes a grid point: its coordinates times large odd numbers, then two rounds of shifts and multiplications,
/// with constants from Wellons, "Prospecting for hash functions" (2018).
#[inline(always)]
fn hash(x: i32, y: i32, z: i32, seed: u32) -> u32 {
    let mut h = (x as u32).wrapping_mul(0x8da6_b343)
        ^ (y as u32).wrapping_mul(0xd816_3841)
        ^ (z as u32).wrapping_mul(0xcb1a_b31f)
        ^ seed.wrapping_mul(0x9e37_79b9);
    h = (h ^ (h >> 16)).wrapping_mul(0x7feb_352d);
    h = (h ^ (h >> 15)).wrapping_mul(0x846c_a68b);
    h ^ (h >> 16)
}

/// Returns a value from −1 to 1 at a grid point.
#[inline(always)]
pub(crate) fn lattice(x: i32, y: i32, z: i32, seed: u32) -> f32 {
    (hash(x, y, z, seed) >> 8) as f32 * (2.0 / 16_777_215.0) - 1.0
}

/// Returns value noise from −1 to 1: grid values mixed with the fade 6t⁵ − 15t⁴ + 10t³ (Perlin 2002) along each
/// axis.
#[inline(always)]
pub(crate) fn value_noise<R: Real>(p: [R; 3], seed: u32) -> R {
    // Beyond this, the grid is finer than f32. The clamp keeps the conversion to integers defined.
    let cell = |c: R| Real::min(Real::max(c.value().floor(), -1e9), 1e9);
    let floor = [cell(p[0]), cell(p[1]), cell(p[2])];
    let (ix, iy, iz) = (floor[0] as i32, floor[1] as i32, floor[2] as i32);
    let fade = |k: usize| {
        let t = (p[k] - floor[k]).clamp_to(0.0, 1.0);
        t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
    };
    let (u, v, w) = (fade(0), fade(1), fade(2));
    let at = |dx, dy, dz| {
        lattice(
            ix.wrapping_add(dx),
            iy.wrapping_add(dy),
            iz.wrapping_add(dz),
            seed,
        )
    };
    let along_x = |dy, dz| {
        let (a, b) = (at(0, dy, dz), at(1, dy, dz));
        u * (b - a) + a
    };
    let along_y = |dz| {
        let (a, b) = (along_x(0, dz), along_x(1, dz));
        a + (b - a) * v
    };
    let (a, b) = (along_y(0), along_y(1));
    a + (b - a) * w
}
