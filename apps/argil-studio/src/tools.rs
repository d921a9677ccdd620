//! The tool bar and the status bar.

use crate::commands::{self, Command};
use crate::pipeline::{Pipeline, SHOWS};
use crate::segmented_control::choice;
use crate::session::Session;
use crate::view::{Tool, ViewState};
use argil::render::RenderMode;
use eframe::egui::{self, Align, Layout};

/// Duration below which progress is not shown.
const MOMENT: std::time::Duration = std::time::Duration::from_millis(500);

impl ViewState {
    /// Shows the tools and the pipelines.
    pub(crate) fn tool_bar(&mut self, session: &mut Session, ui: &mut egui::Ui) {
        egui::Panel::top("tools").show(ui, |ui| {
            ui.horizontal_wrapped(|ui| {
                for (tool, word, command) in [
                    (Tool::Select, "Select", Command::Select),
                    (Tool::Move, "Move", Command::Move),
                    (Tool::Rotate, "Rotate", Command::Rotate),
                    (Tool::Scale, "Scale", Command::Scale),
                    (Tool::Sculpt, "Sculpt", Command::SculptAdd),
                ] {
                    let shortcut = session.preferences.shortcut(commands::info(command));
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
                ui.toggle_value(&mut session.preferences.snap, "Snap");
                if session.preferences.snap {
                    let preferences = &mut session.preferences;
                    let length = egui::DragValue::new(&mut preferences.snap_length)
                        .range(1e-4..=1e3)
                        .speed(0.01)
                        .suffix(" u");
                    named(ui.add(length), "Snap length");
                    let degrees = egui::DragValue::new(&mut preferences.snap_degrees)
                        .range(0.1..=180.0)
                        .suffix("°");
                    named(ui.add(degrees), "Snap degrees");
                }
                ui.separator();
                for pipeline in Pipeline::all() {
                    let is_shown = session.preferences.pipeline == pipeline;
                    if ui.selectable_label(is_shown, pipeline.label()).clicked() {
                        self.look_at(session, pipeline);
                    }
                }
                ui.separator();
                let pipeline = session.preferences.pipeline;
                for (show, word) in SHOWS {
                    let has = pipeline.supports(show);
                    let button = egui::Button::selectable(self.show == show, word);
                    if ui.add_enabled(has, button).clicked() {
                        self.show = show;
                    }
                }
                if !pipeline.supports(self.show) {
                    self.show = RenderMode::Shaded;
                }
                ui.separator();
                self.resolution(session, ui);
                self.split_choice(session, ui);
            });
        });
    }

    /// Shows a pipeline. If it is the second of two, they are exchanged.
    pub(crate) fn look_at(&mut self, session: &mut Session, pipeline: Pipeline) {
        let before = std::mem::replace(&mut session.preferences.pipeline, pipeline);
        if let Some(second) = &mut self.pictures.split
            && *second == pipeline
        {
            *second = before;
        }
    }

    pub(crate) fn resolution(&mut self, session: &mut Session, ui: &mut egui::Ui) {
        let voxels = &mut session.preferences.resolution;
        let all = [32, 64, 128, 192, 256, 384, 512];
        choice(ui, "Resolution", voxels, all, |n| format!("{n} voxels"))
            .on_hover_text("Voxels along the longest side");
    }

    pub(crate) fn split_choice(&mut self, session: &mut Session, ui: &mut egui::Ui) {
        let Some(second) = &mut self.pictures.split else {
            return;
        };
        ui.separator();
        ui.label("against");
        let first = session.preferences.pipeline;
        let all = Pipeline::all().filter(|p| *p != first);
        choice(ui, "Second pipeline", second, all, |p| p.label());
        ui.toggle_value(&mut self.pictures.shows_difference, "Difference");
    }

    /// Shows a build that takes longer than a moment, with a button to cancel it.
    pub(crate) fn building(&mut self, session: &mut Session, ui: &mut egui::Ui) {
        let Some((request, since)) = session.renderer.is_building() else {
            return;
        };
        if since < MOMENT {
            ui.ctx().request_repaint_after(MOMENT - since);
            return;
        }
        let words: Vec<String> = request.pipelines.iter().map(|p| p.label()).collect();
        let resolution = request.resolution;
        ui.spinner();
        ui.label(format!(
            "Building {} of {resolution} voxels",
            words.join(" and ").to_lowercase()
        ));
        if ui.small_button("Cancel").clicked() {
            self.cancel_building(session);
        }
    }

    /// Cancels a build and returns to the previous pipeline, or to the field, which needs no build.
    pub(crate) fn cancel_building(&mut self, session: &mut Session) {
        let wanted = [Some(session.preferences.pipeline), self.pictures.split];
        let before = self.pictures.last_shown();
        let is_other = |(pipelines, resolution): &([Option<Pipeline>; 2], u32)| {
            *pipelines != wanted || *resolution != session.preferences.resolution
        };
        let resolution = session.preferences.resolution;
        let field = ([Some(Pipeline::field()), None], resolution);
        let ([first, second], resolution) = before.filter(is_other).unwrap_or(field);
        session.preferences.pipeline = first.unwrap_or_default();
        session.preferences.resolution = resolution;
        self.pictures.split = second;
        session.forward_edits();
        session
            .renderer
            .abandon(session.document.scene(), session.version);
        self.pictures.forget_request();
        session.show_note("Canceled");
    }

    /// Shows the last message and the running jobs.
    pub(crate) fn status_bar(&mut self, session: &mut Session, ui: &mut egui::Ui) {
        egui::Panel::bottom("status").show(ui, |ui| {
            ui.horizontal(|ui| {
                self.building(session, ui);
                for job in session.jobs.all() {
                    ui.spinner();
                    ui.label(&job.name);
                    // The button comes before the bar, which appears later: the button must not move under the
                    // pointer.
                    if ui.small_button("Cancel").clicked() {
                        job.cancel();
                    }
                    if job.part() > 0.0 {
                        ui.add(egui::ProgressBar::new(job.part()).desired_width(90.0));
                    }
                }
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                    let count = session.document.selection.len();
                    if count > 0 {
                        ui.weak(format!("{count} selected"));
                    }
                    session.note_bar(ui);
                });
            });
        });
    }
}

/// Sets a number's accessible name.
fn named(response: egui::Response, name: &str) {
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::SpinButton, true, name));
}
