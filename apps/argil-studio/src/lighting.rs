//! The scene's lights, its surroundings, and how its picture is developed.

use crate::docs::Docs;
use crate::names::humanize;
use crate::segmented_control::choice;
use crate::session::Session;
use crate::values::{edit_fields, number};
use argil::scene::{
    AmbientOcclusion, Environment, Fog, Lens, Light, LoadedImage, MAX_LIGHTS, Scene, ToneCurve,
    View,
};
use eframe::egui;

/// The panel of lights.
#[derive(Default)]
pub(crate) struct Lighting {
    docs: Docs,
}

impl Lighting {
    /// Shows all that a view says of light, and changes it in steps that can be undone.
    pub(crate) fn ui(&self, session: &mut Session, ui: &mut egui::Ui) {
        egui::CollapsingHeader::new("Light")
            .id_salt("light")
            .show(ui, |ui| {
                let before = &session.document.scene().view;
                let mut view = before.clone();
                self.lights(ui, &mut view);
                self.environment(ui, &mut view.environment);
                self.air_and_lens(ui, &mut view);
                development(ui, &mut view);
                if view != *before {
                    session.change_view(ui, view);
                }
            });
    }

    fn lights(&self, ui: &mut egui::Ui, view: &mut View) {
        let mut has_sun_only = view.lights.is_none();
        let label = ui.checkbox(&mut has_sun_only, "Only the sun of the view");
        if label.changed() {
            view.lights = (!has_sun_only).then(|| vec![sun(view)]);
        }
        let Some(lights) = &mut view.lights else {
            return;
        };
        let mut removed = None;
        for (index, light) in lights.iter_mut().enumerate() {
            let kind = kind_of(light);
            let name = format!("{} {}", humanize(kind), index + 1);
            egui::CollapsingHeader::new(&name)
                .id_salt(("light", index))
                .show(ui, |ui| {
                    edit_fields(ui, &name, light, |key| self.docs.of("Light", kind, key));
                    if ui.button("Remove").clicked() {
                        removed = Some(index);
                    }
                });
        }
        if let Some(index) = removed {
            lights.remove(index);
        }
        if lights.len() >= MAX_LIGHTS {
            return;
        }
        ui.horizontal_wrapped(|ui| {
            for light in new_lights() {
                if ui.button(format!("Add {}", kind_of(&light))).clicked() {
                    lights.push(light);
                }
            }
        });
    }

    fn environment(&self, ui: &mut egui::Ui, environment: &mut Environment) {
        let kinds = ["Sky", "Color", "Image"];
        let kind_of = |surroundings: &Environment| match surroundings {
            Environment::Sky => 0,
            Environment::Color { .. } => 1,
            Environment::Image { .. } => 2,
        };
        let mut kind = kind_of(environment);
        ui.horizontal(|ui| {
            ui.label("Surroundings");
            choice(ui, "Surroundings", &mut kind, 0..3, |&index| {
                kinds[index].into()
            });
        });
        if kind != kind_of(environment) {
            *environment = match kind {
                0 => Environment::Sky,
                1 => Environment::Color {
                    radiance: [0.5, 0.5, 0.5],
                },
                _ => Environment::Image {
                    path: "surroundings.hdr".into(),
                    turn_degrees: 0.0,
                    strength: 1.0,
                    image: LoadedImage::default(),
                },
            };
        }
        let word = ["sky", "color", "image"][kind];
        edit_fields(ui, "Surroundings", environment, |key| {
            self.docs.of("Environment", word, key)
        });
    }

    fn air_and_lens(&self, ui: &mut egui::Ui, view: &mut View) {
        let mut has_fog = view.fog.is_some();
        if ui.checkbox(&mut has_fog, "Fog").changed() {
            view.fog = has_fog.then(Fog::default);
        }
        if let Some(fog) = &mut view.fog {
            edit_fields(ui, "Fog", fog, |key| self.docs.of_struct("Fog", key));
        }
        let mut has_lens = view.lens.is_some();
        if ui.checkbox(&mut has_lens, "Lens").changed() {
            view.lens = has_lens.then_some(Lens {
                aperture_radius: 0.05,
                focus_distance: None,
            });
        }
        if let Some(lens) = &mut view.lens {
            edit_fields(ui, "Lens", lens, |key| self.docs.of_struct("Lens", key));
        }
    }
}

fn development(ui: &mut egui::Ui, view: &mut View) {
    ui.horizontal(|ui| {
        ui.label("Exposure");
        number(ui, "Exposure", "amount", &mut view.exposure);
        view.exposure = view.exposure.clamp(-20.0, 20.0);
        let tones = [ToneCurve::Aces, ToneCurve::Agx, ToneCurve::None];
        choice(ui, "Tone curve", &mut view.tone, tones, |tone| {
            let word = match tone {
                ToneCurve::Aces => "ACES",
                ToneCurve::Agx => "AgX",
                ToneCurve::None => "None",
            };
            word.into()
        });
    });
    let kinds = [AmbientOcclusion::Normal, AmbientOcclusion::BentNormal];
    let occlusion = &mut view.ambient_occlusion;
    choice(ui, "Ambient occlusion", occlusion, kinds, |kind| {
        let word = match kind {
            AmbientOcclusion::Normal => "Along normals",
            AmbientOcclusion::BentNormal => "Bent normals",
        };
        word.into()
    });
}

fn kind_of(light: &Light) -> &'static str {
    match light {
        Light::Sun { .. } => "sun",
        Light::Point { .. } => "point",
        Light::Spot { .. } => "spot",
        Light::Area { .. } => "area",
    }
}

/// The sun that a view without lights has, as a light.
fn sun(view: &View) -> Light {
    Light::Sun {
        direction_degrees: view.sun_degrees,
        irradiance: [5.2, 4.8, 4.2],
        angle_degrees: 0.53,
    }
}

/// A light of each kind, near the origin.
fn new_lights() -> [Light; 4] {
    let (at, target) = ([1.0, 2.0, 1.5], [0.0; 3]);
    [
        sun(&View::default()),
        Light::Point {
            at,
            intensity: [10.0; 3],
            radius: 0.1,
        },
        Light::Spot {
            at,
            target,
            intensity: [20.0; 3],
            angle_degrees: 40.0,
            fade: 0.2,
            radius: 0.1,
        },
        Light::Area {
            at,
            target,
            size: [1.0, 1.0],
            radiance: [10.0; 3],
        },
    ]
}

impl Session {
    /// Replaces the view, as a step that can be undone. A drag is one step.
    fn change_view(&mut self, ui: &egui::Ui, view: View) {
        if ui.input(|i| i.pointer.any_down()) && !self.document.is_in_stroke() {
            self.document.begin_stroke("Change light");
        }
        self.attempt(|s| {
            let mut scratch = Scene::new();
            scratch.view = view;
            s.load_images(&mut scratch)?;
            s.document.set_view("Change light", scratch.view.clone())
        });
    }

    /// Loads the images that a scene names, beside the document's file.
    pub(crate) fn load_images(&self, scene: &mut Scene) -> anyhow::Result<()> {
        // What the document has loaded need not be read again.
        self.document.share_images(scene);
        let folder = self.document.mesh_folder();
        argil::load_images(scene, &folder, self.document.external.clone())?;
        Ok(())
    }
}
