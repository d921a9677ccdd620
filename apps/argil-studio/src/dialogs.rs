//! Shows the dialogs.

use crate::commands::{self, Command};
use crate::dialog::{AfterDialog, Dialog};
use crate::recovery::{self, RecoverableSession};
use crate::session::{Request, Session};
use eframe::egui::{self, Key, KeyboardShortcut};

impl Session {
    /// Shows the open dialog.
    pub(crate) fn dialogs(&mut self, ctx: &egui::Context) {
        let Some(dialog) = self.dialog.take() else {
            return;
        };
        let stays;
        let dialog = match dialog {
            Dialog::Unsaved(then) => {
                stays = self.unsaved(ctx, &then);
                Dialog::Unsaved(then)
            }
            Dialog::Unfinished(steps) => {
                stays = self.unfinished(ctx, steps);
                Dialog::Unfinished(steps)
            }
            Dialog::Recover(mut left) => {
                stays = self.left_over(ctx, &mut left);
                Dialog::Recover(left)
            }
            Dialog::Palette { mut text, mut at } => {
                stays = self.palette(ctx, &mut text, &mut at);
                Dialog::Palette { text, at }
            }
            Dialog::Help(mut bound) => {
                stays = self.help(ctx, &mut bound);
                Dialog::Help(bound)
            }
        };
        // The choice may have opened another dialog.
        if stays && self.dialog.is_none() {
            self.dialog = Some(dialog);
        }
    }

    pub(crate) fn unsaved(&mut self, ctx: &egui::Context, then: &AfterDialog) -> bool {
        let title = self.document.title();
        let mut stays = true;
        let modal = egui::Modal::new(egui::Id::unique("unsaved")).show(ctx, |ui| {
            ui.heading(format!("{title} has unsaved changes"));
            ui.horizontal(|ui| {
                if ui.button("Save").clicked() && self.save_scene(false) {
                    stays = false;
                    self.go_on(ctx, then.clone());
                }
                if ui.button("Do not save").clicked() {
                    stays = false;
                    self.go_on(ctx, then.clone());
                }
                if ui.button("Cancel").clicked() {
                    stays = false;
                }
            });
        });
        stays && !modal.should_close()
    }

    /// Continues after the question whether to save.
    pub(crate) fn go_on(&mut self, ctx: &egui::Context, then: AfterDialog) {
        match then {
            AfterDialog::New => self.replace_scene(argil::scene::Scene::new(), None),
            AfterDialog::Ask => self.ask_to_open(),
            AfterDialog::Open(path) => self.open(&path),
            #[cfg(target_arch = "wasm32")]
            AfterDialog::NamedBytes(scene, meshes) => self.open_given(&scene, &meshes),
            AfterDialog::Sample(name) => {
                if let Some(scene) = crate::sample_scenes::sample(name) {
                    self.replace_scene(scene, None);
                }
            }
            AfterDialog::Quit if !self.jobs.all().is_empty() => self.wait_to_close(),
            AfterDialog::Quit => self.close(ctx),
        }
    }

    pub(crate) fn close(&mut self, ctx: &egui::Context) {
        self.may_close = true;
        ctx.send_viewport_cmd(egui::ViewportCommand::Close);
    }

    /// Closes the window once background jobs have finished.
    pub(crate) fn wait_to_close(&mut self) {
        self.dialog = Some(Dialog::Unfinished(self.document.history().1));
    }

    /// Keeps the window open, because a job failed and its error must be read.
    pub(crate) fn stay_open(&mut self) {
        self.dialog
            .take_if(|dialog| matches!(dialog, Dialog::Unfinished(_)));
    }

    pub(crate) fn unfinished(&mut self, ctx: &egui::Context, steps: usize) -> bool {
        if self.jobs.all().is_empty() {
            // A job may have made an edit after the question whether to save.
            if self.document.history().1 == steps {
                self.close(ctx);
            } else {
                self.dialog = Some(Dialog::Unsaved(AfterDialog::Quit));
            }
            return false;
        }
        let mut stays = true;
        let modal = egui::Modal::new(egui::Id::unique("unfinished")).show(ctx, |ui| {
            ui.heading("Argil Studio closes when this job is done");
            for job in self.jobs.all() {
                ui.label(&job.name);
            }
            ui.horizontal(|ui| {
                if ui.button("Close now").clicked() {
                    stays = false;
                    self.close(ctx);
                }
                if ui.button("Do not close").clicked() {
                    stays = false;
                }
            });
        });
        stays && !modal.should_close()
    }

    pub(crate) fn left_over(
        &mut self,
        ctx: &egui::Context,
        left: &mut Vec<RecoverableSession>,
    ) -> bool {
        let mut stays = true;
        egui::Modal::new(egui::Id::unique("recover")).show(ctx, |ui| {
            ui.heading("A previous session ended without saving");
            let mut chosen = None;
            for (i, session) in left.iter().enumerate() {
                ui.horizontal(|ui| {
                    let name = match &session.scene {
                        Some(path) => path.display().to_string(),
                        None => "Untitled".into(),
                    };
                    ui.label(name);
                    if ui.button("Restore").clicked() {
                        chosen = Some((i, true));
                    }
                    if ui.button("Discard").clicked() {
                        chosen = Some((i, false));
                    }
                });
            }
            if let Some((i, back)) = chosen {
                let session = left.remove(i);
                if back {
                    stays = false;
                    self.attempt(|s| s.recover(session));
                } else {
                    recovery::discard(&session);
                }
            }
            if ui.button("Later").clicked() {
                stays = false;
            }
        });
        stays && !left.is_empty()
    }

    pub(crate) fn palette(
        &mut self,
        ctx: &egui::Context,
        text: &mut String,
        at: &mut usize,
    ) -> bool {
        let mut run = None;
        let modal = egui::Modal::new(egui::Id::unique("palette")).show(ctx, |ui| {
            ui.set_width(340.0);
            let field = egui::TextEdit::singleline(text).hint_text("Find a command");
            let response = ui.add(field.desired_width(f32::INFINITY));
            response.request_focus();
            if response.changed() {
                *at = 0;
            }
            let words: Vec<String> = text.split_whitespace().map(str::to_lowercase).collect();
            let fits = |e: &&commands::CommandInfo| {
                let name = format!("{} {}", e.menu, e.name).to_lowercase();
                words.iter().all(|word| name.contains(word))
            };
            let found: Vec<_> = commands::ALL.iter().filter(fits).collect();
            let (up, down, enter) = ui.input(|i| {
                (
                    i.key_pressed(Key::ArrowUp),
                    i.key_pressed(Key::ArrowDown),
                    i.key_pressed(Key::Enter),
                )
            });
            let last = found.len().saturating_sub(1);
            if down {
                *at = (*at + 1).min(last);
            }
            if up {
                *at = at.saturating_sub(1);
            }
            if enter {
                run = found.get(*at).map(|e| e.command);
            }
            egui::ScrollArea::vertical()
                .max_height(320.0)
                .show(ui, |ui| {
                    for (i, entry) in found.iter().enumerate() {
                        let shortcut = self.preferences.shortcut(entry);
                        let shortcut = shortcut.map(|s| ui.ctx().format_shortcut(&s));
                        let button = egui::Button::selectable(i == *at, entry.name)
                            .shortcut_text(shortcut.unwrap_or_default())
                            .min_size(egui::vec2(ui.available_width(), 0.0));
                        let response = ui.add(button);
                        if i == *at && (up || down) {
                            response.scroll_to_me(None);
                        }
                        if response.clicked() {
                            run = Some(entry.command);
                        }
                    }
                });
        });
        if let Some(command) = run {
            self.requests.push(Request::Run(command));
            return false;
        }
        !modal.should_close()
    }

    pub(crate) fn help(&mut self, ctx: &egui::Context, bound: &mut Option<Command>) -> bool {
        let mut closes = false;
        let modal = egui::Modal::new(egui::Id::unique("help")).show(ctx, |ui| {
            ui.heading("Shortcuts");
            ui.label("In the view: drag to orbit, Shift-drag to pan, scroll to zoom, right-drag to look and fly with W A S D Q E. Shift-drag a handle to duplicate. Type a number while dragging a handle to say by how much; Escape cancels a drag or a stroke.");
            if let Some(command) = *bound {
                let name = commands::info(command).name;
                ui.strong(format!("Press the keys for “{name}”, or Backspace for no shortcut."));
                if let Some(shortcut) = pressed(ui) {
                    let none = shortcut.logical_key == Key::Backspace;
                    self.preferences.bind(command, (!none).then_some(shortcut));
                    *bound = None;
                }
            }
            egui::ScrollArea::vertical()
                .max_height(0.6 * ui.ctx().content_rect().height())
                .show(ui, |ui| {
                    egui::Grid::new("shortcuts").striped(true).show(ui, |ui| {
                        for entry in commands::ALL {
                            ui.label(entry.menu);
                            ui.label(entry.name);
                            let shortcut = self.preferences.shortcut(entry);
                            let text = shortcut.map(|s| ui.ctx().format_shortcut(&s));
                            let button = ui.button(text.unwrap_or_else(|| "–".into()));
                            let name = entry.name;
                            button.widget_info(|| {
                                let text = format!("Shortcut of {name}");
                                egui::WidgetInfo::labeled(egui::Role::Button, true, text)
                            });
                            if button.on_hover_text("Change shortcut").clicked() {
                                *bound = Some(entry.command);
                            }
                            ui.end_row();
                        }
                    });
                });
            ui.horizontal(|ui| {
                closes = ui.button("Close").clicked();
                if ui.button("Reset all").clicked() {
                    self.preferences.shortcuts.clear();
                }
            });
        });
        // Escape may be the shortcut being assigned.
        !closes && (bound.is_some() || !modal.should_close())
    }
}

/// Returns the pressed keys as a shortcut.
fn pressed(ui: &egui::Ui) -> Option<KeyboardShortcut> {
    ui.input(|i| {
        i.events.iter().find_map(|event| match event {
            egui::Event::Key {
                key,
                pressed: true,
                modifiers,
                ..
            } => {
                let held_modifiers = egui::Modifiers {
                    ctrl: false,
                    mac_cmd: false,
                    ..*modifiers
                };
                Some(KeyboardShortcut::new(held_modifiers, *key))
            }
            _ => None,
        })
    })
}
