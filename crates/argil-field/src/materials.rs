//! The table of a scene's materials.

use argil_abi::GpuMaterial;
use argil_scene::{Material, Scene};

/// Returns the table: the default material, and then all materials by name.
pub(crate) fn materials_of(scene: &Scene) -> Vec<GpuMaterial> {
    let own = scene.materials().values().map(words_of);
    std::iter::once(words_of(&Material::default()))
        .chain(own)
        .collect()
}

fn words_of(m: &Material) -> GpuMaterial {
    let ([r, g, b], [er, eg, eb]) = (m.base_color, m.emission);
    GpuMaterial {
        base_roughness: [r, g, b, m.roughness],
        emission_metallic: [er, eg, eb, m.metallic],
    }
}
