//! The open scene, with its file, journal, selection and history.
//!
//! *Practice.* Every change is an [`Action`]. The journal writes it as a line, which recovers it after a crash. The
//! render thread applies the same action to its own copy, whose nodes have the same ids.

use crate::mesh_files::{Named, moved_paths, nothing};
use crate::names::name_of;
use crate::recovery::Recovery;
use anyhow::Context;
use argil::ExternalFiles;
use argil::field::Program;
use argil::scene::{
    Action, Edit, EditOutcome, Material, NodeDesc, NodeId, NodeTree, SampledGrid, Scene, View,
};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// The open document: see the module's page.
pub struct Document {
    pub(super) scene: Scene,
    path: Option<PathBuf>,
    pub(super) recovery: Recovery,
    /// Actions that were not forwarded yet.
    actions: Vec<Action>,
    /// The lines of all actions since the last save, for edits of a world in a store.
    pub(super) log: Option<String>,
    /// Names of all steps that can be undone or redone.
    names: Vec<String>,
    /// Number of steps when the document was saved. `None` if that state cannot be reached again.
    saved: Option<usize>,
    stroke: Option<DocumentStroke>,
    /// Meshes without a placeholder.
    missing: Vec<Named>,
    /// Missing meshes that were not requested yet.
    wanted: Vec<Named>,
    /// Meshes and images that may be read from outside of the scene's folder.
    pub external: ExternalFiles,
    /// Unique id of this document.
    id: u64,
    /// Selected nodes, in the order of selection.
    pub selection: Vec<NodeId>,
}

/// Maximum nesting of groups in a copy, so that a journal can be read again.
const MAX_DEPTH: usize = 50;

fn check_depth(tree: &NodeTree) -> anyhow::Result<()> {
    anyhow::ensure!(
        tree.depth() <= MAX_DEPTH,
        "groups that are nested more than {MAX_DEPTH} deep cannot be copied"
    );
    Ok(())
}

/// Edits that form one undo step.
struct DocumentStroke {
    /// Number of steps before it.
    before: usize,
    /// Name of the step. `None` after it changed something: a stroke without changes is no step.
    name: Option<String>,
}

impl Document {
    /// Creates a document of an unchanged scene. Without `recovery`, nothing is journaled.
    pub fn new(scene: Scene, path: Option<PathBuf>, mut recovery: Recovery) -> Self {
        recovery.begin(&scene, path.as_deref());
        let steps = [scene.undo_depth(), scene.redo_depth()];
        let mut document = Self {
            path,
            recovery,
            actions: Vec::new(),
            log: None,
            names: vec!["Edit".into(); steps.iter().sum()],
            saved: Some(0),
            stroke: None,
            missing: Vec::new(),
            wanted: Vec::new(),
            external: ExternalFiles::default(),
            id: NEXT.fetch_add(1, Ordering::Relaxed),
            selection: Vec::new(),
            scene,
        };
        document.insert_placeholders();
        document
    }

    /// Creates a document of a recovered journal. It is unsaved.
    pub fn recovered(scene: Scene, path: Option<PathBuf>, recovery: Recovery) -> Self {
        let mut document = Self::new(Scene::new(), path, Recovery::off());
        document.names = vec!["Edit".into(); scene.undo_depth() + scene.redo_depth()];
        (document.scene, document.recovery, document.saved) = (scene, recovery, None);
        document.insert_placeholders();
        document
    }

    /// Returns the scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Returns the path of the scene's file.
    pub fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }

    /// Returns the title.
    pub fn title(&self) -> String {
        let file = self.path.as_deref().and_then(Path::file_name);
        match file {
            Some(name) => name.to_string_lossy().into_owned(),
            None if self.scene.name.is_empty() => "Untitled".into(),
            None => self.scene.name.clone(),
        }
    }

    /// Returns true if there are unsaved changes.
    pub fn is_changed(&self) -> bool {
        self.saved != Some(self.scene.undo_depth())
    }

    /// Returns the actions since the last call.
    pub fn take_actions(&mut self) -> Vec<Action> {
        std::mem::take(&mut self.actions)
    }

    /// Applies an edit, as a step with a name.
    ///
    /// # Errors
    /// If the edit fails.
    pub fn edit(&mut self, name: &str, edit: Edit) -> anyhow::Result<EditOutcome> {
        let edited = self.act(name, Action::Edit(edit))?;
        edited.context("an edit that changes nothing")
    }

    /// Replaces a node's description.
    ///
    /// # Errors
    /// If a value is invalid.
    pub fn replace(&mut self, name: &str, node: NodeId, entry: NodeDesc) -> anyhow::Result<()> {
        self.edit(name, Edit::Replace { node, desc: entry })
            .map(drop)
    }

    /// Adds, changes or removes a material.
    ///
    /// # Errors
    /// If a value is invalid, or the material to remove is in use.
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

    /// Replaces the view.
    ///
    /// # Errors
    /// If a value is invalid.
    pub fn set_view(&mut self, name: &str, view: View) -> anyhow::Result<()> {
        let view = Box::new(view);
        self.edit(name, Edit::SetView { view }).map(drop)
    }

    /// Sets the sampled distances of a mesh, for present and later brushes.
    pub fn add_mesh_grid(&mut self, path: &str, resolution: u32, grid: Arc<SampledGrid>) {
        self.scene.set_mesh_grid(path, resolution, grid);
        self.missing
            .retain(|(missing_path, size)| (missing_path.as_str(), *size) != (path, resolution));
    }

    /// Evaluates keyframes at a time in seconds. This is no undo step, and is not saved.
    pub fn set_time(&mut self, time: f32) {
        self.scene.set_time(time);
    }

    /// Returns the meshes that the scene names and that are not loaded yet.
    pub fn missing_meshes(&self) -> Vec<Named> {
        let is_named = |(path, resolution): &&Named| {
            let names = |node: NodeId| {
                let file = self.scene.node(node).desc().kind.file();
                file.is_some_and(|(named, size, _)| named == path && size == *resolution)
            };
            self.scene.iter().any(names)
        };
        self.missing.iter().filter(is_named).cloned().collect()
    }

    /// Replaces missing meshes with empty placeholders.
    fn insert_placeholders(&mut self) {
        self.scene.gray_missing_images();
        for named in self.scene.missing_meshes() {
            self.scene
                .set_mesh_grid(named.0.clone(), named.1, nothing(&named.0));
            self.missing.push(named.clone());
            self.wanted.push(named);
        }
    }

    /// Returns the meshes that became missing since the last call.
    pub fn take_wanted(&mut self) -> Vec<Named> {
        std::mem::take(&mut self.wanted)
    }

    /// Returns the id of the document.
    pub fn id(&self) -> u64 {
        self.id
    }

    /// Inserts a copy of a tree of this or another scene.
    ///
    /// # Errors
    /// If it cannot be inserted there.
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
        // The node inserted first is at the requested index.
        let children = self.scene.node(parent).children();
        children.get(index).copied().context("nothing was inserted")
    }

    /// Returns unlocked copies of nodes with all their children.
    ///
    /// # Errors
    /// If groups are nested too deep for the file format.
    pub fn copies(&self, nodes: &[NodeId]) -> anyhow::Result<Vec<NodeTree>> {
        let copy = |&node: &NodeId| {
            let mut tree = self.scene.subtree(node);
            check_depth(&tree)?;
            tree.desc.locked = false;
            Ok(tree)
        };
        nodes.iter().map(copy).collect()
    }

    pub(super) fn act(
        &mut self,
        name: &str,
        action: Action,
    ) -> anyhow::Result<Option<EditOutcome>> {
        let before = self.scene.undo_depth();
        // The journal refers to nodes by their paths before the action.
        let line = self.line_of(&action)?;
        // An edit that cannot be rendered is rejected before it is recorded.
        let edited = self.scene.perform_checked(&action, Program::check)?;
        let has_mesh = action.entries().any(|entry| entry.kind.file().is_some());
        self.record(&line);
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
        // Searching a large scene takes a while.
        if has_mesh {
            self.insert_placeholders();
        }
        Ok(edited)
    }

    fn record(&mut self, line: &str) {
        self.recovery.record(line);
        if let Some(log) = &mut self.log {
            log.push_str(line);
            log.push('\n');
        }
    }

    /// Records the name of a step.
    fn named(&mut self, before: usize, name: &str) {
        if self.saved.is_some_and(|saved| saved > before) {
            self.saved = None;
        }
        self.names.truncate(before);
        self.names.push(name.into());
    }

    /// Returns the log line of an action.
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
        anyhow::ensure!(is_there, "the node to edit is no longer in the scene");
        Ok(self.scene.action_line(action))
    }

    /// Performs an action that is not an edit.
    pub(super) fn control(&mut self, action: Action) {
        let line = self.scene.action_line(&action);
        if self.scene.perform(&action).is_ok() {
            self.record(&line);
            self.actions.push(action);
        }
    }

    /// Begins a stroke: all edits until its end form one step.
    pub fn begin_stroke(&mut self, name: &str) {
        self.end_stroke();
        let before = self.scene.undo_depth();
        self.control(Action::BeginStroke);
        let name = Some(name.to_owned());
        self.stroke = Some(DocumentStroke { before, name });
    }

    /// Ends a stroke: see [`Document::begin_stroke`].
    pub fn end_stroke(&mut self) {
        if self.stroke.take().is_some() {
            self.control(Action::EndStroke);
        }
    }

    /// Ends a stroke and undoes it.
    pub fn cancel_stroke(&mut self) {
        let Some(before) = self.stroke.as_ref().map(|stroke| stroke.before) else {
            return;
        };
        self.end_stroke();
        if self.scene.undo_depth() > before {
            self.undo();
        }
    }

    /// Returns true during a stroke.
    pub fn is_in_stroke(&self) -> bool {
        self.stroke.is_some()
    }

    /// Undoes the last step.
    pub fn undo(&mut self) {
        self.end_stroke();
        if self.scene.undo_depth() > 0 {
            self.control(Action::Undo);
            self.insert_placeholders();
            self.forget_removed();
        }
    }

    /// Redoes the step that was undone last.
    pub fn redo(&mut self) {
        self.end_stroke();
        if self.scene.redo_depth() > 0 {
            self.control(Action::Redo);
            self.insert_placeholders();
            self.forget_removed();
        }
    }

    /// Returns the names of all steps, and the number of steps that are applied.
    pub fn history(&self) -> (&[String], usize) {
        (&self.names, self.scene.undo_depth())
    }

    /// Undoes or redoes until a number of steps is applied.
    pub fn go_to(&mut self, steps: usize) {
        while self.scene.undo_depth() > steps {
            self.undo();
        }
        while self.scene.undo_depth() < steps && self.scene.redo_depth() > 0 {
            self.redo();
        }
    }

    /// Returns the display name of a node.
    pub fn name_of(&self, node: NodeId) -> String {
        name_of(self.scene.node(node).desc())
    }

    /// Saves the scene to a file, which becomes the document's file. Mesh paths are made relative to its folder.
    ///
    /// # Errors
    /// If the file cannot be written; it then keeps its contents.
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
            for (name, _) in &mut self.missing {
                if let Some(to) = moved.get(name) {
                    name.clone_from(to);
                }
            }
        }
        self.path = Some(path.into());
        self.has_saved();
        // The journal continues, because a later undo may go back beyond this point.
        self.recovery.note_saved(path);
        Ok(())
    }

    pub(super) fn has_saved(&mut self) {
        self.saved = Some(self.scene.undo_depth());
    }

    /// Marks the document as unsaved.
    #[cfg(target_arch = "wasm32")]
    pub fn is_unsaved(&mut self) {
        self.saved = None;
    }

    /// Returns the journal's error, once.
    pub fn take_fault(&mut self) -> Option<String> {
        self.recovery.fault.take()
    }

    /// Closes the document and removes its journal.
    pub fn close(&mut self) {
        self.recovery.end();
    }
}

static NEXT: AtomicU64 = AtomicU64::new(0);
