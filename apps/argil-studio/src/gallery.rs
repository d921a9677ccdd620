//! A picture of each shape, to put it into the scene.

use crate::app::Studio;
use crate::document::shape_name;
use argil::glam::Vec3;
use argil::{Brush, Camera, Engine, Outline, Piece, Scene, Settings, Shape, Show};
use eframe::egui::{self, ColorImage, Sense, TextureHandle, Vec2};

/// Pictures are drawn when they are looked at first.
#[derive(Default)]
pub struct Gallery {
    pictures: Vec<Option<TextureHandle>>,
}

const SIDE: f32 = 52.0;
const PIXELS: u32 = 96;

/// Each shape, of a size that goes together with the others.
pub fn shapes() -> Vec<Shape> {
    let line = |x: f32, y: f32| Piece {
        control: None,
        to: [x, y],
    };
    let curve = |cx: f32, cy: f32, x: f32, y: f32| Piece {
        control: Some([cx, cy]),
        to: [x, y],
    };
    vec![
        Shape::sphere(0.5),
        Shape::Ellipsoid {
            radii: [0.6, 0.35, 0.45],
        },
        Shape::rounded_box([0.45, 0.45, 0.45], 0.05),
        Shape::BoxFrame {
            half_size: [0.45, 0.45, 0.45],
            thickness: 0.06,
        },
        Shape::torus(0.4, 0.15),
        Shape::CappedTorus {
            major_radius: 0.4,
            minor_radius: 0.12,
            half_angle_degrees: 120.0,
        },
        Shape::Link {
            half_length: 0.25,
            major_radius: 0.25,
            minor_radius: 0.1,
        },
        Shape::capsule([0.0, -0.35, 0.0], [0.0, 0.35, 0.0], 0.2),
        Shape::Cylinder {
            radius: 0.4,
            half_height: 0.45,
            rounding: 0.03,
        },
        Shape::Cone {
            radius: 0.45,
            height: 0.9,
        },
        Shape::CappedCone {
            half_height: 0.4,
            bottom_radius: 0.45,
            top_radius: 0.2,
        },
        Shape::RoundCone {
            bottom_radius: 0.35,
            top_radius: 0.15,
            height: 0.5,
        },
        Shape::Plane {
            normal: [0.0, 1.0, 0.0],
            offset: 0.0,
        },
        Shape::HexPrism {
            apothem: 0.4,
            half_depth: 0.25,
        },
        Shape::TriPrism {
            half_side: 0.45,
            half_depth: 0.25,
        },
        Shape::Octahedron { radius: 0.55 },
        Shape::Pyramid {
            base: 0.8,
            height: 0.7,
        },
        Shape::CutSphere {
            radius: 0.5,
            cut: 0.1,
        },
        Shape::CutHollowSphere {
            radius: 0.5,
            cut: 0.1,
            thickness: 0.04,
        },
        Shape::SolidAngle {
            radius: 0.6,
            half_angle_degrees: 35.0,
        },
        Shape::Rhombus {
            half_length_x: 0.5,
            half_length_z: 0.3,
            half_height: 0.15,
            rounding: 0.02,
        },
        Shape::ExtrudedRoundedBox {
            half_size: [0.45, 0.3, 0.45],
            corner_radii: [0.3, 0.1, 0.3, 0.1],
            rounding: [0.05, 0.05],
        },
        Shape::BezierTube {
            from: [-0.5, -0.3, 0.0],
            control: [0.0, 0.9, 0.0],
            to: [0.5, -0.3, 0.0],
            from_radius: 0.15,
            to_radius: 0.06,
        },
        Shape::Lathe {
            outline: Outline {
                start: [0.0, -0.5],
                pieces: vec![
                    line(0.3, -0.5),
                    curve(0.5, -0.1, 0.2, 0.2),
                    line(0.3, 0.5),
                    line(0.0, 0.5),
                ],
            },
        },
        Shape::Extrusion {
            outline: Outline {
                start: [-0.45, -0.4],
                pieces: vec![
                    line(0.45, -0.4),
                    line(0.1, 0.0),
                    curve(0.4, 0.5, -0.45, 0.4),
                ],
            },
            half_depth: 0.15,
        },
    ]
}

fn picture(shape: &Shape) -> Option<ColorImage> {
    let mut scene = Scene::new();
    scene.push(Brush::new(shape.clone())).ok()?;
    let world = Engine::cpu().build(&scene).ok()?;
    let camera = Camera {
        eye: Vec3::new(1.1, 0.9, 1.8),
        target: Vec3::ZERO,
        field_of_view_degrees: 32.0,
    };
    let settings = Settings {
        samples: 4,
        ..world.settings([PIXELS; 2], Show::Shaded)
    };
    let drawn = world.draw(&camera, &settings).ok()?;
    Some(ColorImage::from_rgb(
        drawn.size.map(|n| n as usize),
        &drawn.rgb,
    ))
}

impl Studio {
    /// The shapes: one that is clicked is put where is looked at, one that is dragged where it is let go.
    pub(crate) fn gallery(&mut self, ui: &mut egui::Ui) {
        let shapes = shapes();
        self.gallery.pictures.resize(shapes.len(), None);
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
                    // A few a frame, so that the window opens at once.
                    let slot = &mut self.gallery.pictures[i];
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
                    "{name}\nClick: put it in the middle. Drag: put it on the surface."
                ));
            }
        });
        if let Some(shape) = chosen {
            let at = self.eye.target;
            self.attempt(|s| s.add_shape(shape, at));
        }
    }
}
