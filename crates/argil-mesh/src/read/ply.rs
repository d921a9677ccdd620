//! Stanford triangles (PLY): polygons and triangle strips, as text or binary.

mod header;
mod values;

use super::error::ReadFault;
use super::file::MeshFile;
use super::polygon::Polygons;
use super::strips::strip;
use glam::Vec3;
use header::{Element, Header, Property};
use values::Values;

/// What an element's property means here.
#[derive(Clone, Copy, PartialEq)]
enum Meaning {
    Axis(usize),
    Corners,
    Nothing,
}

fn meaning(property: &Property) -> Meaning {
    let axis = ["x", "y", "z"]
        .iter()
        .position(|&axis| axis == property.name);
    match (axis, property.count) {
        (Some(axis), None) => Meaning::Axis(axis),
        (None, Some(_)) if matches!(&property.name[..], "vertex_indices" | "vertex_index") => {
            Meaning::Corners
        }
        _ => Meaning::Nothing,
    }
}

/// The corners of polygons or strips, each after their number.
type Lists = Vec<u32>;

fn each_list(lists: &Lists) -> impl Iterator<Item = &[u32]> {
    let mut rest = &lists[..];
    std::iter::from_fn(move || {
        let (&count, after) = rest.split_first()?;
        let (list, after) = after.split_at_checked(count as usize)?;
        rest = after;
        Some(list)
    })
}

/// Reads an element's points and lists.
fn element(
    element: &Element,
    values: &mut Values<'_>,
    places: &mut Vec<Vec3>,
    lists: &mut Lists,
) -> Result<(), ReadFault> {
    let meanings: Vec<Meaning> = element.properties.iter().map(meaning).collect();
    let is_vertex = element.name == "vertex";
    if is_vertex && (0..3).any(|axis| !meanings.contains(&Meaning::Axis(axis))) {
        return Err("its vertices have no x, y and z".into());
    }
    if element.properties.is_empty() {
        return Ok(());
    }
    for _ in 0..element.count {
        values.begin()?;
        let mut place = [f32::NAN; 3];
        for (property, meaning) in element.properties.iter().zip(&meanings) {
            let count = match property.count {
                Some(number) => values.count(number)?,
                None => 1,
            };
            match meaning {
                Meaning::Axis(axis) => place[*axis] = values.next(property.number)? as f32,
                Meaning::Corners if !is_vertex => {
                    lists.push(count);
                    for _ in 0..count {
                        lists.push(index(values.next(property.number)?));
                    }
                }
                _ => values.skip(property.number, count)?,
            }
        }
        values.end();
        if is_vertex {
            places.push(place.into());
        }
    }
    Ok(())
}

/// Converts a number to an index. An invalid one becomes one that no vertex has.
fn index(number: f64) -> u32 {
    let is_index = number >= 0.0 && number < f64::from(u32::MAX) && number.fract() == 0.0;
    if is_index { number as u32 } else { u32::MAX }
}

pub(super) fn read(bytes: &[u8]) -> Result<MeshFile, ReadFault> {
    let (header, body) = Header::parse(bytes)?;
    let mut values = Values::new(body, &header);
    let mut file = MeshFile::default();
    let mut faces = Lists::new();
    let mut strips = Lists::new();
    for announced in &header.elements {
        // Each element takes at least one byte.
        if !announced.properties.is_empty() && announced.count > bytes.len() {
            return Err(ReadFault::Damaged(format!(
                "{} times \"{}\" are announced, and the file has {} bytes",
                announced.count,
                announced.name,
                bytes.len()
            )));
        }
        let is_corners = |p: &Property| meaning(p) == Meaning::Corners;
        if announced.name == "face"
            && announced.count > 0
            && !announced.properties.iter().any(is_corners)
        {
            let reason = "its faces have no list of corners named \"vertex_indices\" or \"vertex_index\": rename theirs";
            return Err(ReadFault::Unsupported(reason.into()));
        }
        let mut other = Lists::new();
        let (lists, is_read) = match &announced.name[..] {
            "face" => (&mut faces, true),
            "tristrips" => (&mut strips, true),
            "vertex" => (&mut other, true),
            _ => (&mut other, false),
        };
        element(announced, &mut values, &mut file.mesh.positions, lists)?;
        let has_corners = |p: &Property| is_corners(p) || p.name == "vertex1";
        if !is_read && announced.count > 0 && announced.properties.iter().any(has_corners) {
            let (count, name) = (announced.count, &announced.name);
            file.warnings.push(format!(
                "left out {count} of its \"{name}\": only faces and strips are read"
            ));
        }
    }
    file.warnings.extend(values.warning());
    let mut polygons = Polygons::default();
    for (number, corners) in each_list(&faces).enumerate() {
        polygons.add(corners, &mut file.mesh, number)?;
    }
    for strips in each_list(&strips) {
        // A strip ends at −1.
        let strips = strips.split(|&i| i == u32::MAX);
        file.mesh.triangles.extend(strips.flat_map(strip));
    }
    let count = file.mesh.positions.len();
    if file.mesh.triangles.is_empty() && count > 0 {
        return Err(ReadFault::Unsupported(format!(
            "it is a cloud of {count} points without faces, and a solid needs a surface: reconstruct one, for example in MeshLab"
        )));
    }
    file.warnings.extend(polygons.warnings("face"));
    Ok(file)
}
