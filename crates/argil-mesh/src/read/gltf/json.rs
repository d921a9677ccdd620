//! The parts of glTF's JSON that describe triangles. Elements are parsed when they are used.

use super::super::error::ReadFault;
use glam::{Mat4, Quat, Vec3};
use serde::Deserialize;
use serde_json::value::RawValue;

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct Root<'a> {
    pub(super) scene: Option<usize>,
    #[serde(borrow)]
    pub(super) scenes: Vec<&'a RawValue>,
    #[serde(borrow)]
    pub(super) nodes: Vec<&'a RawValue>,
    #[serde(borrow)]
    pub(super) meshes: Vec<&'a RawValue>,
    #[serde(borrow)]
    pub(super) accessors: Vec<&'a RawValue>,
    #[serde(borrow)]
    pub(super) buffer_views: Vec<&'a RawValue>,
    #[serde(borrow)]
    pub(super) buffers: Vec<&'a RawValue>,
    pub(super) extensions_required: Vec<String>,
}

/// What all versions have.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Head<'a> {
    #[serde(borrow)]
    pub(super) asset: Asset<'a>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Asset<'a> {
    #[serde(borrow)]
    pub(super) version: Option<&'a RawValue>,
}

/// Parses an element of a list.
///
/// # Errors
/// If it is missing, or not what it should be. `what` names it.
pub(super) fn element<'a, T: Deserialize<'a>>(
    list: &[&'a RawValue],
    index: usize,
    what: &str,
) -> Result<T, ReadFault> {
    let text = list
        .get(index)
        .ok_or_else(|| format!("{what} {index} is missing"))?;
    let parsed = serde_json::from_str(text.get());
    parsed.map_err(|error| format!("{what} {index}: {error}").into())
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Scene {
    pub(super) nodes: Vec<usize>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Node {
    pub(super) mesh: Option<usize>,
    pub(super) skin: Option<usize>,
    pub(super) children: Vec<usize>,
    matrix: Option<[f32; 16]>,
    translation: Option<[f32; 3]>,
    rotation: Option<[f32; 4]>,
    scale: Option<[f32; 3]>,
    weights: Vec<f32>,
    pub(super) extensions: NodeExtensions,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct NodeExtensions {
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    pub(super) instancing: Option<Instancing>,
    #[serde(rename = "KHR_node_visibility")]
    visibility: Option<Visibility>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Instancing {
    pub(super) attributes: InstanceAttributes,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "UPPERCASE", default)]
pub(super) struct InstanceAttributes {
    pub(super) translation: Option<usize>,
    pub(super) rotation: Option<usize>,
    pub(super) scale: Option<usize>,
}

#[derive(Debug, Deserialize)]
struct Visibility {
    #[serde(default = "yes")]
    visible: bool,
}

fn yes() -> bool {
    true
}

impl Node {
    /// Returns the transform to the parent's space.
    pub(super) fn parent_from_node(&self) -> Mat4 {
        if let Some(matrix) = &self.matrix {
            return Mat4::from_cols_array(matrix);
        }
        let scale = self.scale.map_or(Vec3::ONE, Vec3::from);
        let rotation = self.rotation.map_or(Quat::IDENTITY, Quat::from_array);
        let translation = self.translation.map_or(Vec3::ZERO, Vec3::from);
        Mat4::from_scale_rotation_translation(scale, rotation.normalize(), translation)
    }

    pub(super) fn is_visible(&self) -> bool {
        let extension = self.extensions.visibility.as_ref();
        extension.is_none_or(|visibility| visibility.visible)
    }

    pub(super) fn is_morphed(&self) -> bool {
        self.weights.iter().any(|&weight| weight != 0.0)
    }
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct MeshJson<'a> {
    #[serde(borrow)]
    pub(super) primitives: Vec<&'a RawValue>,
    weights: Vec<f32>,
}

impl MeshJson<'_> {
    pub(super) fn is_morphed(&self) -> bool {
        self.weights.iter().any(|&weight| weight != 0.0)
    }
}

#[derive(Debug, Deserialize)]
pub(super) struct Primitive<'a> {
    #[serde(default)]
    pub(super) attributes: Attributes,
    pub(super) indices: Option<usize>,
    mode: Option<u32>,
    #[serde(borrow, default)]
    pub(super) extensions: PrimitiveExtensions<'a>,
}

#[derive(Debug, Default, Deserialize)]
pub(super) struct Attributes {
    #[serde(rename = "POSITION")]
    pub(super) position: Option<usize>,
}

#[derive(Debug, Default, Deserialize)]
pub(super) struct PrimitiveExtensions<'a> {
    #[serde(rename = "KHR_draco_mesh_compression", borrow)]
    pub(super) draco: Option<&'a RawValue>,
}

impl Primitive<'_> {
    /// Returns the topology: 4 for triangles, 5 for a strip, 6 for a fan, less for points and lines.
    pub(super) fn mode(&self) -> u32 {
        self.mode.unwrap_or(4)
    }
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct AccessorJson {
    pub(super) buffer_view: Option<usize>,
    #[serde(default)]
    pub(super) byte_offset: usize,
    pub(super) component_type: u32,
    #[serde(default)]
    pub(super) normalized: bool,
    pub(super) count: usize,
    #[serde(rename = "type")]
    pub(super) shape: String,
    pub(super) sparse: Option<SparseJson>,
}

#[derive(Debug, Deserialize)]
pub(super) struct SparseJson {
    pub(super) count: usize,
    pub(super) indices: SparsePart,
    pub(super) values: SparsePart,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparsePart {
    pub(super) buffer_view: usize,
    #[serde(default)]
    pub(super) byte_offset: usize,
    pub(super) component_type: Option<u32>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct ViewJson {
    pub(super) buffer: usize,
    #[serde(default)]
    pub(super) byte_offset: usize,
    pub(super) byte_length: usize,
    pub(super) byte_stride: Option<usize>,
    #[serde(default)]
    pub(super) extensions: ViewExtensions,
}

#[derive(Debug, Default, Deserialize)]
pub(super) struct ViewExtensions {
    #[serde(rename = "EXT_meshopt_compression", alias = "KHR_meshopt_compression")]
    pub(super) meshopt: Option<Compressed>,
}

/// A view that meshopt has compressed.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
#[cfg_attr(
    any(target_arch = "wasm32", not(feature = "simplify")),
    expect(
        dead_code,
        reason = "without a decoder, nothing reads the mode and the filter"
    )
)]
pub(super) struct Compressed {
    pub(super) buffer: usize,
    #[serde(default)]
    pub(super) byte_offset: usize,
    pub(super) byte_length: usize,
    pub(super) byte_stride: usize,
    pub(super) count: usize,
    pub(super) mode: String,
    pub(super) filter: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct BufferJson {
    pub(super) uri: Option<String>,
}
