//! Text over the image.

use eframe::egui::{self, Color32, Pos2, Rect};

/// Draws text over the image.
pub(crate) fn label(ui: &egui::Ui, at: Pos2, text: &str) {
    let font = egui::TextStyle::Monospace.resolve(ui.style());
    let galley = ui
        .painter()
        .layout_no_wrap(text.to_owned(), font, Color32::WHITE);
    let behind = Rect::from_min_size(at, galley.size()).expand(4.0);
    ui.painter()
        .rect_filled(behind, 3.0, Color32::from_black_alpha(160));
    ui.painter().galley(at, galley, Color32::WHITE);
}
