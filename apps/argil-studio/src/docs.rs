//! Descriptions of shapes and modifiers, from the file format's schema.

use serde_json::Value;

/// Descriptions of shapes and modifiers, from the file format's schema.
pub(crate) struct Docs(Value);

impl Docs {
    /// Reads the schema.
    pub(crate) fn new() -> Self {
        Self(serde_json::from_str(&argil::scene::schema()).expect("a schema is JSON"))
    }

    /// Returns the description of a parameter, such as `radius` of the `Shape` `sphere`.
    pub(crate) fn of(&self, which: &str, kind: &str, key: &str) -> Option<&str> {
        let kinds = self.0["$defs"][which]["oneOf"].as_array()?;
        let definition = kinds
            .iter()
            .find(|k| k["properties"]["type"]["const"] == kind)?;
        definition["properties"][key]["description"].as_str()
    }

    /// Returns the description of a value, such as `density` of `Fog`.
    pub(crate) fn of_struct(&self, which: &str, key: &str) -> Option<&str> {
        self.0["$defs"][which]["properties"][key]["description"].as_str()
    }
}

impl Default for Docs {
    fn default() -> Self {
        Self::new()
    }
}
