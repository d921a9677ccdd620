//! Small mesh files that took minutes or gigabytes.

use argil_mesh::{MeshFile, MeshFormat, MeshReadError, from_bytes, repair};
use glam::Vec3;
use std::io::{Cursor, Write};
use std::path::Path;

fn read(bytes: &[u8], format: MeshFormat) -> Result<MeshFile, MeshReadError> {
    from_bytes(bytes, format, Path::new("a.mesh"))
}

#[test]
fn blanks_in_a_line_are_passed_once() {
    let blanks = " ".repeat(3_000_000);
    let refused = read(format!("solid{blanks}\n").as_bytes(), MeshFormat::Stl);
    assert!(refused.is_ok_and(|file| file.mesh.triangles.is_empty()));
    let count = 1_000_000;
    let corners = "0 ".repeat(count);
    let ply = format!(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
         element face 1\nproperty list uint int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n{count} {corners}{blanks}\n"
    );
    let refused = read(ply.as_bytes(), MeshFormat::Ply).unwrap_err();
    assert!(refused.to_string().contains("without faces"), "{refused}");
}

#[test]
fn a_mesh_of_many_nodes_is_read_once() {
    let many = |what: &str, count: usize| vec![what; count].join(",");
    let root = |primitive: &str, extras: usize, nodes: usize| {
        let data = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
        format!(
            r#"{{"asset": {{"version": "2.0"}}, "buffers": [{{"byteLength": 36, "uri": "data:;base64,{data}"}}],
            "bufferViews": [{{"buffer": 0, "byteLength": 36}}],
            "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}}],
            "meshes": [{{"primitives": [{}], "extras": "{}"}}], "nodes": [{}]}}"#,
            many(primitive, 20_000 / nodes.div_ceil(50_000)),
            " ".repeat(extras),
            many(r#"{"mesh": 0}"#, nodes)
        )
    };
    let points = root(r#"{"attributes": {"POSITION": 0}, "mode": 0}"#, 0, 50_000);
    let refused = read(points.as_bytes(), MeshFormat::Gltf).unwrap_err();
    assert!(
        refused
            .to_string()
            .contains("1000000000; they are left out"),
        "{refused}"
    );
    let named = r#"{"attributes": {"POSITION": 0}}"#;
    let one = root("", 4_000_000, 100_000).replacen("[]", &format!("[{named}]"), 1);
    let one = one.replacen(&many("", 10_000), named, 1);
    let file = read(one.as_bytes(), MeshFormat::Gltf).unwrap();
    assert_eq!(file.mesh.triangles.len(), 100_000);
}

fn three_mf(parts: &[&str]) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let how = zip::write::SimpleFileOptions::default();
    archive.start_file("3D/3dmodel.model", how).expect("a file");
    for part in parts {
        archive.write_all(part.as_bytes()).expect("bytes");
    }
    archive.finish().expect("an archive").into_inner()
}

#[test]
fn models_nest_no_deeper_than_they_should() {
    let reason = |parts: &[&str]| {
        let file = three_mf(parts);
        read(&file, MeshFormat::ThreeMf).unwrap_err().to_string()
    };
    let deep = reason(&["<model>", &"<a>".repeat(100)]);
    assert!(deep.contains("nested more than 32 deep"), "{deep}");
    let names: String = (0..100).map(|i| format!(" xmlns:a{i}=\"\"")).collect();
    let named = reason(&["<model", &names, "/>"]);
    assert!(named.contains("declares more than 32"), "{named}");
    let long = reason(&["<model unit=\"", &"a".repeat(17 << 20), "\"/>"]);
    assert!(
        long.contains("longer than 16777216 bytes") || long.contains("unpacks to more"),
        "{long}"
    );
    let required = three_mf(&[
        "<model requiredextensions=\"",
        &"a ".repeat(2_000_000),
        "\"",
        &" b=\"\"".repeat(1_000_000),
        " xmlns:a=\"/material/\"/>",
    ]);
    assert!(read(&required, MeshFormat::ThreeMf).is_ok());
}

/// Parts that touch, and parts that are inside out, take no time for each other.
#[test]
fn many_parts_are_repaired_soon() {
    let point = |i: u32| {
        let at = |n: u32| (i.wrapping_mul(n) >> 8) as f32 / (1 << 24) as f32;
        Vec3::new(at(2_654_435_761), at(2_246_822_519), at(3_266_489_917))
    };
    let mut fans = argil_mesh::Mesh {
        positions: vec![Vec3::ZERO],
        ..Default::default()
    };
    for i in 0..300_000 {
        fans.positions.extend([point(2 * i + 1), point(2 * i + 2)]);
        fans.triangles.push([0, 2 * i + 1, 2 * i + 2]);
    }
    repair(&fans);
    let mut balls = argil_mesh::Mesh::default();
    for i in 0..8000u32 {
        let corner = 100.0 * point(i + 1);
        balls.positions.push(corner);
        balls
            .positions
            .extend(Vec3::AXES.map(|axis| corner + 0.01 * axis));
        let turned = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [0, 2, 3]];
        balls.triangles.extend(turned.map(|t| t.map(|k| 4 * i + k)));
    }
    let (_, report) = repair(&balls);
    assert_eq!(report.parts_flipped, 8000);
}
