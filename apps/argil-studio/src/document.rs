//! The scene that is open, with its file, its journal, what is selected, and the names of its history.
//!
//! *Practice.* Every change is an [`Action`]: the journal writes it as a line, so that it comes back after a crash, and what draws
//! the scene elsewhere does the same action. Nodes have the same ids there.

use crate::mesh_files::{Named, moved_paths, nothing};
use crate::names::name_of;
use crate::recovery::Recovery;
use anyhow::Context;
use argil::field::Program;
use argil::scene::{
    Action, Edit, EditOutcome, Material, NodeDesc, NodeId, NodeTree, SampledGrid, Scene,
};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// See the module's page.
pub struct Document {
    pub(super) scene: Scene,
    path: Option<PathBuf>,
    recovery: Recovery,
    /// Actions that were not handed on yet.
    actions: Vec<Action>,
    /// Of every step that can be undone or redone.
    names: Vec<String>,
    /// How many steps were done when it was saved; none where what was saved cannot be come back to.
    saved: Option<usize>,
    stroke: Option<DocumentStroke>,
    /// Meshes for which nothing stands in.
    missing: Vec<Named>,
    /// Those of them that nobody was asked for yet.
    wanted: Vec<Named>,
    /// Whether meshes are read wherever their paths lead.
    pub reads_anywhere: bool,
    /// Of this document and no other.
    id: u64,
    /// What is selected, in the order of choosing.
    pub selection: Vec<NodeId>,
}

/// Groups within one another that a copy can have, so that a journal can be read again.
const DEEPEST: usize = 50;

fn check_depth(tree: &NodeTree) -> anyhow::Result<()> {
    anyhow::ensure!(
        tree.depth() <= DEEPEST,
        "groups that are nested more than {DEEPEST} deep cannot be copied"
    );
    Ok(())
}

/// Edits that are one step.
struct DocumentStroke {
    /// Steps before it.
    before: usize,
    /// What it is called, until it has changed something: one that changes nothing is no step.
    name: Option<String>,
}

impl Document {
    /// Of a scene that nothing was changed of; nothing is journalled where `recovery` is off.
    pub fn new(scene: Scene, path: Option<PathBuf>, mut recovery: Recovery) -> Self {
        recovery.begin(&scene, path.as_deref());
        let steps = [scene.undo_depth(), scene.redo_depth()];
        let mut document = Self {
            path,
            recovery,
            actions: Vec::new(),
            names: vec!["Edit".into(); steps.iter().sum()],
            saved: Some(0),
            stroke: None,
            missing: Vec::new(),
            wanted: Vec::new(),
            reads_anywhere: false,
            id: NEXT.fetch_add(1, Ordering::Relaxed),
            selection: Vec::new(),
            scene,
        };
        document.insert_placeholders();
        document
    }

    /// Of what a journal brought back: it is not saved.
    pub fn recovered(scene: Scene, path: Option<PathBuf>, recovery: Recovery) -> Self {
        let mut document = Self::new(Scene::new(), path, Recovery::off());
        document.names = vec!["Edit".into(); scene.undo_depth() + scene.redo_depth()];
        (document.scene, document.recovery, document.saved) = (scene, recovery, None);
        document.insert_placeholders();
        document
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Where it was opened from or saved to.
    pub fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }

    /// What to call it.
    pub fn title(&self) -> String {
        let file = self.path.as_deref().and_then(Path::file_name);
        match file {
            Some(name) => name.to_string_lossy().into_owned(),
            None if self.scene.name.is_empty() => "Untitled".into(),
            None => self.scene.name.clone(),
        }
    }

    /// Whether there is something to lose.
    pub fn is_changed(&self) -> bool {
        self.saved != Some(self.scene.undo_depth())
    }

    /// What was done since the last time, for those that follow.
    pub fn take_actions(&mut self) -> Vec<Action> {
        std::mem::take(&mut self.actions)
    }

    /// Do an edit under a name.
    ///
    /// # Errors
    /// If it cannot be done.
    pub fn edit(&mut self, name: &str, edit: Edit) -> anyhow::Result<EditOutcome> {
        let edited = self.act(name, Action::Edit(edit))?;
        edited.context("an edit that changes nothing")
    }

    /// Give a node another entry.
    ///
    /// # Errors
    /// If a value in it cannot be used.
    pub fn replace(&mut self, name: &str, node: NodeId, entry: NodeDesc) -> anyhow::Result<()> {
        self.edit(name, Edit::Replace { node, entry }).map(drop)
    }

    /// Add or change a material, or take one away.
    ///
    /// # Errors
    /// If a value in it cannot be used, or it is to be taken away and is used.
    pub fn set_material(
        &mut self,
        name: &str,
        material: &str,
        value: Option<Material>,
    ) -> anyhow::Result<()> {
        let edit = Edit::SetMaterial {
            name: material.into(),
            material: value,
        };
        self.edit(name, edit).map(drop)
    }

    /// Have a mesh's distances, for brushes that are there and that are put in after.
    pub fn add_mesh_grid(&mut self, path: &str, resolution: u32, grid: Arc<SampledGrid>) {
        self.scene.set_mesh_grid(path, resolution, grid);
        self.missing
            .retain(|(own, size)| (own.as_str(), *size) != (path, resolution));
    }

    /// Have what has keyframes be as it is at a time, in seconds. It is no step, and nothing of it is saved.
    pub fn set_time(&mut self, time: f32) {
        self.scene.set_time(time);
    }

    /// Meshes that the scene names and whose distances are not there, or not yet.
    pub fn missing_meshes(&self) -> Vec<Named> {
        let is_named = |(path, resolution): &&Named| {
            let names = |node: NodeId| {
                let file = self.scene.node(node).desc().kind.file();
                file.is_some_and(|(own, size, _)| own == path && size == *resolution)
            };
            self.scene.iter().any(names)
        };
        self.missing.iter().filter(is_named).cloned().collect()
    }

    /// Have nothing in place of meshes that are not there.
    fn insert_placeholders(&mut self) {
        for named in self.scene.missing_meshes() {
            self.scene
                .set_mesh_grid(named.0.clone(), named.1, nothing(&named.0));
            self.missing.push(named.clone());
            self.wanted.push(named);
        }
    }

    /// Meshes that came to be missing since the last time.
    pub fn take_wanted(&mut self) -> Vec<Named> {
        std::mem::take(&mut self.wanted)
    }

    /// Which document it is.
    pub fn id(&self) -> u64 {
        self.id
    }

    /// Insert a copy of what another scene, or this one, has, with all that it holds.
    ///
    /// # Errors
    /// If it cannot be put there.
    pub fn insert_tree(
        &mut self,
        name: &str,
        (parent, index): (NodeId, usize),
        tree: NodeTree,
    ) -> anyhow::Result<NodeId> {
        check_depth(&tree)?;
        let insert = Action::InsertTree {
            parent,
            index,
            tree,
        };
        self.act(name, insert)?;
        // The first that was inserted is the one at the place.
        let children = self.scene.node(parent).children();
        children.get(index).copied().context("nothing was inserted")
    }

    /// Nodes with all that they hold, for copies, which are not locked.
    ///
    /// # Errors
    /// If groups in them are nested too deep for a file to be read again.
    pub fn copies(&self, nodes: &[NodeId]) -> anyhow::Result<Vec<NodeTree>> {
        let copy = |&node: &NodeId| {
            let mut tree = self.scene.subtree(node);
            check_depth(&tree)?;
            tree.desc.locked = false;
            Ok(tree)
        };
        nodes.iter().map(copy).collect()
    }

    fn act(&mut self, name: &str, action: Action) -> anyhow::Result<Option<EditOutcome>> {
        let before = self.scene.undo_depth();
        // What a journal says of an action is where its nodes are before it.
        let line = self.line_of(&action)?;
        // What cannot be drawn is refused before it is recorded.
        let edited = self.scene.perform_checked(&action, Program::check)?;
        let has_mesh = action.entries().any(|entry| entry.kind.file().is_some());
        self.recovery.record(&line);
        self.actions.push(action);
        match &mut self.stroke {
            None => self.named(before, name),
            Some(DocumentStroke { before, name }) => {
                if let Some(name) = name.take() {
                    let before = *before;
                    self.named(before, &name);
                }
            }
        }
        // Looking through the scene takes a while where it is large.
        if has_mesh {
            self.insert_placeholders();
        }
        Ok(edited)
    }

    /// A step came after so many others.
    fn named(&mut self, before: usize, name: &str) {
        if self.saved.is_some_and(|saved| saved > before) {
            self.saved = None;
        }
        self.names.truncate(before);
        self.names.push(name.into());
    }

    /// The line of an action; nodes that are gone are nowhere.
    fn line_of(&self, action: &Action) -> anyhow::Result<String> {
        let is_there = match *action {
            Action::InsertTree { parent, .. } => self.has(parent),
            Action::Edit(Edit::Insert { parent, .. }) => self.has(parent),
            Action::Edit(Edit::Move { node, parent, .. }) => self.has(node) && self.has(parent),
            Action::Edit(
                Edit::Remove { node }
                | Edit::Replace { node, .. }
                | Edit::SetVisible { node, .. }
                | Edit::Transform { node, .. },
            ) => self.has(node),
            _ => true,
        };
        anyhow::ensure!(
            is_there,
            "what is to be edited is not in the scene any more"
        );
        Ok(self.scene.action_line(action))
    }

    /// An action that is no edit.
    fn control(&mut self, action: Action) {
        let line = self.scene.action_line(&action);
        if self.scene.perform(&action).is_ok() {
            self.recovery.record(&line);
            self.actions.push(action);
        }
    }

    /// From here to its end all edits are one step.
    pub fn begin_stroke(&mut self, name: &str) {
        self.end_stroke();
        let before = self.scene.undo_depth();
        self.control(Action::BeginStroke);
        let name = Some(name.to_owned());
        self.stroke = Some(DocumentStroke { before, name });
    }

    /// See [`Document::begin_stroke`].
    pub fn end_stroke(&mut self) {
        if self.stroke.take().is_some() {
            self.control(Action::EndStroke);
        }
    }

    /// The same, and take back what it did.
    pub fn cancel_stroke(&mut self) {
        let Some(before) = self.stroke.as_ref().map(|stroke| stroke.before) else {
            return;
        };
        self.end_stroke();
        if self.scene.undo_depth() > before {
            self.undo();
        }
    }

    /// Whether a stroke is going on.
    pub fn is_in_stroke(&self) -> bool {
        self.stroke.is_some()
    }

    /// Take the last step back.
    pub fn undo(&mut self) {
        self.end_stroke();
        if self.scene.undo_depth() > 0 {
            self.control(Action::Undo);
            self.insert_placeholders();
            self.forget_removed();
        }
    }

    /// Do again what was undone last.
    pub fn redo(&mut self) {
        self.end_stroke();
        if self.scene.redo_depth() > 0 {
            self.control(Action::Redo);
            self.insert_placeholders();
            self.forget_removed();
        }
    }

    /// The names of all steps, and how many of them are done.
    pub fn history(&self) -> (&[String], usize) {
        (&self.names, self.scene.undo_depth())
    }

    /// Undo or redo until so many steps are done.
    pub fn go_to(&mut self, steps: usize) {
        while self.scene.undo_depth() > steps {
            self.undo();
        }
        while self.scene.undo_depth() < steps && self.scene.redo_depth() > 0 {
            self.redo();
        }
    }

    /// What to call a node.
    pub fn name_of(&self, node: NodeId) -> String {
        name_of(self.scene.node(node).desc())
    }

    /// Write the scene to a file, its own from now on. In another folder its meshes are named from there.
    ///
    /// # Errors
    /// If it cannot be written; what is there stays.
    pub fn save(&mut self, path: &Path) -> anyhow::Result<()> {
        self.end_stroke();
        let moved = moved_paths(&self.scene, self.path(), path);
        let text = if moved.is_empty() {
            self.scene.to_json()
        } else {
            let mut scene = self.scene.clone();
            scene.rename_meshes(&moved);
            scene.to_json()
        };
        crate::save_target::write_output(path, |out| out.write_all(text.as_bytes()))?;
        if !moved.is_empty() {
            self.control(Action::RenameMeshes(moved.clone()));
            for (own, _) in &mut self.missing {
                if let Some(to) = moved.get(own) {
                    own.clone_from(to);
                }
            }
        }
        self.path = Some(path.into());
        self.has_saved();
        // The journal goes on: a later undo may go back beyond this.
        self.recovery.note_saved(path);
        Ok(())
    }

    fn has_saved(&mut self) {
        self.saved = Some(self.scene.undo_depth());
    }

    /// It was not saved when it was kept.
    #[cfg(target_arch = "wasm32")]
    pub fn is_unsaved(&mut self) {
        self.saved = None;
    }

    /// Why nothing is journalled, once.
    pub fn take_fault(&mut self) -> Option<String> {
        self.recovery.fault.take()
    }

    /// Put it away: nothing is to be brought back.
    pub fn close(&mut self) {
        self.recovery.end();
    }
}

static NEXT: AtomicU64 = AtomicU64::new(0);
