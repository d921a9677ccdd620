//! The editor's application object.

use crate::commands::Command;
use crate::dialog::{AfterDialog, Dialog};
use crate::document::Document;
use crate::files::{FileAccess, IS_PAGE};
use crate::gallery::Gallery;
use crate::inspector::Inspector;
use crate::jobs::Jobs;
use crate::lighting::Lighting;
use crate::materials::Materials;
use crate::outliner::{Outliner, history};
use crate::picking::Picker;
use crate::preferences::Preferences;
use crate::recovery::{self, Recovery};
use crate::render_thread::RenderThread;
use crate::session::Session;
use crate::view::{Tool, ViewState};
use crate::viewport_images::ViewportImages;
use argil::Engine;
use argil::scene::Scene;
use eframe::egui::{self, Align, Layout};
use std::path::PathBuf;

/// Options of the editor at start.
pub struct Options {
    /// The engine that renders.
    pub engine: Engine,
    /// The scene to open.
    pub scene: Option<PathBuf>,
    /// Whether meshes may lie outside the scene's folder.
    pub outside: bool,
    /// Folder of journals. Without it, sessions are not recovered.
    pub recovery: Option<PathBuf>,
    /// File dialogs.
    pub files: Box<dyn FileAccess>,
}

/// The editor: see the module's page.
pub struct Studio {
    pub(crate) session: Session,
    pub(crate) view: ViewState,
    pub(crate) list: Outliner,
    pub(crate) gallery: Gallery,
    pub(crate) inspector: Inspector,
    pub(crate) materials: Materials,
    pub(crate) lighting: Lighting,
    pub(crate) shows_history: bool,
    /// Whether a text field had the keyboard focus at the end of the last frame.
    was_typing: bool,
}

const PREFERENCES: &str = "preferences";

impl Studio {
    /// Creates the editor.
    pub fn new(cc: &eframe::CreationContext<'_>, options: Options) -> Self {
        let kept = cc.storage.and_then(|s| eframe::get_value(s, PREFERENCES));
        let preferences = Preferences::mended(kept.unwrap_or_default());
        let ctx = cc.egui_ctx.clone();
        ctx.set_theme(preferences.theme());
        ctx.set_zoom_factor(preferences.zoom);
        let wake = move || ctx.request_repaint();
        let window = cc.wgpu_render_state.as_ref();
        let session = Session {
            document: Document::new(Scene::new(), None, Recovery::off()),
            world: None,
            version: 0,
            // Exports run in the background on the CPU, because the window uses the GPU. A page has one thread,
            // which the GPU relieves.
            export_engine: if IS_PAGE {
                options.engine.clone()
            } else {
                Engine::cpu()
            },
            renderer: RenderThread::new(options.engine, window.map(|state| &state.device), wake),
            picker: Picker::new(),
            preferences,
            dialog: None,
            note: None,
            jobs: Jobs::default(),
            read_meshes: Default::default(),
            files: options.files,
            recovery_folder: options.recovery,
            may_close: false,
            can: Default::default(),
            is_on: Default::default(),
            requests: Vec::new(),
            #[cfg(target_arch = "wasm32")]
            keeper: crate::local_storage::LocalStorage::new(),
        };
        let mut studio = Self {
            session,
            view: ViewState {
                pictures: ViewportImages::in_window(window),
                ..ViewState::default()
            },
            list: Outliner::default(),
            gallery: Gallery::default(),
            inspector: Inspector::new(),
            materials: Materials::default(),
            lighting: Lighting::default(),
            shows_history: false,
            was_typing: false,
        };
        let session = &mut studio.session;
        #[cfg(target_arch = "wasm32")]
        if let Some(address) = crate::web_world::asked_for() {
            session.replace_scene(crate::sample_scenes::first(), None);
            session.show_note(format!("Opening {address}"));
            crate::web_world::fetch(&cc.egui_ctx, address);
            return studio;
        }
        #[cfg(target_arch = "wasm32")]
        if let Some(text) = crate::local_storage::LocalStorage::found() {
            match Scene::from_json(&text, "the scene that the browser stored") {
                Ok(scene) => session.open_kept(scene),
                Err(error) => {
                    crate::local_storage::quarantine(&text);
                    session.replace_scene(crate::sample_scenes::first(), None);
                    session.fail(&error.into());
                }
            }
            return studio;
        }
        if let Some(path) = &options.scene {
            session.open_with(path, options.outside);
        }
        // Show the sample scene if no scene was requested, or if it cannot be opened.
        if session.document.path().is_none() && session.world.is_none() {
            session.replace_scene(crate::sample_scenes::first(), None);
        }
        if let Some(folder) = &session.recovery_folder {
            let left = recovery::left_in(folder);
            if !left.is_empty() {
                session.dialog = Some(Dialog::Recover(left));
            }
        }
        studio
    }

    /// Returns the document.
    pub fn document(&self) -> &Document {
        &self.session.document
    }

    /// Returns the document, for tests that drive the editor.
    pub fn document_mut(&mut self) -> &mut Document {
        &mut self.session.document
    }

    /// Returns the last message.
    pub fn note(&self) -> Option<&str> {
        self.session.note.as_ref().map(|note| note.text.as_str())
    }

    /// Returns the reason why nothing can be rendered.
    pub fn fault(&self) -> Option<&str> {
        self.view.pictures.fault()
    }

    /// Returns what is shown: the document's version, whether it is the final image, and its duration in
    /// milliseconds.
    pub fn shown(&self) -> Option<(u64, bool, f64)> {
        self.view.pictures.shown_request()
    }

    /// Returns the number of pages that the last image lacks because the store of the world does not have them.
    pub fn lost_pages(&self) -> u64 {
        let shown = self.view.pictures.shown.iter();
        shown.map(|shown| shown.lost).sum()
    }

    /// Returns the version of the document.
    pub fn version(&self) -> u64 {
        self.session.version
    }

    /// Returns true if the final image of the current document is shown.
    pub fn is_settled(&self) -> bool {
        self.view.pictures.is_settled && !self.session.renderer.is_busy()
    }

    /// Forwards edits, and ends interactions when the pointer is released.
    pub(crate) fn follow(&mut self, ctx: &egui::Context) {
        if self.session.document.is_in_stroke() && !ctx.input(|i| i.pointer.any_down()) {
            self.session.document.end_stroke();
        }
        self.session.forward_edits();
        if let Some(fault) = self.session.document.take_fault() {
            self.session.fail(&anyhow::anyhow!(
                "this session cannot be recovered after a crash: {fault}"
            ));
        }
        // Do not save a drag that is in progress. A world is not the scene of this browser.
        #[cfg(target_arch = "wasm32")]
        if !self.session.document.is_in_stroke() && !crate::web_world::is_asked_for() {
            let scene = self.session.document.scene();
            let is_changed = self.session.document.is_changed();
            let what = (self.session.version, is_changed);
            let kept = self.session.keeper.keep(ctx, what, || scene.to_json());
            if let Err(error) = kept {
                self.session.fail(&error);
            }
        }
    }

    pub(crate) fn shortcuts(&mut self, ctx: &egui::Context) {
        // Escape has removed the focus from the text field by now, and must not do more.
        if self.session.dialog.is_some() || ctx.text_edit_focused() || self.was_typing {
            return;
        }
        // An open menu has the focus: Escape closes it.
        if egui::Popup::is_any_open(ctx) {
            return;
        }
        // While the pointer is held, keys type numbers for a handle or fly the camera.
        if ctx.input(|i| i.pointer.any_down()) {
            return;
        }
        // egui consumes these keys and sends events instead.
        let clipboard = ctx.input(|i| {
            i.events.iter().find_map(|event| match event {
                egui::Event::Cut => Some((Command::Cut, None)),
                egui::Event::Copy => Some((Command::Copy, None)),
                egui::Event::Paste(text) => Some((Command::Paste, Some(text.clone()))),
                _ => None,
            })
        });
        match clipboard {
            Some((_, Some(text))) => self.session.attempt(|s| s.document.paste(&text)),
            Some((command, None)) => self.run(command, ctx),
            None => {}
        }
        // Match shortcuts with more modifier keys first: Ctrl+Shift+Z also matches Ctrl+Z.
        let mut bound: Vec<_> = crate::commands::ALL
            .iter()
            .filter_map(|e| Some((self.session.preferences.shortcut(e)?, e.command)))
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

    pub(crate) fn guard_closing(&mut self, ctx: &egui::Context) {
        if !ctx.input(|i| i.viewport().close_requested()) || self.session.may_close {
            return;
        }
        if self.session.document.is_changed() {
            ctx.send_viewport_cmd(egui::ViewportCommand::CancelClose);
            self.session.dialog = Some(Dialog::Unsaved(AfterDialog::Quit));
        } else if !self.session.jobs.all().is_empty() {
            ctx.send_viewport_cmd(egui::ViewportCommand::CancelClose);
            self.session.wait_to_close();
        }
    }

    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn dropped(&mut self, ctx: &egui::Context) {
        let files = ctx.input(|i| i.raw.dropped_files.clone());
        for file in files {
            let path = file.path().to_path_buf();
            self.session.open_or_import(&path);
        }
    }

    #[cfg(target_arch = "wasm32")]
    pub(crate) fn dropped(&mut self, ctx: &egui::Context) {
        let files = ctx.input(|i| i.raw.dropped_files.clone());
        if !files.is_empty() {
            crate::browser::read_dropped(ctx, files);
        }
        for world in crate::web_world::arrived() {
            self.session.attempt(|s| s.show_world(world?));
        }
        for files in crate::browser::arrived() {
            match files {
                Ok(files) => self.session.open_bytes(files),
                Err(error) => self.session.fail(&error),
            }
        }
    }

    /// Shows the left panel.
    fn left(&mut self, ui: &mut egui::Ui) {
        let session = &mut self.session;
        let below = 210.0f32.min(0.4 * ui.available_height());
        egui::Panel::bottom("gallery")
            .resizable(true)
            .default_size(below)
            .show(ui, |ui| {
                ui.strong("Shapes");
                let area = egui::ScrollArea::vertical().auto_shrink(false);
                if let Some(shape) = area.show(ui, |ui| self.gallery.ui(ui)).inner {
                    let at = self.view.eye.target;
                    self.view.add_shape(session, shape, at);
                }
            });
        ui.horizontal(|ui| {
            ui.strong("Brushes");
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                ui.weak(format!("{}", session.document.scene().brush_count()));
            });
        });
        let most = if self.shows_history {
            0.5 * ui.available_height()
        } else {
            f32::INFINITY
        };
        self.list.ui(session, ui, most);
        if self.shows_history {
            history(&mut session.document, ui);
        }
    }

    /// Shows the right panel.
    fn right(&mut self, ui: &mut egui::Ui) {
        let session = &mut self.session;
        egui::ScrollArea::vertical()
            .auto_shrink(false)
            .show(ui, |ui| {
                if self.view.tool == Tool::Sculpt {
                    self.view.sculpt_options(session, ui);
                    ui.separator();
                }
                match session.document.active() {
                    Some(node) => self.inspector.ui(session, ui, node),
                    None => {
                        ui.weak("Nothing is selected. Click a brush in the list or in the view.");
                    }
                }
                ui.separator();
                self.materials.ui(session, ui);
                ui.separator();
                self.lighting.ui(session, ui);
            });
    }
}

impl eframe::App for Studio {
    fn ui(&mut self, ui: &mut egui::Ui, _: &mut eframe::Frame) {
        let ctx = ui.ctx().clone();
        self.guard_closing(&ctx);
        self.dropped(&ctx);
        self.shortcuts(&ctx);
        self.work(&ctx);
        self.handle_requests(&ctx);
        self.offer();
        let session = &mut self.session;
        session.menu_bar(ui);
        self.view.tool_bar(session, ui);
        self.view.status_bar(session, ui);
        session.time_bar(ui);
        egui::Panel::left("brushes")
            .default_size(230.0)
            .min_size(180.0)
            .show(ui, |ui| self.left(ui));
        egui::Panel::right("inspector")
            .default_size(270.0)
            .min_size(220.0)
            .show(ui, |ui| self.right(ui));
        egui::CentralPanel::no_frame().show(ui, |ui| self.view.ui(&mut self.session, ui));
        self.session.dialogs(&ctx);
        self.was_typing = ctx.text_edit_focused();
        self.handle_requests(&ctx);
        self.follow(&ctx);
        self.view.ask_for_picture(&mut self.session, &ctx);
        #[cfg(target_arch = "wasm32")]
        crate::browser::store_state(self.is_settled(), self.note(), self.fault());
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        eframe::set_value(storage, PREFERENCES, &self.session.preferences);
        // The page may be about to close. Do not save a drag that is in progress.
        #[cfg(target_arch = "wasm32")]
        if !self.session.document.is_in_stroke() && !crate::web_world::is_asked_for() {
            let session = &mut self.session;
            let scene = session.document.scene();
            let what = (session.version, session.document.is_changed());
            if let Err(error) = session.keeper.keep_now(what, || scene.to_json()) {
                session.fail(&error);
            }
        }
    }

    fn auto_save_interval(&self) -> std::time::Duration {
        std::time::Duration::from_secs(5)
    }

    fn on_exit(&mut self) {
        self.session.document.close();
    }
}
