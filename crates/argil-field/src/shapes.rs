//! The distance functions of shapes, written once for plain and dual numbers. `shapes.wgsl` is the twin, with the
//! same names and the same order of operations. Tests compare both with `naive.rs`.
//!
//! Formulas after Inigo Quilez, <https://iquilezles.org/articles/distfunctions/>, except for the ellipsoid (a bound
//! that keeps the Lipschitz constant 1) and the pyramid (his omits the base). `w` holds a shape's words: see
//! `params.rs`.

use crate::scalar::Real;

type P<R> = [R; 3];

#[inline(always)]
pub(crate) fn length2<R: Real>(x: R, y: R) -> R {
    (x * x + y * y).sqrt()
}

#[inline(always)]
pub(crate) fn length3<R: Real>(x: R, y: R, z: R) -> R {
    (x * x + y * y + z * z).sqrt()
}

/// Returns the distance to a region, given the signed distances along two orthogonal directions.
#[inline(always)]
pub(crate) fn corner2<R: Real>(x: R, y: R) -> R {
    x.max(y).min(R::constant(0.0)) + length2(x.positive_part(), y.positive_part())
}

#[inline(always)]
pub(crate) fn corner3<R: Real>(x: R, y: R, z: R) -> R {
    x.max(y.max(z)).min(R::constant(0.0))
        + length3(x.positive_part(), y.positive_part(), z.positive_part())
}

#[inline(always)]
pub(crate) fn sd_sphere<R: Real>([x, y, z]: P<R>, w: &[f32; 1]) -> R {
    length3(x, y, z) - w[0]
}

/// Returns the distance to an ellipsoid. `w`: radii, their reciprocals, the smallest, the largest.
#[inline(always)]
pub(crate) fn sd_ellipsoid<R: Real>([x, y, z]: P<R>, w: &[f32; 8]) -> R {
    // Three bounds with constant 1: the sphere's in scaled space, and those of the box and the sphere around.
    let scaled = (length3(x * w[3], y * w[4], z * w[5]) - 1.0) * w[6];
    let cuboid = corner3(x.abs() - w[0], y.abs() - w[1], z.abs() - w[2]);
    let ball = length3(x, y, z) - w[7];
    scaled.max(cuboid.max(ball))
}

/// Returns the distance to a box. `w`: half size minus the rounding, rounding.
#[inline(always)]
pub(crate) fn sd_box<R: Real>([x, y, z]: P<R>, w: &[f32; 4]) -> R {
    corner3(x.abs() - w[0], y.abs() - w[1], z.abs() - w[2]) - w[3]
}

#[inline(always)]
pub(crate) fn sd_box_frame<R: Real>([x, y, z]: P<R>, w: &[f32; 4]) -> R {
    let (px, py, pz) = (x.abs() - w[0], y.abs() - w[1], z.abs() - w[2]);
    let e = w[3];
    let (qx, qy, qz) = ((px + e).abs() - e, (py + e).abs() - e, (pz + e).abs() - e);
    corner3(px, qy, qz)
        .min(corner3(qx, py, qz))
        .min(corner3(qx, qy, pz))
}

#[inline(always)]
pub(crate) fn sd_torus<R: Real>([x, y, z]: P<R>, w: &[f32; 2]) -> R {
    length2(length2(x, z) - w[0], y) - w[1]
}

/// Returns the distance to a capped torus. `w`: sine and cosine of the half angle, radii.
#[inline(always)]
pub(crate) fn sd_capped_torus<R: Real>([x, y, z]: P<R>, w: &[f32; 4]) -> R {
    let x = x.abs();
    // Beyond the arc's end, its last point is nearest; otherwise the ring.
    let beyond = w[1] * x.value() > w[0] * y.value();
    let end = length3(x - w[0] * w[2], y - w[1] * w[2], z);
    let ring = length2(length2(x, y) - w[2], z);
    (if beyond { end } else { ring }) - w[3]
}

#[inline(always)]
pub(crate) fn sd_link<R: Real>([x, y, z]: P<R>, w: &[f32; 3]) -> R {
    let y = (y.abs() - w[0]).positive_part();
    length2(length2(x, y) - w[1], z) - w[2]
}

/// Returns the distance to a capsule. `w`: start, end minus start, reciprocal of its squared length, radius.
#[inline(always)]
pub(crate) fn sd_capsule<R: Real>([x, y, z]: P<R>, w: &[f32; 8]) -> R {
    let (x, y, z) = (x - w[0], y - w[1], z - w[2]);
    let h = ((x * w[3] + y * w[4] + z * w[5]) * w[6]).clamp_to(0.0, 1.0);
    length3(x - h * w[3], y - h * w[4], z - h * w[5]) - w[7]
}

/// Returns the distance to a cylinder. `w`: radius and half height minus the rounding, rounding.
#[inline(always)]
pub(crate) fn sd_cylinder<R: Real>([x, y, z]: P<R>, w: &[f32; 3]) -> R {
    corner2(length2(x, z) - w[0], y.abs() - w[1]) - w[2]
}

/// Returns the distance to a cone. `w`: radius, height, reciprocal of the squared length of the side.
#[inline(always)]
pub(crate) fn sd_cone<R: Real>([x, y, z]: P<R>, w: &[f32; 3]) -> R {
    // In the half plane (distance from the axis, y), the side goes from the tip (0, 0) to (radius, −height).
    let q = length2(x, z);
    let side = ((q * w[0] - y * w[1]) * w[2]).clamp_to(0.0, 1.0);
    let (ax, ay) = (q - side * w[0], y + side * w[1]);
    let (bx, by) = (q - q.clamp_to(0.0, w[0]), y + w[1]);
    let d = (ax * ax + ay * ay).min(bx * bx + by * by).sqrt();
    let outside = (q * w[1] + y * w[0]).max(-by);
    d.signed_as(outside)
}

/// Returns the distance to a capped cone. `w`: half height, bottom radius, top radius, difference of radii,
/// reciprocal of the squared length of the side.
#[inline(always)]
pub(crate) fn sd_capped_cone<R: Real>([x, y, z]: P<R>, w: &[f32; 5]) -> R {
    let q = length2(x, z);
    let near = R::constant(if y.value() < 0.0 { w[1] } else { w[2] });
    let (ax, ay) = (q - q.min(near), y.abs() - w[0]);
    // The side, from the top rim.
    let (ux, uy) = (R::constant(w[2]) - q, R::constant(w[0]) - y);
    let t = ((ux * w[3] + uy * (2.0 * w[0])) * w[4]).clamp_to(0.0, 1.0);
    let (bx, by) = (-ux + t * w[3], -uy + t * (2.0 * w[0]));
    let d = (ax * ax + ay * ay).min(bx * bx + by * by).sqrt();
    let inside = bx.value() < 0.0 && ay.value() < 0.0;
    if inside { -d } else { d }
}

/// Returns the distance to a round cone. `w`: bottom radius, top radius, height, sine and cosine of the side's
/// slope.
#[inline(always)]
pub(crate) fn sd_round_cone<R: Real>([x, y, z]: P<R>, w: &[f32; 5]) -> R {
    let q = length2(x, z);
    let k = y * w[4] - q * w[3];
    let bottom = length2(q, y) - w[0];
    let top = length2(q, y - w[2]) - w[1];
    let side = q * w[4] + y * w[3] - w[0];
    let upper = if k.value() > w[4] * w[2] { top } else { side };
    if k.value() < 0.0 { bottom } else { upper }
}

/// Returns the distance to a half space. `w`: unit normal, offset.
#[inline(always)]
pub(crate) fn sd_plane<R: Real>([x, y, z]: P<R>, w: &[f32; 4]) -> R {
    x * w[0] + y * w[1] + z * w[2] - w[3]
}

/// Returns the distance to a hexagonal prism. `w`: apothem, half depth.
#[inline(always)]
pub(crate) fn sd_hex_prism<R: Real>([x, y, z]: P<R>, w: &[f32; 2]) -> R {
    let (x, y) = (x.abs(), y.abs());
    // Fold over the side at 30 degrees.
    let fold = (x * -0.866_025_4 + y * 0.5).min(R::constant(0.0)) * 2.0;
    let (x, y) = (x + fold * 0.866_025_4, y - fold * 0.5);
    let half = w[0] * 0.577_350_26;
    let rise = y - w[0];
    let d = length2(x - x.clamp_to(-half, half), rise).signed_as(rise);
    corner2(d, z.abs() - w[1])
}

/// Returns the distance to a triangular prism. `w`: half side, half depth.
#[inline(always)]
pub(crate) fn sd_tri_prism<R: Real>([x, y, z]: P<R>, w: &[f32; 2]) -> R {
    let x = x.abs() - w[0];
    let y = y + w[0] * 0.577_350_26;
    // Fold over the side at 60 degrees.
    let (fx, fy) = ((x - y * 1.732_050_8) * 0.5, (x * -1.732_050_8 - y) * 0.5);
    let beyond = x.value() + 1.732_050_8 * y.value() > 0.0;
    let (x, y) = if beyond { (fx, fy) } else { (x, y) };
    let x = x - x.clamp_to(-2.0 * w[0], 0.0);
    corner2(length2(x, y).signed_as(-y), z.abs() - w[1])
}

#[inline(always)]
pub(crate) fn sd_octahedron<R: Real>([x, y, z]: P<R>, w: &[f32; 1]) -> R {
    let (x, y, z) = (x.abs(), y.abs(), z.abs());
    let m = x + y + z - w[0];
    // If the foot of the plane leaves the face, the nearest edge is opposite the smallest coordinate.
    let first = 3.0 * x.value() < m.value();
    let second = 3.0 * y.value() < m.value();
    let third = 3.0 * z.value() < m.value();
    let (qx, qy, qz) = if first {
        (x, y, z)
    } else if second {
        (y, z, x)
    } else {
        (z, x, y)
    };
    let k = ((qz - qy + w[0]) * 0.5).clamp_to(0.0, w[0]);
    let edge = length3(qx, qy - w[0] + k, qz - k);
    if first || second || third {
        edge
    } else {
        m * 0.577_350_26
    }
}

/// Returns the distance to a pyramid. `w`: half base, height, length of a face's slope, its cosine and sine.
#[inline(always)]
pub(crate) fn sd_pyramid<R: Real>([x, y, z]: P<R>, w: &[f32; 5]) -> R {
    let (x, z) = (x.abs(), z.abs());
    let swap = z.value() > x.value();
    let (x, z) = if swap { (z, x) } else { (x, z) };
    // Below the base plane, the base is nearest.
    let below = length3((x - w[0]).positive_part(), y, (z - w[0]).positive_part());
    // The face toward +x, seen from its foot: along the slope from the base's edge, and out of its plane.
    let ex = x - w[0];
    let out = ex * w[4] + y * w[3];
    let along = y * w[4] - ex * w[3];
    // The nearest point of the triangle, on the side z ≥ 0 of its middle line.
    let t = along.clamp_to(0.0, w[2]);
    let half = (R::constant(w[2]) - t) * (w[0] / w[2]);
    let inner = length3(along - t, out, (z - half).positive_part());
    // The slanted edge, from (along 0, z = half base) to (along slope, z = 0).
    let s = ((along * w[2] - (z - w[0]) * w[0]) * (1.0 / (w[2] * w[2] + w[0] * w[0])))
        .clamp_to(0.0, 1.0);
    let edge = length3(along - s * w[2], out, z - (R::constant(w[0]) - s * w[0]));
    let over_edge = z.value() > half.value();
    let outside = if over_edge { edge } else { inner };
    let inside = out.max(-y);
    let above = if inside.value() <= 0.0 {
        inside
    } else {
        outside
    };
    if y.value() < 0.0 { below } else { above }
}

/// Returns the distance to a cut sphere. `w`: radius, cut, radius of the rim.
#[inline(always)]
pub(crate) fn sd_cut_sphere<R: Real>([x, y, z]: P<R>, w: &[f32; 3]) -> R {
    let q = length2(x, z);
    let s = (q * q * (w[1] - w[0]) + (y * -2.0 + (w[1] + w[0])) * (w[2] * w[2]))
        .max(q * w[1] - y * w[2]);
    let ball = length2(q, y) - w[0];
    let disc = R::constant(w[1]) - y;
    let rim = length2(q - w[2], y - w[1]);
    let flat = if q.value() < w[2] { disc } else { rim };
    if s.value() < 0.0 { ball } else { flat }
}

/// Returns the distance to a cut hollow sphere. `w`: radius, cut, radius of the rim, thickness.
#[inline(always)]
pub(crate) fn sd_cut_hollow_sphere<R: Real>([x, y, z]: P<R>, w: &[f32; 4]) -> R {
    let q = length2(x, z);
    let rim = length2(q - w[2], y - w[1]);
    let ball = (length2(q, y) - w[0]).abs();
    let beyond = w[1] * q.value() < w[2] * y.value();
    (if beyond { rim } else { ball }) - w[3]
}

/// Returns the distance to a solid angle. `w`: sine and cosine of the half angle, radius.
#[inline(always)]
pub(crate) fn sd_solid_angle<R: Real>([x, y, z]: P<R>, w: &[f32; 3]) -> R {
    let q = length2(x, z);
    let ball = length2(q, y) - w[2];
    let t = (q * w[0] + y * w[1]).clamp_to(0.0, w[2]);
    let side = length2(q - t * w[0], y - t * w[1]).signed_as(q * w[1] - y * w[0]);
    ball.max(side)
}

/// Returns the distance to an extruded rhombus. `w`: half diagonals, half height, rounding, reciprocal of the
/// squared length of a side.
#[inline(always)]
pub(crate) fn sd_rhombus<R: Real>([x, y, z]: P<R>, w: &[f32; 5]) -> R {
    let (x, y, z) = (x.abs(), y.abs(), z.abs());
    let f = (((R::constant(w[0]) - x * 2.0) * w[0] - (R::constant(w[1]) - z * 2.0) * w[1]) * w[4])
        .clamp_to(-1.0, 1.0);
    let (ax, az) = (
        x - (R::constant(1.0) - f) * (0.5 * w[0]),
        z - (f + 1.0) * (0.5 * w[1]),
    );
    let side = x * w[1] + z * w[0] - w[0] * w[1];
    corner2(length2(ax, az).signed_as(side) - w[3], y - w[2])
}

/// Returns the distance to an extruded rounded box. `w`: half size, corner radii, rounding at the top and at the
/// bottom.
#[inline(always)]
pub(crate) fn sd_extruded_rounded_box<R: Real>([x, y, z]: P<R>, w: &[f32; 9]) -> R {
    let right = if z.value() > 0.0 { w[3] } else { w[4] };
    let left = if z.value() > 0.0 { w[5] } else { w[6] };
    let r = if x.value() > 0.0 { right } else { left };
    let flat = corner2(x.abs() - (w[0] - r), z.abs() - (w[2] - r)) - r;
    let rim = if y.value() > 0.0 { w[7] } else { w[8] };
    corner2(flat + rim, y.abs() - (w[1] - rim)) - rim
}

/// Returns the distance to a sheet in a box, from the level at the box's point nearest to `p`. No point of the box
/// is nearer to `p`. `w`: half size, radians per length, reciprocal of the level's largest slope, half of the
/// thickness.
#[inline(always)]
fn sheet_in_box<R: Real>([x, y, z]: P<R>, w: &[f32; 6], level: impl Fn([(R, R); 3]) -> R) -> R {
    let angle = |c: R, half: f32| (c.clamp_to(-half, half) * w[3]).sin_cos();
    let level = level([angle(x, w[0]), angle(y, w[1]), angle(z, w[2])]);
    let sheet = level.abs() * w[4] - w[5];
    sheet.max(corner3(x.abs() - w[0], y.abs() - w[1], z.abs() - w[2]))
}

/// Returns the distance to a gyroid sheet, by the usual approximation of A. Schoen's surface, "Infinite periodic
/// minimal surfaces without self-intersections" (1970).
#[inline(always)]
pub(crate) fn sd_gyroid<R: Real>(p: P<R>, w: &[f32; 6]) -> R {
    sheet_in_box(p, w, |[(sx, cx), (sy, cy), (sz, cz)]| {
        sx * cy + sy * cz + sz * cx
    })
}

/// Returns the distance to a sheet of H. A. Schwarz's P surface, by its usual approximation.
#[inline(always)]
pub(crate) fn sd_schwarz_p<R: Real>(p: P<R>, w: &[f32; 6]) -> R {
    sheet_in_box(p, w, |[(_, cx), (_, cy), (_, cz)]| cx + cy + cz)
}

/// Returns a lower bound of the distance to a superellipsoid: a norm whose unit sphere is the surface. The solid is
/// convex, so its slope is at most the reciprocal of the radius of an inscribed sphere. After A. Barr,
/// "Superquadrics and angle-preserving transformations" (1981). `w`: semi-axes, their reciprocals, the exponents of
/// level and of upright sections, their reciprocals, that radius.
#[inline(always)]
pub(crate) fn sd_superellipsoid<R: Real>([x, y, z]: P<R>, w: &[f32; 11]) -> R {
    let (x, y, z) = (x.abs(), y.abs(), z.abs());
    let (u, v, t) = (x * w[3], y * w[4], z * w[5]);
    // Powers of numbers up to 1.
    let most = u.max(v.max(t)).max(R::constant(1e-18));
    let level = (u / most).power(w[6]) + (t / most).power(w[6]);
    let whole = level.power(w[7] * w[8]) + (v / most).power(w[7]);
    let norm = most * whole.power(w[9]);
    ((norm - 1.0) * w[10]).max(corner3(x - w[0], y - w[1], z - w[2]))
}
