//! Extensions that a file requires.

use super::super::error::ReadFault;

/// Extensions that a reader of triangles can leave out, by the beginnings of their names.
const HARMLESS: &[&str] = &[
    "KHR_materials_",
    "KHR_texture_",
    "EXT_texture_",
    "MSFT_texture_",
    "EXT_materials_",
    "MSFT_packing_",
    "MSFT_lod",
    "KHR_lights_",
    "EXT_lights_",
    "KHR_xmp",
    "KHR_animation_",
    "KHR_audio",
    "KHR_technique",
    "KHR_interactivity",
    "KHR_node_",
    "EXT_mesh_features",
    "EXT_structural_metadata",
    "EXT_feature_metadata",
    "EXT_instance_features",
    "CESIUM_primitive_outline",
    "ADOBE_materials_",
    "AGI_",
    "VRM",
    "KHR_physics_",
];

/// Extensions that are read.
const READ: &[&str] = &[
    "KHR_mesh_quantization",
    "EXT_meshopt_compression",
    "KHR_meshopt_compression",
    "EXT_mesh_gpu_instancing",
];

const DRACO: &str = "KHR_draco_mesh_compression";

pub(super) fn draco() -> ReadFault {
    ReadFault::Unsupported(format!(
        "its meshes are compressed with Draco ({DRACO}), which is not read: export it without, for example from Blender or by \
         `gltf-transform cp in.glb out.glb`"
    ))
}

/// Refuses extensions that may change triangles, by name and with the remedy.
pub(super) fn check(required: &[String]) -> Result<(), ReadFault> {
    for name in required {
        if name == DRACO {
            return Err(draco());
        }
        let is_harmless = HARMLESS.iter().any(|start| name.starts_with(start));
        if !is_harmless && !READ.contains(&&name[..]) {
            return Err(ReadFault::Unsupported(format!(
                "it requires the extension {name}, which is not known here and may change its triangles: export it \
                 without, or take that name out of its \"extensionsRequired\" if triangles stay as they are"
            )));
        }
    }
    Ok(())
}
