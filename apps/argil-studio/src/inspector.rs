//! The inspector, which shows every parameter of the selection.
//!
//! *Practice.* Shapes and modifiers are shown as their JSON values, with descriptions from the schema. A new shape
//! needs no code here.

use crate::docs::Docs;
use crate::document::Document;
use crate::files::IS_PAGE;
use crate::icon::{self, Icon};
use crate::keyframes::keyframes;
use crate::materials::material_choice;
use crate::multi_edit::apply_same_change;
use crate::names::{humanize, modifier_name, name_of, shape_name};
use crate::segmented_control::choice;
use crate::session::Session;
use crate::values::{fields, number};
use argil::scene::{
    BlendProfile, Exactness, Modifier, NodeDesc, NodeId, NodeKind, OperatorKind, Shape, is_image,
};
use eframe::egui::{self, RichText};
use serde_json::Value;

/// The inspector: see the module's page.
pub(crate) struct Inspector {
    docs: Docs,
}

impl Inspector {
    /// Creates the inspector from the file format's schema.
    pub(crate) fn new() -> Self {
        Self { docs: Docs::new() }
    }

    pub(crate) fn ui(&self, session: &mut Session, ui: &mut egui::Ui, node: NodeId) {
        let before = session.document.scene().node(node).desc().clone();
        let mut entry = before.clone();
        let name = name_of(&entry);
        ui.horizontal(|ui| {
            ui.strong(&name);
            match &entry.kind {
                NodeKind::Shape(shape) => {
                    let (text, why) = match shape.exactness() {
                        Exactness::Exact => ("exact", "Its distance is Euclidean."),
                        Exactness::LowerBound => (
                            "bound",
                            "Its distance is a lower bound of the Euclidean distance. Its surface is exact.",
                        ),
                    };
                    ui.label(RichText::new(text).small().weak())
                        .on_hover_text(why);
                }
                NodeKind::Group => {
                    let count = session.document.scene().node(node).children().len();
                    ui.weak(format!("{count} inside"));
                }
            }
        });
        let count = session.document.selection.len();
        if count > 1 {
            ui.weak(format!(
                "{count} nodes are selected, and this is the last one. Changes apply to all selected nodes, except keyframes."
            ));
        }
        let is_locked = session.document.is_locked(node);
        if is_locked {
            ui.weak("This node is locked.");
        }
        let mut done: Option<String> = None;
        ui.add_enabled_ui(!is_locked, |ui| {
            self.operator(&session.document, ui, &mut entry, &mut done);
            if let NodeKind::Shape(shape) = &mut entry.kind {
                ui.separator();
                self.file(session, ui, node, shape);
                if self.shape(ui, shape) {
                    done = Some(format!("Change {}", shape_name(shape).to_lowercase()));
                }
            }
            ui.separator();
            self.modifiers(ui, &mut entry, &mut done);
            ui.separator();
            keyframes(ui, &mut entry, &mut done);
        });
        if let Some(what) = done
            && entry != before
        {
            let is_held = ui.input(|i| i.pointer.any_down());
            session.change(&what, node, (&before, entry), is_held);
        }
    }

    /// Shows the file of a mesh or heightmap, and its resolution. Changing them takes a while.
    fn file(&self, session: &mut Session, ui: &mut egui::Ui, node: NodeId, shape: &Shape) {
        let Some((path, resolution, _)) = shape.file() else {
            return;
        };
        let named = (path.to_owned(), resolution);
        ui.horizontal(|ui| {
            ui.label("File");
            if !IS_PAGE && ui.button("Choose…").clicked() {
                session.relocate(node, resolution);
            }
            ui.add(egui::Label::new(path).truncate());
        });
        if session.document.missing_meshes().contains(&named) {
            ui.label("The mesh file is missing or still loading, so the mesh is not shown.");
        }
        let mut chosen = resolution;
        ui.horizontal(|ui| {
            let kind = if is_image(path) { "heightmap" } else { "mesh" };
            let text = self.docs.of("Shape", kind, "resolution");
            ui.label("Resolution").on_hover_text(text.unwrap_or(""));
            let all = match is_image(path) {
                true => [32, 64, 128, 256, 384, 512, 768, 1024, 2048],
                false => [16, 32, 64, 96, 128, 192, 256, 384, 512],
            };
            choice(ui, "Mesh resolution", &mut chosen, all, |n| {
                format!("{n} samples")
            });
        });
        if chosen != resolution {
            let load = session.load_again(std::iter::once(path));
            session.resample(node, (named.0, chosen), load);
        }
    }

    fn operator(
        &self,
        document: &Document,
        ui: &mut egui::Ui,
        entry: &mut NodeDesc,
        done: &mut Option<String>,
    ) {
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
            let all = kinds.map(|(kind, _)| kind);
            let word = |kind: &OperatorKind| {
                let known = kinds.iter().find(|(known_kind, _)| known_kind == kind);
                known.map_or("", |(_, word)| word).to_owned()
            };
            choice(ui, "Operator", &mut operator.kind, all, word);
        });
        ui.horizontal(|ui| {
            ui.label("Blend radius");
            number(ui, "Blend radius", "blend", &mut operator.blend);
            operator.blend = operator.blend.max(0.0);
            ui.selectable_value(&mut operator.profile, BlendProfile::Smooth, "smooth");
            ui.selectable_value(&mut operator.profile, BlendProfile::Chamfer, "chamfer");
        });
        if operator.kind == OperatorKind::Morph {
            ui.horizontal(|ui| {
                ui.label("Amount");
                ui.add(egui::Slider::new(&mut operator.morph_amount, 0.0..=1.0));
            });
        }
        if *operator != before {
            *done = Some("Change operator".into());
        }
        ui.horizontal(|ui| {
            ui.label("Material");
            let before = entry.material.clone();
            material_choice(document, ui, "Material", &mut entry.material);
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
        let name = humanize(&kind);
        // These keys are edited above.
        let of_file = ["path", "resolution"].map(|key| (key, map.remove(key)));
        if !fields(ui, &name, &mut map, |key| self.docs.of("Shape", &kind, key)) {
            return false;
        }
        for (key, value) in of_file {
            if let Some(value) = value {
                map.insert(key.to_owned(), value);
            }
        }
        match serde_json::from_value(Value::Object(map)) {
            Ok(changed) => *shape = changed,
            // Incomplete text is not a value yet.
            Err(_) => return false,
        }
        true
    }

    fn modifiers(&self, ui: &mut egui::Ui, entry: &mut NodeDesc, done: &mut Option<String>) {
        ui.horizontal(|ui| {
            ui.label("Modifiers");
            ui.menu_button("Add…", |ui| {
                for modifier in Modifier::examples() {
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
}

impl Session {
    /// Changes a node, and the other selected nodes in the same way. While `is_held`, changes form one undo step.
    fn change(
        &mut self,
        what: &str,
        node: NodeId,
        (before, after): (&NodeDesc, NodeDesc),
        is_held: bool,
    ) {
        if !self.document.is_in_stroke() {
            self.document.begin_stroke(what);
        }
        for other in self.document.selection.clone() {
            if other == node || self.document.is_locked(other) {
                continue;
            }
            let desc = self.document.scene().node(other).desc();
            let changed = apply_same_change(before, &after, desc);
            if changed != *desc {
                self.attempt(|s| s.document.replace(what, other, changed));
            }
        }
        self.attempt(|s| s.document.replace(what, node, after));
        if !is_held {
            self.document.end_stroke();
        }
    }
}
