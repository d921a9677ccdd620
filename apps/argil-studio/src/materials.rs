//! The scene's materials.

use crate::app::Studio;
use crate::choice::choice;
use crate::inspector::number;
use argil::{Material, NodeId};
use eframe::egui;

impl Studio {
    /// All materials, to be changed, named and taken away.
    pub(crate) fn materials(&mut self, ui: &mut egui::Ui) {
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
        for (name, material) in all {
            egui::CollapsingHeader::new(&name)
                .id_salt(("material", &name))
                .show(ui, |ui| self.material(ui, &name, material));
        }
    }

    /// Let a material be chosen, or none.
    pub(crate) fn material_choice(
        &self,
        ui: &mut egui::Ui,
        name: &str,
        value: &mut Option<String>,
    ) {
        let known = self.document.scene().materials().keys().cloned().map(Some);
        let word = |own: &Option<String>| own.clone().unwrap_or_else(|| "–".into());
        choice(ui, name, value, std::iter::once(None).chain(known), word);
    }

    fn material(&mut self, ui: &mut egui::Ui, name: &str, before: Material) {
        let mut own = before;
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
            for (axis, value) in ["red", "green", "blue"].iter().zip(&mut own.emission) {
                number(ui, &format!("Emission {axis}"), "amount", value);
                *value = value.clamp(0.0, 1000.0);
            }
        });
        if own != before {
            if ui.input(|i| i.pointer.any_down()) && !self.document.is_in_stroke() {
                self.document.begin_stroke("Change material");
            }
            self.attempt(|s| s.document.set_material("Change material", name, Some(own)));
        }
        if !self.document.selection.is_empty() && ui.button("Use for the selection").clicked() {
            let mut nodes = self.document.selection.clone();
            nodes.retain(|&node| !self.document.is_locked(node));
            let name = Some(name.to_owned());
            self.attempt(|s| {
                anyhow::ensure!(!nodes.is_empty(), "what is selected is locked");
                s.give_material("Change material", &nodes, &name)
            });
        }
        self.material_name(ui, name);
        if ui.button("Remove").clicked() {
            self.attempt(|s| s.remove_material(name));
        }
    }

    fn material_name(&mut self, ui: &mut egui::Ui, name: &str) {
        let being_typed = self.naming.take_if(|(own, _)| own == name);
        let mut text = being_typed.map_or_else(|| name.to_owned(), |(_, text)| text);
        let response = ui.horizontal(|ui| {
            let label = ui.label("Name");
            ui.text_edit_singleline(&mut text).labelled_by(label.id)
        });
        let response = response.inner;
        if response.has_focus() {
            self.naming = Some((name.to_owned(), text));
        } else if response.lost_focus() && text != name {
            let is_given_up = ui.input(|i| i.key_pressed(egui::Key::Escape));
            if !is_given_up {
                self.attempt(|s| s.rename_material(name, text.trim()));
            }
        }
    }

    /// Those that have a material.
    fn users_of(&self, material: &str) -> Vec<NodeId> {
        let scene = self.document.scene();
        let uses = |&node: &NodeId| scene.node(node).entry().material.as_deref() == Some(material);
        scene.walk().filter(uses).collect()
    }

    fn give_material(
        &mut self,
        what: &str,
        nodes: &[NodeId],
        material: &Option<String>,
    ) -> anyhow::Result<()> {
        let is_own = !self.document.is_in_stroke();
        if is_own {
            self.document.begin_stroke(what);
        }
        for &node in nodes {
            let mut entry = self.document.scene().node(node).entry().clone();
            entry.material.clone_from(material);
            self.document.replace(what, node, entry)?;
        }
        if is_own {
            self.document.end_stroke();
        }
        Ok(())
    }

    fn rename_material(&mut self, name: &str, new: &str) -> anyhow::Result<()> {
        let materials = self.document.scene().materials();
        anyhow::ensure!(!new.is_empty(), "a material has to have a name");
        anyhow::ensure!(
            !materials.contains_key(new),
            "there is a material {new} already"
        );
        let material = materials.get(name).copied();
        let users = self.users_of(name);
        self.document.begin_stroke("Rename material");
        self.document
            .set_material("Rename material", new, material)?;
        self.give_material("Rename material", &users, &Some(new.to_owned()))?;
        self.document.set_material("Rename material", name, None)?;
        self.document.end_stroke();
        if self.sculpting.material.as_deref() == Some(name) {
            self.sculpting.material = Some(new.to_owned());
        }
        Ok(())
    }

    /// Take a material away, also from those that have it.
    fn remove_material(&mut self, name: &str) -> anyhow::Result<()> {
        let users = self.users_of(name);
        self.document.begin_stroke("Remove material");
        self.give_material("Remove material", &users, &None)?;
        self.document.set_material("Remove material", name, None)?;
        self.document.end_stroke();
        Ok(())
    }
}
