//! Display names.

use argil::scene::{Modifier, NodeDesc, NodeKind, Shape};

/// Returns a node's name, or its kind.
pub(crate) fn name_of(entry: &NodeDesc) -> String {
    if !entry.name.is_empty() {
        return entry.name.clone();
    }
    match &entry.kind {
        NodeKind::Group => "Group".into(),
        NodeKind::Shape(shape) => shape_name(shape),
    }
}

/// Returns the display name of a shape, such as `Round cone`.
pub(crate) fn shape_name(shape: &Shape) -> String {
    in_words(shape.kind())
}

/// Returns the display name of a modifier, such as `Radial repeat`.
pub(crate) fn modifier_name(modifier: &Modifier) -> String {
    in_words(modifier.kind())
}

/// Converts `RoundCone` to `Round cone`.
fn in_words(kind: &str) -> String {
    let mut words = String::new();
    for letter in kind.chars() {
        if letter.is_uppercase() && !words.is_empty() {
            words.push(' ');
            words.push(letter.to_ascii_lowercase());
        } else {
            words.push(letter);
        }
    }
    words
}

/// Converts a key such as `half_size` to words.
pub(crate) fn humanize(key: &str) -> String {
    let text = key.replace('_', " ");
    let mut letters = text.chars();
    match letters.next() {
        Some(first) => first.to_uppercase().chain(letters).collect(),
        None => text,
    }
}
