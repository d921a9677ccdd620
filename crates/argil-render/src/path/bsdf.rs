//! What a surface reflects.
//!
//! *Theory.* Facets reflect by Schlick's term, what they lose among each other comes back in all directions, and what they let
//! through is reflected by Lambert's law. The three lobes are symmetric, and a white surface reflects all light (Kulla and
//! Conty 2017).

use super::albedo::{ALBEDO, Shares};
use super::microfacets::Microfacets;
use argil_abi::GpuMaterial;
use glam::Vec3;
use std::f32::consts::{FRAC_1_PI, TAU};

/// Reflectance of a dielectric at a right angle.
const DIELECTRIC: f32 = 0.04;

/// A surface that is seen from a direction.
#[derive(Clone, Debug)]
pub(super) struct Bsdf {
    axes: [Vec3; 3],
    /// Toward the viewer, in the axes.
    from: Vec3,
    facets: Microfacets,
    mirror: Vec3,
    /// Factors of the lobes that reflect in all directions, but for what depends on the other direction.
    lost: Vec3,
    body: Vec3,
    /// What a dielectric's facets reflect after several times, as a share of what they lose.
    dielectric_again: f32,
    /// What is reflected toward the viewer, if the same light comes from everywhere.
    pub albedo: Vec3,
    /// The chance to sample a facet.
    mirror_chance: f32,
}

/// A direction that was chosen.
#[derive(Clone, Copy, Debug)]
pub(super) struct BsdfSample {
    pub direction: Vec3,
    /// What is reflected from there, divided by the density.
    pub weight: Vec3,
    pub density: f32,
}

impl Bsdf {
    /// `normal` is on the viewer's side, and `toward` leads to the viewer.
    pub(super) fn new(material: &GpuMaterial, normal: Vec3, toward: Vec3) -> Self {
        let [r, g, b, roughness] = material.base_roughness;
        let metallic = material.emission_metallic[3];
        let base = Vec3::new(r, g, b);
        let facets = Microfacets::new(roughness);
        let mirror = Vec3::splat(DIELECTRIC).lerp(base, metallic);
        let (across, along) = normal.any_orthonormal_pair();
        let axes = [across, along, normal];
        let mut from = Vec3::from(axes.map(|axis| axis.dot(toward)));
        from.z = from.z.max(1e-3);
        let from = from.normalize();

        let [of_angle, mean] = ALBEDO.shares(facets.alpha, from.z);
        let [lost, lost_mean] = [of_angle, mean].map(|shares| 1.0 - shares.element_sum());
        let again = |mirror: Vec3| {
            let mean_mirror = (20.0 * mirror + 1.0) / 21.0;
            mean_mirror * mean_mirror * (1.0 - lost_mean) / (1.0 - mean_mirror * lost_mean)
        };
        // A dielectric and a metal, mixed: Schlick's term is linear in the reflectance.
        let dielectric_again = again(Vec3::splat(DIELECTRIC)).x;
        let again = dielectric_again + metallic * (again(base) - dielectric_again);
        // What a dielectric lets through, from this direction and from all.
        let let_through = |shares: Shares, lost: f32| {
            1.0 - (DIELECTRIC * shares.x + shares.y + dielectric_again * lost)
        };
        let body = base * (1.0 - metallic);
        let through = body * let_through(of_angle, lost);
        let shine = mirror * of_angle.x + of_angle.y;
        let around = again * lost + through;
        let (shine_sum, around_sum) = (shine.element_sum(), around.element_sum());
        Self {
            axes,
            from,
            facets,
            mirror,
            lost: again * (lost / lost_mean.max(1e-6)),
            body: through / let_through(mean, lost_mean).max(1e-6),
            dielectric_again,
            albedo: shine + around,
            mirror_chance: (shine_sum / (shine_sum + around_sum).max(1e-6)).clamp(0.1, 1.0),
        }
    }

    /// Returns what is reflected from a direction, times its cosine, and the density with which it is chosen.
    pub(super) fn reflected(&self, direction: Vec3) -> (Vec3, f32) {
        self.local(Vec3::from(self.axes.map(|axis| axis.dot(direction))))
    }

    fn local(&self, to: Vec3) -> (Vec3, f32) {
        if to.z <= 0.0 {
            return (Vec3::ZERO, 0.0);
        }
        let (from, facets) = (self.from, self.facets);
        let half = (from + to).normalize();
        let density = facets.density(half);
        let rim = (1.0 - from.dot(half)).clamp(0.0, 1.0).powi(5);
        let fresnel = self.mirror + (1.0 - self.mirror) * rim;
        let lobe = density * facets.seen_by_both(from.z, to.z) / (4.0 * from.z);
        let [shares, _] = ALBEDO.shares(facets.alpha, to.z);
        let left = 1.0 - shares.element_sum();
        let through = 1.0 - (DIELECTRIC * shares.x + shares.y + self.dielectric_again * left);
        let around = (self.lost * left + self.body * through) * (FRAC_1_PI * to.z);
        let facet_density = density * facets.seen(from.z) / (4.0 * from.z);
        let chance = self.mirror_chance;
        (
            fresnel * lobe + around,
            chance * facet_density + (1.0 - chance) * FRAC_1_PI * to.z,
        )
    }

    /// Chooses a direction. `lobe` and `point` are random.
    pub(super) fn sample(&self, lobe: f32, point: [f32; 2]) -> Option<BsdfSample> {
        let to = if lobe < self.mirror_chance {
            let half = self.facets.visible_normal(self.from, point);
            2.0 * self.from.dot(half) * half - self.from
        } else {
            cosine_direction(point)
        };
        let (reflected, density) = self.local(to);
        let [x, y, z] = self.axes;
        (density > 0.0).then(|| BsdfSample {
            direction: (to.x * x + to.y * y + to.z * z).normalize(),
            weight: reflected / density,
            density,
        })
    }
}

/// Returns a direction around z, with a density of its cosine over π.
fn cosine_direction([u, v]: [f32; 2]) -> Vec3 {
    let (radius, angle) = (u.sqrt(), TAU * v);
    let (x, y) = (radius * angle.cos(), radius * angle.sin());
    Vec3::new(x, y, (1.0 - u).max(0.0).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::path::sampler::Sampler;

    fn material(base: f32, roughness: f32, metallic: f32) -> GpuMaterial {
        GpuMaterial {
            base_roughness: [base, base, base, roughness],
            emission_metallic: [0.0, 0.0, 0.0, metallic],
        }
    }

    /// A white surface reflects all light, whatever its roughness and metalness, from any angle.
    #[test]
    fn white_surfaces_reflect_all() {
        for roughness in [0.0, 0.1, 0.25, 0.43, 0.6, 0.85, 1.0] {
            for metallic in [0.0, 0.5, 1.0] {
                for cosine in [0.06f32, 0.17, 0.33, 0.6, 0.95, 1.0] {
                    let toward = Vec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
                    let bsdf = Bsdf::new(&material(1.0, roughness, metallic), Vec3::Z, toward);
                    let mut all = 0.0;
                    let count = 1 << 14;
                    for index in 0..count {
                        let mut sampler = Sampler::new(5, index);
                        let (lobe, point) = (sampler.one(), sampler.pair());
                        all += bsdf
                            .sample(lobe, point)
                            .map_or(0.0, |scattered| scattered.weight.x);
                    }
                    let share = all / count as f32;
                    assert!(
                        (share - 1.0).abs() < 0.005,
                        "roughness {roughness}, metallic {metallic}, cosine {cosine}: {share}"
                    );
                }
            }
        }
    }

    /// As much light goes both ways, and the density's integral is at most 1.
    #[test]
    fn lobes_are_symmetric_and_densities_are_whole() {
        let direction = |index: u32| cosine_direction(Sampler::new(9, index).pair());
        for (base, roughness, metallic) in [(0.3, 0.4, 0.0), (0.8, 0.7, 1.0), (0.5, 0.2, 0.3)] {
            let surface = material(base, roughness, metallic);
            for pair in 0..64 {
                let (a, b) = (direction(2 * pair), direction(2 * pair + 1));
                let one = Bsdf::new(&surface, Vec3::Z, a).reflected(b).0 / b.z;
                let other = Bsdf::new(&surface, Vec3::Z, b).reflected(a).0 / a.z;
                assert!(
                    one.abs_diff_eq(other, 2e-3 * (1.0 + one.max_element())),
                    "{one} {other}"
                );
            }
            let bsdf = Bsdf::new(&surface, Vec3::Z, Vec3::new(0.6, 0.0, 0.8));
            let count = 1 << 16;
            let sum: f32 = (0..count)
                .map(|index| {
                    let [u, v] = Sampler::new(3, index).pair();
                    let (z, angle) = (u, TAU * v);
                    let side = (1.0 - z * z).sqrt();
                    bsdf.reflected(Vec3::new(side * angle.cos(), side * angle.sin(), z))
                        .1
                })
                .sum();
            let whole = sum * TAU / count as f32;
            // Some facets reflect below the surface.
            assert!((0.8..1.01).contains(&whole), "{whole}");
        }
    }
}
