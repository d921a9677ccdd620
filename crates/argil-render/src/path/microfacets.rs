//! The GGX distribution of facets, with Smith's shadows (Walter et al., "Microfacet models for refraction through rough
//! surfaces", 2007). Directions are in a frame whose z is the normal.

use glam::Vec3;
use std::f32::consts::{PI, TAU};

/// The facets of a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Microfacets {
    pub alpha: f32,
}

/// The least roughness squared. Smoother surfaces are mirrors to the eye.
const LEAST_ALPHA: f32 = 1e-3;

/// Returns the roughness whose facets have a width.
pub(super) fn to_roughness(alpha: f32) -> f32 {
    alpha.sqrt()
}

impl Microfacets {
    pub(super) fn new(roughness: f32) -> Self {
        Self {
            alpha: (roughness * roughness).max(LEAST_ALPHA),
        }
    }

    /// Returns the density of facets with a normal.
    pub(super) fn density(self, half: Vec3) -> f32 {
        let alpha2 = self.alpha * self.alpha;
        // Without a difference of nearly equal numbers.
        let spread = alpha2 * half.z * half.z + half.x * half.x + half.y * half.y;
        alpha2 / (PI * spread * spread).max(1e-30)
    }

    /// Returns Smith's Λ for a cosine.
    fn shadow(self, cosine: f32) -> f32 {
        let cosine2 = (cosine * cosine).max(1e-12);
        let tangent2 = (1.0 - cosine2).max(0.0) / cosine2;
        0.5 * ((1.0 + self.alpha * self.alpha * tangent2).sqrt() - 1.0)
    }

    /// Returns the share of facets that a direction sees.
    pub(super) fn seen(self, cosine: f32) -> f32 {
        1.0 / (1.0 + self.shadow(cosine))
    }

    /// Returns the share of facets that both directions see, if they see them at heights that depend on each other.
    pub(super) fn seen_by_both(self, one: f32, other: f32) -> f32 {
        1.0 / (1.0 + self.shadow(one) + self.shadow(other))
    }

    /// Returns the share of the facets that `from` sees, and that `to` sees as well.
    pub(super) fn passed(self, from: f32, to: f32) -> f32 {
        let shadow_from = self.shadow(from);
        (1.0 + shadow_from) / (1.0 + shadow_from + self.shadow(to))
    }

    /// Returns the normal of a facet among those that a direction sees (Heitz, "Sampling the GGX distribution of visible
    /// normals", 2018).
    pub(super) fn visible_normal(self, from: Vec3, [u, v]: [f32; 2]) -> Vec3 {
        let stretched = Vec3::new(self.alpha * from.x, self.alpha * from.y, from.z).normalize();
        let across = Vec3::Z.cross(stretched).try_normalize().unwrap_or(Vec3::X);
        let along = stretched.cross(across);
        let (radius, angle) = (u.sqrt(), TAU * v);
        let x = radius * angle.cos();
        let share = 0.5 * (1.0 + stretched.z);
        let y = (1.0 - share) * (1.0 - x * x).max(0.0).sqrt() + share * radius * angle.sin();
        let z = (1.0 - x * x - y * y).max(0.0).sqrt();
        let normal = x * across + y * along + z * stretched;
        Vec3::new(
            self.alpha * normal.x,
            self.alpha * normal.y,
            normal.z.max(1e-6),
        )
        .normalize()
    }
}
