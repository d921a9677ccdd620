//! The bars above and below.

use crate::app::{Studio, Tool};
use crate::commands::{self, Command, MENUS};
use crate::dialogs::Then;
use crate::files::IS_PAGE;
use crate::painter::{Pipeline, SHOWS};
use crate::samples;
use argil::Show;
use eframe::egui::{self, Align, Color32, Layout};

impl Studio {
    /// The menus.
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

    fn menu(&mut self, ui: &mut egui::Ui, menu: &str) {
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

    fn recent(&mut self, ui: &mut egui::Ui) {
        if !IS_PAGE {
            self.recent_files(ui);
        }
        ui.menu_button("Open sample", |ui| {
            for (name, _) in samples::ALL {
                if ui.button(*name).clicked() {
                    ui.close();
                    let ctx = ui.ctx().clone();
                    if self.may_leave(Then::Sample(name)) {
                        self.go_on(&ctx, Then::Sample(name));
                    }
                }
            }
        });
    }

    fn recent_files(&mut self, ui: &mut egui::Ui) {
        ui.menu_button("Open recent", |ui| {
            if self.preferences.recent.is_empty() {
                ui.weak("Nothing yet");
            }
            for path in self.preferences.recent.clone() {
                if ui.button(path.display().to_string()).clicked() {
                    ui.close();
                    if self.may_leave(Then::Open(path.clone())) {
                        self.open(&path);
                    }
                }
            }
        });
    }

    /// A command as a button with its shortcut.
    pub(crate) fn command_button(&mut self, ui: &mut egui::Ui, command: Command) {
        let entry = commands::info(command);
        let shortcut = self.preferences.shortcut(entry);
        let text = shortcut.map(|s| ui.ctx().format_shortcut(&s));
        let button = egui::Button::selectable(self.is_on(command), entry.name)
            .shortcut_text(text.unwrap_or_default());
        let can = self.can(command);
        let response = ui.add_enabled(can, button);
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::MenuItem, can, entry.name));
        if response.clicked() {
            ui.close();
            let ctx = ui.ctx().clone();
            self.run(command, &ctx);
        }
    }

    /// The tools, and what is looked at.
    pub(crate) fn tool_bar(&mut self, ui: &mut egui::Ui) {
        egui::Panel::top("tools").show(ui, |ui| {
            ui.horizontal_wrapped(|ui| {
                for (tool, word, command) in [
                    (Tool::Select, "Select", Command::Select),
                    (Tool::Move, "Move", Command::Move),
                    (Tool::Rotate, "Rotate", Command::Rotate),
                    (Tool::Scale, "Scale", Command::Scale),
                    (Tool::Sculpt, "Sculpt", Command::SculptAdd),
                ] {
                    let shortcut = self.preferences.shortcut(commands::info(command));
                    let keys = shortcut.map(|s| ui.ctx().format_shortcut(&s));
                    let response = ui.selectable_label(self.tool == tool, word);
                    if let Some(keys) = keys {
                        response.clone().on_hover_text(keys);
                    }
                    if response.clicked() {
                        self.tool = tool;
                    }
                }
                ui.separator();
                let axes = if self.is_local { "Local" } else { "World" };
                if ui
                    .button(axes)
                    .on_hover_text("Axes of the handles")
                    .clicked()
                {
                    self.is_local = !self.is_local;
                }
                ui.toggle_value(&mut self.preferences.snap, "Snap");
                if self.preferences.snap {
                    let own = &mut self.preferences;
                    let length = egui::DragValue::new(&mut own.snap_length)
                        .range(1e-4..=1e3)
                        .speed(0.01)
                        .suffix(" u");
                    ui.add(length);
                    let degrees = egui::DragValue::new(&mut own.snap_degrees)
                        .range(0.1..=180.0)
                        .suffix("°");
                    ui.add(degrees);
                }
                ui.separator();
                for pipeline in Pipeline::ALL {
                    let own = &mut self.preferences.pipeline;
                    ui.selectable_value(own, pipeline, pipeline.word());
                }
                ui.separator();
                let has_bricks = self.preferences.pipeline.has_bricks();
                for (show, word) in SHOWS {
                    let has = show != Show::Bricks || has_bricks;
                    let button = egui::Button::selectable(self.show == show, word);
                    if ui.add_enabled(has, button).clicked() {
                        self.show = show;
                    }
                }
                if self.show == Show::Bricks && !has_bricks {
                    self.show = Show::Shaded;
                }
                ui.separator();
                self.resolution(ui);
                self.split_choice(ui);
            });
        });
    }

    fn resolution(&mut self, ui: &mut egui::Ui) {
        let own = &mut self.preferences.resolution;
        egui::ComboBox::from_id_salt("resolution")
            .width(70.0)
            .selected_text(format!("{own} voxels"))
            .show_ui(ui, |ui| {
                for n in [32, 64, 128, 192, 256, 384, 512] {
                    ui.selectable_value(own, n, format!("{n} voxels"));
                }
            })
            .response
            .on_hover_text("Voxels along the longest side");
    }

    fn split_choice(&mut self, ui: &mut egui::Ui) {
        let Some(second) = &mut self.viewport.split else {
            return;
        };
        ui.separator();
        ui.label("against");
        egui::ComboBox::from_id_salt("second")
            .width(60.0)
            .selected_text(second.word())
            .show_ui(ui, |ui| {
                for pipeline in Pipeline::ALL {
                    ui.selectable_value(second, pipeline, pipeline.word());
                }
            });
        ui.toggle_value(&mut self.viewport.shows_difference, "Difference");
    }

    /// What was told, what runs, and how far it is.
    pub(crate) fn status_bar(&mut self, ui: &mut egui::Ui) {
        egui::Panel::bottom("status").show(ui, |ui| {
            ui.horizontal(|ui| {
                for job in self.jobs.all() {
                    ui.spinner();
                    ui.label(&job.name);
                    if job.part() > 0.0 {
                        ui.add(egui::ProgressBar::new(job.part()).desired_width(90.0));
                    }
                    let can = !job.is_cancelled();
                    if ui
                        .add_enabled(can, egui::Button::new("Cancel").small())
                        .clicked()
                    {
                        job.cancel();
                    }
                }
                if let Some(note) = &self.note {
                    if note.is_fault {
                        ui.colored_label(Color32::from_rgb(230, 90, 60), &note.text);
                    } else {
                        ui.label(&note.text);
                    }
                }
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                    let count = self.document.selection.len();
                    if count > 0 {
                        ui.weak(format!("{count} selected"));
                    }
                });
            });
        });
    }
}
