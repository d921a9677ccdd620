//! What paths need to know of a surface.

use argil_abi::GpuMaterial;
use glam::Vec3;

/// The material of a surface that a path met.
#[derive(Clone, Copy, Debug)]
pub struct PathMaterial {
    /// Base color, roughness, emission and metalness.
    pub surface: GpuMaterial,
    /// Share of light that passes a dielectric.
    pub transmission: f32,
    /// Index of refraction.
    pub refractive_index: f32,
    /// 1 / the distance inside after which white light has the base color, or 0.
    pub attenuation: f32,
}

impl From<GpuMaterial> for PathMaterial {
    fn from(surface: GpuMaterial) -> Self {
        Self {
            surface,
            transmission: 0.0,
            refractive_index: 1.5,
            attenuation: 0.0,
        }
    }
}

impl PathMaterial {
    /// Creates a material from its properties: base color, roughness, emission, metalness, transmission, index of refraction,
    /// 1 / attenuation distance, and one that is not used.
    pub fn from_properties(
        [
            r,
            g,
            b,
            rough,
            er,
            eg,
            eb,
            metal,
            through,
            index,
            attenuation,
            _,
        ]: [f32; 12],
    ) -> Self {
        Self {
            surface: GpuMaterial {
                base_roughness: [r, g, b, rough],
                emission_metallic: [er, eg, eb, metal],
            },
            transmission: through,
            refractive_index: index,
            attenuation,
        }
    }

    /// Returns the chance that light meets glass here, and not an opaque surface.
    pub(super) fn glass(&self) -> f32 {
        self.transmission * (1.0 - self.surface.emission_metallic[3])
    }

    pub(super) fn base(&self) -> Vec3 {
        let [r, g, b, _] = self.surface.base_roughness;
        Vec3::new(r, g, b)
    }

    /// Returns what is lost per unit of length inside (Beer and Lambert's law).
    pub(super) fn absorption(&self) -> Vec3 {
        -self.base().max(Vec3::splat(1e-4)).map(f32::ln) * self.attenuation
    }
}
