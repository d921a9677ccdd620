//! The editor as a whole.

use crate::commands::Command;
use crate::dialogs::Dialog;
use crate::document::Document;
use crate::eye::Eye;
use crate::files::{Files, IS_PAGE};
use crate::gallery::Gallery;
use crate::inspector::Docs;
use crate::jobs::Jobs;
use crate::picker::Picker;
use crate::preferences::Preferences;
use crate::recovery::{self, Recovery};
use crate::renderer::Renderer;
use crate::sculpt::Sculpting;
use crate::viewport::Viewport;
use argil::{Engine, Scene, Show};
use eframe::egui;
use std::path::PathBuf;

/// What the pointer does in the viewport.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tool {
    /// Pick.
    #[default]
    Select,
    /// Pick and move.
    Move,
    /// Pick and rotate.
    Rotate,
    /// Pick and scale.
    Scale,
    /// Sculpt.
    Sculpt,
}

/// How it is begun.
pub struct Options {
    /// What to draw on.
    pub engine: Engine,
    /// A scene to open.
    pub scene: Option<PathBuf>,
    /// Whether its meshes may be anywhere.
    pub outside: bool,
    /// Where journals are kept; nothing is brought back without.
    pub recovery: Option<PathBuf>,
    /// How files are asked for.
    pub files: Box<dyn Files>,
}

/// See the module's page.
pub struct Studio {
    pub(crate) document: Document,
    /// Lines of the document since it was opened, and a thousand for each document before.
    pub(crate) version: u64,
    pub(crate) renderer: Renderer,
    pub(crate) picker: Picker,
    pub(crate) eye: Eye,
    pub(crate) tool: Tool,
    pub(crate) is_local: bool,
    pub(crate) show: Show,
    pub(crate) sculpting: Sculpting,
    pub(crate) viewport: Viewport,
    pub(crate) gallery: Gallery,
    pub(crate) docs: Docs,
    pub(crate) preferences: Preferences,
    pub(crate) dialog: Option<Dialog>,
    pub(crate) shows_history: bool,
    pub(crate) renaming: Option<(argil::NodeId, String)>,
    /// A material that is given another name, and what is typed.
    pub(crate) naming: Option<(String, String)>,
    pub(crate) collapsed: std::collections::BTreeSet<argil::NodeId>,
    /// Whose row the list is to show.
    pub(crate) revealed: Option<argil::NodeId>,
    /// The last thing that went wrong, or was done.
    pub(crate) note: Option<Note>,
    pub(crate) jobs: Jobs,
    /// Meshes that were read since it was begun, as scenes name them.
    pub(crate) read_meshes: std::collections::BTreeSet<String>,
    /// Whether text had the keyboard when the last frame ended.
    was_typing: bool,
    /// What exported pictures are drawn on.
    pub(crate) export_engine: Engine,
    pub(crate) files: Box<dyn Files>,
    pub(crate) recovery_folder: Option<PathBuf>,
    pub(crate) may_close: bool,
    #[cfg(target_arch = "wasm32")]
    keeper: crate::page::Keeper,
}

/// Something to be told.
pub struct Note {
    /// In words.
    pub text: String,
    /// Whether it went wrong.
    pub is_fault: bool,
    /// When.
    pub told: web_time::Instant,
}

const PREFERENCES: &str = "preferences";

impl Studio {
    /// Begin.
    pub fn new(cc: &eframe::CreationContext<'_>, options: Options) -> Self {
        let kept = cc.storage.and_then(|s| eframe::get_value(s, PREFERENCES));
        let preferences = Preferences::mended(kept.unwrap_or_default());
        let ctx = cc.egui_ctx.clone();
        ctx.set_theme(preferences.theme());
        ctx.set_zoom_factor(preferences.zoom);
        let wake = move || ctx.request_repaint();
        let mut studio = Self {
            document: Document::new(Scene::new(), None, Recovery::off()),
            version: 0,
            // Beside the window, which has the GPU; but a page has one thread, and the GPU spares it.
            export_engine: if IS_PAGE {
                options.engine.clone()
            } else {
                Engine::cpu()
            },
            renderer: Renderer::new(options.engine, wake),
            picker: Picker::new(),
            eye: Eye::default(),
            tool: Tool::default(),
            is_local: false,
            show: Show::default(),
            sculpting: Sculpting::default(),
            viewport: Viewport::default(),
            gallery: Gallery::default(),
            docs: Docs::new(),
            preferences,
            dialog: None,
            shows_history: false,
            renaming: None,
            naming: None,
            collapsed: Default::default(),
            revealed: None,
            note: None,
            jobs: Jobs::default(),
            read_meshes: Default::default(),
            was_typing: false,
            files: options.files,
            recovery_folder: options.recovery,
            may_close: false,
            #[cfg(target_arch = "wasm32")]
            keeper: crate::page::Keeper::new(),
        };
        #[cfg(target_arch = "wasm32")]
        if let Some(text) = crate::page::Keeper::found() {
            match Scene::from_json(&text, "what the browser kept") {
                Ok(scene) => studio.open_kept(scene),
                Err(error) => {
                    crate::page::set_aside(&text);
                    studio.replace_scene(crate::samples::first(), None);
                    studio.fail(&error.into());
                }
            }
            return studio;
        }
        if let Some(path) = &options.scene {
            studio.open_with(path, options.outside);
        }
        // Where none was asked for, and where it cannot be opened.
        if studio.document.path().is_none() {
            studio.replace_scene(crate::samples::first(), None);
        }
        if let Some(folder) = &studio.recovery_folder {
            let left = recovery::left_in(folder);
            if !left.is_empty() {
                studio.dialog = Some(Dialog::Recover(left));
            }
        }
        studio
    }

    /// The document.
    pub fn document(&self) -> &Document {
        &self.document
    }

    /// The document, for those that drive the editor.
    pub fn document_mut(&mut self) -> &mut Document {
        &mut self.document
    }

    /// What was told last.
    pub fn note(&self) -> Option<&str> {
        self.note.as_ref().map(|note| note.text.as_str())
    }

    /// Why nothing can be drawn.
    pub fn fault(&self) -> Option<&str> {
        self.viewport.fault()
    }

    /// What is shown: after how many lines of the document, whether in full, and what it took in milliseconds.
    pub fn shown(&self) -> Option<(u64, bool, f64)> {
        self.viewport.shown_request()
    }

    /// Lines of the document so far.
    pub fn version(&self) -> u64 {
        self.version
    }

    /// Whether the picture is of what is there now, in full.
    pub fn is_settled(&self) -> bool {
        self.viewport.is_settled && !self.renderer.is_busy()
    }

    /// Have a scene in place of the one that is open.
    pub(crate) fn replace_scene(&mut self, scene: Scene, path: Option<PathBuf>) {
        self.document.close();
        let recovery = match &self.recovery_folder {
            Some(folder) => Recovery::within(folder.clone()),
            None => Recovery::off(),
        };
        self.take_in(Document::new(scene, path, recovery));
    }

    /// Have a document that is as it should be.
    pub(crate) fn take_in(&mut self, document: Document) {
        self.document = document;
        self.version += 1000;
        self.picker.forget();
        self.collapsed.clear();
        self.renderer.load(self.document.scene(), self.version);
        let scene = self.document.scene();
        if let Some(world) = self.picker.world(scene, self.version) {
            self.eye = Eye::of(&world.camera());
        }
        self.viewport.forget();
    }

    pub(crate) fn tell(&mut self, text: impl Into<String>) {
        self.say(text.into(), false);
    }

    pub(crate) fn fail(&mut self, error: &anyhow::Error) {
        self.say(format!("{error:#}"), true);
    }

    fn say(&mut self, text: String, is_fault: bool) {
        let told = web_time::Instant::now();
        self.note = Some(Note {
            text,
            is_fault,
            told,
        });
    }

    /// Do, and tell what goes wrong.
    pub(crate) fn attempt(&mut self, what: impl FnOnce(&mut Self) -> anyhow::Result<()>) {
        if let Err(error) = what(self) {
            self.fail(&error);
        }
    }

    /// Hand on what was done.
    pub(crate) fn hand_on(&mut self) {
        self.load_wanted();
        let lines = self.document.take_lines();
        self.version += lines.len() as u64;
        self.renderer.follow(lines);
    }

    /// Hand on what was done, and end what ends with the pointer.
    fn follow(&mut self, ctx: &egui::Context) {
        if self.document.is_in_stroke() && !ctx.input(|i| i.pointer.any_down()) {
            self.document.end_stroke();
        }
        self.hand_on();
        if let Some(fault) = self.document.take_fault() {
            self.fail(&anyhow::anyhow!(
                "after a crash nothing would come back: {fault}"
            ));
        }
        // Half of a drag is not what anybody wants back.
        #[cfg(target_arch = "wasm32")]
        if !self.document.is_in_stroke() {
            let scene = self.document.scene();
            let is_changed = self.document.is_changed();
            let what = (self.version, is_changed);
            let kept = self.keeper.keep(ctx, what, || scene.to_json());
            if let Err(error) = kept {
                self.fail(&error);
            }
        }
    }

    fn shortcuts(&mut self, ctx: &egui::Context) {
        // Escape has taken the keyboard from what was typed by now, and is not to take more.
        if self.dialog.is_some() || ctx.text_edit_focused() || self.was_typing {
            return;
        }
        // An open menu has the keyboard: Escape closes it.
        if egui::Popup::is_any_open(ctx) {
            return;
        }
        // What is held goes to its end first: keys are numbers for a handle then, or fly.
        if ctx.input(|i| i.pointer.any_down()) {
            return;
        }
        // egui takes these keys and gives events in their place.
        let clipboard = ctx.input(|i| {
            i.events.iter().find_map(|event| match event {
                egui::Event::Cut => Some((Command::Cut, None)),
                egui::Event::Copy => Some((Command::Copy, None)),
                egui::Event::Paste(text) => Some((Command::Paste, Some(text.clone()))),
                _ => None,
            })
        });
        match clipboard {
            Some((_, Some(text))) => self.attempt(|s| s.paste(&text)),
            Some((command, None)) => self.run(command, ctx),
            None => {}
        }
        // With more keys held first: Ctrl+Shift+Z is Ctrl+Z too.
        let mut bound: Vec<_> = crate::commands::ALL
            .iter()
            .filter_map(|e| Some((self.preferences.shortcut(e)?, e.command)))
            .collect();
        bound.sort_by_key(|(s, _)| {
            let m = s.modifiers;
            std::cmp::Reverse(u8::from(m.shift) + u8::from(m.alt) + u8::from(m.command))
        });
        for (shortcut, command) in bound {
            if ctx.input_mut(|i| i.consume_shortcut(&shortcut)) {
                self.run(command, ctx);
            }
        }
    }

    fn guard_closing(&mut self, ctx: &egui::Context) {
        if !ctx.input(|i| i.viewport().close_requested()) || self.may_close {
            return;
        }
        if self.document.is_changed() {
            ctx.send_viewport_cmd(egui::ViewportCommand::CancelClose);
            self.dialog = Some(Dialog::Unsaved(crate::dialogs::Then::Quit));
        } else if !self.jobs.all().is_empty() {
            ctx.send_viewport_cmd(egui::ViewportCommand::CancelClose);
            self.wait_to_close();
        }
    }

    #[cfg(not(target_arch = "wasm32"))]
    fn dropped(&mut self, ctx: &egui::Context) {
        let files = ctx.input(|i| i.raw.dropped_files.clone());
        for file in files {
            let path = file.path().to_path_buf();
            self.open_or_import(&path);
        }
    }

    #[cfg(target_arch = "wasm32")]
    fn dropped(&mut self, ctx: &egui::Context) {
        let files = ctx.input(|i| i.raw.dropped_files.clone());
        if !files.is_empty() {
            crate::page::read_dropped(ctx, files);
        }
        for files in crate::page::arrived() {
            match files {
                Ok(files) => self.open_bytes(files),
                Err(error) => self.fail(&error),
            }
        }
    }
}

impl eframe::App for Studio {
    fn ui(&mut self, ui: &mut egui::Ui, _: &mut eframe::Frame) {
        let ctx = ui.ctx().clone();
        self.guard_closing(&ctx);
        self.dropped(&ctx);
        self.shortcuts(&ctx);
        self.work(&ctx);
        self.menu_bar(ui);
        self.tool_bar(ui);
        self.status_bar(ui);
        self.time_bar(ui);
        egui::Panel::left("brushes")
            .default_size(230.0)
            .min_size(180.0)
            .show(ui, |ui| self.left(ui));
        egui::Panel::right("inspector")
            .default_size(270.0)
            .min_size(220.0)
            .show(ui, |ui| self.right(ui));
        egui::CentralPanel::no_frame().show(ui, |ui| self.view(ui));
        self.dialogs(&ctx);
        self.was_typing = ctx.text_edit_focused();
        self.follow(&ctx);
        self.ask_for_picture(&ctx);
        #[cfg(target_arch = "wasm32")]
        crate::page::note(self.is_settled(), self.note());
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        eframe::set_value(storage, PREFERENCES, &self.preferences);
        // The page may be about to go.
        // Half of a drag is not what anybody wants back.
        #[cfg(target_arch = "wasm32")]
        if !self.document.is_in_stroke() {
            let scene = self.document.scene();
            let what = (self.version, self.document.is_changed());
            if let Err(error) = self.keeper.keep_now(what, || scene.to_json()) {
                self.fail(&error);
            }
        }
    }

    fn auto_save_interval(&self) -> std::time::Duration {
        std::time::Duration::from_secs(5)
    }

    fn on_exit(&mut self) {
        self.document.close();
    }
}
