//! Binary glTF 2.0.

use super::error::{MAX_TRIANGLES, ReadFault};
use super::strips::{fan, strip};
use crate::Mesh;
use glam::Mat4;

/// Refuses extensions that the reader does not support, by name and with the remedy.
fn check_extensions(bytes: &[u8]) -> Result<(), ReadFault> {
    let Ok(glb) = gltf::Glb::from_slice(bytes) else {
        // The reader reports the reason.
        return Ok(());
    };
    let Ok(root) = serde_json::from_slice::<serde_json::Value>(&glb.json) else {
        return Ok(());
    };
    let required = root["extensionsRequired"].as_array();
    let names = required
        .into_iter()
        .flatten()
        .filter_map(|name| name.as_str());
    for name in names {
        let (what, remedy) = match name {
            "KHR_draco_mesh_compression" => ("compressed with Draco", "cp"),
            "EXT_meshopt_compression" | "KHR_meshopt_compression" => {
                ("compressed with meshopt", "cp")
            }
            "KHR_mesh_quantization" => ("quantized", "dequantize"),
            _ => continue,
        };
        return Err(ReadFault::Unsupported(format!(
            "its meshes are {what} ({name}), which is not read: export it without, for example from Blender or by \
             `gltf-transform {remedy} in.glb out.glb`"
        )));
    }
    Ok(())
}

pub(super) fn read(bytes: &[u8]) -> Result<Mesh, ReadFault> {
    check_extensions(bytes)?;
    let gltf = gltf::Gltf::from_slice(bytes).map_err(|e| e.to_string())?;
    let blob = gltf.blob.as_deref();
    let mut mesh = Mesh::default();
    let scenes: Vec<_> = match gltf.default_scene() {
        Some(scene) => vec![scene],
        None => gltf.scenes().collect(),
    };
    let mut seen = vec![false; gltf.nodes().len()];
    let mut todo: Vec<(gltf::Node<'_>, Mat4)> = scenes
        .iter()
        .flat_map(|scene| scene.nodes())
        .map(|node| (node, Mat4::IDENTITY))
        .collect();
    while let Some((node, parent)) = todo.pop() {
        if std::mem::replace(&mut seen[node.index()], true) {
            return Err(format!("node {} has two parents", node.index()).into());
        }
        let map = parent * Mat4::from_cols_array_2d(&node.transform().matrix());
        todo.extend(node.children().map(|child| (child, map)));
        let Some(own) = node.mesh() else { continue };
        for primitive in own.primitives() {
            use gltf::mesh::Mode;
            let mode = primitive.mode();
            if !matches!(
                mode,
                Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan
            ) {
                continue;
            }
            if let Some(places) = primitive.get(&gltf::Semantic::Positions) {
                let (floats, vectors) = (
                    gltf::accessor::DataType::F32,
                    gltf::accessor::Dimensions::Vec3,
                );
                let is_right = places.data_type() == floats && places.dimensions() == vectors;
                check_accessor(&places, is_right, blob)?;
            }
            if let Some(indices) = primitive.indices() {
                use gltf::accessor::{DataType, Dimensions};
                let whole = [DataType::U8, DataType::U16, DataType::U32];
                let is_right = whole.contains(&indices.data_type())
                    && indices.dimensions() == Dimensions::Scalar;
                check_accessor(&indices, is_right, blob)?;
            }
            let reader = primitive.reader(|buffer| match buffer.source() {
                gltf::buffer::Source::Bin => blob,
                // Only data in the file itself is read.
                gltf::buffer::Source::Uri(_) => None,
            });
            let Some(places) = reader.read_positions() else {
                return Err("the corners of a part are not in the file itself".into());
            };
            let base = mesh.positions.len() as u32;
            mesh.positions
                .extend(places.map(|p| map.transform_point3(p.into())));
            let indices: Vec<u32> = match reader.read_indices() {
                Some(indices) => indices.into_u32().collect(),
                None => (0..mesh.positions.len() as u32 - base).collect(),
            };
            let triangles: Vec<[u32; 3]> = match mode {
                Mode::TriangleStrip => strip(&indices).collect(),
                Mode::TriangleFan => fan(&indices).collect(),
                _ => indices.as_chunks::<3>().0.to_vec(),
            };
            let is_mirrored = map.determinant() < 0.0;
            mesh.triangles.extend(triangles.iter().map(|&[a, b, c]| {
                let [b, c] = if is_mirrored { [c, b] } else { [b, c] };
                [a, b, c].map(|i| base.saturating_add(i))
            }));
            if mesh.triangles.len() > MAX_TRIANGLES {
                return Err(format!("more than {MAX_TRIANGLES} triangles").into());
            }
        }
    }
    Ok(mesh)
}

/// Refuses accessors of another type than required, or beyond the end of the file, because the reader trusts both.
fn check_accessor(
    accessor: &gltf::Accessor<'_>,
    is_right: bool,
    blob: Option<&[u8]>,
) -> Result<(), String> {
    let fault = |what: &str| Err(format!("accessor {}: {what}", accessor.index()));
    if !is_right {
        return fault("unsupported component type");
    }
    let Some(view) = accessor.view().filter(|_| accessor.sparse().is_none()) else {
        return fault("sparse accessors are not supported");
    };
    let stride = view.stride().unwrap_or(accessor.size());
    let last = accessor.count().saturating_sub(1);
    let own = last
        .checked_mul(stride)
        .and_then(|n| n.checked_add(accessor.offset()))
        .and_then(|n| n.checked_add(accessor.size()));
    let end = view.offset().checked_add(view.length());
    let is_held = own.is_some_and(|own| own <= view.length())
        && end.is_some_and(|end| blob.is_some_and(|blob| end <= blob.len()));
    if stride < accessor.size() || !is_held {
        return fault("its data lie outside the buffer");
    }
    Ok(())
}
