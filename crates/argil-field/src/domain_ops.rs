//! Changes of the point: folds, copies, deformations. `domain_ops.wgsl` is the twin.

use crate::scalar::{LANES, Real};

/// Words of a repetition: spacing, offset, smallest and largest cell, candidates, three each; then the largest jump
/// of the root's operand that contains it.
pub(crate) const REPEAT_WORDS: usize = 16;
/// Words of a radial repetition: copies, angle between them, candidates; then the largest jump.
pub(crate) const RADIAL_WORDS: usize = 4;
/// Words after those of either repetition: the box of what is repeated, the square of the factor from the distance to it
/// to that of the solid, and what rounding can add.
pub(crate) const COPY_WORDS: usize = 8;
/// Words of a clamp: minimum corner, maximum corner; then the angle per unit of length, the scale to the scene's unit,
/// and the largest distance from the y axis.
pub(crate) const TWIST_WORDS: usize = 9;

/// Returns candidate `j` of `candidates` around a coordinate's own cell: with two, the own cell and the nearest
/// neighbor; with more, the same number on each side, nearest first.
#[inline(always)]
pub(crate) fn nearby(nearest: f32, beyond: f32, j: f32, candidates: f32) -> f32 {
    let side = if beyond < 0.0 { -j } else { j };
    let away = (0.5 * j + 0.5).floor();
    let is_after = 2.0 * away > j;
    let offset = if candidates <= 2.0 {
        side
    } else if is_after {
        away
    } else {
        -away
    };
    nearest + offset
}

/// Returns a coordinate relative to the center of candidate cell `j`.
#[inline(always)]
pub(crate) fn repeat_axis<R: Real>(p: R, j: f32, w: &[f32; REPEAT_WORDS], axis: usize) -> R {
    let (spacing, offset, low, high, candidates) =
        (w[axis], w[3 + axis], w[6 + axis], w[9 + axis], w[12 + axis]);
    let shifted = p + offset;
    let nearest = Real::clamp_to((shifted.value() / spacing + 0.5).floor(), low, high);
    let near = Real::clamp_to(
        nearby(nearest, shifted.value() - nearest * spacing, j, candidates),
        low,
        high,
    );
    // All cells, one after another.
    let cell = if candidates > high - low {
        low + j
    } else {
        near
    };
    shifted - cell * spacing
}

/// Returns an angle within 1e-4, which is enough to find a sector. The exact rotation follows.
#[inline(always)]
pub(crate) fn rough_atan2(y: f32, x: f32) -> f32 {
    let (ax, ay) = (x.abs(), y.abs());
    let (high, low) = (Real::max(ax, ay), Real::min(ax, ay));
    let a = low / Real::max(high, 1e-30);
    let s = a * a;
    let r = ((-0.046_496_475 * s + 0.159_314_22) * s - 0.327_622_76) * s * a + a;
    let r = if ay > ax {
        std::f32::consts::FRAC_PI_2 - r
    } else {
        r
    };
    let r = if x < 0.0 { std::f32::consts::PI - r } else { r };
    if y < 0.0 { -r } else { r }
}

/// Returns x and z rotated back by candidate `j`'s angle.
#[inline(always)]
pub(crate) fn radial<R: Real>(x: R, z: R, j: f32, w: &[f32; RADIAL_WORDS]) -> (R, R) {
    let nearest = (rough_atan2(z.value(), x.value()) / w[1] + 0.5).floor();
    let (s, c) = crate::scalar::sin_cos(nearest * w[1]);
    let across = z.value() * c - x.value() * s;
    let sector = nearby(nearest, across, j, w[2]);
    let (s, c) = crate::scalar::sin_cos(sector * w[1]);
    (x * c + z * s, z * c - x * s)
}

/// The angle within which a sector may be another one than the rough angle tells, with room for rounding.
const ROUGH: f32 = 3e-4;

/// The sectors of a candidate for many points.
pub(crate) enum Sectors {
    /// All have the same one.
    One(f32),
    /// All have the same one of their own, and the candidate is the neighbor before it or after it.
    Beside(f32),
    /// They differ.
    Many,
}

/// Returns the sectors of candidate `j`, which [`radial`] finds for each point.
#[inline(always)]
pub(crate) fn sectors<R: Real>(
    xs: &R::Lanes,
    zs: &R::Lanes,
    j: f32,
    w: &[f32; RADIAL_WORDS],
    active: usize,
) -> Sectors {
    let (step, candidates) = (w[1], w[2]);
    if candidates == w[0] {
        return Sectors::One(j);
    }
    let half = 0.5 * step - ROUGH;
    if !(ROUGH..1.5).contains(&half) {
        return Sectors::Many;
    }
    let angle = rough_atan2(R::get(zs, 0).value(), R::get(xs, 0).value());
    let nearest = (angle / step + 0.5).floor();
    let (s, c) = crate::scalar::sin_cos(nearest * step);
    let (sine, cosine) = crate::scalar::sin_cos(half);
    let limit = sine / cosine;
    let mut strays = 0u32;
    for i in 0..active.min(LANES) {
        let (x, z) = (R::get(xs, i).value(), R::get(zs, i).value());
        let (along, across) = (x * c + z * s, z * c - x * s);
        let is_clear = across.abs() <= limit * along;
        strays |= u32::from(!is_clear);
    }
    if strays != 0 {
        Sectors::Many
    } else if candidates > 2.0 || j == 0.0 {
        Sectors::One(nearby(nearest, 0.0, j, candidates))
    } else {
        Sectors::Beside(nearest)
    }
}

/// Rotates points back by candidate `j`'s angle.
#[inline(always)]
pub(crate) fn radial_points<R: Real>(
    [xs, ys, zs]: &[R::Lanes; 3],
    [px, py, pz]: &mut [R::Lanes; 3],
    j: f32,
    w: &[f32; RADIAL_WORDS],
    active: usize,
) {
    let turn = |sector: f32| crate::scalar::sin_cos(sector * w[1]);
    match sectors::<R>(xs, zs, j, w, active) {
        Sectors::One(sector) => {
            let (s, c) = turn(sector);
            for i in 0..active.min(LANES) {
                let (x, z) = (R::get(xs, i), R::get(zs, i));
                R::set(px, i, x * c + z * s);
                R::set(pz, i, z * c - x * s);
            }
        }
        Sectors::Beside(nearest) => {
            let (s, c) = turn(nearest);
            let (before, after) = (turn(nearest - 1.0), turn(nearest + 1.0));
            for i in 0..active.min(LANES) {
                let (x, z) = (R::get(xs, i), R::get(zs, i));
                let is_before = z.value() * c - x.value() * s < 0.0;
                let s = if is_before { before.0 } else { after.0 };
                let c = if is_before { before.1 } else { after.1 };
                R::set(px, i, x * c + z * s);
                R::set(pz, i, z * c - x * s);
            }
        }
        Sectors::Many => {
            for i in 0..active.min(LANES) {
                let (x, z) = radial(R::get(xs, i), R::get(zs, i), j, w);
                R::set(px, i, x);
                R::set(pz, i, z);
            }
        }
    }
    py.clone_from(ys);
}

#[inline(always)]
pub(crate) fn twist<R: Real>([x, y, z]: [R; 3], rate: f32) -> [R; 3] {
    let (s, c) = (y * rate).sin_cos();
    [c * x + s * z, y, c * z - s * x]
}

#[inline(always)]
pub(crate) fn bend<R: Real>([x, y, z]: [R; 3], rate: f32) -> [R; 3] {
    let (s, c) = (x * rate).sin_cos();
    [c * x - s * y, s * x + c * y, z]
}

/// Returns the nearest point of a clamp.
#[inline(always)]
pub(crate) fn held<R: Real>([x, y, z]: [R; 3], w: &[f32; TWIST_WORDS]) -> [R; 3] {
    let (x, z) = (x.clamp_to(w[0], w[3]), z.clamp_to(w[2], w[5]));
    let (far, most) = (x * x + z * z, w[8] * w[8]);
    let by = if far.value() > most {
        (R::constant(most) / far).sqrt()
    } else {
        R::constant(1.0)
    };
    [x * by, y.clamp_to(w[1], w[4]), z * by]
}

/// Returns the distance from outside a clamp: the distances to it and within it are legs of a right triangle.
#[inline(always)]
pub(crate) fn unclamp<R: Real>(d: R, p: [R; 3], w: &[f32; TWIST_WORDS]) -> R {
    let q = held(p, w);
    let gap = [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
    let outside = (gap[0] * gap[0] + gap[1] * gap[1] + gap[2] * gap[2]) * (w[7] * w[7]);
    let h = d.positive_part();
    if outside.value() > 0.0 {
        (outside + h * h).sqrt()
    } else {
        d
    }
}

/// Maps every lane of a point by a function.
#[inline(always)]
pub(crate) fn map_point<R: Real>(
    p: &mut [R::Lanes; 3],
    active: usize,
    f: impl Fn([R; 3]) -> [R; 3],
) {
    let [xs, ys, zs] = p;
    for i in 0..active.min(LANES) {
        let [x, y, z] = f([R::get(xs, i), R::get(ys, i), R::get(zs, i)]);
        R::set(xs, i, x);
        R::set(ys, i, y);
        R::set(zs, i, z);
    }
}
