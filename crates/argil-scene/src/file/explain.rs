//! What is wrong with a file, and where.

use super::tokens::{Source, Tokens, tokens};
use crate::ValidationError;
use serde::de::DeserializeOwned;
use serde_json::Value;
use struson::reader::{JsonReader, ReaderError, SyntaxErrorKind, ValueType};

/// Name the member that serde's error is about: the one without which serde only misses it. (Tagged enums are read
/// through a buffer, which forgets where it was.)
pub(super) fn explain<T: DeserializeOwned>(
    path: &str,
    text: &[u8],
    error: &serde_json::Error,
) -> ValidationError {
    let message = error.to_string();
    let reason = message.split(" at line ").next().unwrap_or_default();
    let mut fault = ValidationError::new("", reason);
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
pub(super) fn complaint<T: DeserializeOwned>(value: Value) -> Option<String> {
    let error = serde_json::from_slice::<T>(value.to_string().as_bytes())
        .err()?
        .to_string();
    // The place is one in a text that nobody has written.
    Some(error.split(" at line ").next().unwrap_or(&error).to_owned())
}

/// The member without which there is no complaint, or only that it is missing.
pub(super) fn culprit(
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
pub(super) fn locate(source: Source<'_>, path: &str) -> (u64, u64) {
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
pub(super) fn position(reader: &Tokens<'_>) -> (u64, u64) {
    reader
        .current_position(false)
        .line_pos
        .map_or((1, 1), |p| (p.line + 1, p.column + 1))
}

pub(super) fn enter_array(reader: &mut Tokens<'_>, index: usize) -> Result<bool, ReaderError> {
    if reader.peek()? != ValueType::Array {
        return Ok(false);
    }
    reader.begin_array()?;
    for _ in 0..index {
        reader.skip_value()?;
    }
    reader.has_next()
}

/// Former names of members, which files of earlier versions have, and their names now.
const RENAMED: &[(&str, &str)] = &[
    ("frame", "bounds"),
    ("look", "look_at"),
    ("pieces", "segments"),
];

/// Enter the first member whose name the path begins with, and take that off the path. Names may hold dots and brackets:
/// what follows the name must be the path's end or a new step.
pub(super) fn enter_object(reader: &mut Tokens<'_>, path: &mut &str) -> Result<bool, ReaderError> {
    if reader.peek()? != ValueType::Object {
        return Ok(false);
    }
    reader.begin_object()?;
    while reader.has_next()? {
        let name = reader.next_name()?;
        let now = RENAMED.iter().find(|(former, _)| *former == name);
        if let Some(after) = path
            .strip_prefix(name)
            .or_else(|| path.strip_prefix(now?.1))
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
pub(super) fn in_words(name: &str) -> String {
    let mut words = String::new();
    for c in name.chars() {
        if c.is_uppercase() && !words.is_empty() {
            words.push(' ');
        }
        words.extend(c.to_lowercase());
    }
    words
}

pub(super) fn describe(error: &ReaderError) -> String {
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
