//! The ground grid and the axes, drawn over the image and hidden behind solids.

use crate::view::ViewState;
use argil::glam::{Vec2, Vec3};
use eframe::egui::{self, Color32, Pos2, Rect, Stroke};

/// Lines on each side of the center.
const LINES: i32 = 20;
/// Segments per line, for which visibility is tested.
const PIECES: usize = 96;
/// Tolerance of the depth test, as a fraction of the distance.
const SLACK: f32 = 0.004;

impl ViewState {
    /// Draws the grid.
    pub(crate) fn draw_grid(&self, ui: &egui::Ui, rect: Rect) {
        // About ten lines per image height, at a power of ten.
        let spacing = 10.0f32.powf((self.eye.half_height() * 0.4).log10().floor());
        let reach = LINES as f32 * spacing;
        for i in -LINES..=LINES {
            let at = i as f32 * spacing;
            let [x, z] = if i == 0 {
                [[230, 70, 70], [70, 120, 240]]
                    .map(|[r, g, b]| Color32::from_rgba_unmultiplied(r, g, b, 130))
            } else {
                [Color32::from_white_alpha(if i % 10 == 0 { 40 } else { 14 }); 2]
            };
            let [low, high] = [-reach, reach];
            self.draw_line(
                ui,
                rect,
                [Vec3::new(low, 0.0, at), Vec3::new(high, 0.0, at)],
                x,
            );
            self.draw_line(
                ui,
                rect,
                [Vec3::new(at, 0.0, low), Vec3::new(at, 0.0, high)],
                z,
            );
        }
    }

    /// Draws the visible parts of a line.
    pub(crate) fn draw_line(&self, ui: &egui::Ui, rect: Rect, [a, b]: [Vec3; 2], color: Color32) {
        let painter = ui.painter_at(rect);
        let stroke = Stroke::new(1.0, color);
        let seen = |t: f32| self.seen_at(rect, a.lerp(b, t));
        // The visible part from its first to its last point.
        let mut run: Option<[Pos2; 2]> = None;
        let mut before = 0.0;
        for i in 0..=PIECES {
            let t = i as f32 / PIECES as f32;
            match (seen(t), run) {
                (Some(at), None) => {
                    run = Some([seen(last_seen(t, before, seen)).unwrap_or(at), at])
                }
                (Some(at), Some([from, _])) => run = Some([from, at]),
                (None, Some([from, to])) => {
                    let to = seen(last_seen(before, t, seen)).unwrap_or(to);
                    painter.line_segment([from, to], stroke);
                    run = None;
                }
                (None, None) => {}
            }
            before = t;
        }
        if let Some(seen) = run {
            painter.line_segment(seen, stroke);
        }
    }

    /// Returns a point's position on screen, or `None` if it is behind the camera or a solid.
    pub(crate) fn seen_at(&self, rect: Rect, place: Vec3) -> Option<Pos2> {
        let size = Vec2::new(rect.width(), rect.height());
        let at = self.eye.project(place, size)?;
        let part = at / size;
        let is_inside = part.cmpge(Vec2::ZERO).all() && part.cmplt(Vec2::ONE).all();
        let hides = |length: f32| {
            let away = place.distance(self.eye.camera().eye);
            // With a narrow field of view from far away, the tolerance depends on the size of what is viewed.
            length < away - SLACK * away.min(self.eye.distance)
        };
        let length = self.pictures.length_at(part).filter(|_| is_inside);
        (!length.is_some_and(hides)).then(|| Pos2::new(rect.left() + at.x, rect.top() + at.y))
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

/// Finds the last visible parameter by bisection.
fn last_seen(mut is: f32, mut is_not: f32, seen: impl Fn(f32) -> Option<Pos2>) -> f32 {
    for _ in 0..6 {
        let middle = 0.5 * (is + is_not);
        if seen(middle).is_some() {
            is = middle;
        } else {
            is_not = middle;
        }
    }
    is
}
