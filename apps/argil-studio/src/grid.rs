//! The ground grid, which solids hide, and the axes.

use crate::view::ViewState;
use crate::viewport_renderer::GridLine;
use argil::glam::Vec3;
use eframe::egui::{self, Color32, Rect, Stroke};

/// Lines on each side of the center.
const LINES: i32 = 20;

impl ViewState {
    /// Returns the lines of the grid.
    pub(crate) fn grid(&self) -> Vec<GridLine> {
        // About ten lines per image height, at a power of ten.
        let spacing = 10.0f32.powf((self.eye.half_height() * 0.4).log10().floor());
        let reach = LINES as f32 * spacing;
        let lines_at = |i: i32| {
            let at = i as f32 * spacing;
            let [x, z] = if i == 0 {
                [[230, 70, 70], [70, 120, 240]]
                    .map(|[r, g, b]| Color32::from_rgba_unmultiplied(r, g, b, 130))
            } else {
                [Color32::from_white_alpha(if i % 10 == 0 { 40 } else { 14 }); 2]
            };
            let along_x = [-reach, reach].map(|end| Vec3::new(end, 0.0, at));
            let along_z = [-reach, reach].map(|end| Vec3::new(at, 0.0, end));
            [GridLine::new(along_x, x), GridLine::new(along_z, z)]
        };
        (-LINES..=LINES).flat_map(lines_at).collect()
    }

    pub(crate) fn draw_triad(&self, ui: &egui::Ui, rect: Rect) {
        let middle = rect.right_top() + egui::vec2(-45.0, 45.0);
        let [right, up] = self.eye.axes();
        let mut axes = [
            (Vec3::X, "x", Color32::from_rgb(230, 70, 70)),
            (Vec3::Y, "y", Color32::from_rgb(90, 190, 70)),
            (Vec3::Z, "z", Color32::from_rgb(70, 120, 240)),
        ];
        // Draw the nearest last.
        let depth = |a: Vec3| a.dot(self.eye.backward());
        axes.sort_by(|a, b| depth(a.0).total_cmp(&depth(b.0)));
        let painter = ui.painter_at(rect);
        for (axis, name, color) in axes {
            let end = middle + 26.0 * egui::vec2(axis.dot(right), -axis.dot(up));
            painter.line_segment([middle, end], Stroke::new(2.0, color));
            let font = egui::TextStyle::Small.resolve(ui.style());
            painter.circle_filled(end, 7.0, color);
            painter.text(end, egui::Align2::CENTER_CENTER, name, font, Color32::WHITE);
        }
    }
}
