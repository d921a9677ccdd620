//! glTF files as other programs write them.

use argil_mesh::{Mesh, MeshFile, MeshFormat, MeshReadError, MeshReport, MeshSource, from_bytes};
use base64::Engine;
use glam::Vec3;
use serde_json::{Value, json};
use std::path::Path;

const CORNERS: [[f32; 3]; 4] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
];
const INDICES: [u16; 12] = [0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3];

fn floats(all: &[[f32; 3]]) -> Vec<u8> {
    all.as_flattened()
        .iter()
        .flat_map(|n| n.to_le_bytes())
        .collect()
}

fn shorts(all: &[u16]) -> Vec<u8> {
    all.iter().flat_map(|n| n.to_le_bytes()).collect()
}

/// A file of one tetrahedron, to which tests add views.
#[derive(Clone)]
struct Parts {
    root: Value,
    bytes: Vec<u8>,
}

impl Parts {
    fn new() -> Self {
        let mut parts = Self {
            root: json!({
                "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
                "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
                "accessors": [], "bufferViews": [], "buffers": [{}],
            }),
            bytes: Vec::new(),
        };
        parts.accessor(&floats(&CORNERS), 5126, "VEC3", 4);
        parts.accessor(&shorts(&INDICES), 5123, "SCALAR", 12);
        parts
    }

    fn view(&mut self, bytes: &[u8]) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let view = json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()});
        self.bytes.extend_from_slice(bytes);
        self.push("bufferViews", view)
    }

    fn push(&mut self, list: &str, value: Value) -> usize {
        let list = self.root[list].as_array_mut().expect("a list");
        list.push(value);
        list.len() - 1
    }

    fn accessor(&mut self, bytes: &[u8], kind: u32, shape: &str, count: usize) -> usize {
        let view = self.view(bytes);
        let row = json!({"bufferView": view, "componentType": kind, "type": shape, "count": count});
        self.push("accessors", row)
    }

    fn glb(&self) -> Vec<u8> {
        let mut root = self.root.clone();
        root["buffers"][0]["byteLength"] = json!(self.bytes.len());
        let glb = gltf::binary::Glb {
            header: gltf::binary::Header {
                magic: *b"glTF",
                version: 2,
                length: 0,
            },
            json: serde_json::to_vec(&root).expect("JSON").into(),
            bin: Some((&self.bytes[..]).into()),
        };
        glb.to_vec().expect("a GLB")
    }

    fn read(&self) -> Result<MeshFile, String> {
        read(&self.glb())
    }
}

fn read(bytes: &[u8]) -> Result<MeshFile, String> {
    from_bytes(bytes, MeshFormat::Glb, Path::new("a.glb")).map_err(|error| error.to_string())
}

fn plain(parts: &Parts) -> Mesh {
    let file = parts.read().unwrap_or_else(|error| panic!("{error}"));
    assert!(file.warnings.is_empty(), "{:?}", file.warnings);
    file.mesh
}

fn volume(mesh: &Mesh) -> f64 {
    6.0 * MeshReport::of(&mesh.welded()).volume
}

#[test]
fn extensions_that_touch_no_triangle_are_accepted() {
    for name in [
        "KHR_texture_transform",
        "KHR_texture_basisu",
        "EXT_texture_webp",
        "KHR_materials_variants",
        "KHR_materials_unlit",
        "KHR_lights_punctual",
        "KHR_xmp_json_ld",
        "KHR_mesh_quantization",
    ] {
        let mut parts = Parts::new();
        parts.root["extensionsRequired"] = json!([name]);
        assert_eq!(volume(&plain(&parts)).round(), 1.0, "{name}");
    }
    for name in ["KHR_draco_mesh_compression", "CESIUM_RTC", "NEW_geometry"] {
        let mut parts = Parts::new();
        parts.root["extensionsRequired"] = json!(["KHR_materials_unlit", name]);
        let error = parts.read().expect_err("a fault");
        assert!(
            error.contains(name) && error.contains("export it without"),
            "{error}"
        );
    }
}

/// Compressed parts need not be required: what is missing then is named.
#[test]
fn draco_without_a_fallback_is_named() {
    let mut parts = Parts::new();
    parts.root["meshes"][0]["primitives"][0]["extensions"] =
        json!({"KHR_draco_mesh_compression": {"bufferView": 0}});
    assert_eq!(plain(&parts).triangles.len(), 4);
    parts.root["accessors"][0] = json!({"componentType": 5126, "type": "VEC3", "count": 4});
    assert!(parts.read().expect_err("a fault").contains("Draco"));
}

#[test]
fn all_instances_arrive() {
    let mut parts = Parts::new();
    let places = parts.accessor(
        &floats(&[[0.0; 3], [10.0, 0.0, 0.0], [20.0, 0.0, 0.0]]),
        5126,
        "VEC3",
        3,
    );
    let scales = parts.accessor(
        &floats(&[[1.0; 3], [-1.0, 1.0, 1.0], [2.0; 3]]),
        5126,
        "VEC3",
        3,
    );
    // Quarter turns around z, as normalized bytes: half an angle of 45 degrees.
    let turns: Vec<u8> = [0, 0, 0, 127, 0, 0, 90, 90, 0, 0, 0, 0].to_vec();
    let turns = parts.accessor(&turns, 5120, "VEC4", 3);
    parts.root["accessors"][turns]["normalized"] = json!(true);
    let attributes = json!({"TRANSLATION": places, "SCALE": scales, "ROTATION": turns});
    parts.root["nodes"][0]["extensions"] =
        json!({"EXT_mesh_gpu_instancing": {"attributes": attributes}});
    parts.root["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    let mesh = plain(&parts);
    assert_eq!((mesh.triangles.len(), mesh.positions.len()), (12, 12));
    // The mirrored one is not inside out.
    assert!((volume(&mesh) - 10.0).abs() < 1e-4, "{}", volume(&mesh));
    assert_eq!(mesh.aabb().max.x, 22.0);
}

#[test]
fn sparse_and_quantized_numbers_are_read() {
    let mut parts = Parts::new();
    let (at, to) = (parts.view(&[3]), parts.view(&floats(&[[0.0, 0.0, 5.0]])));
    parts.root["accessors"][0]["sparse"] = json!({"count": 1, "indices": {"bufferView": at, "componentType": 5121}, "values": {"bufferView": to}});
    assert!((volume(&plain(&parts)) - 5.0).abs() < 1e-6);
    // All others are zero.
    let at = parts.view(&shorts(&[1, 2, 3]));
    let to = parts.view(&floats(&CORNERS[1..]));
    parts.root["accessors"][0] = json!({
        "componentType": 5126, "type": "VEC3", "count": 4,
        "sparse": {"count": 3, "indices": {"bufferView": at, "componentType": 5123}, "values": {"bufferView": to}},
    });
    assert!((volume(&plain(&parts)) - 1.0).abs() < 1e-6);
    // Zeros that no file stores take memory too, as positions and as indices.
    let mut zeros = parts.clone();
    zeros.root["accessors"][0]["count"] = json!(99_999_999);
    let positions = json!({"attributes": {"POSITION": 0}});
    zeros.root["meshes"][0]["primitives"] = json!([positions]);
    assert!(zeros.read().expect_err("a fault").contains("may take"));
    zeros.root["accessors"][1] = zeros.root["accessors"][0].clone();
    zeros.root["accessors"][1]["type"] = json!("SCALAR");
    zeros.root["accessors"][1]["componentType"] = json!(5125);
    zeros.root["accessors"][0]["count"] = json!(4);
    zeros.root["meshes"][0]["primitives"][0]["indices"] = json!(1);
    assert!(zeros.read().expect_err("a fault").contains("may take"));
    let mut unsorted = parts;
    let at = unsorted.view(&shorts(&[1, 3, 2]));
    unsorted.root["accessors"][0]["sparse"]["indices"]["bufferView"] = json!(at);
    assert!(unsorted.read().expect_err("a fault").contains("sparse"));

    for (kind, scale, is_normalized) in [
        (5122, 1.0, false),
        (5122, 1.0 / 32767.0, true),
        (5123, 1.0, false),
    ] {
        let mut parts = Parts::new();
        let steps =
            CORNERS.map(|p| p.map(|c| if is_normalized { 32767.0 * c } else { 7.0 * c } as u16));
        let bytes: Vec<u8> = steps
            .iter()
            .flat_map(|p| shorts(&[p[0], p[1], p[2], 9]))
            .collect();
        let view = parts.view(&bytes);
        parts.root["bufferViews"][view]["byteStride"] = json!(8);
        parts.root["accessors"][0] = json!({"bufferView": view, "componentType": kind, "normalized": is_normalized, "type": "VEC3", "count": 4});
        let side: f64 = if is_normalized { 1.0 } else { 7.0 };
        assert!(
            (volume(&plain(&parts)) - side.powi(3)).abs() < 1e-3,
            "{kind} {scale}"
        );
    }
}

/// What `gltfpack -c` writes.
#[test]
fn views_that_meshopt_compressed_are_read() {
    let mut parts = Parts::new();
    let vertices: Vec<[u16; 4]> = CORNERS
        .map(|p| [p[0] as u16, p[1] as u16, p[2] as u16, 0])
        .to_vec();
    let indices: Vec<u32> = INDICES.map(u32::from).to_vec();
    let packed = [
        (
            meshopt::encode_vertex_buffer(&vertices).expect("bytes"),
            "ATTRIBUTES",
            8,
            4,
        ),
        (
            meshopt::encode_index_buffer(&indices, 4).expect("bytes"),
            "TRIANGLES",
            4,
            12,
        ),
    ];
    for (index, (bytes, mode, stride, count)) in packed.iter().enumerate() {
        let view = parts.view(bytes);
        let extension = json!({
            "buffer": 0, "byteOffset": parts.root["bufferViews"][view]["byteOffset"], "byteLength": bytes.len(),
            "byteStride": stride, "count": count, "mode": mode,
        });
        parts.root["bufferViews"][index] = json!({
            "buffer": 1, "byteLength": stride * count, "byteStride": stride, "extensions": {"EXT_meshopt_compression": extension},
        });
    }
    parts.root["accessors"][0]["componentType"] = json!(5123);
    parts.root["accessors"][1]["componentType"] = json!(5125);
    parts.root["extensionsRequired"] = json!(["KHR_mesh_quantization", "EXT_meshopt_compression"]);
    assert!((volume(&plain(&parts)) - 1.0).abs() < 1e-6);
    let extension = &mut parts.root["bufferViews"][0]["extensions"]["EXT_meshopt_compression"];
    extension["count"] = json!(4_000_000_000_u64);
    assert!(parts.read().expect_err("a fault").contains("may take"));
    let extension = &mut parts.root["bufferViews"][0]["extensions"]["EXT_meshopt_compression"];
    extension["count"] = json!(400);
    assert!(parts.read().expect_err("a fault").contains("damaged"));
}

#[test]
fn buffers_may_be_text_or_other_files() {
    let mut parts = Parts::new();
    let expected = plain(&parts);
    let bytes = std::mem::take(&mut parts.bytes);
    let data = base64::engine::general_purpose::STANDARD_NO_PAD.encode(&bytes);
    parts.root["buffers"][0] =
        json!({"uri": format!("data:application/octet-stream;base64,{data}")});
    let text = serde_json::to_vec_pretty(&parts.root).expect("JSON");
    let found = from_bytes(&text, MeshFormat::Gltf, Path::new("a.gltf")).expect("a mesh");
    assert_eq!(found.mesh, expected);
    assert_eq!(plain(&parts), expected);

    let here = tempfile::tempdir().expect("a folder");
    let inner = here.path().join("scene");
    std::fs::create_dir_all(inner.join("sub")).expect("folders");
    std::fs::write(inner.join("sub/a b.bin"), &bytes).expect("a file");
    std::fs::write(here.path().join("secret.bin"), &bytes).expect("a file");
    let path = inner.join("a.gltf");
    let mut open = |uri: &str| {
        parts.root["buffers"][0] = json!({"uri": uri});
        std::fs::write(&path, serde_json::to_vec(&parts.root).expect("JSON")).expect("a file");
        argil_mesh::read(&path)
    };
    assert_eq!(open("sub/a%20b.bin").expect("a mesh").mesh, expected);
    for outside in [
        "../secret.bin",
        "sub/../../secret.bin",
        "/etc/passwd",
        "%2e%2e/secret.bin",
    ] {
        let error = open(outside).expect_err("outside").to_string();
        assert!(error.contains("outside its folder"), "{error}");
    }
    let missing = open("sub/b.bin").expect_err("missing");
    assert!(
        matches!(&missing, MeshReadError::Io { path, .. } if path.ends_with("sub/b.bin")),
        "{missing}"
    );
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(here.path().join("secret.bin"), inner.join("link.bin"))
            .expect("a link");
        assert!(open("link.bin").is_err());
    }
    let given = serde_json::to_vec(&parts.root).expect("JSON");
    let source = MeshSource::new(&given[..], MeshFormat::Gltf, Path::new("a.gltf"));
    let source = source.with_files(|_| Ok(bytes.clone())).expect("files");
    assert_eq!(source.read().expect("a mesh").mesh, expected);
    assert_eq!(source.parts().count(), 2);
}

#[test]
fn what_a_scene_leaves_out_is_named() {
    let mut parts = Parts::new();
    for mode in [0, 1, 2, 3] {
        let line = json!({"attributes": {"POSITION": 0}, "mode": mode});
        parts.root["meshes"][0]["primitives"]
            .as_array_mut()
            .expect("a list")
            .push(line);
    }
    parts.root["nodes"] = json!([
        {"mesh": 0, "skin": 0, "weights": [0.0, 0.5], "children": [1]},
        {"extensions": {"KHR_node_visibility": {"visible": false}}, "children": [2]},
        {"mesh": 0}, {"mesh": 0}, {"camera": 0},
    ]);
    parts.root["scenes"] = json!([{"nodes": [0]}, {"nodes": [3, 4]}]);
    let file = parts.read().expect("a mesh");
    assert_eq!(file.mesh.triangles.len(), 4);
    let said = file.warnings.join("\n");
    for part in [
        "points or lines: 4;",
        "with a skeleton: 1;",
        "morph targets: 1;",
        "hidden: 1;",
        "outside the default scene: 1;",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    // Without a default scene, all are read, and without any scene all nodes.
    parts.root["nodes"] =
        json!([{"mesh": 0, "children": [1]}, {"mesh": 0, "translation": [5, 0, 0]}, {"mesh": 0}]);
    let root = parts.root.as_object_mut().expect("an object");
    root.remove("scene");
    root.insert("scenes".into(), json!([{"nodes": [0]}, {"nodes": [2, 0]}]));
    assert_eq!(parts.read().expect("a mesh").mesh.triangles.len(), 12);
    parts
        .root
        .as_object_mut()
        .expect("an object")
        .remove("scenes");
    assert_eq!(parts.read().expect("a mesh").mesh.triangles.len(), 12);
    parts.root["meshes"][0]["primitives"] = json!([{"attributes": {"POSITION": 0}, "mode": 1}]);
    assert!(
        parts
            .read()
            .expect_err("nothing")
            .contains("points or lines")
    );
}

#[test]
fn strips_fans_and_vertices_without_indices() {
    let mut parts = Parts::new();
    let indices = parts.accessor(&[0, 2, 1, 3], 5121, "SCALAR", 4);
    let primitives = json!([
        {"attributes": {"POSITION": 0}, "indices": indices, "mode": 5},
        {"attributes": {"POSITION": 0}, "indices": indices, "mode": 6},
        {"attributes": {"POSITION": 0}},
    ]);
    parts.root["meshes"][0]["primitives"] = primitives;
    let mesh = plain(&parts);
    let named = mesh
        .triangles
        .iter()
        .map(|t| t.map(|i| mesh.positions[i as usize]));
    let [a, b, c, d] = CORNERS.map(Vec3::from);
    assert_eq!(
        named.collect::<Vec<_>>(),
        [[a, c, b], [b, c, d], [a, c, b], [a, b, d], [a, b, c]]
    );
}

/// Copies of large meshes would fill the memory: the file is refused with both numbers, before they are made.
#[test]
fn copies_are_limited() {
    let mut parts = Parts::new();
    let count = 300_000;
    let places = parts.accessor(&vec![0; 12 * count], 5126, "VEC3", count);
    parts.root["nodes"][0]["extensions"] =
        json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": places}}});
    assert_eq!(plain(&parts).triangles.len(), 4 * count);
    let many: Vec<u16> = INDICES.repeat(5_000);
    let indices = parts.accessor(&shorts(&many), 5123, "SCALAR", many.len());
    parts.root["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    let error = parts.read().expect_err("too large");
    assert!(
        error.contains("6000000000 triangles in 300000 copies"),
        "{error}"
    );
    // A thousand nodes whose triangles use a few of many vertices.
    let mut parts = Parts::new();
    let wide = parts.accessor(&vec![0; 12_000_000], 5126, "VEC3", 1_000_000);
    parts.root["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(wide);
    parts.root["nodes"] = (0..1000).map(|_| json!({"mesh": 0})).collect();
    parts.root["scenes"][0]["nodes"] = (0..1000).collect();
    assert_eq!(plain(&parts).positions.len(), 4000);
    // All of them, a thousand times.
    parts.root["meshes"][0]["primitives"] = json!([{"attributes": {"POSITION": wide}}]);
    let error = parts.read().expect_err("too large");
    assert!(
        error.contains("333333000 triangles in 1000 copies"),
        "{error}"
    );
}

#[test]
fn files_that_are_not_gltf_2_are_named() {
    let mut old = b"glTF\x01\0\0\0".to_vec();
    old.extend([0; 12]);
    assert!(read(&old).expect_err("old").contains("glTF 1"));
    assert!(
        read(b"{\"asset\": {\"version\": \"1.0\"}}")
            .expect_err("old")
            .contains("glTF 1.0")
    );
    assert!(read(b"nonsense").expect_err("a fault").contains("neither"));
    assert!(
        read(b"{\"nodes\": {}, \"asset\": {\"version\": 1.0}}")
            .expect_err("old")
            .contains("glTF 1.0")
    );
    // The next chunk follows at once, without fill.
    let mut whole = Parts::new().glb();
    let length = u32::from_le_bytes(whole[12..16].try_into().expect("a word")) as usize;
    whole.insert(20 + length, b' ');
    whole[12..16].copy_from_slice(&(length as u32 + 1).to_le_bytes());
    assert!(read(&whole).is_ok());
    let cut = &Parts::new().glb()[..200];
    assert!(read(cut).expect_err("a fault").contains("truncated"));
}
