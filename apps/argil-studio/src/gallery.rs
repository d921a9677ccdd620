//! The shape gallery.

use crate::names::shape_name;
use crate::ready::ready;
use argil::Engine;
use argil::glam::Vec3;
use argil::render::{Camera, RenderMode, RenderSettings};
use argil::scene::{Brush, Scene, Shape};
use eframe::egui::{self, ColorImage, Sense, TextureHandle, Vec2};

/// The gallery. Its images are rendered on first use.
#[derive(Default)]
pub(crate) struct Gallery {
    pictures: Vec<Option<TextureHandle>>,
}

const SIDE: f32 = 52.0;
const PIXELS: u32 = 96;

fn picture(shape: &Shape) -> Option<ColorImage> {
    let mut scene = Scene::new();
    scene.push(Brush::new(shape.clone())).ok()?;
    let world = Engine::cpu().build(&scene).ok()?.field();
    let camera = Camera {
        eye: Vec3::new(1.1, 0.9, 1.8),
        target: Vec3::ZERO,
        field_of_view_degrees: 32.0,
    };
    let settings = RenderSettings {
        samples: 4,
        ..world.render_settings([PIXELS; 2], RenderMode::Shaded)
    };
    let drawn = ready(world.render_async(&camera, &settings)).ok()?;
    Some(ColorImage::from_rgb(
        drawn.size.map(|n| n as usize),
        &drawn.rgb,
    ))
}

impl Gallery {
    /// Shows the shapes. A clicked shape goes to the camera's target, and a dragged one to where it is dropped.
    pub(crate) fn ui(&mut self, ui: &mut egui::Ui) -> Option<Shape> {
        let shapes = Shape::examples();
        self.pictures.resize(shapes.len(), None);
        let mut drawn = 0;
        let mut chosen = None;
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing = Vec2::splat(4.0);
            for (i, shape) in shapes.iter().enumerate() {
                let name = shape_name(shape);
                let (rect, response) =
                    ui.allocate_exact_size(Vec2::splat(SIDE), Sense::click_and_drag());
                response.widget_info(|| {
                    egui::WidgetInfo::labeled(egui::Role::Button, true, format!("Add {name}"))
                });
                if ui.is_rect_visible(rect) {
                    // A few images per frame, so that the window opens at once.
                    let slot = &mut self.pictures[i];
                    if slot.is_none() && drawn < 2 {
                        drawn += 1;
                        *slot = picture(shape).map(|image| {
                            ui.ctx()
                                .load_texture(name.clone(), image, egui::TextureOptions::LINEAR)
                        });
                    }
                    let visuals = ui.style().interact(&response);
                    ui.painter().rect_filled(rect, 4.0, visuals.bg_fill);
                    match slot {
                        Some(texture) => egui::Image::from_texture((texture.id(), rect.size()))
                            .corner_radius(4)
                            .paint_at(ui, rect.shrink(2.0)),
                        None => ui.ctx().request_repaint(),
                    }
                    if response.has_focus() || response.hovered() {
                        ui.painter().rect_stroke(
                            rect,
                            4.0,
                            visuals.fg_stroke,
                            egui::StrokeKind::Inside,
                        );
                    }
                }
                response.dnd_set_drag_payload(shape.clone());
                if response.clicked() {
                    chosen = Some(shape.clone());
                }
                response.on_hover_text(format!(
                    "{name}\nClick to put it at the center, or drag it onto the surface."
                ));
            }
        });
        chosen
    }
}
