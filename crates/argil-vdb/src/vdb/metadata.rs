//! Metadata and transforms in files.

use super::bytes::{Reader, write_string};
use crate::{MetaValue, Metadata, Transform, VdbError};

/// Appends a list of metadata.
pub(super) fn write(all: &[(String, MetaValue)], out: &mut Vec<u8>) {
    out.extend((all.len() as u32).to_le_bytes());
    for (name, value) in all {
        let (kind, bytes) = packed(value);
        write_string(name, out);
        write_string(kind, out);
        out.extend((bytes.len() as u32).to_le_bytes());
        out.extend(bytes);
    }
}

fn packed(value: &MetaValue) -> (&str, Vec<u8>) {
    match value {
        MetaValue::String(text) => ("string", text.as_bytes().to_vec()),
        MetaValue::Bool(is) => ("bool", vec![u8::from(*is)]),
        MetaValue::Int32(n) => ("int32", n.to_le_bytes().to_vec()),
        MetaValue::Int64(n) => ("int64", n.to_le_bytes().to_vec()),
        MetaValue::Float(n) => ("float", n.to_le_bytes().to_vec()),
        MetaValue::Double(n) => ("double", n.to_le_bytes().to_vec()),
        MetaValue::Vec3i(all) => ("vec3i", all.iter().flat_map(|n| n.to_le_bytes()).collect()),
        MetaValue::Other(kind, bytes) => (kind, bytes.clone()),
    }
}

pub(super) fn read(from: &mut Reader<'_>) -> Result<Metadata, VdbError> {
    let count = from.u32("metadata")? as usize;
    // Each has three lengths.
    if count > from.left() / 12 {
        return Err(from.damaged(format!("{count} entries of metadata")));
    }
    let mut all = Vec::new();
    for _ in 0..count {
        let name = from.string("a name of metadata")?;
        let kind = from.string("a type of metadata")?;
        let length = from.u32("a length of metadata")? as usize;
        let bytes = from.take(length, "metadata")?;
        all.push((name, unpacked(kind, bytes)));
    }
    Ok(all)
}

fn unpacked(kind: String, bytes: &[u8]) -> MetaValue {
    let four = bytes.first_chunk::<4>().filter(|_| bytes.len() == 4);
    let eight = bytes.first_chunk::<8>().filter(|_| bytes.len() == 8);
    match (kind.as_str(), four, eight) {
        ("string", ..) => MetaValue::String(String::from_utf8_lossy(bytes).into_owned()),
        ("bool", ..) if bytes.len() == 1 => MetaValue::Bool(bytes[0] != 0),
        ("int32", Some(bytes), _) => MetaValue::Int32(i32::from_le_bytes(*bytes)),
        ("float", Some(bytes), _) => MetaValue::Float(f32::from_le_bytes(*bytes)),
        ("int64", _, Some(bytes)) => MetaValue::Int64(i64::from_le_bytes(*bytes)),
        ("double", _, Some(bytes)) => MetaValue::Double(f64::from_le_bytes(*bytes)),
        ("vec3i", ..) if bytes.len() == 12 => {
            let all = bytes.as_chunks::<4>().0;
            MetaValue::Vec3i([0, 1, 2].map(|i| i32::from_le_bytes(all[i])))
        }
        _ => MetaValue::Other(kind, bytes.to_vec()),
    }
}

pub(super) fn write_transform(transform: &Transform, out: &mut Vec<u8>) {
    let mut numbers = Vec::new();
    let is_moved = transform.translation != [0.0; 3];
    let name = match transform.uniform_voxel_size() {
        Some(edge) => {
            if is_moved {
                numbers.extend(transform.translation);
            }
            for value in [edge, edge, 1.0 / edge, 1.0 / (edge * edge), 0.5 / edge] {
                numbers.extend([value; 3]);
            }
            if is_moved {
                "UniformScaleTranslateMap"
            } else {
                "UniformScaleMap"
            }
        }
        None => {
            for column in transform.columns {
                numbers.extend(column);
                numbers.push(0.0);
            }
            numbers.extend(transform.translation);
            numbers.push(1.0);
            "AffineMap"
        }
    };
    write_string(name, out);
    out.extend(numbers.iter().flat_map(|n| n.to_le_bytes()));
}

pub(super) fn read_transform(from: &mut Reader<'_>) -> Result<Transform, VdbError> {
    let what = "a transform";
    let name = from.string(what)?;
    let mut three = || Ok::<_, VdbError>([from.f64(what)?, from.f64(what)?, from.f64(what)?]);
    let scaled = |scale: [f64; 3], translation: [f64; 3]| {
        let mut transform = Transform::uniform(1.0, translation);
        for (axis, length) in scale.into_iter().enumerate() {
            transform.columns[axis][axis] = length;
        }
        transform
    };
    let transform = match name.as_str() {
        "UniformScaleMap" | "ScaleMap" => {
            let transform = scaled(three()?, [0.0; 3]);
            from.take(4 * 24, what)?;
            transform
        }
        "UniformScaleTranslateMap" | "ScaleTranslateMap" => {
            let translation = three()?;
            let transform = scaled(three()?, translation);
            from.take(4 * 24, what)?;
            transform
        }
        "TranslationMap" => scaled([1.0; 3], three()?),
        "AffineMap" | "UnitaryMap" => {
            let mut rows = [[0.0; 4]; 4];
            for row in rows.as_flattened_mut() {
                *row = from.f64(what)?;
            }
            let of = |row: [f64; 4]| [row[0], row[1], row[2]];
            Transform {
                columns: [of(rows[0]), of(rows[1]), of(rows[2])],
                translation: of(rows[3]),
            }
        }
        _ => {
            return Err(VdbError::Unsupported(format!(
                "a transform of the type {name:?} is not supported: resample the grid to uniform voxels"
            )));
        }
    };
    if !transform.is_finite() {
        return Err(from.damaged("a transform is not finite"));
    }
    Ok(transform)
}
