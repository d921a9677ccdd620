//! Reads a document's tokens with a stack on the heap.

use super::error::{FORMAT_VERSION, FileError, MAX_PART_BYTES, fault_of};
use crate::file::explain::{describe, explain, locate, position, unknown_field};
use crate::file::tokens::{ByteSource, Meter, Stop, Tokens, tokens};
use crate::node::pose_of;
use crate::{EditError, Group, NodeDesc, NodeId, NodeKind, Scene, ValidationError};
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::path::Path;
use struson::reader::{JsonReader, ReaderError, TransferError, ValueType};
use struson::writer::{JsonStreamWriter, JsonWriter};

/// Reads from `source`. `again` opens it once more, to find the line of an error.
pub(super) fn read<'a>(
    path: &Path,
    source: ByteSource<'a>,
    again: &dyn Fn() -> Result<ByteSource<'a>, FileError>,
) -> Result<Scene, FileError> {
    let content = |line, column, fault| FileError::Content {
        path: path.into(),
        line,
        column,
        fault,
    };
    let meter = Meter::default();
    let mut reader = tokens(source, Some(&meter));
    match document(&mut reader, &meter).and_then(with_known_materials) {
        Ok(scene) => {
            let (line, column) = position(&reader);
            let follows = |_| {
                content(
                    line,
                    column,
                    ValidationError::new("", "unexpected data after the scene's closing brace"),
                )
            };
            reader.consume_trailing_whitespace().map_err(follows)?;
            Ok(scene)
        }
        Err(Stop::Reader(ReaderError::IoError { error, .. }))
            if error.kind() != std::io::ErrorKind::InvalidData =>
        {
            Err(FileError::Io {
                path: path.into(),
                source: error,
            })
        }
        Err(Stop::Reader(error)) => {
            let (line, column) = position(&reader);
            Err(content(
                line,
                column,
                ValidationError::new("", describe(&error)),
            ))
        }
        Err(Stop::Fault(fault)) => {
            match version(again()?) {
                // What a later version adds is no fault of the file.
                Some(Some(found)) if found > u64::from(FORMAT_VERSION) => {
                    return Err(FileError::Newer {
                        path: path.into(),
                        found,
                    });
                }
                None => {
                    let reason = "not a scene: the field \"argil\": 1, the version of the format, is missing";
                    return Err(content(1, 1, ValidationError::new("", reason)));
                }
                Some(_) => {}
            }
            let (line, column) = locate(again()?, &fault);
            Err(content(line, column, fault))
        }
    }
}

fn document(reader: &mut Tokens<'_>, meter: &Meter) -> Result<Scene, Stop> {
    let mut scene = Scene::new();
    let fault = |path: &str, reason: &str| Err(Stop::Fault(ValidationError::new(path, reason)));
    if reader.peek()? != ValueType::Object {
        return fault("", "a scene file holds one JSON object, {\"argil\": 1, …}");
    }
    reader.begin_object()?;
    let mut seen: Vec<String> = Vec::new();
    while reader.has_next()? {
        meter.mark();
        let key = reader.next_name_owned()?;
        if seen.contains(&key) {
            return fault(&key, "duplicate field");
        }
        match key.as_str() {
            "$schema" => drop(part::<String>(reader, "$schema")?),
            "argil" => {
                let version: Value = part(reader, "argil")?;
                if version.as_u64() != Some(u64::from(FORMAT_VERSION)) {
                    let reason = format!(
                        "{version} is not a version of the format: write \"argil\": {FORMAT_VERSION}"
                    );
                    return fault("argil", &reason);
                }
            }
            "name" => scene.name = part(reader, "name")?,
            "credit" => scene.credit = part(reader, "credit")?,
            "view" => {
                scene.view = part(reader, "view")?;
                scene
                    .view
                    .check()
                    .map_err(|f| Stop::Fault(f.within("view")))?;
            }
            "materials" => materials(reader, meter, &mut scene)?,
            "brushes" => brushes(reader, meter, &mut scene)?,
            other => return fault(other, &unknown_field(other, &KEYS)),
        }
        seen.push(key);
    }
    for needed in ["argil", "brushes"] {
        if !seen.iter().any(|key| key == needed) {
            return fault("", &format!("the field \"{needed}\" is missing"));
        }
    }
    reader.end_object()?;
    Ok(scene)
}

/// Reads a valid document, but for the materials of its brushes.
pub(super) fn unchecked(text: &[u8]) -> Option<Scene> {
    let meter = Meter::default();
    document(&mut tokens(Box::new(text), Some(&meter)), &meter).ok()
}

/// Checks the materials of brushes, which can come after them.
fn with_known_materials(scene: Scene) -> Result<Scene, Stop> {
    let known = |node: NodeId| match &scene.node(node).desc().material {
        Some(name) => scene.materials.contains_key(name),
        None => true,
    };
    if let Some(node) = scene.iter().find(|&node| !known(node)) {
        let name = scene.node(node).desc().material.clone().unwrap_or_default();
        let unknown = fault_of(EditError::NoSuchMaterial(name));
        return Err(Stop::Fault(unknown.within(&scene.path(node))));
    }
    Ok(scene)
}

/// Returns the version of the format that a document has, `Some(None)` if that cannot be read, and `None` if it is another object.
fn version(source: ByteSource<'_>) -> Option<Option<u64>> {
    let mut reader = tokens(source, None);
    let mut read_version = || {
        reader.begin_object()?;
        while reader.has_next()? {
            if reader.next_name()? == "argil" {
                let version: Result<Value, Stop> = part(&mut reader, "argil");
                return Ok(Some(version.ok().and_then(|version| version.as_u64())));
            }
            reader.skip_value()?;
        }
        Ok::<_, ReaderError>(None)
    };
    read_version().unwrap_or(Some(None))
}

const KEYS: [&str; 7] = [
    "$schema",
    "argil",
    "name",
    "credit",
    "view",
    "materials",
    "brushes",
];

fn materials(reader: &mut Tokens<'_>, meter: &Meter, scene: &mut Scene) -> Result<(), Stop> {
    reader.begin_object()?;
    while reader.has_next()? {
        meter.mark();
        let name = reader.next_name_owned()?;
        let path = format!("materials.{name}");
        if scene.materials.contains_key(&name) {
            return Err(Stop::Fault(ValidationError::new(
                path,
                "duplicate material name",
            )));
        }
        let material = part(reader, &path)?;
        scene
            .set_material(name, material)
            .map_err(|f| Stop::Fault(f.within("materials")))?;
    }
    Ok(reader.end_object()?)
}

/// An open item: its fields so far, and its node once it is known to be a group.
struct Open {
    /// The group that contains the item, and its index there.
    parent: NodeId,
    index: usize,
    entry: NodeDesc,
    group: Option<NodeId>,
    has_shape: bool,
    seen: u32,
}

const FIELDS: [&str; 13] = [
    "name",
    "visible",
    "locked",
    "operator",
    "blend",
    "profile",
    "amount",
    "ramp",
    "material",
    "modifiers",
    "keyframes",
    "shape",
    "brushes",
];

fn brushes(reader: &mut Tokens<'_>, meter: &Meter, scene: &mut Scene) -> Result<(), Stop> {
    reader.begin_array()?;
    let mut open: Vec<Open> = Vec::new();
    // Whether the next token belongs to a list of items, or to the item on top.
    let mut in_list = true;
    loop {
        meter.mark();
        if in_list {
            if reader.has_next()? {
                // Begin the next item of the list.
                reader.begin_object()?;
                let parent = open.last().and_then(|o| o.group).unwrap_or(Scene::ROOT);
                let index = scene.node(parent).children.len();
                open.push(Open {
                    parent,
                    index,
                    entry: Group::new().into(),
                    group: None,
                    has_shape: false,
                    seen: 0,
                });
                in_list = false;
            } else {
                // The list ends: return to its group, or finish.
                reader.end_array()?;
                if open.is_empty() {
                    return Ok(());
                }
                in_list = false;
            }
            continue;
        }
        if reader.has_next()? {
            let key = reader.next_name_owned()?;
            in_list = field(reader, scene, &mut open, &key)?;
        } else {
            reader.end_object()?;
            let fault = open.last_mut().map(|item| finish(scene, item));
            if let Some(Err(fault)) = fault {
                return Err(Stop::Fault(fault.within(&path_of(&open))));
            }
            open.pop();
            in_list = true;
        }
    }
}

/// Reads one field of the item on top. Returns whether it began a list of items.
fn field(
    reader: &mut Tokens<'_>,
    scene: &mut Scene,
    open: &mut [Open],
    key: &str,
) -> Result<bool, Stop> {
    let at = |open: &[Open]| format!("{}.{key}", path_of(open));
    let fault =
        |open: &[Open], reason: String| Err(Stop::Fault(ValidationError::new(at(open), reason)));
    let Some(number) = FIELDS.iter().position(|f| *f == key) else {
        return fault(open, unknown_field(key, &FIELDS));
    };
    let Some(item) = open.last_mut() else {
        return Ok(false);
    };
    if item.seen & (1 << number) != 0 {
        return fault(open, "duplicate field".into());
    }
    item.seen |= 1 << number;
    // The path costs a walk over the open groups, so it is made only for errors.
    let result = match key {
        "name" => part(reader, "").map(|v| item.entry.name = v),
        "visible" => part(reader, "").map(|v| item.entry.visible = v),
        "locked" => part(reader, "").map(|v| item.entry.locked = v),
        "operator" => part(reader, "").map(|v| item.entry.operator.kind = v),
        "blend" => part(reader, "").map(|v| item.entry.operator.blend = v),
        "profile" => part(reader, "").map(|v| item.entry.operator.profile = v),
        "amount" => part(reader, "").map(|v| item.entry.operator.morph_amount = v),
        "ramp" => part(reader, "").map(|v| item.entry.ramp = Some(v)),
        "material" => part(reader, "").map(|v| item.entry.material = Some(v)),
        "modifiers" => part(reader, "").map(|v| item.entry.modifiers = v),
        "keyframes" => part(reader, "").map(|v| item.entry.keyframes = v),
        "shape" => part(reader, "").map(|v| {
            item.entry.kind = NodeKind::Shape(v);
            item.has_shape = true;
        }),
        _ => {
            reader.begin_array()?;
            item.group = Some(scene.append(item.parent, Group::new().into()));
            return Ok(true);
        }
    };
    match result {
        Err(Stop::Fault(fault)) => Err(Stop::Fault(fault.within(&at(open)))),
        other => other.map(|()| false),
    }
}

/// Inserts a complete item into the scene.
fn finish(scene: &mut Scene, item: &mut Open) -> Result<(), ValidationError> {
    item.entry.check()?;
    match (item.group, item.has_shape) {
        (Some(_), true) => Err(ValidationError::new(
            "",
            "a brush has a \"shape\" and a group has \"brushes\": this has both",
        )),
        (None, false) => Err(ValidationError::new(
            "",
            "neither a \"shape\" (a brush) nor \"brushes\" (a group)",
        )),
        (Some(group), false) => {
            let node = &mut scene.nodes[group.index()];
            node.desc = std::mem::replace(&mut item.entry, Group::new().into());
            node.evaluated = pose_of(&node.desc, 0.0);
            Ok(())
        }
        (None, true) => {
            let entry = std::mem::replace(&mut item.entry, Group::new().into());
            scene.append(item.parent, entry);
            Ok(())
        }
    }
}

fn path_of(open: &[Open]) -> String {
    let steps: Vec<_> = open
        .iter()
        .map(|o| format!("brushes[{}]", o.index))
        .collect();
    steps.join(".")
}

/// Most values are shorter than this.
const USUAL_PART_BYTES: usize = 256;

/// Copies the next value and parses it with serde.
fn part<T: DeserializeOwned>(reader: &mut Tokens<'_>, path: &str) -> Result<T, Stop> {
    let mut text = Vec::with_capacity(USUAL_PART_BYTES);
    let mut writer = JsonStreamWriter::new(Limited(&mut text));
    let too_long = || {
        Stop::Fault(ValidationError::new(
            path,
            format!("longer than the limit, {MAX_PART_BYTES} bytes"),
        ))
    };
    match reader.transfer_to(&mut writer) {
        Ok(()) => {}
        Err(TransferError::ReaderError(error)) => return Err(error.into()),
        Err(TransferError::WriterError(_)) => return Err(too_long()),
    }
    writer.finish_document().map_err(|_| too_long())?;
    serde_json::from_slice(&text).map_err(|error| Stop::Fault(explain::<T>(path, &text, &error)))
}

/// A vector that refuses to grow beyond the limit.
pub(crate) struct Limited<'a>(pub &'a mut Vec<u8>);

impl std::io::Write for Limited<'_> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        if self.0.len() + bytes.len() > MAX_PART_BYTES {
            return Err(std::io::Error::other(format!(
                "a value is longer than the limit, {MAX_PART_BYTES} bytes"
            )));
        }
        self.0.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}
