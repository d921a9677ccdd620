//! Parses the bytes of each format.

use super::error::{MAX_TRIANGLES, ReadFault};
use crate::Mesh;
use glam::{Mat4, Vec3};
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};
use std::io::{BufReader, Cursor, ErrorKind};

/// Returns an OBJ file's text as its reader expects it: UTF-8 without a byte order mark, with line feeds only, and
/// with continued lines joined. Invalid bytes count as Latin-1, which comments and names of old programs use.
fn obj_lines(bytes: &[u8]) -> String {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let text = match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|&byte| char::from(byte)).collect(),
    };
    let text = text.replace("\r\n", "\n").replace('\r', "\n");
    text.replace("\\\n", " ")
}

/// Returns the first line of an OBJ file that is not a valid vertex or face, although it begins as one.
fn bad_obj_line(text: &str) -> Option<String> {
    let corners = text
        .lines()
        .filter(|line| line.split_whitespace().next() == Some("v"));
    let corners = corners.count() as u64;
    let is_bad = |line: &str| {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let numbers = words.map_while(|word| word.parse::<f32>().ok());
                numbers.count() < 3
            }
            Some("f") => {
                let is_index = |word: &str| {
                    let first = word.split('/').next().unwrap_or(word);
                    let index = first.parse::<i64>().map(i64::unsigned_abs);
                    index.is_ok_and(|index| (1..=corners).contains(&index))
                };
                let words: Vec<&str> = words.take_while(|word| !word.starts_with('#')).collect();
                words.len() < 3 || !words.iter().all(|word| is_index(word))
            }
            _ => false,
        }
    };
    let mut lines = (1..).zip(text.lines());
    let (number, line) = lines.find(|(_, line)| is_bad(line))?;
    let line: String = line.chars().take(60).collect();
    Some(format!("line {number}: \"{line}\""))
}

pub(super) fn obj(bytes: &[u8]) -> Result<Mesh, ReadFault> {
    let options = tobj::LoadOptions {
        triangulate: true,
        ignore_points: true,
        ignore_lines: true,
        ..tobj::LoadOptions::default()
    };
    if bytes.contains(&0) {
        return Err("not UTF-8 text".into());
    }
    let text = obj_lines(bytes);
    let mut file = BufReader::new(Cursor::new(text.as_bytes()));
    // Materials are in another file, and are ignored.
    let found = tobj::load_obj_buf(&mut file, &options, |_| Ok(Default::default()));
    let (models, _) = found.map_err(|e| bad_obj_line(&text).unwrap_or_else(|| e.to_string()))?;
    let mut mesh = Mesh::default();
    for model in models {
        let base = mesh.positions.len() as u32;
        let (places, rest) = model.mesh.positions.as_chunks::<3>();
        if !rest.is_empty() {
            return Err("incomplete vertex: a position needs three coordinates".into());
        }
        mesh.positions.extend(places.iter().map(|&p| Vec3::from(p)));
        let (triangles, _) = model.mesh.indices.as_chunks::<3>();
        mesh.triangles
            .extend(triangles.iter().map(|t| t.map(|i| base + i)));
    }
    Ok(mesh)
}

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

pub(super) fn glb(bytes: &[u8]) -> Result<Mesh, ReadFault> {
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

/// Iterates over the triangles of a strip. Every other one is reversed.
fn strip(corners: &[u32]) -> impl Iterator<Item = [u32; 3]> + '_ {
    let all = corners.windows(3).enumerate();
    all.map(|(nth, own)| match nth % 2 {
        0 => [own[0], own[1], own[2]],
        _ => [own[1], own[0], own[2]],
    })
}

/// Iterates over the triangles of a fan, or of a polygon.
fn fan(corners: &[u32]) -> impl Iterator<Item = [u32; 3]> + '_ {
    let sides = corners.get(1..).unwrap_or_default().windows(2);
    sides.map(|side| [corners[0], side[0], side[1]])
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

/// Returns a reader's message with a remedy.
fn said(kind: ErrorKind, text: String) -> String {
    match kind {
        ErrorKind::UnexpectedEof => "unexpected end of file: it is truncated".to_owned(),
        _ => text,
    }
}

/// Returns a PLY reader's message: its first line, and the text that it is about.
fn ply_fault(error: &ParseError) -> String {
    let text = error.to_string();
    let mut lines = text.lines();
    let first = lines.next().unwrap_or_default();
    let about = lines.find_map(|line| line.trim().strip_prefix("String: "));
    let about = about.map(|about| about.chars().take(60).collect::<String>());
    let text = match about {
        Some(about) => format!("{first}: {about}"),
        None => first.to_owned(),
    };
    said(error.kind(), text)
}

pub(super) fn stl(bytes: &[u8]) -> Result<Mesh, ReadFault> {
    let found = stl_io::read_stl(&mut Cursor::new(bytes));
    let found = found.map_err(|e| said(e.kind(), e.to_string()))?;
    Ok(Mesh {
        positions: found.vertices.iter().map(|v| Vec3::from(v.0)).collect(),
        triangles: found
            .faces
            .iter()
            .map(|face| face.vertices.map(|i| i as u32))
            .collect(),
        ..Mesh::default()
    })
}

/// A vertex or a polygon of a PLY file, depending on its element. Other properties are skipped.
struct PlyPart {
    place: Vec3,
    corners: Vec<u32>,
}

impl PropertyAccess for PlyPart {
    fn new() -> Self {
        Self {
            place: Vec3::NAN,
            corners: Vec::new(),
        }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        // An invalid index becomes one that does not exist.
        fn all<T: TryInto<u32>>(list: Vec<T>) -> Vec<u32> {
            let index = |i: T| i.try_into().unwrap_or(u32::MAX);
            list.into_iter().map(index).collect()
        }
        let number = match property {
            Property::Float(v) => v,
            Property::Double(v) => v as f32,
            Property::Int(v) => v as f32,
            Property::UInt(v) => v as f32,
            Property::Short(v) => v.into(),
            Property::UShort(v) => v.into(),
            Property::Char(v) => v.into(),
            Property::UChar(v) => v.into(),
            list => {
                if !matches!(name, "vertex_indices" | "vertex_index") {
                    return PropertyAccessResult::Ignored;
                }
                self.corners = match list {
                    Property::ListChar(v) => all(v),
                    Property::ListUChar(v) => all(v),
                    Property::ListShort(v) => all(v),
                    Property::ListUShort(v) => all(v),
                    Property::ListInt(v) => all(v),
                    Property::ListUInt(v) => v,
                    _ => return PropertyAccessResult::Ignored,
                };
                return PropertyAccessResult::Set;
            }
        };
        match name {
            "x" => self.place.x = number,
            "y" => self.place.y = number,
            "z" => self.place.z = number,
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

pub(super) fn ply(bytes: &[u8]) -> Result<Mesh, ReadFault> {
    let parser = Parser::<PlyPart>::new();
    let mut file = Reader::new(bytes);
    let header = parser.read_header(&mut file).map_err(|e| ply_fault(&e))?;
    let mut mesh = Mesh::default();
    for element in header.elements.values() {
        // Each element takes at least one byte.
        if element.count > bytes.len() {
            return Err(format!(
                "{} times \"{}\" are announced, and the file has {} bytes",
                element.count,
                element.name,
                bytes.len()
            )
            .into());
        }
        let parts = parser
            .read_payload_for_element(&mut file, element, &header)
            .map_err(|e| ply_fault(&e))?;
        match element.name.as_str() {
            "vertex" => mesh.positions = parts.iter().map(|part| part.place).collect(),
            "face" => {
                for part in parts {
                    mesh.triangles.extend(fan(&part.corners));
                }
            }
            "tristrips" => {
                // A strip ends at −1.
                let strips = parts
                    .iter()
                    .flat_map(|part| part.corners.split(|&i| i == u32::MAX));
                mesh.triangles.extend(strips.flat_map(strip));
            }
            _ => {}
        }
    }
    Ok(mesh)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_of_damaged_files_name_the_place() {
        let reason = |found: Result<Mesh, ReadFault>| match found {
            Err(ReadFault::Damaged(reason)) => reason,
            other => panic!("{other:?}"),
        };
        let corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
        for face in ["f 1 2 4", "f 1 2 -4", "f 0 1 2", "f 1 2 x"] {
            let found = reason(obj(format!("{corners}f 1 2 3\n{face}\n").as_bytes()));
            assert_eq!(found, format!("line 5: \"{face}\""));
        }
        assert!(reason(obj(b"v 0 0 0\0\x01")).contains("not UTF-8"));
        let mut binary = vec![0; 80];
        binary.extend(2u32.to_le_bytes());
        binary.extend([0; 60]);
        assert!(reason(stl(&binary)).contains("truncated"));
        let header = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
        let found = reason(ply(format!("{header}0 0 0\n1 a 0\n").as_bytes()));
        assert!(
            found.contains("ine 9") && found.contains("1 a 0") && !found.contains('\n'),
            "{found}"
        );
        assert!(reason(ply(format!("{header}0 0 0\n").as_bytes())).contains("truncated"));
    }

    #[test]
    fn old_and_odd_text_is_read() {
        let plain = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
        let expected = obj(plain.as_bytes()).expect("a mesh");
        let latin = [b"# caf\xe9\no Stra\xdfe\n", plain.as_bytes()].concat();
        let marked = [b"\xef\xbb\xbf", plain.as_bytes()].concat();
        let returns = plain.replace('\n', "\r").into_bytes();
        let both = plain.replace('\n', "\r\n").into_bytes();
        let long = plain.replace("f 1 2 3", "f 1 \\\n2 3").into_bytes();
        for odd in [latin, marked, returns, both, long] {
            let found = obj(&odd).expect("a mesh");
            assert_eq!(found.positions, expected.positions);
            assert_eq!(found.triangles, expected.triangles);
        }
    }
}
