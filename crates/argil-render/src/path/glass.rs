//! Surfaces that let light through.
//!
//! *Theory.* A facet of the GGX distribution reflects by Fresnel's equations, or refracts by Snell's law (Walter et al.,
//! "Microfacet models for refraction through rough surfaces", 2007). Directions are chosen so that their weight is only the
//! share of facets that both directions see.

use super::microfacets::Microfacets;
use glam::Vec3;

/// A direction that light takes at glass.
#[derive(Clone, Copy, Debug)]
pub(super) struct GlassSample {
    pub direction: Vec3,
    pub weight: f32,
    pub is_through: bool,
}

/// Returns what a facet reflects of light at a cosine, and the cosine beyond it. `ratio` is the index on the light's side over that
/// on the other.
fn fresnel(cosine: f32, ratio: f32) -> (f32, f32) {
    let sine2 = ratio * ratio * (1.0 - cosine * cosine).max(0.0);
    if sine2 >= 1.0 {
        return (1.0, 0.0);
    }
    let beyond = (1.0 - sine2).sqrt();
    let across = (ratio * cosine - beyond) / (ratio * cosine + beyond);
    let along = (cosine - ratio * beyond) / (cosine + ratio * beyond);
    (0.5 * (across * across + along * along), beyond)
}

/// Chooses where light goes. `normal` is on the viewer's side, and `toward` leads to the viewer. `ratio` is the index of refraction
/// on the viewer's side over that on the other.
pub(super) fn sample(
    normal: Vec3,
    toward: Vec3,
    roughness: f32,
    ratio: f32,
    choice: f32,
    point: [f32; 2],
) -> Option<GlassSample> {
    let facets = Microfacets::new(roughness);
    let (across, along) = normal.any_orthonormal_pair();
    let mut from = Vec3::new(across.dot(toward), along.dot(toward), normal.dot(toward));
    from.z = from.z.max(1e-3);
    let from = from.normalize();
    let half = facets.visible_normal(from, point);
    let cosine = from.dot(half).clamp(0.0, 1.0);
    let (reflected, beyond) = fresnel(cosine, ratio);
    let is_through = choice >= reflected;
    let to = if is_through {
        (ratio * cosine - beyond) * half - ratio * from
    } else {
        2.0 * cosine * half - from
    };
    let is_on_its_side = (to.z < 0.0) == is_through;
    let direction = to.x * across + to.y * along + to.z * normal;
    is_on_its_side.then(|| GlassSample {
        direction: direction.normalize(),
        weight: facets.passed(from.z, to.z.abs()),
        is_through,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Known values for glass: 4 % at a right angle, all beyond the critical angle, and Snell's law.
    #[test]
    fn light_follows_fresnel_and_snell() {
        let (head_on, _) = fresnel(1.0, 1.0 / 1.5);
        assert!((head_on - 0.04).abs() < 1e-6);
        // The critical angle of glass is 41.8°.
        assert_eq!(fresnel(42f32.to_radians().cos(), 1.5).0, 1.0);
        assert!(fresnel(41f32.to_radians().cos(), 1.5).0 < 1.0);
        // At Brewster's angle, only one polarization is reflected.
        let brewster = 1.5f32.atan();
        let s = ((brewster - (brewster.sin() / 1.5).asin()).sin()
            / (brewster + (brewster.sin() / 1.5).asin()).sin())
        .powi(2);
        assert!((fresnel(brewster.cos(), 1.0 / 1.5).0 - 0.5 * s).abs() < 1e-5);
        // As many paths are reflected as light is.
        let (count, grazing) = (4096u32, Vec3::new(0.96, 0.0, 0.28));
        let reflects = |index: &u32| {
            let choice = (*index as f32 + 0.5) / count as f32;
            let found = sample(Vec3::Z, grazing, 0.0, 1.0 / 1.5, choice, [0.1, 0.1]);
            found.is_some_and(|found| !found.is_through)
        };
        let share = (0..count).filter(reflects).count() as f32 / count as f32;
        let expected = fresnel(grazing.z, 1.0 / 1.5).0;
        assert!(
            (share - expected).abs() < 0.002 && expected > 0.1,
            "{share} {expected}"
        );
        let toward = Vec3::new(0.6, 0.0, 0.8);
        let through = sample(Vec3::Z, toward, 0.0, 1.0 / 1.5, 0.99, [0.1, 0.1]);
        let through = through.expect("a direction");
        assert!(through.is_through);
        let sine = (1.0 - through.direction.z * through.direction.z).sqrt();
        assert!((sine - 0.4).abs() < 2e-3, "{sine}");
    }
}
