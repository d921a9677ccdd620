//! The XML of a model: objects, and where they are placed.

use super::super::budget::Budget;
use super::super::error::ReadFault;
use super::package::{Package, fault};
use glam::{Affine3A, Vec3};
use quick_xml::events::{BytesStart, Event};
use quick_xml::name::ResolveResult;
use quick_xml::reader::NsReader;
use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;
use std::str::FromStr;

/// Extensions that may be required, by a part of their namespaces. Shapes of theirs that are not triangles are named.
const KNOWN: &[&str] = &[
    "/material/",
    "/production/",
    "/slice/",
    "/beamlattice/",
    "/trianglesets/",
    "/booleanoperations/",
    "/displacement/",
];

/// Elements of extensions that are shapes, and their names.
const SHAPES: &[(&[u8], &str)] = &[
    (b"beamlattice", "beam lattice"),
    (b"booleanshape", "boolean shape"),
    (b"displacementmesh", "displaced mesh"),
    (b"levelset", "level set"),
];

/// Maximum depth of elements, and maximum namespaces of one. Elements of models nest six deep.
const MAX_NESTED: u16 = 32;
const MAX_NAMESPACES: usize = 32;

/// What an object is for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum Role {
    #[default]
    Model,
    /// A support, or something that is not printed.
    Other,
}

#[derive(Debug, Default)]
pub(super) struct Object {
    pub(super) positions: Vec<Vec3>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) components: Vec<Placement>,
    pub(super) role: Role,
    /// Shapes that are not read, counted.
    pub(super) left_out: BTreeMap<&'static str, u64>,
}

/// An object in a place.
#[derive(Clone, Debug)]
pub(super) struct Placement {
    /// The model part that has the object, if it is another.
    pub(super) part: Option<Rc<str>>,
    pub(super) object: u32,
    pub(super) transform: Affine3A,
    pub(super) is_printed: bool,
}

#[derive(Debug, Default)]
pub(super) struct Model {
    /// Meters per unit, if it names one.
    pub(super) meters: Option<f32>,
    pub(super) objects: HashMap<u32, Object>,
    pub(super) items: Vec<Placement>,
    namespace: Option<Vec<u8>>,
    current: u32,
}

/// Bytes that an element takes while lists grow.
fn cost<T>() -> u64 {
    2 * size_of::<T>() as u64
}

impl Model {
    pub(super) fn read(
        package: &mut Package<'_>,
        name: &str,
        budget: &mut Budget,
    ) -> Result<Self, ReadFault> {
        let mut reader = NsReader::from_reader(package.part(name)?);
        let names = reader.resolver_mut();
        names.set_max_declarations_per_element(MAX_NAMESPACES);
        let mut model = Self::default();
        let mut buffer = Vec::new();
        loop {
            buffer.clear();
            reader.get_mut().get_mut().event = 0;
            let event = reader.read_event_into(&mut buffer);
            let position = reader.buffer_position();
            let place = || format!("{name}, byte {position}");
            let event = event.map_err(|error| match error {
                quick_xml::Error::Io(error) => fault(name, &error),
                error => ReadFault::Damaged(format!("{}: its XML: {error}", place())),
            })?;
            match event {
                Event::Start(_) if reader.resolver().level() > MAX_NESTED => {
                    let reason =
                        format!("{}: its XML is nested more than {MAX_NESTED} deep", place());
                    return Err(ReadFault::Damaged(reason));
                }
                Event::Start(tag) | Event::Empty(tag) => {
                    let (namespace, _) = reader.resolver().resolve_element(tag.name());
                    let is_core = model.is_core(&namespace);
                    let read = match is_core {
                        true => model.element(&tag, budget),
                        false => model.extension(&tag),
                    };
                    read.map_err(|fault| fault.within(&place()))?;
                }
                Event::Eof => return Ok(model),
                _ => {}
            }
        }
    }

    /// Whether an element belongs to the core: it has the namespace of the first element, or none if that has none.
    fn is_core(&mut self, namespace: &ResolveResult<'_>) -> bool {
        let name: &[u8] = match namespace {
            ResolveResult::Unbound => b"",
            ResolveResult::Bound(name) => name.as_ref(),
            ResolveResult::Unknown(_) => return false,
        };
        self.namespace.get_or_insert_with(|| name.to_vec()) == name
    }

    fn element(&mut self, tag: &BytesStart<'_>, budget: &mut Budget) -> Result<(), ReadFault> {
        match tag.local_name().as_ref() {
            b"vertex" => {
                let [x, y, z] = numbers(tag, ["x", "y", "z"])?;
                let p = Vec3::new(x, y, z);
                if !p.is_finite() {
                    return Err(format!("the vertex {p} is not finite").into());
                }
                budget.take(cost::<Vec3>())?;
                self.object().positions.push(p);
            }
            b"triangle" => {
                let corners = numbers(tag, ["v1", "v2", "v3"])?;
                budget.take(cost::<[u32; 3]>())?;
                self.object().triangles.push(corners);
            }
            b"model" => self.begin(tag)?,
            b"object" => {
                budget.take(2 * cost::<Object>())?;
                [self.current] = numbers(tag, ["id"])?;
                let role = match attribute(tag, "type")?.as_deref() {
                    Some("support" | "solidsupport" | "other") => Role::Other,
                    _ => Role::Model,
                };
                let is_coarse = |name| {
                    Ok::<_, ReadFault>(
                        attribute(tag, name)?.is_some_and(|value| value != "fullres"),
                    )
                };
                let is_coarse = is_coarse("meshresolution")? || is_coarse("modelresolution")?;
                let object = self.object();
                object.role = role;
                if is_coarse {
                    object.left_out.insert("finer version", 1);
                }
            }
            b"component" => {
                let part = placement(tag, budget)?;
                self.object().components.push(part);
            }
            b"item" => {
                let item = placement(tag, budget)?;
                self.items.push(item);
            }
            _ => {}
        }
        Ok(())
    }

    fn object(&mut self) -> &mut Object {
        self.objects.entry(self.current).or_default()
    }

    /// Notes an extension's shape.
    fn extension(&mut self, tag: &BytesStart<'_>) -> Result<(), ReadFault> {
        let name = tag.local_name();
        let shape = SHAPES.iter().find(|(known, _)| *known == name.as_ref());
        if let Some(&(_, shape)) = shape {
            self.object().left_out.insert(shape, 1);
        }
        Ok(())
    }

    /// Reads the first element: the unit, and which extensions the model requires.
    fn begin(&mut self, tag: &BytesStart<'_>) -> Result<(), ReadFault> {
        self.meters = match attribute(tag, "unit")?.as_deref() {
            None => None,
            Some("micron") => Some(1e-6),
            Some("millimeter") => Some(1e-3),
            Some("centimeter") => Some(1e-2),
            Some("inch") => Some(0.0254),
            Some("foot") => Some(0.3048),
            Some("meter") => Some(1.0),
            Some(unit) => return Err(format!("the unit {unit:?} is unknown").into()),
        };
        let required = attribute(tag, "requiredextensions")?.unwrap_or_default();
        let mut attributes = tag.attributes();
        let named = attributes.with_checks(false).flatten().filter_map(|entry| {
            let prefix = entry.key.as_ref().strip_prefix(b"xmlns:")?.to_vec();
            Some((prefix, String::from_utf8_lossy(&entry.value).into_owned()))
        });
        let named: BTreeMap<Vec<u8>, String> = named.collect();
        for prefix in required.split_whitespace() {
            let namespace = named.get(prefix.as_bytes());
            let namespace = namespace.map_or(prefix, String::as_str);
            if !KNOWN.iter().any(|known| namespace.contains(known)) {
                return Err(ReadFault::Unsupported(format!(
                    "it requires the extension {namespace}, which is not read: save its parts as plain meshes (3MF core), or as STL"
                )));
            }
        }
        Ok(())
    }
}

pub(super) fn attribute(tag: &BytesStart<'_>, name: &str) -> Result<Option<String>, ReadFault> {
    for entry in tag.attributes().with_checks(false) {
        let entry = entry.map_err(|error| error.to_string())?;
        if entry.key.local_name().as_ref() == name.as_bytes() {
            let text = String::from_utf8_lossy(&entry.value);
            let text = quick_xml::escape::unescape(&text).map_err(|error| error.to_string())?;
            return Ok(Some(text.into_owned()));
        }
    }
    Ok(None)
}

/// Reads attributes that are numbers.
pub(super) fn numbers<const N: usize, T: FromStr + Copy + Default>(
    tag: &BytesStart<'_>,
    names: [&str; N],
) -> Result<[T; N], ReadFault> {
    let mut all = [None; N];
    for entry in tag.attributes().with_checks(false) {
        let entry = entry.map_err(|error| error.to_string())?;
        let Some(at) = names
            .iter()
            .position(|name| entry.key.as_ref() == name.as_bytes())
        else {
            continue;
        };
        let text = std::str::from_utf8(&entry.value).unwrap_or_default();
        let number = text.trim().parse();
        all[at] = Some(number.map_err(|_| format!("{} is {text:?}, not a number", names[at]))?);
    }
    match all.iter().position(Option::is_none) {
        Some(at) => Err(format!("{} is missing", names[at]).into()),
        None => Ok(all.map(Option::unwrap_or_default)),
    }
}

fn placement(tag: &BytesStart<'_>, budget: &mut Budget) -> Result<Placement, ReadFault> {
    let [object] = numbers(tag, ["objectid"])?;
    let part = attribute(tag, "path")?.map(Rc::from);
    budget.take(
        cost::<Placement>()
            + part
                .as_ref()
                .map_or(0, |part: &Rc<str>| 2 * part.len() as u64),
    )?;
    Ok(Placement {
        part,
        object,
        transform: transform(tag)?,
        is_printed: attribute(tag, "printable")?
            .is_none_or(|value| value.trim() != "0" && value.trim() != "false"),
    })
}

fn transform(tag: &BytesStart<'_>) -> Result<Affine3A, ReadFault> {
    let Some(text) = attribute(tag, "transform")? else {
        return Ok(Affine3A::IDENTITY);
    };
    let parsed: Vec<f32> = text
        .split_whitespace()
        .map_while(|n| n.parse().ok())
        .collect();
    let is_whole = text.split_whitespace().count() == parsed.len();
    let parsed = <[f32; 12]>::try_from(parsed)
        .ok()
        .filter(|all| is_whole && all.iter().all(|n| n.is_finite()));
    let parsed = parsed.ok_or_else(|| format!("the transform {text:?} has no 12 numbers"))?;
    Ok(Affine3A::from_cols_array(&parsed))
}
