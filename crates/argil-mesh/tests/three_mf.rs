//! 3MF files: objects, units, colors and components.

use argil_abi::GpuMaterial;
use argil_mesh::{
    Mesh, MeshFile, MeshFormat, MeshReport, MeshWriteOptions, ThreeMfMetadata, from_bytes,
    write_3mf,
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
    read_all(bytes).map(|file| file.mesh)
}

fn read_all(bytes: &[u8]) -> Result<MeshFile, String> {
    let file = from_bytes(bytes, MeshFormat::ThreeMf, Path::new("a.3mf"));
    file.map_err(|error| error.to_string())
}

/// Returns an archive of these parts.
fn archive_of(parts: &[(&str, &str)]) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let how = zip::write::SimpleFileOptions::default();
    for (name, text) in parts {
        archive.start_file(*name, how).expect("a file");
        archive.write_all(text.as_bytes()).expect("bytes");
    }
    archive.finish().expect("an archive").into_inner()
}

/// Returns a file with a model of this text.
fn file_of(text: &str) -> Vec<u8> {
    archive_of(&[("3D/3dmodel.model", text)])
}

const RELATIONS: &str = r#"<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
    <Relationship Target="/3D/thumb.png" Id="a" Type="http://schemas.openxmlformats.org/package/2006/relationships/metadata/thumbnail"/>
    <Relationship Target="/3D/the_main.model" Id="b" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>"#;

const NAMESPACES: &str = r#"xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
    xmlns:p="http://schemas.microsoft.com/3dmanufacturing/production/2015/06"
    xmlns:b="http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02"
    xmlns:s="http://schemas.microsoft.com/3dmanufacturing/slice/2015/07""#;

/// Returns the element of a tetrahedron, of a volume of a sixth.
fn mesh_at(x: f32) -> String {
    mesh_of(&[x])
}

/// Returns the element of tetrahedra.
fn mesh_of(places: &[f32]) -> String {
    let (mut vertices, mut triangles) = (String::new(), String::new());
    for (first, x) in (0..).step_by(4).zip(places) {
        for p in tetrahedron().positions {
            vertices += &format!("<vertex x=\"{}\" y=\"{}\" z=\"{}\"/>", x + p.x, p.y, p.z);
        }
        for t in tetrahedron().triangles {
            let [a, b, c] = t.map(|i| first + i);
            triangles += &format!("<triangle v1=\"{a}\" v2=\"{b}\" v3=\"{c}\"/>");
        }
    }
    format!("<mesh><vertices>{vertices}</vertices><triangles>{triangles}</triangles></mesh>")
}

fn object(id: u32, content: &str) -> String {
    format!("<object id=\"{id}\" type=\"model\">{content}</object>")
}

fn model(attributes: &str, objects: &str, items: &str) -> String {
    format!(
        "<?xml version=\"1.0\"?><model unit=\"meter\" {NAMESPACES} {attributes}><resources>{objects}</resources><build>{items}</build></model>"
    )
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
    refused("<model><resources", "3D/3dmodel.model, byte");
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

/// Returns six times the volume: the number of tetrahedra of side 1.
fn sixths(mesh: &Mesh) -> f64 {
    6.0 * MeshReport::of(mesh).volume
}

#[test]
fn relations_name_the_model() {
    let main = model("", &object(1, &mesh_at(0.0)), "<item objectid=\"1\"/>");
    let other = model("", &object(1, &mesh_at(50.0)), "<item objectid=\"1\"/>");
    for [first, second] in [
        ["3D/a.model", "3D/the_main.model"],
        ["a.model", "3D/THE_main.model"],
        ["3D/a.model", "3D\\the%5Fmain.model"],
    ] {
        let parts = [
            ("_rels/.rels", RELATIONS),
            (first, &other[..]),
            (second, &main[..]),
            ("Metadata/x.model", "not XML"),
        ];
        let mesh = read(&archive_of(&parts)).expect("a mesh");
        assert_eq!(mesh.aabb().max.x, 1.0);
        let mesh = read(&archive_of(&[parts[1], ("3D/3dmodel.model", &main)])).expect("a mesh");
        assert_eq!(mesh.aabb().max.x, 1.0);
        let error = read(&archive_of(&parts[1..3])).expect_err("unclear");
        assert!(error.contains("several models"), "{error}");
        let error = read(&archive_of(&parts[..2])).expect_err("missing");
        assert!(error.contains("no part \"/3D/the_main.model\""), "{error}");
    }
}

/// The production extension: slicers keep each object in a part of its own.
#[test]
fn objects_of_other_parts_are_placed() {
    let part = model(
        "",
        &(object(1, &mesh_at(50.0)) + &object(2, &mesh_at(0.0))),
        "",
    );
    let inches = part.replace("\"meter\"", "\"inch\"");
    let item = r#"<item objectid="1" p:path="/3D/Objects/part.model" transform="1 0 0 0 1 0 0 0 1 100 0 0"/>"#;
    let components = r#"<components><component objectid="2" p:path="/3D/objects/Part.model"/><component objectid="1" transform="-1 0 0 0 1 0 0 0 1 0 0 0"/></components>"#;
    let objects = object(1, &mesh_at(0.0)) + &object(7, components);
    let main = model(
        "requiredextensions=\"p\"",
        &objects,
        &format!("{item}<item objectid=\"7\"/>"),
    );
    let file = archive_of(&[
        ("3D/3dmodel.model", &main),
        ("3D/Objects/part.model", &part),
    ]);
    let all = read_all(&file).expect("a mesh");
    assert!(all.warnings.is_empty(), "{:?}", all.warnings);
    assert!(
        (sixths(&all.mesh) - 3.0).abs() < 1e-4,
        "{}",
        sixths(&all.mesh)
    );
    let aabb = all.mesh.aabb();
    assert_eq!((aabb.min.x, aabb.max.x), (-1.0, 151.0));
    let file = archive_of(&[
        ("3D/3dmodel.model", &main),
        ("3D/Objects/part.model", &inches),
    ]);
    let volume = sixths(&read(&file).expect("a mesh"));
    assert!(
        (volume - 1.0 - 2.0 * 0.0254f64.powi(3)).abs() < 1e-4,
        "{volume}"
    );
    let error = read(&file_of(&main)).expect_err("missing");
    assert!(error.contains("part.model"), "{error}");
}

#[test]
fn what_is_left_out_is_named() {
    let lattice = r#"<mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/></vertices><triangles/>
        <b:beamlattice radius="1"><b:beams><b:beam v1="0" v2="1"/></b:beams></b:beamlattice></mesh>"#;
    let objects = object(1, &mesh_at(0.0))
        + &object(2, lattice)
        + &object(3, &mesh_at(5.0))
        + &object(4, &mesh_at(9.0)).replace("\"model\"", "\"support\"")
        + &object(5, &mesh_at(11.0)).replace(
            "type=",
            "s:slicestackid=\"9\" s:meshresolution=\"lowres\" type=",
        );
    let items = r#"<item objectid="1"/><item objectid="2"/><item objectid="1" printable="0"/><item objectid="4"/><item objectid="5"/>"#;
    let file = read_all(&file_of(&model(
        "requiredextensions=\"b s\"",
        &objects,
        items,
    )))
    .expect("a mesh");
    assert_eq!(file.mesh.triangles.len(), 8);
    let said = file.warnings.join("\n");
    for part in [
        "1 × beam lattice",
        "1 × item that is not printed",
        "1 × support",
        "1 × finer version",
        "1 × object that its build does not place",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    let alone = model(
        "requiredextensions=\"b\"",
        &object(2, lattice),
        "<item objectid=\"2\"/>",
    );
    let error = read(&file_of(&alone)).expect_err("nothing");
    assert!(
        error.contains("beam lattice") && error.contains("no triangle is left"),
        "{error}"
    );
    // A build without items.
    let file = read_all(&file_of(&model("", &object(1, &mesh_at(0.0)), ""))).expect("a mesh");
    assert!(file.mesh.triangles.len() == 4 && file.warnings[0].contains("places nothing"));
}

/// Slicers write what cuts an object, or changes how it is printed, beside its solid, and say so elsewhere.
#[test]
fn modifiers_of_slicers_are_left_out() {
    let prusa = r#"<config><object id="1" instances_count="1"><metadata type="object" key="name" value="x"/>
        <volume firstid="0" lastid="3"><metadata type="volume" key="volume_type" value="ModelPart"/></volume>
        <volume firstid="4" lastid="7"><metadata type="volume" key="volume_type" value="NegativeVolume"/></volume>
        <volume firstid="8" lastid="11"><metadata type="volume" key="modifier" value="1"/>
        <metadata type="volume" key="volume_type" value="ParameterModifier"/></volume></object></config>"#;
    let main = model(
        "",
        &object(1, &mesh_of(&[0.0, 3.0, 6.0])),
        "<item objectid=\"1\"/>",
    );
    let file = read_all(&archive_of(&[
        ("3D/3dmodel.model", &main),
        ("Metadata/Slic3r_PE_model.config", prusa),
    ]));
    let file = file.expect("a mesh");
    assert!(
        (sixths(&file.mesh) - 1.0).abs() < 1e-5,
        "{:?}",
        file.warnings
    );
    let said = file.warnings.join("\n");
    assert!(
        said.contains("1 × negative volume") && said.contains("1 × modifier"),
        "{said}"
    );

    let bambu = r#"<config><object id="3"><metadata key="name" value="x"/>
        <part id="1" subtype="normal_part"/><part id="2" subtype="negative_part"/></object></config>"#;
    let parts = "<components><component objectid=\"1\"/><component objectid=\"2\"/></components>";
    let objects = object(1, &mesh_at(0.0)) + &object(2, &mesh_at(5.0)) + &object(3, parts);
    let main = model("", &objects, "<item objectid=\"3\"/>");
    let file = read_all(&archive_of(&[
        ("3D/3dmodel.model", &main),
        ("Metadata/model_settings.config", bambu),
    ]));
    let file = file.expect("a mesh");
    assert_eq!(file.mesh.triangles.len(), 4);
    assert!(
        file.warnings[0].contains("1 × negative volume"),
        "{:?}",
        file.warnings
    );
}

#[test]
fn unknown_required_extensions_are_refused() {
    for (attributes, name) in [
        (
            "xmlns:x=\"http://example.com/secure\" requiredextensions=\"p x\"",
            "http://example.com/secure",
        ),
        ("requiredextensions=\"zz\"", "zz"),
    ] {
        let text = model(
            attributes,
            &object(1, &mesh_at(0.0)),
            "<item objectid=\"1\"/>",
        );
        let error = read(&file_of(&text)).expect_err("refused");
        assert!(
            error.contains(name) && error.contains("plain meshes"),
            "{error}"
        );
    }
    let text = model(
        "requiredextensions=\"p s\"",
        &object(1, &mesh_at(0.0)),
        "<item objectid=\"1\"/>",
    );
    assert!(read(&file_of(&text)).is_ok());
    // The core may have a prefix, too.
    let text = text
        .replace("xmlns=", "xmlns:c=")
        .replace('<', "<c:")
        .replace("<c:/", "</c:")
        .replace("<c:?", "<?");
    assert_eq!(
        read(&file_of(&text)).map(|mesh| mesh.triangles.len()),
        Ok(4),
        "{text}"
    );
}

/// A small file that unpacks to much is refused before it fills the memory.
#[test]
fn bombs_are_refused_with_both_numbers() {
    let many = |text: &str| text.repeat(40_000_000 / text.len());
    let vertices = many("<vertex x=\"0\" y=\"0\" z=\"0\"/>");
    let objects = many("<object id=\"1\"/>");
    for content in [vertices, objects, many("<!---->"), " ".repeat(40_000_000)] {
        let bytes = file_of(&format!(
            "<model><object id=\"1\"><mesh>{content}</mesh></object></model>"
        ));
        assert!(bytes.len() < 400_000);
        let error = read(&bytes).expect_err("a bomb");
        let size = bytes.len().to_string();
        assert!(
            error.contains("than 16777216 bytes") || error.contains(&size),
            "{error}"
        );
    }
}
