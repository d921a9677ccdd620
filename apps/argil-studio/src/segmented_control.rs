//! A segmented control.

use eframe::egui;

/// Shows a choice between `all`, with a name for screen readers.
pub(crate) fn choice<T: PartialEq>(
    ui: &mut egui::Ui,
    name: &str,
    value: &mut T,
    all: impl IntoIterator<Item = T>,
    word: impl Fn(&T) -> String,
) -> egui::Response {
    let response = egui::ComboBox::from_id_salt(name)
        .width(70.0)
        .selected_text(word(value))
        .show_ui(ui, |ui| {
            for option in all {
                let word = word(&option);
                ui.selectable_value(value, option, word);
            }
        })
        .response;
    let shown = word(value);
    response.widget_info(|| {
        let mut info = egui::WidgetInfo::labeled(egui::Role::ComboBox, true, name);
        info.current_text_value = Some(shown.clone());
        info
    });
    response
}
