//! Icon buttons.

use eframe::egui::{self, Pos2, Rect, Sense, Shape, Stroke, Vec2};

/// The icons.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Icon {
    /// An open or closed eye.
    Eye(bool),
    /// A closed or open lock.
    Lock(bool),
    /// An arrow up.
    Up,
    /// An arrow down.
    Down,
    /// An arrow to the right.
    Right,
    /// A cross.
    Cross,
}

/// Returns the side length of a button.
pub(crate) fn side(ui: &egui::Ui) -> f32 {
    ui.spacing().icon_width + 2.0
}

/// Shows an icon button with an accessible label.
pub(crate) fn button(ui: &mut egui::Ui, icon: Icon, enabled: bool, label: &str) -> egui::Response {
    let side = side(ui);
    let sense = if enabled {
        Sense::click()
    } else {
        Sense::hover()
    };
    let (rect, response) = ui.allocate_exact_size(Vec2::splat(side), sense);
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, enabled, label));
    let visuals = ui.style().interact(&response);
    let is_quiet = !enabled || matches!(icon, Icon::Eye(false) | Icon::Lock(false));
    let color = if is_quiet && !response.hovered() {
        visuals.fg_stroke.color.gamma_multiply(0.35)
    } else {
        visuals.fg_stroke.color
    };
    if response.has_focus() {
        let inside = egui::StrokeKind::Inside;
        ui.painter()
            .rect_stroke(rect, 2.0, visuals.fg_stroke, inside);
    }
    draw(
        ui.painter(),
        icon,
        rect.shrink(3.0),
        Stroke::new(1.3, color),
    );
    response.on_hover_text(label)
}

fn draw(painter: &egui::Painter, icon: Icon, rect: Rect, stroke: Stroke) {
    let at = |x: f32, y: f32| {
        Pos2::new(
            rect.left() + x * rect.width(),
            rect.top() + y * rect.height(),
        )
    };
    let line = |points: &[[f32; 2]]| {
        let points = points.iter().map(|p| at(p[0], p[1])).collect();
        painter.add(Shape::line(points, stroke));
    };
    match icon {
        Icon::Eye(is_open) => {
            let lid = |sign: f32| {
                let points = (0..=8).map(|i| {
                    let x = i as f32 / 8.0;
                    at(x, 0.5 - sign * 1.4 * x * (1.0 - x))
                });
                painter.add(Shape::line(points.collect(), stroke));
            };
            lid(-1.0);
            if is_open {
                lid(1.0);
                painter.circle_filled(at(0.5, 0.5), 0.18 * rect.width(), stroke.color);
            }
        }
        Icon::Lock(is_closed) => {
            let body = Rect::from_min_max(at(0.1, 0.45), at(0.9, 1.0));
            painter.rect_filled(body, 1.0, stroke.color);
            let lift = if is_closed { 0.0 } else { -0.12 };
            let right = if is_closed { 0.45 } else { 0.2 };
            line(&[
                [0.25, 0.45],
                [0.25, 0.2 + lift],
                [0.4, 0.05 + lift],
                [0.6, 0.05 + lift],
                [0.75, 0.2 + lift],
                [0.75, right],
            ]);
        }
        Icon::Up => line(&[[0.15, 0.7], [0.5, 0.3], [0.85, 0.7]]),
        Icon::Down => line(&[[0.15, 0.3], [0.5, 0.7], [0.85, 0.3]]),
        Icon::Right => line(&[[0.3, 0.15], [0.7, 0.5], [0.3, 0.85]]),
        Icon::Cross => {
            line(&[[0.2, 0.2], [0.8, 0.8]]);
            line(&[[0.8, 0.2], [0.2, 0.8]]);
        }
    }
}
