//! The structure of a scene file.

use super::document::Item;
use crate::{Material, View};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;

/// A scene file of Argil.
#[derive(Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct SceneDocument {
    /// Where editors find this schema. Programs ignore it.
    #[serde(default, rename = "$schema", skip_serializing_if = "String::is_empty")]
    pub schema: String,
    /// Version of the format.
    #[schemars(range(min = 1, max = 1))]
    pub argil: u32,
    /// A human-readable name.
    #[serde(default)]
    pub name: String,
    /// Source and license of the scene or its parts.
    #[serde(default)]
    pub credit: String,
    /// Camera, ground, sun and bounds.
    #[serde(default)]
    pub view: View,
    /// Materials by name.
    #[serde(default)]
    pub materials: BTreeMap<String, Material>,
    /// Brushes and groups in order.
    pub brushes: Vec<Item>,
}

/// Returns the JSON schema of scene files as text.
///
/// # Panics
/// Never: every type of the schema serializes.
pub fn schema() -> String {
    let mut sorted = schemars::schema_for!(SceneDocument).to_value();
    // Whether members keep their order depends on features that others turn on.
    sorted.sort_all_objects();
    let schema = schemars::Schema::try_from(sorted).expect("a schema is an object");
    serde_json::to_string_pretty(&schema).expect("a schema is JSON") + "\n"
}
