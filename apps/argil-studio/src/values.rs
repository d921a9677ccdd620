//! Editors of JSON values.

use crate::names::humanize;
use eframe::egui::{self, DragValue};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

/// Returns the unit of a key, for the label shown.
fn suffix(name: &str, key: &str) -> &'static str {
    if name.starts_with("Scale") || name.starts_with("Stretch") {
        "×"
    } else if key == "time" {
        " s"
    } else if key == "frequency" {
        " /u"
    } else if key.contains("degrees_per_unit") {
        "°/u"
    } else if key.contains("degrees") {
        "°"
    } else if matches!(
        key,
        "count"
            | "seed"
            | "octaves"
            | "amount"
            | "axis"
            | "normal"
            | "resolution"
            | "irradiance"
            | "intensity"
            | "radiance"
            | "strength"
            | "fade"
            | "density"
            | "falloff"
            | "albedo"
            | "anisotropy"
    ) {
        ""
    } else {
        " u"
    }
}

/// Shows a number to drag or type.
pub(crate) fn number(ui: &mut egui::Ui, name: &str, key: &str, value: &mut f32) -> bool {
    let speed = if key.contains("degrees") {
        0.5
    } else {
        0.005 * value.abs().max(0.4)
    };
    let response = ui.add(
        DragValue::new(value)
            .speed(speed)
            .max_decimals(4)
            // Typed text counts only when it is complete.
            .update_while_editing(false)
            .suffix(suffix(name, key)),
    );
    let name = name.to_owned();
    let current = f64::from(*value);
    response.widget_info(|| {
        let mut info = egui::WidgetInfo::labeled(egui::Role::SpinButton, true, name.clone());
        info.value = Some(current);
        info
    });
    response.changed()
}

/// Shows a value for editing. Returns true if it changed.
fn value_ui(ui: &mut egui::Ui, name: &str, key: &str, value: &mut Value) -> bool {
    match value {
        Value::Bool(on) => ui.checkbox(on, "").changed(),
        Value::Number(n) if n.is_u64() => {
            let mut whole = n.as_u64().unwrap_or(0);
            let changed = ui.add(DragValue::new(&mut whole).speed(0.1)).changed();
            if changed {
                *value = whole.into();
            }
            changed
        }
        Value::Number(n) => {
            let mut single = n.as_f64().unwrap_or(0.0) as f32;
            let changed = number(ui, name, key, &mut single);
            if changed {
                *value = single.into();
            }
            changed
        }
        Value::Array(all) => {
            let axes = ["x", "y", "z", "w"];
            let mut changed = false;
            let is_flat = all.iter().all(|v| !v.is_array() && !v.is_object());
            let mut each = |ui: &mut egui::Ui| {
                for (i, entry) in all.iter_mut().enumerate() {
                    let axis = axes.get(i).copied().unwrap_or("");
                    let name = format!("{name} {axis}");
                    changed |= ui.push_id(i, |ui| value_ui(ui, &name, key, entry)).inner;
                }
            };
            if is_flat {
                ui.horizontal_wrapped(each);
            } else {
                ui.vertical(|ui| each(ui));
            }
            changed
        }
        Value::Object(map) => ui.vertical(|ui| fields(ui, name, map, |_| None)).inner,
        Value::String(text) if key == "text" => ui.text_edit_multiline(text).changed(),
        Value::String(text) => ui.text_edit_singleline(text).changed(),
        Value::Null => {
            ui.weak("–");
            false
        }
    }
}

/// Shows the values of something for editing, and takes those that can be read. Choices among words are not shown.
pub(crate) fn edit_fields<'a, T: Serialize + DeserializeOwned>(
    ui: &mut egui::Ui,
    name: &str,
    value: &mut T,
    docs: impl Fn(&str) -> Option<&'a str>,
) {
    let Ok(Value::Object(mut map)) = serde_json::to_value(&*value) else {
        return;
    };
    let words = ["mapping"].map(|key| (key, map.remove(key)));
    if !fields(ui, name, &mut map, docs) {
        return;
    }
    for (key, word) in words {
        if let Some(word) = word {
            map.insert(key.to_owned(), word);
        }
    }
    // Incomplete text is not a value yet.
    if let Ok(changed) = serde_json::from_value(Value::Object(map)) {
        *value = changed;
    }
}

/// Shows all values of an object except its type.
pub(crate) fn fields<'a>(
    ui: &mut egui::Ui,
    within: &str,
    map: &mut Map<String, Value>,
    docs: impl Fn(&str) -> Option<&'a str>,
) -> bool {
    let mut changed = false;
    for (key, value) in map.iter_mut().filter(|(key, _)| *key != "type") {
        ui.push_id(key, |ui| {
            ui.horizontal(|ui| {
                let spoken = humanize(key);
                let label = ui.label(&spoken);
                if let Some(text) = docs(key) {
                    label.on_hover_text(text);
                }
                let name = format!("{within} {}", spoken.to_lowercase());
                changed |= value_ui(ui, name.trim(), key, value);
            });
        });
    }
    changed
}
