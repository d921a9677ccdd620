//! What wide scenes share: random numbers, instances, materials, and text.

use serde_json::{Value, json};

/// A sequence of numbers from 0 to 1 (xorshift, Marsaglia 2003).
pub(crate) struct Random(pub(crate) u32);

impl Random {
    pub(crate) fn next(&mut self) -> f32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        (self.0 >> 8) as f32 / 16_777_216.0
    }

    pub(crate) fn within(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.next()
    }

    pub(crate) fn choice(&mut self, values: &[f32]) -> f32 {
        values[((self.next() * values.len() as f32) as usize).min(values.len() - 1)]
    }
}

/// Replaces numbers by the shortest ones that are the same as `f32`.
pub(crate) fn shorten(value: &mut Value) {
    match value {
        Value::Number(number) if number.is_f64() => {
            let single = number.as_f64().unwrap_or_default() as f32;
            let short: Result<f64, _> = single.to_string().parse();
            *value = json!(short.unwrap_or_default());
        }
        Value::Array(all) => all.iter_mut().for_each(shorten),
        Value::Object(all) => all.values_mut().for_each(shorten),
        _ => {}
    }
}

/// Writes a scene with one line for each of the outermost brushes. Materials come before the brushes that name them.
pub(crate) fn lines_of(scene: &Value) -> String {
    let keys = ["argil", "name", "view", "materials", "brushes"];
    let fields = keys.iter().map(|&key| match &scene[key] {
        Value::Array(brushes) => {
            let lines: Vec<String> = brushes.iter().map(|brush| format!("    {brush}")).collect();
            format!("  {key:?}: [\n{}\n  ]", lines.join(",\n"))
        }
        value => format!("  {key:?}: {value}"),
    });
    let fields: Vec<String> = fields.collect();
    format!("{{\n{}\n}}\n", fields.join(",\n"))
}

pub(crate) fn translate(by: [f32; 3]) -> Value {
    json!({ "type": "translate", "by": by })
}

pub(crate) fn instances(name: &str, brushes: Vec<Value>, poses: &[[f32; 5]]) -> Value {
    json!({ "name": name, "brushes": brushes, "modifiers": [{ "type": "instances", "poses": poses }] })
}

pub(crate) fn materials() -> Value {
    let plain = |base_color: [f32; 3], roughness: f32| json!({ "base_color": base_color, "roughness": roughness });
    json!({
        "grass": plain([0.2, 0.3, 0.1], 0.95),
        "rock": plain([0.36, 0.33, 0.3], 0.9),
        "water": plain([0.06, 0.15, 0.18], 0.1),
        "bark": plain([0.2, 0.13, 0.08], 0.9),
        "needles": plain([0.07, 0.17, 0.08], 0.9),
        "leaf": plain([0.15, 0.28, 0.07], 0.85),
        "plaster": plain([0.75, 0.7, 0.6], 0.8),
        "tile": plain([0.5, 0.2, 0.12], 0.7),
    })
}
