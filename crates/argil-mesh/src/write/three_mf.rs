//! 3D Manufacturing Format: a zip archive with the mesh as XML (<https://github.com/3MFConsortium/spec_core> 1.3, and the
//! color groups of <https://github.com/3MFConsortium/spec_materials> 1.2). z is up.

use super::options::{MeshWriteOptions, UpAxis, turned};
use super::srgb::srgb;
use crate::Mesh;
use std::collections::HashMap;
use std::io::{self, Cursor, Seek, Write};
use zip::write::{SimpleFileOptions, ZipWriter};

/// Facts about a 3MF file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ThreeMfMetadata {
    /// Title.
    pub title: Option<String>,
    /// Author.
    pub designer: Option<String>,
    /// Description.
    pub description: Option<String>,
}

const TYPES: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types"><Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/><Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>
"#;

const RELATIONS: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Target="/3D/3dmodel.model" Id="rel0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>
"#;

/// Units of 3MF, and how many of them a meter has.
const UNITS: [(&str, f32); 4] = [
    ("meter", 1.0),
    ("centimeter", 100.0),
    ("millimeter", 1000.0),
    ("inch", 1.0 / 0.0254),
];

/// Writes meshes as the objects of a 3MF file. The axis z points up, whatever `options.axes` says. Vertices with materials
/// have their base colors. The unit is the one of which `options.scale` makes a meter: 1 for meters, 1000 for millimeters.
///
/// ```
/// use argil_mesh::{Mesh, MeshWriteOptions, ThreeMfMetadata, write_3mf};
/// let mesh = Mesh {
///     positions: [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Into::into).to_vec(),
///     triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
///     ..Mesh::default()
/// };
/// let objects = [("left", &mesh), ("right", &mesh)];
/// let mut file = std::io::Cursor::new(Vec::new());
/// write_3mf(&objects, &MeshWriteOptions::default(), &ThreeMfMetadata::default(), &mut file)?;
/// # Ok::<(), std::io::Error>(())
/// ```
///
/// # Errors
/// If `out` fails.
pub fn write_3mf(
    objects: &[(&str, &Mesh)],
    options: &MeshWriteOptions,
    metadata: &ThreeMfMetadata,
    out: &mut (impl Write + Seek),
) -> io::Result<()> {
    let mut archive = ZipWriter::new(out);
    // The time of a file is the same in each, so that files are equal if their meshes are.
    let how = SimpleFileOptions::default()
        .compression_method(zip::CompressionMethod::Deflated)
        .compression_level(Some(4));
    for (name, text) in [("[Content_Types].xml", TYPES), ("_rels/.rels", RELATIONS)] {
        archive.start_file(name, how).map_err(io::Error::other)?;
        archive.write_all(text.as_bytes())?;
    }
    let is_large = objects
        .iter()
        .map(|(_, mesh)| mesh.triangles.len())
        .sum::<usize>()
        > 10_000_000;
    let how = how.large_file(is_large);
    archive
        .start_file("3D/3dmodel.model", how)
        .map_err(io::Error::other)?;
    let mut text = io::BufWriter::with_capacity(1 << 16, &mut archive);
    model(objects, options, metadata, &mut text)?;
    text.flush()?;
    drop(text);
    archive.finish().map_err(io::Error::other)?;
    Ok(())
}

/// Writes one mesh, to a stream that cannot seek.
pub(super) fn write(
    mesh: &Mesh,
    options: &MeshWriteOptions,
    out: &mut impl Write,
) -> io::Result<()> {
    let mut bytes = Cursor::new(Vec::new());
    write_3mf(
        &[("", mesh)],
        options,
        &ThreeMfMetadata::default(),
        &mut bytes,
    )?;
    out.write_all(bytes.get_ref())
}

fn model(
    objects: &[(&str, &Mesh)],
    options: &MeshWriteOptions,
    metadata: &ThreeMfMetadata,
    out: &mut impl Write,
) -> io::Result<()> {
    let near = |scale: f32| (options.scale / scale - 1.0).abs() < 1e-4;
    let unit = UNITS
        .iter()
        .find(|(_, scale)| near(*scale))
        .map_or("meter", |(name, _)| name);
    write!(
        out,
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<model unit=\"{unit}\" xml:lang=\"en-US\" xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" xmlns:m=\"http://schemas.microsoft.com/3dmanufacturing/material/2015/02\">\n"
    )?;
    let facts = [
        ("Title", metadata.title.as_deref()),
        ("Designer", metadata.designer.as_deref()),
        ("Description", metadata.description.as_deref()),
        (
            "Application",
            Some(concat!("Argil ", env!("CARGO_PKG_VERSION"))),
        ),
    ];
    for (name, text) in facts {
        if let Some(text) = text {
            writeln!(
                out,
                "<metadata name=\"{name}\">{}</metadata>",
                escaped(text)
            )?;
        }
    }
    writeln!(out, "<resources>")?;
    for (i, (name, mesh)) in objects.iter().enumerate() {
        object(2 * i + 1, name, mesh, options, out)?;
    }
    writeln!(out, "</resources>\n<build>")?;
    for i in 0..objects.len() {
        writeln!(out, "<item objectid=\"{}\"/>", 2 * i + 2)?;
    }
    writeln!(out, "</build>\n</model>")
}

/// Writes an object with the identifier `id + 1`, after its colors with the identifier `id`.
fn object(
    id: usize,
    name: &str,
    mesh: &Mesh,
    options: &MeshWriteOptions,
    out: &mut impl Write,
) -> io::Result<()> {
    let upright = MeshWriteOptions {
        axes: UpAxis::ZUp,
        ..*options
    };
    let turned = turned(mesh, &upright);
    let (colors, of_vertices) = colors(mesh);
    let group = if colors.is_empty() {
        String::new()
    } else {
        writeln!(out, "<m:colorgroup id=\"{id}\">")?;
        for [r, g, b] in &colors {
            writeln!(out, "<m:color color=\"#{r:02X}{g:02X}{b:02X}\"/>")?;
        }
        writeln!(out, "</m:colorgroup>")?;
        format!(" pid=\"{id}\" pindex=\"0\"")
    };
    let name = match name {
        "" => String::new(),
        name => format!(" name=\"{}\"", escaped(name)),
    };
    writeln!(
        out,
        "<object id=\"{}\" type=\"model\"{name}{group}><mesh>\n<vertices>",
        id + 1
    )?;
    for p in &turned.positions {
        writeln!(out, "<vertex x=\"{}\" y=\"{}\" z=\"{}\"/>", p.x, p.y, p.z)?;
    }
    writeln!(out, "</vertices>\n<triangles>")?;
    for &[a, b, c] in &turned.triangles {
        // A triangle without an area is not allowed to name a vertex twice.
        if a == b || b == c || c == a {
            continue;
        }
        write!(out, "<triangle v1=\"{a}\" v2=\"{b}\" v3=\"{c}\"")?;
        if !colors.is_empty() {
            let [a, b, c] = [a, b, c].map(|vertex| of_vertices[vertex as usize]);
            write!(out, " pid=\"{id}\" p1=\"{a}\"")?;
            if a != b || b != c {
                write!(out, " p2=\"{b}\" p3=\"{c}\"")?;
            }
        }
        writeln!(out, "/>")?;
    }
    writeln!(out, "</triangles>\n</mesh></object>")
}

/// Returns the colors of a mesh, and each vertex's place among them.
fn colors(mesh: &Mesh) -> (Vec<[u8; 3]>, Vec<u32>) {
    let mut all = Vec::new();
    let mut places = HashMap::new();
    let of = |material: &argil_abi::GpuMaterial| {
        let [r, g, b, _] = material.base_roughness;
        let color = [r, g, b].map(srgb);
        *places.entry(color).or_insert_with(|| {
            all.push(color);
            all.len() as u32 - 1
        })
    };
    let of_vertices = mesh.materials.iter().map(of).collect();
    (all, of_vertices)
}

fn escaped(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}
