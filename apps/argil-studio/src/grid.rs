//! The grid on the ground and the axes, drawn over the picture, behind what is in front of them.

use crate::view::View;
use argil::glam::{Vec2, Vec3};
use eframe::egui::{self, Color32, Pos2, Rect, Stroke};

/// Lines to each side of the middle.
const LINES: i32 = 20;
/// In so many pieces it is found out where a line is seen.
const PIECES: usize = 96;
/// By this part of its distance, something may lie before a line that does not hide it.
const SLACK: f32 = 0.004;

impl View {
    /// Draw the grid.
    pub(crate) fn draw_grid(&self, ui: &egui::Ui, rect: Rect) {
        // Ten lines or so to the picture's height, a power of ten apart.
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

    /// Draw what is seen of a line.
    pub(crate) fn draw_line(&self, ui: &egui::Ui, rect: Rect, [a, b]: [Vec3; 2], color: Color32) {
        let painter = ui.painter_at(rect);
        let stroke = Stroke::new(1.0, color);
        let seen = |t: f32| self.seen_at(rect, a.lerp(b, t));
        // What is seen of it goes from the first place to the second.
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

    /// Where a place is on the screen; nothing where it is behind the eye or a solid.
    pub(crate) fn seen_at(&self, rect: Rect, place: Vec3) -> Option<Pos2> {
        let size = Vec2::new(rect.width(), rect.height());
        let at = self.eye.project(place, size)?;
        let part = at / size;
        let is_inside = part.cmpge(Vec2::ZERO).all() && part.cmplt(Vec2::ONE).all();
        let hides = |length: f32| {
            let away = place.distance(self.eye.camera().eye);
            // Through a lens from far away, what is near to one another is told by the size of what is looked at.
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
        // Those in front last.
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

/// The last parameter from one that is seen to one that may not be.
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
