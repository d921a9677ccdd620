//! Finds what is wrong with a file, and where.

use super::tokens::{ByteSource, Tokens, tokens};
use crate::ValidationError;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::cell::Cell;
use struson::reader::{JsonReader, ReaderError, SyntaxErrorKind, ValueType};

/// Finds the member that serde's error is about: without it, serde only misses it. Serde reads tagged enums through
/// a buffer, which loses the place.
pub(super) fn explain<T: DeserializeOwned>(
    path: &str,
    text: &[u8],
    error: &serde_json::Error,
) -> ValidationError {
    let message = error.to_string();
    let reason = message.split(" at line ").next().unwrap_or_default();
    let mut fault = ValidationError::new("", plain(reason));
    let misses = reason.starts_with("missing field");
    let search = Search::new(text.len());
    let root = serde_json::from_slice(text);
    if let Ok(root) = &root
        && let Some(way) = unknown_member::<T>(root, reason, &search)
    {
        fault.path = path_of(&way);
        return fault.within(path);
    }
    match root {
        Ok(root @ Value::Object(_)) => {
            fault.path = path_of(&deepest::<T>(&root, misses, &search));
        }
        _ if misses => {}
        Ok(Value::Array(elements)) => {
            // The first element that is invalid by itself.
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
                    let culprit_path = culprit(&members, &search, |m| alone(Value::Object(m)));
                    fault.path = culprit_path.unwrap_or_default();
                }
                fault = fault.within(&format!("[{index}]"));
            }
        }
        _ => {}
    }
    fault.within(path)
}

/// Returns the column of what serde's error about a line is about, from 1, and what is wrong there.
pub(crate) fn explain_line<T: DeserializeOwned>(
    line: &str,
    error: &serde_json::Error,
) -> (u64, ValidationError) {
    let fault = explain::<T>("", line.as_bytes(), error);
    let (_, column) = locate(Box::new(line.as_bytes()), &fault);
    (column, fault)
}

/// Returns a reason without words of Rust, and with the nearest of the names that are expected.
fn plain(reason: &str) -> String {
    if let Some((before, _)) = reason.split_once("expected internally tagged enum ") {
        return format!("{before}expected an object with a \"type\"");
    }
    let mut quoted = reason.split('`').skip(1).step_by(2);
    let name = quoted.next().unwrap_or_default();
    match reason.starts_with("unknown ") {
        true => format!("{reason}{}", nearest(name, quoted)),
        false => reason.to_owned(),
    }
}

/// Asks whether the known name was meant that is nearest to another one, if one is near.
fn nearest<'a>(unknown: &str, known: impl Iterator<Item = &'a str>) -> String {
    let ratings = known.map(|name| (strsim::normalized_damerau_levenshtein(unknown, name), name));
    let best = ratings.max_by(|(a, _), (b, _)| a.total_cmp(b));
    match best {
        Some((rating, name)) if rating >= 0.5 => format!("; did you mean `{name}`?"),
        _ => String::new(),
    }
}

/// Returns the reason why a field is refused.
pub(super) fn unknown_field(name: &str, known: &[&str]) -> String {
    let hint = nearest(name, known.iter().copied());
    format!(
        "unknown field `{name}`, expected one of `{}`{hint}",
        known.join("`, `")
    )
}

/// Bytes that are read again to find a fault: in all, and per byte of the text.
const MAX_WORK: (usize, usize) = (1 << 25, 8);

/// What is left of the work to find a fault.
struct Search {
    tries: Cell<usize>,
}

impl Search {
    fn new(bytes: usize) -> Self {
        let (all, per_byte) = MAX_WORK;
        let tries = Cell::new(per_byte + all / bytes.max(1));
        Self { tries }
    }

    /// Whether the text may be read once more.
    fn goes_on(&self) -> bool {
        let left = self.tries.get().checked_sub(1);
        self.tries.set(left.unwrap_or(0));
        left.is_some()
    }
}

/// Returns the way to the member or the name that an error calls unknown: the first one without which the error is another.
fn unknown_member<T: DeserializeOwned>(
    root: &Value,
    reason: &str,
    search: &Search,
) -> Option<Vec<Step>> {
    let field = reason.strip_prefix("unknown field `");
    let variant = reason.strip_prefix("unknown variant `");
    let name = field.or(variant)?.split('`').next()?;
    let is_named = |step: &Step, value: Option<&Value>| match field {
        Some(_) => *step == Step::Name(name.to_owned()),
        None => value.and_then(Value::as_str) == Some(name),
    };
    let (mut candidates, mut open) = (Vec::new(), vec![Vec::new()]);
    while let Some(way) = open.pop() {
        let inner = at(root, &way)?;
        let steps: Vec<Step> = match inner {
            Value::Object(members) => members.keys().cloned().map(Step::Name).collect(),
            Value::Array(elements) if elements.len() <= MAX_SEARCHED => {
                (0..elements.len()).map(Step::Index).collect()
            }
            _ => continue,
        };
        for step in steps {
            let way = [&way[..], std::slice::from_ref(&step)].concat();
            if is_named(&step, at(root, &way)) {
                candidates.push(way.clone());
            }
            open.push(way);
        }
    }
    let is_it = |way: &Vec<Step>| {
        search.goes_on() && complaint::<T>(without(root, way)).as_deref() != Some(reason)
    };
    candidates.into_iter().find(is_it)
}

/// Returns the value at the end of a way.
fn at<'a>(root: &'a Value, way: &[Step]) -> Option<&'a Value> {
    way.iter().try_fold(root, |value, step| match step {
        Step::Name(name) => value.get(name),
        Step::Index(index) => value.get(index),
    })
}

/// A step from a value to one in it.
#[derive(Clone, Debug, PartialEq)]
enum Step {
    Name(String),
    Index(usize),
}

/// Members that tell what the others are.
const KINDS: &[&str] = &["type", "edit"];

/// Lists longer than this are not searched.
const MAX_SEARCHED: usize = 256;

/// Returns the way to the deepest value without which serde accepts the whole, or only misses that value. If the whole `misses` a
/// field, only the first counts.
fn deepest<T: DeserializeOwned>(root: &Value, misses: bool, search: &Search) -> Vec<Step> {
    let mut steps = Vec::new();
    loop {
        let next: Vec<Step> = match at(root, &steps) {
            Some(Value::Object(members)) => {
                // Whether members keep their order depends on features that others turn on.
                let mut names: Vec<String> = members.keys().cloned().collect();
                // Without its kind, everything misses that first.
                names.sort_unstable_by_key(|name| (KINDS.contains(&&**name), name.clone()));
                names.into_iter().map(Step::Name).collect()
            }
            Some(Value::Array(elements)) if elements.len() <= MAX_SEARCHED => {
                (0..elements.len()).map(Step::Index).collect()
            }
            _ => return steps,
        };
        let complaint_without = |step: &Step| {
            let way = [&steps[..], std::slice::from_ref(step)].concat();
            complaint::<T>(without(root, &way))
        };
        let is_accepted = |step: &&Step| search.goes_on() && complaint_without(step).is_none();
        let accepted = next.iter().find(is_accepted);
        let missed = || {
            next.iter().find(|step| match step {
                Step::Name(name) if search.goes_on() => complaint_without(step)
                    .is_some_and(|c| c.starts_with(&format!("missing field `{name}`"))),
                _ => false,
            })
        };
        let cause = accepted.or_else(|| if misses { None } else { missed() });
        match cause {
            Some(step) => steps.push(step.clone()),
            None => return steps,
        }
    }
}

/// Returns a value without one that is in it.
fn without(root: &Value, way: &[Step]) -> Value {
    let mut root = root.clone();
    let Some((last, before)) = way.split_last() else {
        return root;
    };
    let mut inner = Some(&mut root);
    for step in before {
        inner = inner.and_then(|value| match step {
            Step::Name(name) => value.get_mut(name),
            Step::Index(index) => value.get_mut(index),
        });
    }
    match (inner, last) {
        (Some(Value::Object(members)), Step::Name(name)) => drop(members.remove(name)),
        (Some(Value::Array(elements)), Step::Index(index)) if *index < elements.len() => {
            drop(elements.remove(*index));
        }
        _ => {}
    }
    root
}

fn path_of(steps: &[Step]) -> String {
    let mut path = String::new();
    for step in steps {
        match step {
            Step::Name(name) if path.is_empty() => path.push_str(name),
            Step::Name(name) => path.extend([".", name]),
            Step::Index(index) => path += &format!("[{index}]"),
        }
    }
    path
}

/// Returns serde's complaint about a value.
fn complaint<T: DeserializeOwned>(value: Value) -> Option<String> {
    let error = serde_json::from_slice::<T>(value.to_string().as_bytes())
        .err()?
        .to_string();
    // Its place refers to text that no user wrote.
    Some(error.split(" at line ").next().unwrap_or(&error).to_owned())
}

/// Returns the member without which serde accepts the value, or only misses the member. By their names, because whether
/// members keep their order depends on features that others turn on, and without its type a shape misses that first.
fn culprit(
    members: &serde_json::Map<String, Value>,
    search: &Search,
    complaint: impl Fn(serde_json::Map<String, Value>) -> Option<String>,
) -> Option<String> {
    let without = |key: &str| {
        let rest = members.iter().filter(|(name, _)| *name != key);
        let mut rest: Vec<_> = rest
            .map(|(name, value)| (name.clone(), value.clone()))
            .collect();
        rest.sort_unstable_by(|(a, _), (b, _)| a.cmp(b));
        complaint(rest.into_iter().collect())
    };
    let missed =
        |key: &str| without(key).is_some_and(|c| c.starts_with(&format!("missing field `{key}`")));
    let mut names: Vec<&String> = members.keys().collect();
    names.sort_unstable();
    let is_accepted = |key: &&&String| search.goes_on() && without(key).is_none();
    let accepted = names.iter().find(is_accepted);
    accepted
        .or_else(|| {
            let is_missed = |key: &&&String| search.goes_on() && missed(key);
            names.iter().find(is_missed)
        })
        .map(|key| (*key).clone())
}

/// Returns line and column, from 1, of the value that is at fault, or of its name if that is unknown. If there is none, it is
/// the deepest part of the path that exists.
pub(super) fn locate(source: ByteSource<'_>, fault: &ValidationError) -> (u64, u64) {
    let is_unknown = fault.reason.starts_with("unknown field");
    // The first pass already checked this part against the limits.
    let mut reader = tokens(source, None);
    let mut rest = &*fault.path;
    let mut name_at = None;
    while !rest.is_empty() {
        let entered = match rest.strip_prefix('[').and_then(|r| r.split_once(']')) {
            Some((index, after)) => {
                rest = after;
                enter_array(&mut reader, index.parse().unwrap_or(0))
            }
            None => enter_object(&mut reader, &mut rest).map(|name_position| {
                name_at = name_position;
                name_position.is_some()
            }),
        };
        if !matches!(entered, Ok(true)) {
            // The path ends here: this place is close enough.
            return position(&reader);
        }
        rest = rest.strip_prefix('.').unwrap_or(rest);
    }
    if let Some(name_at) = name_at.filter(|_| is_unknown) {
        return name_at;
    }
    // Peeking skips white space before the value.
    let _ = reader.peek();
    position(&reader)
}

/// Returns the reader's line and column, from 1.
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

/// Former names of members, in files of earlier versions, with their current names.
const RENAMED: &[(&str, &str)] = &[
    ("frame", "bounds"),
    ("look", "look_at"),
    ("pieces", "segments"),
];

/// Enters the first member whose name begins the path, and removes it from the path. Names may contain dots and
/// brackets, so the rest must be empty or start a new step. Returns the position of the name.
fn enter_object(
    reader: &mut Tokens<'_>,
    path: &mut &str,
) -> Result<Option<(u64, u64)>, ReaderError> {
    if reader.peek()? != ValueType::Object {
        return Ok(None);
    }
    reader.begin_object()?;
    while reader.has_next()? {
        let name_at = position(reader);
        let name = reader.next_name()?;
        let now = RENAMED.iter().find(|(former, _)| *former == name);
        if let Some(after) = path
            .strip_prefix(name)
            .or_else(|| path.strip_prefix(now?.1))
            .filter(|a| a.is_empty() || a.starts_with(['.', '[']))
        {
            *path = after;
            return Ok(Some(name_at));
        }
        reader.skip_value()?;
    }
    Ok(None)
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
                "unexpected end of file: it is truncated".to_owned()
            }
            SyntaxErrorKind::CommentsNotEnabled => {
                "JSON has no comments: remove it, or write it into a \"name\" or \"credit\""
                    .to_owned()
            }
            SyntaxErrorKind::TrailingCommaNotEnabled => {
                "JSON has no comma after the last value: remove it".to_owned()
            }
            kind => format!("invalid JSON: {}", in_words(&format!("{kind:?}"))),
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
