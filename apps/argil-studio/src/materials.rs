//! The scene's materials.

use crate::docs::Docs;
use crate::document::Document;
use crate::segmented_control::choice;
use crate::session::{Request, Session};
use crate::textures::textures;
use crate::values::number;
use argil::scene::{Material, Scene};
use eframe::egui;

/// The materials panel.
#[derive(Default)]
pub(crate) struct Materials {
    docs: Docs,
    /// A material being renamed, and the text typed so far.
    naming: Option<(String, String)>,
}

impl Materials {
    /// Shows all materials, to edit, rename and remove.
    pub(crate) fn ui(&mut self, session: &mut Session, ui: &mut egui::Ui) {
        ui.horizontal(|ui| {
            ui.strong("Materials");
            if ui.button("New material").clicked() {
                let known = session.document.scene().materials();
                let name = (1..)
                    .map(|i| format!("material {i}"))
                    .find(|name| !known.contains_key(name));
                if let Some(name) = name {
                    let material = Some(Material::default());
                    session.attempt(|s| s.document.set_material("Add material", &name, material));
                }
            }
        });
        let all: Vec<(String, Material)> = session
            .document
            .scene()
            .materials()
            .iter()
            .map(|(name, material)| (name.clone(), material.clone()))
            .collect();
        for (name, material) in all {
            egui::CollapsingHeader::new(&name)
                .id_salt(("material", &name))
                .show(ui, |ui| self.material(session, ui, &name, material));
        }
    }

    pub(crate) fn material(
        &mut self,
        session: &mut Session,
        ui: &mut egui::Ui,
        name: &str,
        before: Material,
    ) {
        let mut edited = before.clone();
        ui.horizontal(|ui| {
            ui.label("Color");
            ui.color_edit_button_rgb(&mut edited.base_color);
        });
        for (label, value) in [
            ("Roughness", &mut edited.roughness),
            ("Metallic", &mut edited.metallic),
        ] {
            ui.add(egui::Slider::new(value, 0.0..=1.0).text(label));
        }
        ui.horizontal(|ui| {
            ui.label("Emission");
            for (axis, value) in ["red", "green", "blue"].iter().zip(&mut edited.emission) {
                number(ui, &format!("Emission {axis}"), "amount", value);
                *value = value.clamp(0.0, 1000.0);
            }
        });
        transmission(ui, &mut edited);
        textures(&self.docs, ui, &mut edited);
        if edited != before {
            if ui.input(|i| i.pointer.any_down()) && !session.document.is_in_stroke() {
                session.document.begin_stroke("Change material");
            }
            session.attempt(|s| {
                let mut scratch = Scene::new();
                scratch.set_material(name, edited)?;
                s.load_images(&mut scratch)?;
                let checked = scratch.materials().get(name).cloned();
                s.document.set_material("Change material", name, checked)
            });
        }
        if !session.document.selection.is_empty() && ui.button("Assign to selection").clicked() {
            let mut nodes = session.document.selection.clone();
            nodes.retain(|&node| !session.document.is_locked(node));
            let name = Some(name.to_owned());
            session.attempt(|s| {
                anyhow::ensure!(!nodes.is_empty(), "the selection is locked");
                s.document.give_material("Change material", &nodes, &name)
            });
        }
        self.material_name(session, ui, name);
        if ui.button("Remove").clicked() {
            session.attempt(|s| s.document.remove_material(name));
        }
    }

    pub(crate) fn material_name(&mut self, session: &mut Session, ui: &mut egui::Ui, name: &str) {
        let being_typed = self.naming.take_if(|(typed, _)| typed == name);
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
                session.attempt(|s| {
                    s.document.rename_material(name, text.trim())?;
                    let names = [name, text.trim()].map(str::to_owned);
                    s.requests.push(Request::Rename(names));
                    Ok(())
                });
            }
        }
    }
}

/// Shows what stills need of glass.
fn transmission(ui: &mut egui::Ui, material: &mut Material) {
    let slider = egui::Slider::new(&mut material.transmission, 0.0..=1.0);
    ui.add(slider.text("Transmission"));
    if material.transmission > 0.0 {
        let slider = egui::Slider::new(&mut material.refractive_index, 1.0..=4.0);
        ui.add(slider.text("Index of refraction"));
        ui.horizontal(|ui| {
            ui.label("Attenuation distance");
            let distance = &mut material.attenuation_distance;
            number(ui, "Attenuation distance", "distance", distance);
            *distance = distance.max(0.0);
        });
    }
}

/// Shows a choice of a material or none.
pub(crate) fn material_choice(
    document: &Document,
    ui: &mut egui::Ui,
    name: &str,
    value: &mut Option<String>,
) {
    let known = document.scene().materials().keys().cloned().map(Some);
    let word = |material: &Option<String>| material.clone().unwrap_or_else(|| "–".into());
    choice(ui, name, value, std::iter::once(None).chain(known), word);
}
