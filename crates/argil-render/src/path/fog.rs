//! Fog that thins out upward.
//!
//! *Theory.* The density falls exponentially with height, so that its sum along a ray has a formula, and the length after
//! which a given share of light is lost, too (exponential height fog: Quilez, "Better fog", 2010). Scattered light prefers a direction
//! by the function of Henyey and Greenstein (1941).

use argil_scene::Fog;
use glam::Vec3;
use std::f32::consts::{PI, TAU};

/// Below this product, the density counts as constant along a ray.
const EVEN: f32 = 1e-4;

/// Returns the optical depth of a ray from a point, up to a length.
pub(crate) fn depth(fog: &Fog, origin: Vec3, direction: Vec3, length: f32) -> f32 {
    let density = density_at(fog, origin);
    let slope = fog.falloff * direction.y;
    let change = slope * length;
    if change.abs() < EVEN {
        return density * length * (1.0 - 0.5 * change);
    }
    density * -(-change).exp_m1() / slope
}

fn density_at(fog: &Fog, point: Vec3) -> f32 {
    // Deep below its height, fog is opaque in any case.
    fog.density * (-fog.falloff * (point.y - fog.height)).min(40.0).exp()
}

/// Returns the share of light that passes.
pub(crate) fn transmitted(fog: &Fog, origin: Vec3, direction: Vec3, length: f32) -> f32 {
    (-depth(fog, origin, direction, length)).exp()
}

/// Returns the length after which a ray has an optical depth. `None` if it never has.
pub(crate) fn length_of(fog: &Fog, origin: Vec3, direction: Vec3, depth: f32) -> Option<f32> {
    let density = density_at(fog, origin);
    if density <= 0.0 {
        return None;
    }
    let slope = fog.falloff * direction.y;
    let even = depth / density;
    if (slope * even).abs() < EVEN {
        return Some(even);
    }
    let left = 1.0 - even * slope;
    (left > 0.0).then(|| -left.ln() / slope)
}

/// Returns the density of a scattered direction, which is also the share of light that goes there.
pub(crate) fn phase(anisotropy: f32, cosine: f32) -> f32 {
    let g = anisotropy;
    let denominator = (1.0 + g * g - 2.0 * g * cosine).max(1e-6);
    (1.0 - g * g) / (2.0 * TAU * denominator * denominator.sqrt())
}

/// Chooses a direction that light is scattered to, and returns its density.
pub(super) fn scattered(anisotropy: f32, forward: Vec3, [u, v]: [f32; 2]) -> (Vec3, f32) {
    let g = anisotropy;
    let cosine = if g.abs() < 1e-3 {
        1.0 - 2.0 * u
    } else {
        let share = (1.0 - g * g) / (1.0 - g + 2.0 * g * u);
        ((1.0 + g * g - share * share) / (2.0 * g)).clamp(-1.0, 1.0)
    };
    let side = (1.0 - cosine * cosine).max(0.0).sqrt();
    let turn = 2.0 * PI * v;
    let (x, y) = forward.any_orthonormal_pair();
    let direction = side * turn.cos() * x + side * turn.sin() * y + cosine * forward;
    (direction.normalize(), phase(g, cosine))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The formula is the integral, its inverse undoes it, and all scattered light goes somewhere.
    #[test]
    fn depths_are_integrals() {
        let fog = Fog {
            density: 0.7,
            falloff: 0.8,
            height: 0.5,
            ..Fog::default()
        };
        let origin = Vec3::new(0.0, 0.3, 0.0);
        for direction in [Vec3::Y, Vec3::NEG_Y, Vec3::X, Vec3::new(0.6, 0.8, 0.0)] {
            let length = 2.3;
            let steps = 10_000;
            let sum: f64 = (0..steps)
                .map(|i| {
                    let t = (i as f32 + 0.5) * length / steps as f32;
                    f64::from(density_at(&fog, origin + t * direction))
                })
                .sum::<f64>()
                * f64::from(length)
                / f64::from(steps);
            let found = depth(&fog, origin, direction, length);
            assert!(
                (f64::from(found) - sum).abs() < 1e-3 * sum,
                "{direction} {found} {sum}"
            );
            let back = length_of(&fog, origin, direction, found).expect("a length");
            assert!((back - length).abs() < 1e-3, "{direction} {back}");
        }
        // Upward, fog ends.
        assert_eq!(length_of(&fog, origin, Vec3::Y, 10.0), None);
        for g in [-0.8, 0.0, 0.5, 0.9] {
            let steps = 20_000;
            let sum: f64 = (0..steps)
                .map(|i| f64::from(phase(g, 2.0 * (i as f32 + 0.5) / steps as f32 - 1.0)))
                .sum::<f64>()
                * 2.0
                / f64::from(steps)
                * f64::from(TAU);
            assert!((sum - 1.0).abs() < 1e-2, "{g} {sum}");
            let (direction, density) = scattered(g, Vec3::Z, [0.3, 0.6]);
            assert!((phase(g, direction.z) - density).abs() < 1e-3 * density);
        }
    }
}
