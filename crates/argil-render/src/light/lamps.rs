//! Lamps: lights besides the sun. `lamps.wgsl` is the twin.
//!
//! *Theory.* A surface receives the light of all of a lamp that is above its horizon, in closed form. For rectangles, that is Lambert's
//! (1760), and for spheres Snyder's ("Area light sources for real-time graphics", 1996). A shadow leaves a share of it (Heitz et
//! al., "Combining analytic direct illumination and stochastic shadows", 2018).

use argil_abi as abi;
use glam::Vec3;
use std::f32::consts::PI;

/// Reciprocals of the tangents of the widest and the narrowest penumbra's half angle.
const SHARPNESS: [f32; 2] = [3.0, 200.0];

/// Spheres below this radius are points, which are not seen.
const LEAST_RADIUS: f32 = 1e-5;

/// A lamp, as seen from a point.
pub(super) struct LampLight {
    pub direction: Vec3,
    pub distance: f32,
    /// What a surface receives that faces it.
    pub light: Vec3,
    /// Of its shadow in fog.
    pub sharpness: f32,
}

/// Returns what a lamp brings to a point in fog, from its four rows.
pub(super) fn lamp_at(rows: &[[f32; 4]], p: Vec3) -> LampLight {
    lamp_above(rows, p, Vec3::ZERO)
}

/// Returns what a lamp brings to a surface. What of a sphere or rectangle is below its horizon does not shine on it.
pub(super) fn lamp_above(rows: &[[f32; 4]], p: Vec3, n: Vec3) -> LampLight {
    let xyz = |row: usize| Vec3::from_slice(&rows[row]);
    let soft = |sharpness: f32| sharpness.clamp(SHARPNESS[0], SHARPNESS[1]);
    let kind = rows[0][3] as u32;
    if kind == abi::LIGHT_SUN {
        let rim = rows[2][0];
        let sine = (1.0 - rim * rim).max(1e-12).sqrt();
        return LampLight {
            direction: xyz(0),
            distance: f32::MAX,
            light: xyz(1),
            sharpness: soft(rim / sine),
        };
    }
    let to = xyz(0) - p;
    let square = to.length_squared().max(1e-12);
    let distance = square.sqrt();
    let direction = to / distance;
    if kind == abi::LIGHT_SPHERE {
        let radius = rows[1][3];
        let share = cone_share(rows, -direction);
        let (direction, above) = sphere_above(n, direction, radius * radius / square);
        return LampLight {
            direction,
            distance,
            light: xyz(1) * (share * above / square),
            sharpness: soft(distance / radius.max(1e-6)),
        };
    }
    let flow = rectangle_flow(rows, to, n);
    let size = flow.length();
    LampLight {
        direction: if size > 0.0 { flow / size } else { direction },
        distance,
        light: xyz(1) * size,
        sharpness: soft(distance / (0.5 * (rows[2][3] + rows[3][3])).max(1e-6)),
    }
}

/// Returns the direction from which a sphere shines on a surface, and what that receives from there, relative to a point of light.
/// `size` is the square of the sine of half the angle that the sphere fills. A normal of zero has no horizon.
fn sphere_above(n: Vec3, direction: Vec3, size: f32) -> (Vec3, f32) {
    if size >= 1.0 {
        // Nothing shines inward.
        return (direction, 0.0);
    }
    let (cosine, sine) = (n.dot(direction), size.sqrt());
    if n == Vec3::ZERO || cosine >= sine {
        return (direction, 1.0);
    }
    if cosine <= -sine {
        return (direction, 0.0);
    }
    let toward = (direction + 0.5 * (sine - cosine) * n).normalize();
    let facing = n.dot(toward).max(1e-6);
    if size < 1e-3 {
        // A flat disc.
        let t = cosine / sine;
        let integral = t * (0.5 * PI + t.asin()) + (1.0 - t * t).sqrt() * (2.0 + t * t) / 3.0;
        return (toward, sine * integral.max(0.0) / PI / facing);
    }
    let side = (1.0 - cosine * cosine).max(1e-12).sqrt();
    let x = (1.0 / size - 1.0).max(1e-12).sqrt();
    let y = (-x * cosine / side).clamp(-1.0, 1.0);
    let across = side * (1.0 - y * y).sqrt();
    let received = (cosine * y.acos() - x * across) * size + (across / x).atan();
    let received = received.max(0.0) / (PI * size);
    (toward, received / facing)
}

/// Returns the direction from which a rectangle shines on average, times what a surface receives that faces it, for a radiance of 1.
/// It is a sum over the sides of what is above the horizon (Lambert 1760). `to` leads to its center.
fn rectangle_flow(rows: &[[f32; 4]], to: Vec3, n: Vec3) -> Vec3 {
    let [width, height] = [2, 3].map(|row: usize| Vec3::from_slice(&rows[row]) * rows[row][3]);
    if to.dot(width.cross(height)) >= 0.0 {
        return Vec3::ZERO;
    }
    let corners = [
        to - width - height,
        to - width + height,
        to + width + height,
        to + width - height,
    ];
    let mut sum = Vec3::ZERO;
    // Where the outline goes below the horizon, and where it comes back.
    let (mut leaves, mut returns) = (Vec3::ZERO, Vec3::ZERO);
    for index in 0..4 {
        let (a, b) = (corners[index], corners[(index + 1) % 4]);
        let (above_a, above_b) = (n.dot(a), n.dot(b));
        if above_a < 0.0 && above_b < 0.0 {
            continue;
        }
        let (mut from, mut until) = (a, b);
        if above_a < 0.0 {
            from = a + (b - a) * (above_a / (above_a - above_b));
            returns = from;
        } else if above_b < 0.0 {
            until = a + (b - a) * (above_a / (above_a - above_b));
            leaves = until;
        }
        sum += flow_of_side(from, until);
    }
    sum + flow_of_side(leaves, returns)
}

fn flow_of_side(a: Vec3, b: Vec3) -> Vec3 {
    let (a, b) = (a.normalize_or_zero(), b.normalize_or_zero());
    let across = a.cross(b);
    let sine = across.length();
    // Narrow sides are as long as their angle.
    let ratio = if sine > 1e-4 {
        sine.atan2(a.dot(b)) / sine
    } else {
        1.0
    };
    0.5 * ratio * across
}

/// Returns the share of a sphere's light that its cone lets through.
fn cone_share(rows: &[[f32; 4]], away: Vec3) -> f32 {
    let (side, full) = (rows[2][3], rows[3][0]);
    let cosine = away.dot(Vec3::from_slice(&rows[2]));
    if cosine >= full {
        return 1.0;
    }
    let t = ((cosine - side) / (full - side).max(1e-6)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Returns where a ray meets a lamp, and what comes from there.
pub(super) fn met(rows: &[[f32; 4]], eye: Vec3, direction: Vec3) -> Option<(f32, Vec3)> {
    let xyz = |row: usize| Vec3::from_slice(&rows[row]);
    let to = xyz(0) - eye;
    match rows[0][3] as u32 {
        abi::LIGHT_SPHERE => {
            let square = rows[1][3] * rows[1][3];
            let along = to.dot(direction);
            let inside = square - (to - along * direction).length_squared();
            let length = along - inside.max(0.0).sqrt();
            let light = xyz(1) * (cone_share(rows, -direction) / (PI * square).max(1e-20));
            (inside > 0.0 && length > 0.0 && rows[1][3] >= LEAST_RADIUS).then_some((length, light))
        }
        abi::LIGHT_RECTANGLE => {
            let (width, height) = (xyz(2), xyz(3));
            let out = width.cross(height);
            let facing = out.dot(direction);
            let length = out.dot(to) / facing.min(-1e-20);
            let p = length * direction - to;
            let is_in = p.dot(width).abs() < rows[2][3] && p.dot(height).abs() < rows[3][3];
            (facing < 0.0 && length > 0.0 && is_in).then_some((length, xyz(1)))
        }
        _ => None,
    }
}
