//! What slicers write beside a model: which parts of an object are no solids, but cut it or change how it is printed.

use super::super::budget::Budget;
use super::super::error::ReadFault;
use super::model::{Model, Object, Role, attribute, numbers};
use super::package::{Package, fault};
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

/// The parts of an archive with the settings of PrusaSlicer, and of Bambu Studio and OrcaSlicer.
const SETTINGS: &[&str] = &[
    "Metadata/Slic3r_PE_model.config",
    "Metadata/model_settings.config",
];

/// Names of what is not a solid, by the words of both.
const KINDS: &[(&[&str], &str)] = &[
    (&["NegativeVolume", "negative_part"], "negative volume"),
    (&["ParameterModifier", "modifier_part"], "modifier"),
    (&["SupportBlocker", "support_blocker"], "support blocker"),
    (&["SupportEnforcer", "support_enforcer"], "support enforcer"),
];

/// Triangles of an object.
struct Part {
    object: u32,
    /// The first one, and the last.
    triangles: [u32; 2],
    /// What they are, if they are not a solid.
    kind: Option<&'static str>,
}

fn kind_of(word: &str) -> Option<&'static str> {
    let found = KINDS.iter().find(|(words, _)| words.contains(&word));
    found.map(|(_, name)| *name)
}

/// What the settings of an archive say about its parts.
pub(super) struct Settings {
    parts: Vec<Part>,
}

impl Settings {
    pub(super) fn read(package: &mut Package<'_>, budget: &mut Budget) -> Result<Self, ReadFault> {
        let mut parts = Vec::new();
        for name in SETTINGS {
            if package.has(name) {
                read_parts(package, name, budget, &mut parts)?;
            }
        }
        parts.retain(|part| part.kind.is_some());
        parts.sort_by_key(|part| part.object);
        Ok(Self { parts })
    }

    /// Takes what is not a solid out of a model.
    pub(super) fn apply(&self, model: &mut Model) {
        for parts in self.parts.chunk_by(|a, b| a.object == b.object) {
            if let Some(object) = model.objects.get_mut(&parts[0].object) {
                take_out(object, parts);
            }
        }
    }
}

fn take_out(object: &mut Object, parts: &[Part]) {
    let count = object.triangles.len();
    // How many ranges begin at each triangle, less those that end there.
    let mut begins = vec![0i32; count + 1];
    for part in parts {
        let [first, last] = part.triangles.map(|i| i as usize);
        let end = last.saturating_add(1).min(count);
        // What the model itself does not print is counted there.
        if let Some(kind) = part.kind
            && first < end
            && object.role == Role::Model
        {
            begins[first] += 1;
            begins[end] -= 1;
            *object.left_out.entry(kind).or_default() += 1;
        }
    }
    let mut open = 0;
    let mut begins = begins.into_iter();
    object.triangles.retain(|_| {
        open += begins.next().unwrap_or_default();
        open == 0
    });
}

/// Reads which triangles of objects have a kind. What has no numbers says nothing.
fn read_parts(
    package: &mut Package<'_>,
    name: &str,
    budget: &mut Budget,
    parts: &mut Vec<Part>,
) -> Result<(), ReadFault> {
    let mut reader = Reader::from_reader(package.part(name)?);
    let mut object = None;
    let mut buffer = Vec::new();
    loop {
        buffer.clear();
        let event = reader.read_event_into(&mut buffer);
        let event = event.map_err(|error| match error {
            quick_xml::Error::Io(error) => fault(name, &error),
            error => ReadFault::Damaged(format!("{name}: its XML: {error}")),
        })?;
        match event {
            Event::Start(tag) | Event::Empty(tag) => {
                budget.take(2 * size_of::<Part>() as u64)?;
                element(&tag, &mut object, parts);
            }
            Event::Eof => return Ok(()),
            _ => {}
        }
    }
}

fn element(tag: &BytesStart<'_>, object: &mut Option<u32>, parts: &mut Vec<Part>) {
    let text = |name| attribute(tag, name).ok().flatten().unwrap_or_default();
    let id = || numbers(tag, ["id"]).ok().map(|[id]| id);
    let mut add = |object: Option<u32>, triangles: Option<[u32; 2]>, kind| {
        if let (Some(object), Some(triangles)) = (object, triangles) {
            parts.push(Part {
                object,
                triangles,
                kind,
            });
        }
    };
    match tag.local_name().as_ref() {
        b"object" => *object = id(),
        b"volume" => add(*object, numbers(tag, ["firstid", "lastid"]).ok(), None),
        // A part is an object of its own.
        b"part" => add(id(), Some([0, u32::MAX]), kind_of(&text("subtype"))),
        b"metadata" => {
            let kind = match (&text("key")[..], &text("value")[..]) {
                ("volume_type", word) => kind_of(word),
                // Older files say no more.
                ("modifier", "1") => Some("modifier"),
                _ => None,
            };
            if let Some(part) = parts.last_mut() {
                part.kind = kind.or(part.kind);
            }
        }
        _ => {}
    }
}
