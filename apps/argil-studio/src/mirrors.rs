//! Mirror planes of the selection and of strokes, drawn over the image.

use crate::document::Document;
use crate::node_transform::NodeTransform;
use crate::session::Session;
use crate::view::{Tool, ViewState};
use argil::glam::{DVec3, Vec2};
use argil::scene::{Modifier, NodeId};
use eframe::egui::{self, Color32, Pos2, Rect, Shape, Stroke};

const COLORS: [[u8; 3]; 3] = [[230, 70, 70], [90, 190, 70], [70, 120, 240]];

impl ViewState {
    /// Draws the mirror planes.
    pub(crate) fn draw_mirrors(&self, session: &mut Session, ui: &egui::Ui, rect: Rect) {
        if self.tool == Tool::Sculpt {
            return self.draw_mirror(ui, rect, &NodeTransform::default(), self.sculpting.mirror);
        }
        let Some(node) = session.document.active() else {
            return;
        };
        for (pose, axes) in session.document.mirrors_of(node) {
            self.draw_mirror(ui, rect, &pose, axes);
        }
    }

    pub(crate) fn draw_mirror(
        &self,
        ui: &egui::Ui,
        rect: Rect,
        pose: &NodeTransform,
        axes: [bool; 3],
    ) {
        let size = Vec2::new(rect.width(), rect.height());
        // Half the visible height at the camera's target.
        let half = f64::from(0.5 * self.eye.half_height());
        for axis in (0..3).filter(|&axis| axes[axis]) {
            let [u, v] = [1, 2].map(|next| pose.turn * DVec3::AXES[(axis + next) % 3] * half);
            let corners = [u + v, u - v, -u - v, v - u].map(|off| pose.shift + off);
            let seen = corners.map(|corner| self.eye.project(corner.as_vec3(), size));
            // Skip a plane that is partly behind the camera.
            let [Some(a), Some(b), Some(c), Some(d)] = seen else {
                continue;
            };
            let corners = [a, b, c, d].map(|at| Pos2::new(rect.left() + at.x, rect.top() + at.y));
            let [red, green, blue] = COLORS[axis];
            let fill = Color32::from_rgba_unmultiplied(red, green, blue, 24);
            let line = Color32::from_rgba_unmultiplied(red, green, blue, 160);
            let plane = Shape::convex_polygon(corners.to_vec(), fill, Stroke::new(1.0, line));
            ui.painter_at(rect).add(plane);
        }
    }
}

impl Document {
    /// Returns the positions of a node's mirrors, and their mirrored axes.
    pub(crate) fn mirrors_of(&self, node: NodeId) -> Vec<(NodeTransform, [bool; 3])> {
        let scene = self.scene();
        let entry = scene.node(node).desc();
        let around = NodeTransform::around(scene, node);
        let mirrors = entry.modifiers.iter().enumerate();
        mirrors
            .filter_map(|(i, modifier)| match *modifier {
                Modifier::Mirror { axes } => {
                    Some((NodeTransform::behind(entry, i + 1).and(&around), axes))
                }
                _ => None,
            })
            .collect()
    }
}
