//! Every parameter of what is selected.
//!
//! *Practice.* Shapes and modifiers are shown by what they are in a file, value by value, with what the file's schema says
//! of each: a new shape needs nothing here.

use crate::app::Studio;
use crate::document::{name_of, shape_name, spoken};
use crate::icon::{self, Icon};
use argil::{Body, Entry, Exactness, Material, Modifier, NodeId, OperatorKind, Profile, Shape};
use eframe::egui::{self, DragValue, RichText};
use serde_json::{Map, Value};

/// What the file's schema says of shapes and modifiers.
pub struct Docs(Value);

impl Docs {
    /// Of the schema.
    pub fn new() -> Self {
        Self(serde_json::from_str(&argil::schema()).unwrap_or_default())
    }

    /// What stands at a key of a kind, such as `radius` of the `Shape` `sphere`.
    fn of(&self, which: &str, kind: &str, key: &str) -> Option<&str> {
        let kinds = self.0["$defs"][which]["oneOf"].as_array()?;
        let own = kinds
            .iter()
            .find(|k| k["properties"]["type"]["const"] == kind)?;
        own["properties"][key]["description"].as_str()
    }
}

impl Default for Docs {
    fn default() -> Self {
        Self::new()
    }
}

/// Values that are put in where something is added.
fn new_modifiers() -> Vec<Modifier> {
    vec![
        Modifier::Translate { by: [0.0; 3] },
        Modifier::Rotate {
            axis: [0.0, 1.0, 0.0],
            degrees: 0.0,
        },
        Modifier::Scale { by: 1.0 },
        Modifier::Mirror {
            axes: [true, false, false],
        },
        Modifier::Repeat {
            spacing: [1.5, 0.0, 0.0],
            count: Some([3, 1, 1]),
        },
        Modifier::RadialRepeat { count: 6 },
        Modifier::Elongate {
            by: [0.2, 0.0, 0.0],
        },
        Modifier::Round { radius: 0.05 },
        Modifier::Shell { thickness: 0.03 },
        Modifier::Twist {
            degrees_per_unit: 45.0,
        },
        Modifier::Bend {
            degrees_per_unit: 30.0,
        },
        Modifier::Displace {
            amplitude: 0.05,
            frequency: 4.0,
            seed: 0,
            octaves: 3,
        },
    ]
}

fn modifier_name(modifier: &Modifier) -> String {
    let value = serde_json::to_value(modifier).unwrap_or_default();
    spoken(value["type"].as_str().unwrap_or("modifier"))
}

/// The unit that a key stands for, under the name that it is shown by.
fn suffix(name: &str, key: &str) -> &'static str {
    if name.starts_with("Scale") {
        "×"
    } else if key == "frequency" {
        " /u"
    } else if key.contains("degrees_per_unit") {
        "°/u"
    } else if key.contains("degrees") {
        "°"
    } else if matches!(
        key,
        "count" | "seed" | "octaves" | "amount" | "axis" | "normal" | "resolution"
    ) {
        ""
    } else {
        " u"
    }
}

/// A number to be dragged or typed.
fn number(ui: &mut egui::Ui, name: &str, key: &str, value: &mut f32) -> bool {
    let speed = if key.contains("degrees") {
        0.5
    } else {
        0.005 * value.abs().max(0.4)
    };
    let response = ui.add(
        DragValue::new(value)
            .speed(speed)
            .max_decimals(4)
            // What is typed counts when it is whole.
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

/// Show a value of a file, and let it be changed; whether it was.
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
            let mut own = n.as_f64().unwrap_or(0.0) as f32;
            let changed = number(ui, name, key, &mut own);
            if changed {
                *value = own.into();
            }
            changed
        }
        Value::Array(all) => {
            let axes = ["x", "y", "z", "w"];
            let mut changed = false;
            let is_flat = all.iter().all(|v| !v.is_array() && !v.is_object());
            let mut each = |ui: &mut egui::Ui| {
                for (i, own) in all.iter_mut().enumerate() {
                    let axis = axes.get(i).copied().unwrap_or("");
                    let name = format!("{name} {axis}");
                    changed |= ui.push_id(i, |ui| value_ui(ui, &name, key, own)).inner;
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
        Value::String(text) => ui.text_edit_singleline(text).changed(),
        Value::Null => {
            ui.weak("–");
            false
        }
    }
}

/// All values of an object but its type.
fn fields<'a>(
    ui: &mut egui::Ui,
    within: &str,
    map: &mut Map<String, Value>,
    docs: impl Fn(&str) -> Option<&'a str>,
) -> bool {
    let mut changed = false;
    for (key, value) in map.iter_mut().filter(|(key, _)| *key != "type") {
        ui.push_id(key, |ui| {
            ui.horizontal(|ui| {
                let spoken = spoken(key);
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

impl Studio {
    /// The panel on the right.
    pub(crate) fn right(&mut self, ui: &mut egui::Ui) {
        egui::ScrollArea::vertical()
            .auto_shrink(false)
            .show(ui, |ui| {
                if self.tool == crate::app::Tool::Sculpt {
                    self.sculpt_options(ui);
                    ui.separator();
                }
                match self.document.active() {
                    Some(node) => self.inspect(ui, node),
                    None => {
                        ui.weak("Nothing is selected. Click a brush in the list or in the view.");
                    }
                }
                ui.separator();
                self.materials(ui);
            });
    }

    fn inspect(&mut self, ui: &mut egui::Ui, node: NodeId) {
        let before = self.document.scene().node(node).entry().clone();
        let mut entry = before.clone();
        let name = name_of(&entry);
        ui.horizontal(|ui| {
            ui.strong(&name);
            match &entry.body {
                Body::Shape(shape) => {
                    let (text, why) = match shape.exactness() {
                        Exactness::Exact => ("exact", "Its distance is the Euclidean one."),
                        Exactness::Bound => (
                            "bound",
                            "Its distance is a lower bound of the Euclidean one; its surface is right.",
                        ),
                    };
                    ui.label(RichText::new(text).small().weak())
                        .on_hover_text(why);
                }
                Body::Group => {
                    let count = self.document.scene().node(node).children().len();
                    ui.weak(format!("{count} inside"));
                }
            }
        });
        let count = self.document.selection.len();
        if count > 1 {
            ui.weak(format!("{count} are selected; this is the last of them."));
        }
        let mut done: Option<String> = None;
        self.operator(ui, &mut entry, &mut done);
        if let Body::Shape(shape) = &mut entry.body {
            ui.separator();
            if self.shape(ui, shape) {
                done = Some(format!("Change {}", shape_name(shape).to_lowercase()));
            }
        }
        ui.separator();
        self.modifiers(ui, &mut entry, &mut done);
        if let Some(what) = done
            && entry != before
        {
            if ui.input(|i| i.pointer.any_down()) && !self.document.is_in_stroke() {
                self.document.begin_stroke(&what);
            }
            self.attempt(|s| s.document.replace(&what, node, entry));
        }
    }

    fn operator(&self, ui: &mut egui::Ui, entry: &mut Entry, done: &mut Option<String>) {
        let before = entry.operator;
        let operator = &mut entry.operator;
        ui.horizontal(|ui| {
            ui.label("Operator");
            let kinds = [
                (OperatorKind::Union, "Union"),
                (OperatorKind::Subtract, "Subtract"),
                (OperatorKind::Intersect, "Intersect"),
                (OperatorKind::Paint, "Paint"),
                (OperatorKind::Morph, "Morph"),
            ];
            let shown = kinds.iter().find(|(k, _)| *k == operator.kind);
            egui::ComboBox::from_id_salt("operator")
                .selected_text(shown.map_or("", |(_, word)| word))
                .show_ui(ui, |ui| {
                    for (kind, word) in kinds {
                        ui.selectable_value(&mut operator.kind, kind, word);
                    }
                });
        });
        ui.horizontal(|ui| {
            ui.label("Blend radius");
            number(ui, "Blend radius", "blend", &mut operator.blend);
            operator.blend = operator.blend.max(0.0);
            ui.selectable_value(&mut operator.profile, Profile::Smooth, "smooth");
            ui.selectable_value(&mut operator.profile, Profile::Chamfer, "chamfer");
        });
        if operator.kind == OperatorKind::Morph {
            ui.horizontal(|ui| {
                ui.label("Amount");
                ui.add(egui::Slider::new(&mut operator.amount, 0.0..=1.0));
            });
        }
        if *operator != before {
            *done = Some("Change operator".into());
        }
        ui.horizontal(|ui| {
            ui.label("Material");
            let shown = entry.material.clone().unwrap_or_else(|| "–".into());
            let before = entry.material.clone();
            egui::ComboBox::from_id_salt("material")
                .selected_text(shown)
                .show_ui(ui, |ui| {
                    ui.selectable_value(&mut entry.material, None, "–");
                    for name in self.document.scene().materials().keys() {
                        ui.selectable_value(&mut entry.material, Some(name.clone()), name);
                    }
                });
            if entry.material != before {
                *done = Some("Change material".into());
            }
        });
    }

    fn shape(&self, ui: &mut egui::Ui, shape: &mut Shape) -> bool {
        let Ok(Value::Object(mut map)) = serde_json::to_value(&*shape) else {
            return false;
        };
        let kind = map["type"].as_str().unwrap_or_default().to_owned();
        let name = spoken(&kind);
        // A mesh of another file or resolution is to be sampled first: it is imported anew.
        let is_sampled = kind == "mesh";
        let own = |ui: &mut egui::Ui| {
            fields(ui, &name, &mut map, |key| self.docs.of("Shape", &kind, key))
        };
        if !ui.add_enabled_ui(!is_sampled, own).inner {
            return false;
        }
        match serde_json::from_value(Value::Object(map)) {
            Ok(changed) => *shape = changed,
            // Half typed text is no value yet.
            Err(_) => return false,
        }
        true
    }

    fn modifiers(&self, ui: &mut egui::Ui, entry: &mut Entry, done: &mut Option<String>) {
        ui.horizontal(|ui| {
            ui.label("Modifiers");
            ui.menu_button("Add…", |ui| {
                for modifier in new_modifiers() {
                    if ui.button(modifier_name(&modifier)).clicked() {
                        *done = Some(format!("Add {}", modifier_name(&modifier).to_lowercase()));
                        entry.modifiers.push(modifier);
                        ui.close();
                    }
                }
            });
        });
        let mut gone = None;
        let mut swap = None;
        let count = entry.modifiers.len();
        for (i, modifier) in entry.modifiers.iter_mut().enumerate() {
            ui.push_id(i, |ui| {
                let name = modifier_name(modifier);
                ui.horizontal(|ui| {
                    ui.label(RichText::new(&name).strong());
                    for (icon, words, on) in [
                        (Icon::Up, "Earlier", i > 0),
                        (Icon::Down, "Later", i + 1 < count),
                        (Icon::Cross, "Remove", true),
                    ] {
                        let words_of = format!("{words} {}", name.to_lowercase());
                        let response = icon::button(ui, icon, on, &words_of);
                        if response.clicked() {
                            match words {
                                "Earlier" => swap = Some(i - 1),
                                "Later" => swap = Some(i),
                                _ => gone = Some(i),
                            }
                        }
                    }
                });
                let Ok(Value::Object(mut map)) = serde_json::to_value(&*modifier) else {
                    return;
                };
                let kind = map["type"].as_str().unwrap_or_default().to_owned();
                let docs = |key: &str| self.docs.of("Modifier", &kind, key);
                if fields(ui, &name, &mut map, docs)
                    && let Ok(changed) = serde_json::from_value(Value::Object(map))
                {
                    *modifier = changed;
                    *done = Some(format!("Change {}", name.to_lowercase()));
                }
            });
        }
        if let Some(i) = swap {
            entry.modifiers.swap(i, i + 1);
            *done = Some("Reorder modifiers".into());
        }
        if let Some(i) = gone {
            entry.modifiers.remove(i);
            *done = Some("Remove modifier".into());
        }
    }

    fn materials(&mut self, ui: &mut egui::Ui) {
        ui.horizontal(|ui| {
            ui.strong("Materials");
            if ui.button("New material").clicked() {
                let known = self.document.scene().materials();
                let name = (1..)
                    .map(|i| format!("material {i}"))
                    .find(|name| !known.contains_key(name));
                if let Some(name) = name {
                    let material = Some(Material::default());
                    self.attempt(|s| s.document.set_material("Add material", &name, material));
                }
            }
        });
        let all: Vec<(String, Material)> = self
            .document
            .scene()
            .materials()
            .iter()
            .map(|(name, material)| (name.clone(), *material))
            .collect();
        for (name, before) in all {
            let mut own = before;
            egui::CollapsingHeader::new(&name)
                .id_salt(("material", &name))
                .show(ui, |ui| {
                    ui.horizontal(|ui| {
                        ui.label("Color");
                        ui.color_edit_button_rgb(&mut own.base_color);
                    });
                    for (label, value) in [
                        ("Roughness", &mut own.roughness),
                        ("Metallic", &mut own.metallic),
                    ] {
                        ui.add(egui::Slider::new(value, 0.0..=1.0).text(label));
                    }
                    ui.horizontal(|ui| {
                        ui.label("Emission");
                        for (axis, value) in ["red", "green", "blue"].iter().zip(&mut own.emission)
                        {
                            number(ui, &format!("Emission {axis}"), "amount", value);
                            *value = value.clamp(0.0, 1000.0);
                        }
                    });
                    if let Some(node) = self.document.active()
                        && ui.button("Use for the selection").clicked()
                    {
                        let mut entry = self.document.scene().node(node).entry().clone();
                        entry.material = Some(name.clone());
                        self.attempt(|s| s.document.replace("Change material", node, entry));
                    }
                });
            if own != before {
                if ui.input(|i| i.pointer.any_down()) && !self.document.is_in_stroke() {
                    self.document.begin_stroke("Change material");
                }
                self.attempt(|s| s.document.set_material("Change material", &name, Some(own)));
            }
        }
    }
}
