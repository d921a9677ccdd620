//! How much light a rough mirror reflects in all directions together.
//!
//! *Theory.* A microfacet model follows light to one facet only, and loses what would go on from there. The share that is left
//! depends on the angle and the roughness. It is linear in the reflectance at a right angle, so that two tables hold it for all
//! (Karis, "Real shading in Unreal Engine 4", 2013), and a third lobe brings back what is lost (Kulla and Conty, "Revisiting
//! physically based shading at Imageworks", 2017).

use super::microfacets::{Microfacets, to_roughness};
use super::sampler::Sampler;
use glam::{Vec2, Vec3};
use std::sync::LazyLock;

/// Places of a table along the cosine, and along the roughness.
const SIDE: usize = argil_abi::ALBEDO_SIDE as usize;
/// Samples of a place.
const SAMPLES: u32 = 1024;

/// Shares of light that a mirror reflects whose facets reflect all of it at a right angle, and none: at other angles, Schlick's
/// term grows. Their sum is for facets that reflect all.
pub(super) type Shares = Vec2;

/// The tables.
pub(super) struct AlbedoTables {
    /// By roughness, then by cosine.
    of: Vec<Shares>,
    /// Means over all directions, by roughness.
    means: Vec<Shares>,
}

pub(super) static ALBEDO: LazyLock<AlbedoTables> = LazyLock::new(AlbedoTables::new);

impl AlbedoTables {
    fn new() -> Self {
        use rayon::prelude::*;
        let place = |index: usize| index as f32 / (SIDE - 1) as f32;
        let of: Vec<Shares> = (0..SIDE * SIDE)
            .into_par_iter()
            .map(|index| shares(place(index / SIDE), place(index % SIDE).max(1e-3)))
            .collect();
        let means = of
            .chunks(SIDE)
            .map(|row| {
                // ∫ 2 μ E(μ) dμ, where E is linear between places.
                let steps = row.windows(2).enumerate();
                steps
                    .map(|(index, pair)| {
                        let (a, b) = (place(index), place(index + 1));
                        let slope = (pair[1] - pair[0]) / (b - a);
                        let start = pair[0] - slope * a;
                        start * (b * b - a * a) + slope * (2.0 / 3.0) * (b * b * b - a * a * a)
                    })
                    .sum()
            })
            .collect();
        Self { of, means }
    }

    /// Iterates over the table by roughness and cosine, and then over the means by roughness.
    pub(super) fn entries(&self) -> impl Iterator<Item = Shares> {
        self.of.iter().chain(&self.means).copied()
    }

    /// Returns the shares at a cosine, and their means over all directions.
    pub(super) fn shares(&self, alpha: f32, cosine: f32) -> [Shares; 2] {
        let (row, up) = between(to_roughness(alpha));
        let (column, right) = between(cosine);
        let at = |row: usize| {
            let entries = &self.of[SIDE * row + column..];
            entries[0].lerp(entries[1], right)
        };
        [
            at(row).lerp(at(row + 1), up),
            self.means[row].lerp(self.means[row + 1], up),
        ]
    }
}

fn between(share: f32) -> (usize, f32) {
    let place = share.clamp(0.0, 1.0) * (SIDE - 1) as f32;
    let first = (place as usize).min(SIDE - 2);
    (first, place - first as f32)
}

/// Integrates over all directions into which light is reflected.
fn shares(roughness: f32, cosine: f32) -> Shares {
    let facets = Microfacets::new(roughness);
    let from = Vec3::new((1.0 - cosine * cosine).max(0.0).sqrt(), 0.0, cosine);
    let mut all = Shares::ZERO;
    for index in 0..SAMPLES {
        let half = facets.visible_normal(from, Sampler::new(0, index).pair());
        let along = from.dot(half).max(0.0);
        let to = 2.0 * along * half - from;
        if to.z > 0.0 {
            let rim = (1.0 - along).powi(5);
            all += facets.passed(from.z, to.z) * Vec2::new(1.0 - rim, rim);
        }
    }
    all / SAMPLES as f32
}
