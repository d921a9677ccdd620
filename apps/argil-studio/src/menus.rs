//! The bars above and below.

use crate::app::{Studio, Tool};
use crate::choice::choice;
use crate::commands::{self, Command, MENUS};
use crate::dialogs::Then;
use crate::files::IS_PAGE;
use crate::icon::{self, Icon};
use crate::painter::{Pipeline, SHOWS};
use crate::samples;
use argil::Show;
use eframe::egui::{self, Align, Color32, Layout};

/// So long a message is shown that nothing went wrong of.
const SHOWN: std::time::Duration = std::time::Duration::from_secs(12);

/// What takes no longer is not told of.
const MOMENT: std::time::Duration = std::time::Duration::from_millis(500);

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
                    named(ui.add(length), "Snap length");
                    let degrees = egui::DragValue::new(&mut own.snap_degrees)
                        .range(0.1..=180.0)
                        .suffix("°");
                    named(ui.add(degrees), "Snap degrees");
                }
                ui.separator();
                for pipeline in Pipeline::ALL {
                    let is_shown = self.preferences.pipeline == pipeline;
                    if ui.selectable_label(is_shown, pipeline.word()).clicked() {
                        self.look_at(pipeline);
                    }
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

    /// The time that is looked at, of a scene that changes with it.
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
            // In the order in which it was done.
            self.hand_on();
            self.document.set_time(time);
            self.renderer.set_time(time);
            self.version += 1;
        }
    }

    /// Draw by a pipeline; where it is the second of two, they change places.
    fn look_at(&mut self, pipeline: Pipeline) {
        let before = std::mem::replace(&mut self.preferences.pipeline, pipeline);
        if let Some(second) = &mut self.viewport.split
            && *second == pipeline
        {
            *second = before;
        }
    }

    fn resolution(&mut self, ui: &mut egui::Ui) {
        let own = &mut self.preferences.resolution;
        let all = [32, 64, 128, 192, 256, 384, 512];
        choice(ui, "Resolution", own, all, |n| format!("{n} voxels"))
            .on_hover_text("Voxels along the longest side");
    }

    fn split_choice(&mut self, ui: &mut egui::Ui) {
        let Some(second) = &mut self.viewport.split else {
            return;
        };
        ui.separator();
        ui.label("against");
        let first = self.preferences.pipeline;
        let all = Pipeline::ALL.into_iter().filter(|p| *p != first);
        choice(ui, "Second pipeline", second, all, |p| p.word().into());
        ui.toggle_value(&mut self.viewport.shows_difference, "Difference");
    }

    /// What is being made to be drawn, if it takes longer than a moment; and a way back.
    fn building(&mut self, ui: &mut egui::Ui) {
        let Some((request, since)) = self.renderer.is_building() else {
            return;
        };
        if since < MOMENT {
            ui.ctx().request_repaint_after(MOMENT - since);
            return;
        }
        let words: Vec<&str> = request.pipelines.iter().map(|p| p.word()).collect();
        let resolution = request.resolution;
        ui.spinner();
        ui.label(format!(
            "Building {} of {resolution} voxels",
            words.join(" and ").to_lowercase()
        ));
        if ui.small_button("Cancel").clicked() {
            self.give_up_building();
        }
    }

    /// Go back to what was shown before, or to the field, which takes no building.
    fn give_up_building(&mut self) {
        let wanted = [Some(self.preferences.pipeline), self.viewport.split];
        let before = self.viewport.last_shown();
        let is_other = |(pipelines, resolution): &([Option<Pipeline>; 2], u32)| {
            *pipelines != wanted || *resolution != self.preferences.resolution
        };
        let resolution = self.preferences.resolution;
        let field = ([Some(Pipeline::Field), None], resolution);
        let ([first, second], resolution) = before.filter(is_other).unwrap_or(field);
        self.preferences.pipeline = first.unwrap_or_default();
        self.preferences.resolution = resolution;
        self.viewport.split = second;
        self.hand_on();
        self.renderer.abandon(self.document.scene(), self.version);
        self.viewport.forget_request();
        self.tell("Cancelled");
    }

    /// What was told: for a while, and what went wrong until it is put away.
    fn note_bar(&mut self, ui: &mut egui::Ui) {
        let Some(note) = &self.note else { return };
        let mut text = egui::RichText::new(&note.text);
        let mut is_read = false;
        if note.is_fault {
            text = text.color(Color32::from_rgb(230, 90, 60));
            is_read = icon::button(ui, Icon::Cross, true, "Put the message away").clicked();
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

    /// What was told, what runs, and how far it is.
    pub(crate) fn status_bar(&mut self, ui: &mut egui::Ui) {
        egui::Panel::bottom("status").show(ui, |ui| {
            ui.horizontal(|ui| {
                self.building(ui);
                for job in self.jobs.all() {
                    ui.spinner();
                    ui.label(&job.name);
                    if job.part() > 0.0 {
                        ui.add(egui::ProgressBar::new(job.part()).desired_width(90.0));
                    }
                    if ui.small_button("Cancel").clicked() {
                        job.cancel();
                    }
                }
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                    let count = self.document.selection.len();
                    if count > 0 {
                        ui.weak(format!("{count} selected"));
                    }
                    self.note_bar(ui);
                });
            });
        });
    }
}

/// Have screen readers told what a number is.
fn named(response: egui::Response, name: &str) {
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::SpinButton, true, name));
}
