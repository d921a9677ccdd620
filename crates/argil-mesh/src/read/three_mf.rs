//! 3D Manufacturing Format: objects and their placements, in meters with y up.

use super::error::{MAX_TRIANGLES, ReadFault};
use crate::Mesh;
use glam::{Affine3A, Vec3};
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use std::collections::HashMap;
use std::io::{Cursor, Read};

/// Maximum bytes of the model's XML.
const MAX_BYTES: u64 = 4 << 30;
/// Maximum objects and components that are placed.
const MAX_PLACED: u32 = 100_000;
/// Maximum depth of components.
const MAX_DEPTH: u32 = 16;

#[derive(Default)]
struct Object {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    components: Vec<(u32, Affine3A)>,
}

#[derive(Default)]
struct Model {
    scale: f32,
    objects: HashMap<u32, Object>,
    items: Vec<(u32, Affine3A)>,
    current: u32,
}

pub(super) fn read(bytes: &[u8]) -> Result<Mesh, ReadFault> {
    let damaged = |error: &dyn std::fmt::Display| ReadFault::Damaged(error.to_string());
    let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).map_err(|error| damaged(&error))?;
    let names: Vec<String> = archive.file_names().map(str::to_owned).collect();
    let is_model = |name: &&String| name.to_lowercase().ends_with(".model");
    let main = names.iter().filter(is_model).min_by_key(|name| name.len());
    let name =
        main.ok_or_else(|| ReadFault::Damaged("the archive has no 3D/3dmodel.model".into()))?;
    let mut text = Vec::new();
    let file = archive.by_name(name).map_err(|error| damaged(&error))?;
    // No more than the archive can hold: deflate shrinks a thousandfold at most.
    let most = MAX_BYTES.min(1100 * bytes.len() as u64);
    file.take(most)
        .read_to_end(&mut text)
        .map_err(|error| damaged(&error))?;
    if text.starts_with(&[0xff, 0xfe]) || text.starts_with(&[0xfe, 0xff]) {
        let reason = "its XML is UTF-16: save it as UTF-8";
        return Err(ReadFault::Unsupported(reason.into()));
    }
    let model = parse(&text)?;
    let mut mesh = Mesh::default();
    let mut placed = 0;
    for &(id, placement) in &model.items {
        add(&model, (id, placement), 0, &mut placed, &mut mesh)?;
    }
    // z up to y up, in meters.
    for p in &mut mesh.positions {
        *p = model.scale * Vec3::new(p.x, p.z, -p.y);
    }
    Ok(mesh)
}

fn parse(text: &[u8]) -> Result<Model, ReadFault> {
    let mut reader = Reader::from_reader(text);
    let mut model = Model {
        scale: 1e-3,
        ..Model::default()
    };
    loop {
        let event = reader.read_event();
        let position = reader.buffer_position();
        let event = event
            .map_err(|error| ReadFault::Damaged(format!("its XML at byte {position}: {error}")))?;
        match event {
            Event::Start(tag) | Event::Empty(tag) => {
                element(&tag, &mut model).map_err(|reason| {
                    ReadFault::Damaged(format!("its XML at byte {position}: {reason}"))
                })?
            }
            Event::Eof => return Ok(model),
            _ => {}
        }
    }
}

fn attribute(tag: &BytesStart<'_>, name: &str) -> Result<Option<String>, String> {
    for own in tag.attributes() {
        let own = own.map_err(|error| error.to_string())?;
        if own.key.local_name().as_ref() == name.as_bytes() {
            return Ok(Some(String::from_utf8_lossy(&own.value).into_owned()));
        }
    }
    Ok(None)
}

fn number<T: std::str::FromStr>(tag: &BytesStart<'_>, name: &str) -> Result<T, String> {
    let text = attribute(tag, name)?.ok_or_else(|| format!("{name} is missing"))?;
    text.trim()
        .parse()
        .map_err(|_| format!("{name} is {text:?}, not a number"))
}

fn transform(tag: &BytesStart<'_>) -> Result<Affine3A, String> {
    let Some(text) = attribute(tag, "transform")? else {
        return Ok(Affine3A::IDENTITY);
    };
    let numbers: Vec<f32> = text
        .split_whitespace()
        .filter_map(|n| n.parse().ok())
        .collect();
    let numbers = <[f32; 12]>::try_from(numbers);
    let numbers = numbers.map_err(|_| format!("the transform {text:?} has no 12 numbers"))?;
    Ok(Affine3A::from_cols_array(&numbers))
}

fn element(tag: &BytesStart<'_>, model: &mut Model) -> Result<(), String> {
    // Elements of extensions, such as slices, have a prefix.
    if tag.name().prefix().is_some() {
        return Ok(());
    }
    match tag.local_name().as_ref() {
        b"model" => {
            model.scale = match attribute(tag, "unit")?.as_deref() {
                Some("micron") => 1e-6,
                None | Some("millimeter") => 1e-3,
                Some("centimeter") => 1e-2,
                Some("inch") => 0.0254,
                Some("foot") => 0.3048,
                Some("meter") => 1.0,
                Some(unit) => return Err(format!("the unit {unit:?} is unknown")),
            };
        }
        b"object" => {
            model.current = number(tag, "id")?;
            model.objects.entry(model.current).or_default();
        }
        b"vertex" => {
            let p = Vec3::new(number(tag, "x")?, number(tag, "y")?, number(tag, "z")?);
            if !p.is_finite() {
                return Err(format!("the vertex {p} is not finite"));
            }
            let object = model.objects.entry(model.current).or_default();
            object.positions.push(p);
        }
        b"triangle" => {
            let corners = [number(tag, "v1")?, number(tag, "v2")?, number(tag, "v3")?];
            let object = model.objects.entry(model.current).or_default();
            object.triangles.push(corners);
        }
        b"component" => {
            if attribute(tag, "path")?.is_some() {
                return Err(
                    "a component lies in another file of the archive, which is not supported"
                        .into(),
                );
            }
            let part = (number(tag, "objectid")?, transform(tag)?);
            let object = model.objects.entry(model.current).or_default();
            object.components.push(part);
        }
        b"item" => model
            .items
            .push((number(tag, "objectid")?, transform(tag)?)),
        _ => {}
    }
    Ok(())
}

/// Adds an object and its components.
fn add(
    model: &Model,
    (id, placement): (u32, Affine3A),
    depth: u32,
    placed: &mut u32,
    mesh: &mut Mesh,
) -> Result<(), ReadFault> {
    let damaged = |reason: String| Err(ReadFault::Damaged(reason));
    let Some(object) = model.objects.get(&id) else {
        return damaged(format!("object {id} is missing"));
    };
    if depth > MAX_DEPTH {
        return damaged(format!(
            "the components of object {id} are nested more than {MAX_DEPTH} deep"
        ));
    }
    *placed += 1;
    let vertices = mesh.positions.len() + object.positions.len();
    if *placed > MAX_PLACED || vertices > 3 * MAX_TRIANGLES {
        return damaged(format!(
            "it places more than {MAX_PLACED} objects, or more vertices than {MAX_TRIANGLES} triangles have"
        ));
    }
    if mesh.triangles.len() + object.triangles.len() > MAX_TRIANGLES {
        return damaged(format!("it has more than {MAX_TRIANGLES} triangles"));
    }
    let count = object.positions.len() as u32;
    if object
        .triangles
        .iter()
        .flatten()
        .any(|&corner| corner >= count)
    {
        return damaged(format!(
            "a triangle of object {id} refers to a missing vertex"
        ));
    }
    let first = mesh.positions.len() as u32;
    let positions = object.positions.iter();
    mesh.positions
        .extend(positions.map(|&p| placement.transform_point3(p)));
    // A mirrored object would be inside out.
    let is_mirrored = placement.matrix3.determinant() < 0.0;
    mesh.triangles
        .extend(object.triangles.iter().map(|&[a, b, c]| {
            let [b, c] = if is_mirrored { [c, b] } else { [b, c] };
            [first + a, first + b, first + c]
        }));
    for &(part, inner) in &object.components {
        add(model, (part, placement * inner), depth + 1, placed, mesh)?;
    }
    Ok(())
}
