//! Reading: a walk over the document's tokens with a stack on the heap.

use super::error::{FORMAT_VERSION, FileError, MAX_DEPTH, MAX_PART_BYTES, fault_of};
use crate::node::pose_of;
use crate::{Body, Entry, Fault, Group, NodeId, Scene};
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::cell::Cell;
use std::io::Read;
use std::path::Path;
use std::rc::Rc;
use struson::reader::{
    JsonReader, JsonStreamReader, ReaderError, ReaderSettings, SyntaxErrorKind, TransferError,
    ValueType,
};
use struson::writer::{JsonStreamWriter, JsonWriter};

/// What stopped the reading.
enum Stop {
    /// A value that can be read but not used, with its path from the document's root.
    Fault(Fault),
    /// Not the JSON that was expected; the reader knows where.
    Reader(ReaderError),
    Newer(u64),
}

impl From<ReaderError> for Stop {
    fn from(error: ReaderError) -> Self {
        Self::Reader(error)
    }
}

type Tokens<'a> = JsonStreamReader<Metered<'a>>;

/// Where bytes come from. Of one type, so that all that reads is compiled once.
pub(super) type Source<'a> = Box<dyn Read + 'a>;

/// A source that refuses to give more than a part's length between two marks: names and numbers have no limit of their
/// own.
struct Metered<'a> {
    source: Source<'a>,
    meter: Option<Meter>,
    /// What was read of the source's beginning, to see whether it is a byte order mark, and is still to be given.
    head: Option<Vec<u8>>,
}

/// What some editors put before UTF-8.
pub(super) const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// Bytes since the last mark.
#[derive(Clone, Default)]
struct Meter(Rc<Cell<usize>>);

impl Meter {
    fn mark(&self) {
        self.0.set(0);
    }
}

impl Read for Metered<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        if self.head.is_none() {
            let mut head = Vec::new();
            let length = BYTE_ORDER_MARK.len() as u64;
            (&mut self.source).take(length).read_to_end(&mut head)?;
            if head == BYTE_ORDER_MARK {
                head.clear();
            }
            self.head = Some(head);
        }
        let count = match &mut self.head {
            Some(head) if !head.is_empty() => {
                let count = head.len().min(buffer.len());
                buffer[..count].copy_from_slice(&head[..count]);
                head.drain(..count);
                count
            }
            _ => self.source.read(buffer)?,
        };
        let Some(Meter(used)) = &self.meter else {
            return Ok(count);
        };
        used.set(used.get() + count);
        if used.get() > 2 * MAX_PART_BYTES {
            let reason =
                format!("a name or value is longer than the limit, {MAX_PART_BYTES} bytes");
            return Err(std::io::Error::new(std::io::ErrorKind::InvalidData, reason));
        }
        Ok(count)
    }
}

fn tokens<'a>(source: Source<'a>, meter: Option<&Meter>) -> Tokens<'a> {
    let settings = ReaderSettings {
        max_nesting_depth: Some(MAX_DEPTH),
        restrict_number_values: false,
        track_path: false,
        ..ReaderSettings::default()
    };
    JsonStreamReader::new_custom(
        Metered {
            source,
            meter: meter.cloned(),
            head: None,
        },
        settings,
    )
}

/// Read from `source`; `again` opens it anew, to find the line of a fault.
pub(super) fn read<'a>(
    path: &Path,
    source: Source<'a>,
    again: &dyn Fn() -> Result<Source<'a>, FileError>,
) -> Result<Scene, FileError> {
    let content = |line, column, fault| FileError::Content {
        path: path.into(),
        line,
        column,
        fault,
    };
    let meter = Meter::default();
    let mut reader = tokens(source, Some(&meter));
    match document(&mut reader, &meter) {
        Ok(scene) => {
            let (line, column) = position(&reader);
            let follows = |_| {
                content(
                    line,
                    column,
                    Fault::new("", "something follows the scene's closing brace"),
                )
            };
            reader.consume_trailing_whitespace().map_err(follows)?;
            Ok(scene)
        }
        Err(Stop::Newer(found)) => Err(FileError::Newer {
            path: path.into(),
            found,
        }),
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
            Err(content(line, column, Fault::new("", describe(&error))))
        }
        Err(Stop::Fault(fault)) => {
            let (line, column) = locate(again()?, &fault.path);
            Err(content(line, column, fault))
        }
    }
}

fn document(reader: &mut Tokens<'_>, meter: &Meter) -> Result<Scene, Stop> {
    let mut scene = Scene::new();
    let fault = |path: &str, reason: &str| Err(Stop::Fault(Fault::new(path, reason)));
    if reader.peek()? != ValueType::Object {
        return fault("", "a scene file holds one JSON object, {\"argil\": 1, …}");
    }
    reader.begin_object()?;
    if !reader.has_next()? || reader.next_name()? != "argil" {
        return fault(
            "",
            "not a scene: the first field must be \"argil\", the version of the format",
        );
    }
    let version: Value = part(reader, "argil")?;
    match version.as_u64() {
        Some(n) if n > u64::from(FORMAT_VERSION) => return Err(Stop::Newer(n)),
        Some(1..) => {}
        _ => {
            return fault(
                "argil",
                &format!("{version} is not a version of the format"),
            );
        }
    }
    let mut brushes_read = false;
    let mut seen: Vec<String> = Vec::new();
    while reader.has_next()? {
        meter.mark();
        let key = reader.next_name_owned()?;
        if seen.contains(&key) {
            return fault(&key, "this field stands twice");
        }
        match key.as_str() {
            "name" => scene.name = part(reader, "name")?,
            "credit" => scene.credit = part(reader, "credit")?,
            "view" => {
                scene.view = part(reader, "view")?;
                scene
                    .view
                    .check()
                    .map_err(|f| Stop::Fault(f.within("view")))?;
            }
            "materials" if brushes_read => {
                return fault("materials", "materials must come before the brushes");
            }
            "materials" => materials(reader, meter, &mut scene)?,
            "brushes" => {
                brushes(reader, meter, &mut scene)?;
                brushes_read = true;
            }
            other => {
                return fault(
                    other,
                    "unknown field, expected one of `name`, `credit`, `view`, `materials`, `brushes`",
                );
            }
        }
        seen.push(key);
    }
    if !brushes_read {
        return fault("", "the field \"brushes\" is missing");
    }
    reader.end_object()?;
    Ok(scene)
}

fn materials(reader: &mut Tokens<'_>, meter: &Meter, scene: &mut Scene) -> Result<(), Stop> {
    reader.begin_object()?;
    while reader.has_next()? {
        meter.mark();
        let name = reader.next_name_owned()?;
        let path = format!("materials.{name}");
        if scene.materials.contains_key(&name) {
            return Err(Stop::Fault(Fault::new(
                path,
                "a material of this name stands above",
            )));
        }
        let material = part(reader, &path)?;
        scene
            .set_material(name, material)
            .map_err(|f| Stop::Fault(f.within("materials")))?;
    }
    Ok(reader.end_object()?)
}

/// An item that is open: its fields so far, and its node once it is known to be a group.
struct Open {
    /// The group that the item belongs to, and its index there.
    parent: NodeId,
    index: usize,
    entry: Entry,
    group: Option<NodeId>,
    has_shape: bool,
    seen: u32,
}

const FIELDS: [&str; 12] = [
    "name",
    "visible",
    "locked",
    "operator",
    "blend",
    "profile",
    "amount",
    "material",
    "modifiers",
    "keyframes",
    "shape",
    "brushes",
];

fn brushes(reader: &mut Tokens<'_>, meter: &Meter, scene: &mut Scene) -> Result<(), Stop> {
    reader.begin_array()?;
    let mut open: Vec<Open> = Vec::new();
    // Whether the next token is in a list of items; else it is in the item on top.
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
                // The list ends: back to the group it belongs to, or done.
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

/// Read one field of the item on top; whether it began a list of items.
fn field(
    reader: &mut Tokens<'_>,
    scene: &mut Scene,
    open: &mut [Open],
    key: &str,
) -> Result<bool, Stop> {
    let at = |open: &[Open]| format!("{}.{key}", path_of(open));
    let fault = |open: &[Open], reason: String| Err(Stop::Fault(Fault::new(at(open), reason)));
    let Some(number) = FIELDS.iter().position(|f| *f == key) else {
        return fault(
            open,
            format!("unknown field, expected one of `{}`", FIELDS.join("`, `")),
        );
    };
    let Some(item) = open.last_mut() else {
        return Ok(false);
    };
    if item.seen & (1 << number) != 0 {
        return fault(open, "this field stands twice".into());
    }
    item.seen |= 1 << number;
    // The path costs a walk over the open groups: made only when something is wrong.
    let result = match key {
        "name" => part(reader, "").map(|v| item.entry.name = v),
        "visible" => part(reader, "").map(|v| item.entry.visible = v),
        "locked" => part(reader, "").map(|v| item.entry.locked = v),
        "operator" => part(reader, "").map(|v| item.entry.operator.kind = v),
        "blend" => part(reader, "").map(|v| item.entry.operator.blend = v),
        "profile" => part(reader, "").map(|v| item.entry.operator.profile = v),
        "amount" => part(reader, "").map(|v| item.entry.operator.amount = v),
        "material" => part(reader, "").map(|v| item.entry.material = Some(v)),
        "modifiers" => part(reader, "").map(|v| item.entry.modifiers = v),
        "keyframes" => part(reader, "").map(|v| item.entry.keyframes = v),
        "shape" => part(reader, "").map(|v| {
            item.entry.body = Body::Shape(v);
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

/// Put a closed item into the scene.
fn finish(scene: &mut Scene, item: &mut Open) -> Result<(), Fault> {
    scene.check_entry(&item.entry).map_err(fault_of)?;
    match (item.group, item.has_shape) {
        (Some(_), true) => Err(Fault::new(
            "",
            "a brush has a \"shape\" and a group has \"brushes\": this has both",
        )),
        (None, false) => Err(Fault::new(
            "",
            "neither a \"shape\" (a brush) nor \"brushes\" (a group)",
        )),
        (Some(group), false) => {
            let node = &mut scene.nodes[group.index()];
            node.entry = std::mem::replace(&mut item.entry, Group::new().into());
            node.posed = pose_of(&node.entry, 0.0);
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

/// Most values are shorter.
const USUAL_PART_BYTES: usize = 256;

/// Copy the next value out and let serde read it.
fn part<T: DeserializeOwned>(reader: &mut Tokens<'_>, path: &str) -> Result<T, Stop> {
    let mut text = Vec::with_capacity(USUAL_PART_BYTES);
    let mut writer = JsonStreamWriter::new(Limited(&mut text));
    let too_long = || {
        Stop::Fault(Fault::new(
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

/// Name the member that serde's error is about: the one without which serde only misses it. (Tagged enums are read
/// through a buffer, which forgets where it was.)
fn explain<T: DeserializeOwned>(path: &str, text: &[u8], error: &serde_json::Error) -> Fault {
    let message = error.to_string();
    let reason = message.split(" at line ").next().unwrap_or_default();
    let mut fault = Fault::new("", reason);
    if reason.starts_with("missing field") {
        return fault.within(path);
    }
    match serde_json::from_slice(text) {
        Ok(Value::Object(members)) => {
            fault.path =
                culprit(&members, |m| complaint::<T>(Value::Object(m))).unwrap_or_default();
        }
        Ok(Value::Array(elements)) => {
            // The first element that cannot stand alone in a list.
            let alone = |v: Value| complaint::<T>(Value::Array(vec![v]));
            if let Some((index, element)) = elements
                .into_iter()
                .enumerate()
                .find(|(_, v)| alone(v.clone()).is_some())
            {
                fault.reason = alone(element.clone()).unwrap_or_default();
                if let Value::Object(members) = element
                    && !fault.reason.starts_with("missing field")
                {
                    fault.path = culprit(&members, |m| alone(Value::Object(m))).unwrap_or_default();
                }
                fault = fault.within(&format!("[{index}]"));
            }
        }
        _ => {}
    }
    fault.within(path)
}

/// What serde says against a value.
fn complaint<T: DeserializeOwned>(value: Value) -> Option<String> {
    let error = serde_json::from_slice::<T>(value.to_string().as_bytes())
        .err()?
        .to_string();
    // The place is one in a text that nobody has written.
    Some(error.split(" at line ").next().unwrap_or(&error).to_owned())
}

/// The member without which there is no complaint, or only that it is missing.
fn culprit(
    members: &serde_json::Map<String, Value>,
    complaint: impl Fn(serde_json::Map<String, Value>) -> Option<String>,
) -> Option<String> {
    let without = |key: &str| {
        let mut rest = members.clone();
        rest.remove(key);
        complaint(rest)
    };
    let missed = |key: &&String| {
        without(key).is_some_and(|c| c.starts_with(&format!("missing field `{key}`")))
    };
    members
        .keys()
        .find(|key| without(key).is_none())
        .or_else(|| members.keys().find(missed))
        .cloned()
}

/// Line and column, from 1, of the value at a path, or of the deepest part of the path that is there.
fn locate(source: Source<'_>, path: &str) -> (u64, u64) {
    // The first pass has held this part of the file against the limits.
    let mut reader = tokens(source, None);
    let mut rest = path;
    while !rest.is_empty() {
        let entered = match rest.strip_prefix('[').and_then(|r| r.split_once(']')) {
            Some((index, after)) => {
                rest = after;
                enter_array(&mut reader, index.parse().unwrap_or(0))
            }
            None => enter_object(&mut reader, &mut rest),
        };
        if !matches!(entered, Ok(true)) {
            // Not further along the path: the place reached so far is near enough.
            return position(&reader);
        }
        rest = rest.strip_prefix('.').unwrap_or(rest);
    }
    // Peeking skips the blanks before the value.
    let _ = reader.peek();
    position(&reader)
}

/// Line and column of the reader, from 1.
fn position(reader: &Tokens<'_>) -> (u64, u64) {
    reader
        .current_position(false)
        .line_pos
        .map_or((1, 1), |p| (p.line + 1, p.column + 1))
}

fn enter_array(reader: &mut Tokens<'_>, index: usize) -> Result<bool, ReaderError> {
    if reader.peek()? != ValueType::Array {
        return Ok(false);
    }
    reader.begin_array()?;
    for _ in 0..index {
        reader.skip_value()?;
    }
    reader.has_next()
}

/// Enter the first member whose name the path begins with, and take that off the path. Names may hold dots and brackets:
/// what follows the name must be the path's end or a new step.
fn enter_object(reader: &mut Tokens<'_>, path: &mut &str) -> Result<bool, ReaderError> {
    if reader.peek()? != ValueType::Object {
        return Ok(false);
    }
    reader.begin_object()?;
    while reader.has_next()? {
        let name = reader.next_name()?;
        if let Some(after) = path
            .strip_prefix(name)
            .filter(|a| a.is_empty() || a.starts_with(['.', '[']))
        {
            *path = after;
            return Ok(true);
        }
        reader.skip_value()?;
    }
    Ok(false)
}

/// `UnexpectedComma` → `unexpected comma`.
fn in_words(name: &str) -> String {
    let mut words = String::new();
    for c in name.chars() {
        if c.is_uppercase() && !words.is_empty() {
            words.push(' ');
        }
        words.extend(c.to_lowercase());
    }
    words
}

fn describe(error: &ReaderError) -> String {
    match error {
        ReaderError::SyntaxError(e) => match e.kind {
            SyntaxErrorKind::IncompleteDocument => {
                "the file ends in the middle: it is cut off".to_owned()
            }
            kind => format!("not JSON here: {}", in_words(&format!("{kind:?}"))),
        },
        ReaderError::UnexpectedValueType {
            expected, actual, ..
        } => format!("expected JSON of type {expected}, found {actual}").to_lowercase(),
        ReaderError::MaxNestingDepthExceeded {
            max_nesting_depth, ..
        } => {
            format!("values nest deeper than the limit, {max_nesting_depth}")
        }
        ReaderError::IoError { error, .. } => error.to_string(),
        other => other.to_string(),
    }
}
