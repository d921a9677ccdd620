//! The menu bar, the time bar and the message bar.

use crate::commands::{self, Command, MENUS};
use crate::dialog::AfterDialog;
use crate::files::IS_PAGE;
use crate::icon::{self, Icon};
use crate::sample_scenes;
use crate::session::{Request, Session};
use eframe::egui::{self, Align, Color32, Layout};

/// Duration for which a message is shown, unless it reports an error.
const SHOWN: std::time::Duration = std::time::Duration::from_secs(12);

impl Session {
    /// Shows the menus.
    pub(crate) fn menu_bar(&mut self, ui: &mut egui::Ui) {
        egui::Panel::top("menus").show(ui, |ui| {
            egui::MenuBar::new().ui(ui, |ui| {
                for menu in MENUS {
                    ui.menu_button(menu, |ui| self.menu(ui, menu));
                }
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                    let mark = if self.document.is_changed() {
                        " •"
                    } else {
                        ""
                    };
                    ui.weak(format!("{}{mark}", self.document.title()));
                });
            });
        });
    }

    pub(crate) fn menu(&mut self, ui: &mut egui::Ui, menu: &str) {
        for entry in commands::ALL.iter().filter(|e| e.menu == menu) {
            // A page is closed with its tab.
            if IS_PAGE && entry.command == Command::Quit {
                continue;
            }
            self.command_button(ui, entry.command);
            if entry.command == Command::Open {
                self.recent(ui);
            }
        }
    }

    pub(crate) fn recent(&mut self, ui: &mut egui::Ui) {
        if !IS_PAGE {
            self.recent_files(ui);
        }
        ui.menu_button("Open sample", |ui| {
            for (name, _) in sample_scenes::ALL {
                if ui.button(*name).clicked() {
                    ui.close();
                    let ctx = ui.ctx().clone();
                    self.leave_for(&ctx, AfterDialog::Sample(name));
                }
            }
        });
    }

    pub(crate) fn recent_files(&mut self, ui: &mut egui::Ui) {
        ui.menu_button("Open recent", |ui| {
            if self.preferences.recent.is_empty() {
                ui.weak("No recent files");
            }
            for path in self.preferences.recent.clone() {
                if ui.button(path.display().to_string()).clicked() {
                    ui.close();
                    if self.may_leave(AfterDialog::Open(path.clone())) {
                        self.open(&path);
                    }
                }
            }
        });
    }

    /// Shows a command as a button with its shortcut.
    pub(crate) fn command_button(&mut self, ui: &mut egui::Ui, command: Command) {
        let entry = commands::info(command);
        let shortcut = self.preferences.shortcut(entry);
        let text = shortcut.map(|s| ui.ctx().format_shortcut(&s));
        let button = egui::Button::selectable(self.is_on.contains(&command), entry.name)
            .shortcut_text(text.unwrap_or_default());
        let can = self.can.contains(&command);
        let response = ui.add_enabled(can, button);
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::MenuItem, can, entry.name));
        if response.clicked() {
            ui.close();
            self.requests.push(Request::Run(command));
        }
    }

    /// Shows the current time of an animated scene.
    pub(crate) fn time_bar(&mut self, ui: &mut egui::Ui) {
        let Some(duration) = self.document.scene().duration() else {
            return;
        };
        let before = self.document.scene().time();
        let mut time = before;
        egui::Panel::bottom("time").show(ui, |ui| {
            ui.horizontal(|ui| {
                let label = ui.label("Time");
                ui.spacing_mut().slider_width = (ui.available_width() - 80.0).max(40.0);
                let slider = egui::Slider::new(&mut time, 0.0..=duration).suffix(" s");
                ui.add(slider).labelled_by(label.id);
            });
        });
        if time != before {
            // Forward edits in the order in which they were made.
            self.forward_edits();
            self.document.set_time(time);
            self.renderer.set_time(time);
            self.version += 1;
        }
    }

    /// Shows the last message: for a while, or until it is dismissed if it reports an error.
    pub(crate) fn note_bar(&mut self, ui: &mut egui::Ui) {
        let Some(note) = &self.note else { return };
        let mut text = egui::RichText::new(&note.text);
        let mut is_read = false;
        if note.is_fault {
            text = text.color(Color32::from_rgb(230, 90, 60));
            is_read = icon::button(ui, Icon::Cross, true, "Dismiss").clicked();
        } else {
            let left = SHOWN.saturating_sub(note.told.elapsed());
            if left.is_zero() {
                return;
            }
            ui.ctx().request_repaint_after(left);
        }
        ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
            ui.add(egui::Label::new(text).truncate());
        });
        if is_read {
            self.note = None;
        }
    }
}
