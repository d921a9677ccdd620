//! What commands do.

use crate::app::{Studio, Tool};
use crate::commands::Command;
use crate::dialogs::{Dialog, Then};
use crate::eye::Side;
use crate::files::{Ask, IS_PAGE};
use crate::jobs::Done;
use crate::painter::Pipeline;
use crate::pose::Pose;
use crate::sculpt::Kind;
use argil::glam::Vec3;
use argil::{Body, Edit, Entry, Group, Modifier, NodeId, Scene};
use eframe::egui;

impl Studio {
    /// Whether a command would do something.
    pub(crate) fn can(&self, command: Command) -> bool {
        let (names, done) = self.document.history();
        let has_selection = !self.document.selection.is_empty();
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
            | Command::FrameSelection => has_selection,
            Command::Difference => self.viewport.split.is_some(),
            _ => true,
        }
    }

    /// Whether what it switches is on.
    pub(crate) fn is_on(&self, command: Command) -> bool {
        match command {
            Command::Select => self.tool == Tool::Select,
            Command::Move => self.tool == Tool::Move,
            Command::Rotate => self.tool == Tool::Rotate,
            Command::Scale => self.tool == Tool::Scale,
            Command::LocalSpace => self.is_local,
            Command::Snap => self.preferences.snap,
            Command::Ortho => self.eye.is_ortho,
            Command::Grid => self.preferences.grid,
            Command::Readings => self.preferences.readings,
            Command::Split => self.viewport.split.is_some(),
            Command::Difference => self.viewport.shows_difference,
            Command::History => self.shows_history,
            _ => false,
        }
    }

    /// Do a command.
    pub(crate) fn run(&mut self, command: Command, ctx: &egui::Context) {
        if !self.can(command) {
            return;
        }
        match command {
            Command::New => {
                if self.may_leave(Then::New) {
                    self.go_on(ctx, Then::New);
                }
            }
            Command::Open => {
                // A page asks when it has read what was chosen.
                if IS_PAGE || self.may_leave(Then::Ask) {
                    self.ask_to_open();
                }
            }
            Command::Save => drop(self.save_scene(false)),
            Command::SaveAs => drop(self.save_scene(true)),
            Command::Import => self.ask_to_import(),
            Command::ExportMesh => self.export(Ask::Mesh),
            Command::ExportPicture => self.export(Ask::Picture),
            Command::ExportTurntable => self.export(Ask::Turntable),
            Command::ExportVolume => self.export(Ask::Volume),
            Command::Quit => {
                if self.may_leave(Then::Quit) {
                    self.go_on(ctx, Then::Quit);
                }
            }
            Command::Undo => self.document.undo(),
            Command::Redo => self.document.redo(),
            Command::History => self.shows_history = !self.shows_history,
            Command::Cut => {
                self.copy(ctx);
                self.attempt(|s| s.delete("Cut"));
            }
            Command::Copy => self.copy(ctx),
            // A page is not given what was copied but by the keys.
            Command::Paste if IS_PAGE => self.tell("To paste, press Ctrl+V, or ⌘V"),
            Command::Paste => ctx.send_viewport_cmd(egui::ViewportCommand::RequestPaste),
            Command::Duplicate => self.attempt(|s| s.duplicate()),
            Command::Delete => self.attempt(|s| s.delete("Delete")),
            Command::Group => self.attempt(Self::group),
            Command::Ungroup => self.attempt(Self::ungroup),
            Command::Hide => self.attempt(Self::hide),
            Command::Lock => self.attempt(Self::lock),
            Command::Rename => {
                if let Some(node) = self.document.active() {
                    let name = self.document.scene().node(node).entry().name.clone();
                    self.renaming = Some((node, name));
                    self.reveal(node, true);
                }
            }
            Command::SelectAll => {
                let scene = self.document.scene();
                self.document.selection = scene.node(Scene::ROOT).children().to_vec();
            }
            Command::SelectNone => self.document.selection.clear(),
            Command::MirrorX => self.attempt(|s| s.mirror([true, false, false])),
            Command::MirrorY => self.attempt(|s| s.mirror([false, true, false])),
            Command::MirrorZ => self.attempt(|s| s.mirror([false, false, true])),
            Command::NudgeLeft => self.attempt(|s| s.nudge(-Vec3::X)),
            Command::NudgeRight => self.attempt(|s| s.nudge(Vec3::X)),
            Command::NudgeUp => self.attempt(|s| s.nudge(Vec3::Y)),
            Command::NudgeDown => self.attempt(|s| s.nudge(-Vec3::Y)),
            Command::NudgeNearer => self.attempt(|s| s.nudge(Vec3::Z)),
            Command::NudgeFarther => self.attempt(|s| s.nudge(-Vec3::Z)),
            Command::Select => self.tool = Tool::Select,
            Command::Move => self.tool = Tool::Move,
            Command::Rotate => self.tool = Tool::Rotate,
            Command::Scale => self.tool = Tool::Scale,
            Command::SculptAdd => self.take_up(Kind::Add),
            Command::SculptCarve => self.take_up(Kind::Carve),
            Command::SculptSmooth => self.take_up(Kind::Smooth),
            Command::SculptPaint => self.take_up(Kind::Paint),
            Command::LocalSpace => self.is_local = !self.is_local,
            Command::Snap => self.preferences.snap = !self.preferences.snap,
            Command::FrameSelection => self.frame_selection(),
            Command::FrameAll => self.frame_all(),
            Command::Front => self.eye.along(Side::Front),
            Command::Right => self.eye.along(Side::Right),
            Command::Top => self.eye.along(Side::Top),
            Command::Ortho => self.eye.is_ortho = !self.eye.is_ortho,
            Command::Grid => self.preferences.grid = !self.preferences.grid,
            Command::Readings => self.preferences.readings = !self.preferences.readings,
            Command::Split => self.split(),
            Command::Difference => {
                self.viewport.shows_difference = !self.viewport.shows_difference;
            }
            Command::ZoomIn => self.zoom(ctx, self.preferences.zoom * 1.1),
            Command::ZoomOut => self.zoom(ctx, self.preferences.zoom / 1.1),
            Command::ZoomReset => self.zoom(ctx, 1.0),
            Command::Theme => {
                self.preferences.is_dark = Some(ctx.theme() == egui::Theme::Light);
                ctx.set_theme(self.preferences.theme());
            }
            Command::Palette => {
                self.dialog = Some(Dialog::Palette {
                    text: String::new(),
                    at: 0,
                });
            }
            Command::Help => self.dialog = Some(Dialog::Help(None)),
        }
    }

    fn zoom(&mut self, ctx: &egui::Context, zoom: f32) {
        self.preferences.zoom = zoom.clamp(0.5, 3.0);
        ctx.set_zoom_factor(self.preferences.zoom);
    }

    fn split(&mut self) {
        self.viewport.split = match self.viewport.split {
            Some(_) => None,
            None if self.preferences.pipeline == Pipeline::Field => Some(Pipeline::Bricks),
            None => Some(Pipeline::Field),
        };
        self.viewport.divider = 0.5;
        self.viewport.shows_difference = false;
    }

    /// Put an entry at the end, and select it.
    pub(crate) fn add_entry(&mut self, name: &str, entry: Entry) -> anyhow::Result<()> {
        let index = self.document.scene().node(Scene::ROOT).children().len();
        let made = self.document.edit(
            name,
            &Edit::Insert {
                parent: Scene::ROOT,
                index,
                entry,
            },
        )?;
        self.document.select(Some(made.node), false);
        Ok(())
    }

    /// What is selected and not locked.
    fn unlocked(&self) -> anyhow::Result<Vec<NodeId>> {
        let nodes = self.movable();
        anyhow::ensure!(!nodes.is_empty(), "what is selected is locked");
        Ok(nodes)
    }

    fn delete(&mut self, name: &str) -> anyhow::Result<()> {
        let nodes = self.unlocked()?;
        self.document.begin_stroke(name);
        for node in nodes {
            self.document.edit(name, &Edit::Remove { node })?;
        }
        self.document.end_stroke();
        self.document.selection.clear();
        Ok(())
    }

    fn copy(&mut self, ctx: &egui::Context) {
        let items = self.document.items(&self.document.outermost());
        if let Ok(text) = serde_json::to_string_pretty(&items) {
            ctx.copy_text(text);
        }
    }

    /// Put what was copied behind what is selected.
    pub(crate) fn paste(&mut self, text: &str) -> anyhow::Result<()> {
        let items: Vec<serde_json::Value> = serde_json::from_str(text)
            .map_err(|_| anyhow::anyhow!("what was copied is no brush of Argil"))?;
        let (parent, index) = self.behind_selection();
        self.document.begin_stroke("Paste");
        let mut made = Vec::new();
        for (i, item) in items.iter().enumerate() {
            let node = self
                .document
                .insert_item("Paste", (parent, index + i), item);
            if node.is_err() {
                self.document.end_stroke();
            }
            made.push(node?);
        }
        self.document.end_stroke();
        self.document.selection = made;
        Ok(())
    }

    fn behind_selection(&self) -> (NodeId, usize) {
        let scene = self.document.scene();
        let last = self.document.outermost().last().copied();
        let place = last.and_then(|node| {
            let parent = scene.node(node).parent()?;
            let own = scene.node(parent).children();
            Some((parent, own.iter().position(|&n| n == node)? + 1))
        });
        place.unwrap_or((Scene::ROOT, scene.node(Scene::ROOT).children().len()))
    }

    fn duplicate(&mut self) -> anyhow::Result<()> {
        self.document.begin_stroke("Duplicate");
        let made = self.duplicate_within_stroke();
        self.document.end_stroke();
        made.map(drop)
    }

    /// Put a copy of each that is selected behind it, and select the copies.
    pub(crate) fn duplicate_within_stroke(&mut self) -> anyhow::Result<Vec<NodeId>> {
        let mut made = Vec::new();
        let nodes = self.document.outermost();
        let items = self.document.items(&nodes);
        for (node, item) in nodes.into_iter().zip(items) {
            let scene = self.document.scene();
            let Some(parent) = scene.node(node).parent() else {
                continue;
            };
            let own = scene.node(parent).children();
            let index = own.iter().position(|&n| n == node).unwrap_or(0) + 1;
            let copy = self
                .document
                .insert_item("Duplicate", (parent, index), &item);
            made.push(copy?);
        }
        self.document.selection = made.clone();
        Ok(made)
    }

    fn group(&mut self) -> anyhow::Result<()> {
        let nodes = self.unlocked()?;
        let Some(&first) = nodes.first() else {
            return Ok(());
        };
        let scene = self.document.scene();
        let parent = scene.node(first).parent().unwrap_or(Scene::ROOT);
        let own = scene.node(parent).children();
        let index = own.iter().position(|&n| n == first).unwrap_or(0);
        self.document.begin_stroke("Group");
        let entry = Group::new().into();
        let insert = Edit::Insert {
            parent,
            index,
            entry,
        };
        let group = self.document.edit("Group", &insert)?.node;
        for (index, node) in nodes.into_iter().enumerate() {
            let edit = Edit::Move {
                node,
                parent: group,
                index,
            };
            self.document.edit("Group", &edit)?;
        }
        self.document.end_stroke();
        self.document.select(Some(group), false);
        Ok(())
    }

    /// Put what groups hold in their place. Groups that do more than hold are told of.
    fn ungroup(&mut self) -> anyhow::Result<()> {
        let mut groups = self.unlocked()?;
        let scene = self.document.scene();
        groups.retain(|&node| matches!(scene.node(node).entry().body, Body::Group));
        anyhow::ensure!(!groups.is_empty(), "no group is selected");
        self.document.begin_stroke("Ungroup");
        let mut freed = Vec::new();
        for group in groups {
            let scene = self.document.scene();
            let entry = scene.node(group).entry().clone();
            let plain: Entry = Group::new().into();
            let does_more = entry.operator != plain.operator
                || entry.modifiers.iter().any(|m| !m.is_similarity());
            if does_more {
                self.document.end_stroke();
                anyhow::bail!(
                    "{} acts as a whole, by its operator or its modifiers: ungrouped, it would be another solid",
                    self.document.name_of(group)
                );
            }
            let parent = scene.node(group).parent().unwrap_or(Scene::ROOT);
            let own = scene.node(parent).children();
            let index = own.iter().position(|&n| n == group).unwrap_or(0);
            for (i, node) in scene
                .node(group)
                .children()
                .to_vec()
                .into_iter()
                .enumerate()
            {
                let mut inner = self.document.scene().node(node).entry().clone();
                inner.modifiers.extend(entry.modifiers.iter().cloned());
                self.document.replace("Ungroup", node, inner)?;
                let edit = Edit::Move {
                    node,
                    parent,
                    index: index + 1 + i,
                };
                self.document.edit("Ungroup", &edit)?;
                freed.push(node);
            }
            self.document
                .edit("Ungroup", &Edit::Remove { node: group })?;
        }
        self.document.end_stroke();
        self.document.selection = freed;
        Ok(())
    }

    fn hide(&mut self) -> anyhow::Result<()> {
        let scene = self.document.scene();
        let is_shown = |&n: &NodeId| scene.node(n).entry().visible;
        let visible = !self.document.selection.iter().any(is_shown);
        let word = if visible { "Show" } else { "Hide" };
        self.document.begin_stroke(word);
        for node in self.document.selection.clone() {
            self.document
                .edit(word, &Edit::SetVisible { node, visible })?;
        }
        self.document.end_stroke();
        Ok(())
    }

    fn lock(&mut self) -> anyhow::Result<()> {
        let nodes = self.document.selection.clone();
        let is_open = |&node: &NodeId| !self.document.scene().node(node).entry().locked;
        let locked = nodes.iter().any(is_open);
        self.document.lock(&nodes, locked)
    }

    fn mirror(&mut self, axes: [bool; 3]) -> anyhow::Result<()> {
        let nodes = self.unlocked()?;
        self.document.begin_stroke("Mirror");
        for node in nodes {
            let mut entry = self.document.scene().node(node).entry().clone();
            entry.modifiers.push(Modifier::Mirror { axes });
            self.document.replace("Mirror", node, entry)?;
        }
        self.document.end_stroke();
        Ok(())
    }

    /// Shift what is selected by a step of the snap along the axis that is nearest to a direction of the picture.
    fn nudge(&mut self, seen: Vec3) -> anyhow::Result<()> {
        let nodes = self.unlocked()?;
        let Some((_, axes)) = self.frame_of(&nodes) else {
            return Ok(());
        };
        let [right, up] = self.eye.axes();
        let along = seen.x * right + seen.y * up + seen.z * self.eye.backward();
        let steepest = |a: &Vec3, b: &Vec3| a.dot(along).abs().total_cmp(&b.dot(along).abs());
        let Some(axis) = axes.into_iter().max_by(steepest) else {
            return Ok(());
        };
        let by = axis * self.preferences.snap_length.copysign(axis.dot(along));
        self.document.begin_stroke("Nudge");
        for node in nodes {
            let scene = self.document.scene();
            let mut entry = scene.node(node).entry().clone();
            let outer = Pose::around(scene, node);
            let mut pose = Pose::of(&entry).and(&outer);
            pose.shift += by.as_dvec3();
            pose.within(&outer).write(&mut entry);
            self.document.replace("Nudge", node, entry)?;
        }
        self.document.end_stroke();
        Ok(())
    }

    fn frame_selection(&mut self) {
        let scene = self.document.scene();
        let boxes = self.document.selection.clone().into_iter();
        let boxes = boxes.filter_map(|node| self.picker.box_of(scene, node));
        if let Some(all) = boxes.reduce(|a, b| a.union(b)) {
            self.eye.frame(all);
        }
    }

    fn frame_all(&mut self) {
        let scene = self.document.scene();
        if let Some(world) = self.picker.world(scene, self.version) {
            self.eye.frame(world.focus());
        }
    }

    /// Take in what jobs have come to.
    pub(crate) fn work(&mut self, ctx: &egui::Context) {
        // What comes of work is a step of its own, and waits for the hand.
        let finished = if self.document.is_in_stroke() {
            Vec::new()
        } else {
            self.jobs.finished()
        };
        for result in finished {
            match result {
                Ok(Done::Written(text)) => self.tell(text),
                Ok(Done::Loaded(loaded)) => self.attempt(|s| s.have_meshes(loaded)),
                Ok(Done::Cancelled) => self.tell("Cancelled"),
                Err(error) => {
                    self.fail(&error);
                    self.stay_open();
                }
            }
        }
        if !self.jobs.all().is_empty() {
            ctx.request_repaint_after(std::time::Duration::from_millis(100));
        }
    }
}
