//! Runs commands.

use crate::app::Studio;
use crate::commands::{self, Command};
use crate::dialog::{AfterDialog, Dialog};
use crate::document::Document;
use crate::files::{FileRequest, IS_PAGE};
use crate::jobs::JobResult;
use crate::sculpting::SculptKind;
use crate::session::{Request, Session};
use crate::view::Tool;
use crate::viewport_camera::{ViewSide, ViewportCamera};
use argil::glam::Vec3;
use argil::scene::Scene;
use eframe::egui;

impl Studio {
    /// Returns true if a command is available.
    fn can(&self, command: Command) -> bool {
        let document = &self.session.document;
        let (names, done) = document.history();
        match command {
            Command::Undo => done > 0,
            Command::Redo => done < names.len(),
            Command::Cut
            | Command::Copy
            | Command::Duplicate
            | Command::Delete
            | Command::Group
            | Command::Ungroup
            | Command::Hide
            | Command::Lock
            | Command::Rename
            | Command::MirrorX
            | Command::MirrorY
            | Command::MirrorZ
            | Command::NudgeLeft
            | Command::NudgeRight
            | Command::NudgeUp
            | Command::NudgeDown
            | Command::NudgeNearer
            | Command::NudgeFarther
            | Command::SelectNone
            | Command::FrameSelection => !document.selection.is_empty(),
            Command::Difference => self.view.pictures.split.is_some(),
            Command::Paths => !crate::files::IS_PAGE && self.view.pictures.split.is_none(),
            _ => true,
        }
    }

    /// Returns true if a command's switch is on.
    fn is_on(&self, command: Command) -> bool {
        let (view, preferences) = (&self.view, &self.session.preferences);
        match command {
            Command::Select => view.tool == Tool::Select,
            Command::Move => view.tool == Tool::Move,
            Command::Rotate => view.tool == Tool::Rotate,
            Command::Scale => view.tool == Tool::Scale,
            Command::LocalSpace => view.is_local,
            Command::Snap => preferences.snap,
            Command::Ortho => view.eye.is_ortho,
            Command::Grid => preferences.grid,
            Command::Readings => preferences.readings,
            Command::Split => view.pictures.split.is_some(),
            Command::Difference => view.pictures.shows_difference,
            Command::Paths => view.traces_paths,
            Command::History => self.shows_history,
            _ => false,
        }
    }

    /// Updates which commands are available and which switches are on.
    pub(crate) fn offer(&mut self) {
        let all = || commands::ALL.iter().map(|entry| entry.command);
        let can = all().filter(|&command| self.can(command)).collect();
        let is_on = all().filter(|&command| self.is_on(command)).collect();
        (self.session.can, self.session.is_on) = (can, is_on);
    }

    /// Runs a command.
    pub(crate) fn run(&mut self, command: Command, ctx: &egui::Context) {
        if !self.can(command) {
            return;
        }
        let (session, view) = (&mut self.session, &mut self.view);
        let document = &mut session.document;
        let preferences = &mut session.preferences;
        match command {
            Command::New => session.leave_for(ctx, AfterDialog::New),
            // On a page, the question follows after the chosen file is read.
            Command::Open if IS_PAGE => session.ask_to_open(),
            Command::Open => session.leave_for(ctx, AfterDialog::Ask),
            Command::Save => drop(session.save_scene(false)),
            Command::SaveAs => drop(session.save_scene(true)),
            Command::Import => session.ask_to_import(),
            Command::ExportMesh => session.export(FileRequest::Mesh, view.eye),
            Command::ExportPicture => session.export(FileRequest::Picture, view.eye),
            Command::ExportTurntable => session.export(FileRequest::Turntable, view.eye),
            Command::ExportVolume => session.export(FileRequest::Volume, view.eye),
            Command::Quit => session.leave_for(ctx, AfterDialog::Quit),
            Command::Undo => document.undo(),
            Command::Redo => document.redo(),
            Command::History => self.shows_history = !self.shows_history,
            Command::Cut | Command::Copy => self.copy(ctx, command == Command::Cut),
            // A page receives the clipboard only through the keyboard.
            Command::Paste if IS_PAGE => session.show_note("To paste, press Ctrl+V, or ⌘V"),
            Command::Paste => ctx.send_viewport_cmd(egui::ViewportCommand::RequestPaste),
            Command::Duplicate => session.attempt(|s| s.document.duplicate()),
            Command::Delete => session.attempt(|s| s.document.delete("Delete")),
            Command::Group => session.attempt(|s| s.document.group()),
            Command::Ungroup => session.attempt(|s| s.document.ungroup()),
            Command::Hide => session.attempt(|s| s.document.hide()),
            Command::Lock => session.attempt(|s| s.document.lock_selection()),
            Command::Rename => self.list.begin_renaming(document),
            Command::SelectAll => select_all(document),
            Command::SelectNone => document.selection.clear(),
            Command::MirrorX => session.mirror([true, false, false]),
            Command::MirrorY => session.mirror([false, true, false]),
            Command::MirrorZ => session.mirror([false, false, true]),
            Command::NudgeLeft => view.nudge(session, -Vec3::X),
            Command::NudgeRight => view.nudge(session, Vec3::X),
            Command::NudgeUp => view.nudge(session, Vec3::Y),
            Command::NudgeDown => view.nudge(session, -Vec3::Y),
            Command::NudgeNearer => view.nudge(session, Vec3::Z),
            Command::NudgeFarther => view.nudge(session, -Vec3::Z),
            Command::Select => view.tool = Tool::Select,
            Command::Move => view.tool = Tool::Move,
            Command::Rotate => view.tool = Tool::Rotate,
            Command::Scale => view.tool = Tool::Scale,
            Command::SculptAdd => view.pick_material(session, SculptKind::Add),
            Command::SculptCarve => view.pick_material(session, SculptKind::Carve),
            Command::SculptSmooth => view.pick_material(session, SculptKind::Smooth),
            Command::SculptPaint => view.pick_material(session, SculptKind::Paint),
            Command::LocalSpace => view.is_local = !view.is_local,
            Command::Snap => preferences.snap = !preferences.snap,
            Command::FrameSelection => view.frame_selection(session),
            Command::FrameAll => view.frame_all(session),
            Command::Front => view.eye.along(ViewSide::Front),
            Command::Right => view.eye.along(ViewSide::Right),
            Command::Top => view.eye.along(ViewSide::Top),
            Command::Ortho => view.eye.is_ortho = !view.eye.is_ortho,
            Command::Grid => preferences.grid = !preferences.grid,
            Command::Readings => preferences.readings = !preferences.readings,
            Command::Split => view.split(session),
            Command::Difference => view.pictures.switch_difference(),
            Command::Paths => {
                view.traces_paths = !view.traces_paths;
                view.pictures.forget_request();
            }
            Command::ZoomIn => session.zoom(ctx, |zoom| zoom * 1.1),
            Command::ZoomOut => session.zoom(ctx, |zoom| zoom / 1.1),
            Command::ZoomReset => session.zoom(ctx, |_| 1.0),
            Command::Theme => session.switch_theme(ctx),
            Command::Palette => session.dialog = Some(Dialog::palette()),
            Command::Help => session.dialog = Some(Dialog::Help(None)),
        }
    }

    fn copy(&mut self, ctx: &egui::Context, takes: bool) {
        self.session.attempt(|s| {
            let trees = s.document.copies(&s.document.outermost())?;
            ctx.copy_text(serde_json::to_string_pretty(&trees)?);
            if takes {
                s.document.delete("Cut")?;
            }
            Ok(())
        });
    }

    /// Handles requests between parts of the editor.
    pub(crate) fn handle_requests(&mut self, ctx: &egui::Context) {
        for wish in std::mem::take(&mut self.session.requests) {
            let session = &mut self.session;
            match wish {
                Request::Run(command) => self.run(command, ctx),
                Request::ShowAll => {
                    let scene = session.document.scene();
                    if let Some(world) = session.picker.world(scene, session.version) {
                        self.view.eye = ViewportCamera::of(&world.camera());
                    }
                    self.view.forget();
                    self.list.forget();
                }
                Request::ShowNew => self.view.frame_what_is_off(session),
                Request::Reveal(node) => self.list.reveal(&session.document, node, false),
                Request::Fold(node) => self.list.fold(node),
                Request::Rename([from, to]) => self.view.sculpting.rename(&from, to),
            }
        }
    }

    /// Handles the results of background jobs.
    pub(crate) fn work(&mut self, ctx: &egui::Context) {
        let session = &mut self.session;
        // A job's result is an undo step of its own, and waits for the end of a drag.
        let finished = if session.document.is_in_stroke() {
            Vec::new()
        } else {
            session.jobs.finished()
        };
        for result in finished {
            match result {
                Ok(JobResult::Written(text)) => session.show_note(text),
                Ok(JobResult::Loaded(loaded)) => session.attempt(|s| s.have_meshes(loaded)),
                Ok(JobResult::Cancelled) => session.show_note("Canceled"),
                Err(error) => {
                    session.fail(&error);
                    session.stay_open();
                }
            }
        }
        if !session.jobs.all().is_empty() {
            ctx.request_repaint_after(std::time::Duration::from_millis(100));
        }
    }
}

fn select_all(document: &mut Document) {
    document.selection = document.scene().node(Scene::ROOT).children().to_vec();
}

impl Session {
    fn zoom(&mut self, ctx: &egui::Context, change: impl FnOnce(f32) -> f32) {
        let zoom = &mut self.preferences.zoom;
        *zoom = change(*zoom).clamp(0.5, 3.0);
        ctx.set_zoom_factor(*zoom);
    }

    fn switch_theme(&mut self, ctx: &egui::Context) {
        self.preferences.is_dark = Some(ctx.theme() == egui::Theme::Light);
        ctx.set_theme(self.preferences.theme());
    }

    fn mirror(&mut self, axes: [bool; 3]) {
        self.attempt(|s| s.document.mirror(axes));
    }
}
