//! 3MF files: objects, units, colors and components.

use argil_abi::GpuMaterial;
use argil_mesh::{
    Mesh, MeshFormat, MeshReport, MeshWriteOptions, ThreeMfMetadata, from_bytes, write_3mf,
};
use glam::Vec3;
use std::io::{Cursor, Read, Write};
use std::path::Path;

fn tetrahedron() -> Mesh {
    Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z],
        triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
        ..Mesh::default()
    }
}

fn read(bytes: &[u8]) -> Result<Mesh, String> {
    let file = from_bytes(bytes, MeshFormat::ThreeMf, Path::new("a.3mf"));
    file.map(|file| file.mesh)
        .map_err(|error| error.to_string())
}

/// Returns a file with a model of this text.
fn file_of(text: &str) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let how = zip::write::SimpleFileOptions::default();
    archive.start_file("3D/3dmodel.model", how).expect("a file");
    archive.write_all(text.as_bytes()).expect("bytes");
    archive.finish().expect("an archive").into_inner()
}

fn model_of(bytes: &[u8]) -> String {
    let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).expect("an archive");
    let mut text = String::new();
    let mut file = archive.by_name("3D/3dmodel.model").expect("a model");
    file.read_to_string(&mut text).expect("text");
    text
}

#[test]
fn objects_have_names_colors_and_a_unit() {
    let mut colored = tetrahedron();
    let color = |r: f32| GpuMaterial {
        base_roughness: [r, 0.0, 0.0, 0.5],
        ..GpuMaterial::default()
    };
    colored.materials = vec![color(1.0), color(1.0), color(1.0), color(0.0)];
    let plain = tetrahedron();
    let options = MeshWriteOptions {
        scale: 1000.0,
        ..MeshWriteOptions::default()
    };
    let metadata = ThreeMfMetadata {
        title: Some("a < b & \"c\"".into()),
        ..ThreeMfMetadata::default()
    };
    let mut out = Cursor::new(Vec::new());
    let objects = [("left", &colored), ("right", &plain)];
    write_3mf(&objects, &options, &metadata, &mut out).expect("a file");
    let bytes = out.into_inner();
    let text = model_of(&bytes);
    for part in [
        "unit=\"millimeter\"",
        "name=\"left\"",
        "name=\"right\"",
        "a &lt; b &amp; &quot;c&quot;",
        "<m:color color=\"#FF0000\"/>",
        "<m:color color=\"#000000\"/>",
        "<item objectid=\"2\"/>",
        "<item objectid=\"4\"/>",
        // y up to z up, in millimeters.
        "<vertex x=\"0\" y=\"-1000\" z=\"0\"/>",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    // One color for a whole triangle, or one for each corner.
    assert_eq!(text.matches("p1=\"0\"/>").count(), 1, "{text}");
    assert_eq!(text.matches("p3=\"1\"/>").count(), 3, "{text}");
    // Both objects, in meters.
    let back = read(&bytes).expect("a mesh");
    let volume = MeshReport::of(&back).volume;
    assert!((volume - 2.0 / 6.0).abs() < 1e-6, "{volume}");
}

#[test]
fn components_are_placed() {
    let mesh = |unit: &str, item: &str| {
        let text = format!(
            r#"<model unit="{unit}"><resources>
            <object id="1"><mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/><vertex x="0" y="1" z="0"/><vertex x="0" y="0" z="1"/></vertices>
            <triangles><triangle v1="0" v2="2" v3="1"/><triangle v1="0" v2="1" v3="3"/><triangle v1="1" v2="2" v3="3"/><triangle v1="2" v2="0" v3="3"/></triangles></mesh></object>
            <object id="2"><components><component objectid="1" transform="2 0 0 0 2 0 0 0 2 10 0 0"/></components></object>
            </resources><build>{item}</build></model>"#
        );
        read(&file_of(&text))
    };
    let plain = mesh("meter", "<item objectid=\"2\"/>").expect("a mesh");
    let volume = MeshReport::of(&plain).volume;
    assert!((volume - 8.0 / 6.0).abs() < 1e-5, "{volume}");
    assert_eq!(plain.aabb().min.x, 10.0);
    // Mirrored: the volume stays positive.
    let mirrored = mesh(
        "inch",
        r#"<item objectid="1" transform="-1 0 0 0 1 0 0 0 1 0 0 0"/>"#,
    );
    let volume = MeshReport::of(&mirrored.expect("a mesh")).volume;
    assert!((volume - 0.0254f64.powi(3) / 6.0).abs() < 1e-9, "{volume}");
    for (unit, item, reason) in [
        ("furlong", "<item objectid=\"1\"/>", "furlong"),
        ("meter", "<item objectid=\"7\"/>", "object 7 is missing"),
        ("meter", "<item objectid=\"x\"/>", "not a number"),
        (
            "meter",
            "<item objectid=\"1\" transform=\"1 2 3\"/>",
            "12 numbers",
        ),
    ] {
        let error = mesh(unit, item).expect_err("refused");
        assert!(error.contains(reason), "{error}");
    }
}

/// Components that place a component ten times each, fourteen deep, would never end.
#[test]
fn bombs_of_components_are_refused() {
    let mut text =
        r#"<model><object id="0"><mesh><vertex x="0" y="0" z="0"/></mesh></object>"#.to_owned();
    for id in 1..15 {
        let part = format!("<component objectid=\"{}\"/>", id - 1).repeat(10);
        text += &format!("<object id=\"{id}\"><components>{part}</components></object>");
    }
    text += "<item objectid=\"14\"/></model>";
    assert!(
        read(&file_of(&text))
            .expect_err("refused")
            .contains("100000")
    );
    // Vertices of extensions are theirs.
    let text = r#"<model xmlns:s="s"><object id="1"><mesh><s:vertex x="0" y="0"/></mesh></object></model>"#;
    assert!(read(&file_of(text)).is_ok_and(|mesh| mesh.positions.is_empty()));
}

#[test]
fn senseless_models_are_refused_and_end() {
    let refused = |text: &str, reason: &str| {
        let error = read(&file_of(text)).expect_err("refused");
        assert!(error.contains(reason), "{reason}: {error}");
    };
    refused("<model><resources", "XML at byte");
    refused(
        r#"<model><object id="1"><components><component objectid="1"/></components></object><item objectid="1"/></model>"#,
        "nested",
    );
    refused(
        r#"<model><object id="1"><mesh><vertex x="0" y="0" z="0"/><triangle v1="0" v2="1" v3="2"/></mesh></object><item objectid="1"/></model>"#,
        "missing vertex",
    );
    refused(
        r#"<model><object id="1"><mesh><vertex x="0" y="zero" z="0"/></mesh></object></model>"#,
        "\"zero\"",
    );
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let how = zip::write::SimpleFileOptions::default();
    archive.start_file("readme.txt", how).expect("a file");
    let bytes = archive.finish().expect("an archive").into_inner();
    assert!(read(&bytes).expect_err("refused").contains("3dmodel.model"));
}
