//! The user interface: two sliders, and the world beside them.

use super::sculpture::{Draw, Sculpture};
use argil::glam::camera::rh::{proj::directx, view::look_at_mat4};
use argil::glam::{Quat, Vec3};
use eframe::egui;
use eframe::egui_wgpu::{self, CallbackTrait};

/// What the user sets.
pub(crate) struct View {
    pub(crate) draw: Draw,
    turn: f32,
}

impl Default for View {
    fn default() -> Self {
        Self {
            draw: Draw::default(),
            turn: 0.6,
        }
    }
}

impl View {
    /// Shows everything.
    pub(crate) fn show(&mut self, ui: &mut egui::Ui) {
        egui::Panel::left("settings").show(ui, |ui| {
            ui.label("Radius");
            ui.add(egui::Slider::new(&mut self.draw.radius, 0.2..=0.9));
            ui.label("Blend");
            ui.add(egui::Slider::new(&mut self.draw.blend, 0.0..=0.4));
        });
        egui::CentralPanel::no_frame().show(ui, |ui| {
            let (rect, response) = ui.allocate_exact_size(ui.available_size(), egui::Sense::drag());
            self.turn -= 0.01 * response.drag_delta().x;
            let size = rect.size() * ui.ctx().pixels_per_point();
            self.draw.size = [size.x, size.y].map(|side| side.round().max(1.0) as u32);
            let projection = directx::perspective(0.7, rect.aspect_ratio().max(0.01), 0.1, 100.0);
            let eye = Quat::from_rotation_y(self.turn) * Vec3::new(0.0, 1.6, 3.6);
            let view = look_at_mat4(eye, Vec3::ZERO, Vec3::Y);
            self.draw.clip_from_world = (projection * view).to_cols_array_2d();
            let callback = egui_wgpu::Callback::new_paint_callback(rect, self.draw.clone());
            ui.painter().add(callback);
        });
    }
}

impl eframe::App for View {
    fn ui(&mut self, ui: &mut egui::Ui, _: &mut eframe::Frame) {
        self.show(ui);
    }
}

/// egui asks for the commands of a frame, and later for the draw in its render pass.
impl CallbackTrait for Draw {
    fn prepare(
        &self,
        _: &egui_wgpu::wgpu::Device,
        _: &egui_wgpu::wgpu::Queue,
        _: &egui_wgpu::ScreenDescriptor,
        encoder: &mut egui_wgpu::wgpu::CommandEncoder,
        resources: &mut egui_wgpu::CallbackResources,
    ) -> Vec<egui_wgpu::wgpu::CommandBuffer> {
        if let Some(sculpture) = resources.get_mut::<Sculpture>()
            && let Err(fault) = sculpture.encode(self, encoder)
        {
            eprintln!("{fault}");
        }
        Vec::new()
    }

    fn paint(
        &self,
        _: egui::PaintCallbackInfo,
        pass: &mut egui_wgpu::wgpu::RenderPass<'static>,
        resources: &egui_wgpu::CallbackResources,
    ) {
        if let Some(sculpture) = resources.get::<Sculpture>() {
            sculpture.composite(pass);
        }
    }
}
