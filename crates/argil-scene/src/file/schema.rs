//! The shape of a scene file as a whole.

use super::document::Item;
use crate::{Material, View};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;

/// A scene file of Argil.
#[derive(Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Document {
    /// Version of the format; must come first.
    #[schemars(range(min = 1, max = 1))]
    pub argil: u32,
    /// A name for people.
    #[serde(default)]
    pub name: String,
    /// Where the scene or its parts come from.
    #[serde(default)]
    pub credit: String,
    /// How the scene is meant to be looked at.
    #[serde(default)]
    pub view: View,
    /// Materials by name; must come before the brushes that use them.
    #[serde(default)]
    pub materials: BTreeMap<String, Material>,
    /// Brushes and groups in order.
    pub brushes: Vec<Item>,
}

/// The JSON schema of scene files, as text.
///
/// # Panics
/// Never: every type of the schema serializes.
pub fn schema() -> String {
    let schema = schemars::schema_for!(Document);
    serde_json::to_string_pretty(&schema).expect("a schema is JSON") + "\n"
}
