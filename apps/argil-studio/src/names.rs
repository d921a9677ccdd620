//! What to call what a scene holds.

use argil::{Body, Entry, Shape};

/// An entry's name, or what it is.
pub fn name_of(entry: &Entry) -> String {
    if !entry.name.is_empty() {
        return entry.name.clone();
    }
    match &entry.body {
        Body::Group => "Group".into(),
        Body::Shape(shape) => shape_name(shape),
    }
}

/// What a shape is, such as `Round cone`.
pub fn shape_name(shape: &Shape) -> String {
    let mut words = String::new();
    for (i, letter) in shape.kind().chars().enumerate() {
        if i > 0 && letter.is_uppercase() {
            words.push(' ');
        }
        words.push(if i > 0 {
            letter.to_ascii_lowercase()
        } else {
            letter
        });
    }
    words
}

/// A key such as `half_size` in words.
pub fn spoken(key: &str) -> String {
    let text = key.replace('_', " ");
    let mut letters = text.chars();
    match letters.next() {
        Some(first) => first.to_uppercase().chain(letters).collect(),
        None => text,
    }
}
