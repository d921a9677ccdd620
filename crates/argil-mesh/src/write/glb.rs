//! glTF 2.0: binary, or as JSON that holds its buffer.
//!
//! *Practice.* Triangles are grouped by the quantized roughness, metalness and emission of their vertices. Colors
//! are per vertex, so that blends survive.

use crate::Mesh;
use argil_abi::GpuMaterial;
use base64::Engine;
use glam::Vec3;
use serde_json::{Value, json};
use std::collections::{BTreeMap, HashMap};
use std::io::{self, Write};

/// Bytes of a GLB before its chunks, and of a chunk before its data.
const HEADER: usize = 12;
const CHUNK_HEADER: usize = 8;

const FLOAT: u32 = 5126;
const UNSIGNED: u32 = 5125;
const SHORT: u32 = 5123;

const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

/// A material without its color, quantized: roughness, metalness, and emission in red, green and blue.
type Finish = [u32; 5];

const STEPS: f32 = 64.0;

/// Maximum materials of a file.
const MAX_FINISHES: usize = 16;

/// The material of a mesh without materials.
const PLAIN: GpuMaterial = GpuMaterial {
    base_roughness: [1.0, 1.0, 1.0, 0.55],
    emission_metallic: [0.0; 4],
};

fn finish(material: &GpuMaterial) -> Finish {
    let [_, _, _, roughness] = material.base_roughness;
    let [r, g, b, metallic] = material.emission_metallic;
    [roughness, metallic, r, g, b].map(|value| (STEPS * value).round() as u32)
}

pub(super) fn write(mesh: &Mesh, out: &mut impl Write) -> io::Result<()> {
    let (root, bytes) = contents(mesh)?;
    let json = serde_json::to_vec(&root).map_err(io::Error::other)?;
    let padded = |length: usize| length.next_multiple_of(4);
    let length = HEADER + 2 * CHUNK_HEADER + padded(json.len()) + padded(bytes.len());
    let length = u32::try_from(length).map_err(io::Error::other)?;
    out.write_all(b"glTF")?;
    out.write_all(&2u32.to_le_bytes())?;
    out.write_all(&length.to_le_bytes())?;
    for (kind, chunk, filler) in [(b"JSON", &json, b' '), (b"BIN\0", &bytes, 0)] {
        let length = padded(chunk.len());
        out.write_all(&(length as u32).to_le_bytes())?;
        out.write_all(kind)?;
        out.write_all(chunk)?;
        out.write_all(&vec![filler; length - chunk.len()])?;
    }
    Ok(())
}

/// Writes JSON that holds the buffer, in base64.
pub(super) fn write_text(mesh: &Mesh, out: &mut impl Write) -> io::Result<()> {
    let (mut root, bytes) = contents(mesh)?;
    let data = base64::engine::general_purpose::STANDARD.encode(bytes);
    root["buffers"][0]["uri"] = json!(format!("data:application/octet-stream;base64,{data}"));
    serde_json::to_writer(out, &root).map_err(io::Error::other)
}

/// Returns the JSON and the buffer.
fn contents(mesh: &Mesh) -> io::Result<(Value, Vec<u8>)> {
    if mesh.triangles.is_empty() {
        let reason = "there are no triangles, and glTF has no empty meshes";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, reason));
    }
    let groups = groups(mesh);
    let mut parts = GlbParts::default();
    let mut primitives = Vec::new();
    let mut materials = Vec::new();
    let mut is_strong = false;
    for (finish, triangles) in &groups {
        // Readers give each primitive its own vertices, so shared ones would be duplicated.
        let mut primitive = primitive(&mut parts, &mesh.submesh(triangles));
        primitive["material"] = json!(materials.len());
        primitives.push(primitive);
        let material = material(finish);
        is_strong |= material.get("extensions").is_some();
        materials.push(material);
    }
    if u32::try_from(parts.bytes.len() + (1 << 20)).is_err() {
        let reason = "a GLB holds 4 GiB at most: take fewer triangles, or write .ply or .stl";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, reason));
    }
    let mut root = json!({
        "asset": { "version": "2.0", "generator": "Argil" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": primitives }],
        "materials": materials,
        "accessors": parts.accessors,
        "bufferViews": parts.views,
        "buffers": [{ "byteLength": parts.bytes.len() }],
    });
    if is_strong {
        root["extensionsUsed"] = json!(["KHR_materials_emissive_strength"]);
    }
    Ok((root, parts.bytes))
}

fn primitive(parts: &mut GlbParts, mesh: &Mesh) -> Value {
    let count = mesh.positions.len();
    let mut attributes = json!({});
    let bounds = mesh.aabb();
    attributes["POSITION"] = parts.accessor(
        bytemuck::cast_slice(&mesh.positions),
        json!({
            "componentType": FLOAT, "count": count, "type": "VEC3",
            "min": bounds.min.to_array(), "max": bounds.max.to_array(),
        }),
    );
    if !mesh.normals.is_empty() {
        // Where the field has no gradient, there is no normal, but glTF requires unit vectors.
        let unit = |n: &Vec3| {
            if n.length_squared() > 0.5 {
                *n
            } else {
                Vec3::Y
            }
        };
        let normals: Vec<Vec3> = mesh.normals.iter().map(unit).collect();
        let about = json!({ "componentType": FLOAT, "count": count, "type": "VEC3" });
        attributes["NORMAL"] = parts.accessor(bytemuck::cast_slice(&normals), about);
    }
    if !mesh.materials.is_empty() {
        let step = |c: f32| (65535.0 * c.clamp(0.0, 1.0) + 0.5) as u16;
        let color = |m: &GpuMaterial| {
            let [r, g, b, _] = m.base_roughness;
            [step(r), step(g), step(b), u16::MAX]
        };
        let colors: Vec<[u16; 4]> = mesh.materials.iter().map(color).collect();
        let about = json!({
            "componentType": SHORT, "normalized": true, "count": count, "type": "VEC4",
        });
        attributes["COLOR_0"] = parts.accessor(bytemuck::cast_slice(&colors), about);
    }
    let about = json!({
        "componentType": UNSIGNED, "count": 3 * mesh.triangles.len(), "type": "SCALAR",
    });
    let indices = parts.accessor(bytemuck::cast_slice(&mesh.triangles), about);
    json!({ "attributes": attributes, "indices": indices })
}

/// The file's one buffer, and its accessors.
#[derive(Default)]
struct GlbParts {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl GlbParts {
    /// Adds bytes, whose length is a multiple of four, and the accessor that reads them. Returns its index.
    fn accessor(&mut self, bytes: &[u8], mut about: Value) -> Value {
        let is_index = about["type"] == "SCALAR";
        let target = if is_index { INDICES } else { VERTICES };
        about["bufferView"] = json!(self.views.len());
        self.views.push(json!({
            "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len(), "target": target,
        }));
        self.bytes.extend_from_slice(bytes);
        self.accessors.push(about);
        json!(self.accessors.len() - 1)
    }
}

/// Returns the triangles of each finish. There are few: one that few vertices have, as in a blend between two
/// materials, becomes the nearest of the others.
fn groups(mesh: &Mesh) -> BTreeMap<Finish, Vec<[u32; 3]>> {
    let mut groups: BTreeMap<Finish, Vec<[u32; 3]>> = BTreeMap::new();
    if mesh.materials.is_empty() {
        groups.insert(finish(&PLAIN), mesh.triangles.clone());
        return groups;
    }
    let mut finishes_of_vertices: Vec<Finish> = mesh.materials.iter().map(finish).collect();
    let mut counts: HashMap<Finish, usize> = HashMap::new();
    for finish in &finishes_of_vertices {
        *counts.entry(*finish).or_default() += 1;
    }
    let mut common: Vec<(usize, Finish)> = counts.iter().map(|(&f, &n)| (n, f)).collect();
    common.sort_unstable_by(|a, b| b.cmp(a));
    let enough = finishes_of_vertices.len() / 100;
    let kept = common.iter().take_while(|(n, _)| *n > enough).count();
    common.truncate(kept.clamp(1, MAX_FINISHES));
    let nearest = |finish: &Finish| {
        let way = |other: &Finish| -> u32 {
            let pairs = finish.iter().zip(other);
            pairs.map(|(a, b)| a.abs_diff(*b)).sum()
        };
        let best = common.iter().min_by_key(|(_, other)| way(other));
        best.map_or(*finish, |(_, other)| *other)
    };
    let snapped: HashMap<Finish, Finish> = counts.keys().map(|f| (*f, nearest(f))).collect();
    for finish in &mut finishes_of_vertices {
        *finish = snapped[finish];
    }
    for &triangle in &mesh.triangles {
        // The one of two vertices, else the middle one.
        let mut finishes = triangle.map(|i| finishes_of_vertices[i as usize]);
        finishes.sort_unstable();
        groups.entry(finishes[1]).or_default().push(triangle);
    }
    groups
}

fn material(finish: &Finish) -> Value {
    let [roughness, metallic, r, g, b] = finish.map(|step| step as f32 / STEPS);
    let mut material = json!({
        "pbrMetallicRoughness": {
            "baseColorFactor": [1, 1, 1, 1],
            "metallicFactor": metallic.min(1.0),
            "roughnessFactor": roughness.min(1.0),
        },
    });
    let strongest = r.max(g).max(b);
    if strongest > 0.0 {
        let scale = 1.0 / strongest.max(1.0);
        material["emissiveFactor"] = json!([r * scale, g * scale, b * scale]);
        if strongest > 1.0 {
            material["extensions"] = json!({
                "KHR_materials_emissive_strength": { "emissiveStrength": strongest },
            });
        }
    }
    material
}
