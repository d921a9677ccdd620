//! Edits that commands make to a document.

use crate::document::Document;
use crate::mesh_files::folder_of;
use argil::scene::{
    Action, Edit, Group, Modifier, NodeDesc, NodeId, NodeKind, NodeTree, Scene, Shape,
};
use std::path::{Path, PathBuf};

impl Document {
    /// Gives a scene the images that this document has loaded.
    pub(crate) fn share_images(&self, scene: &mut Scene) {
        self.scene.share_images(scene);
    }

    /// Performs the lines of a log, as saved steps, and keeps the lines of later actions.
    ///
    /// # Errors
    /// If a line cannot be read or performed.
    pub(crate) fn replay_saved(&mut self, lines: &str) -> anyhow::Result<()> {
        for line in lines.lines().filter(|line| !line.trim().is_empty()) {
            let action = self.scene.read_action(line)?;
            match action {
                Action::Edit(_) | Action::InsertTree { .. } => {
                    self.act("Saved edit", action)?;
                }
                _ => self.control(action),
            }
        }
        self.keep_log();
        Ok(())
    }

    /// Keeps the lines of actions from here on, where the document is saved.
    pub(crate) fn keep_log(&mut self) {
        self.end_stroke();
        self.log = Some(String::new());
        self.has_saved();
    }

    /// Returns the lines of all actions since the last save.
    pub(crate) fn log(&self) -> &str {
        self.log.as_deref().unwrap_or_default()
    }

    /// Appends a node and selects it.
    pub(crate) fn add_entry(&mut self, name: &str, entry: NodeDesc) -> anyhow::Result<()> {
        let index = self.scene().node(Scene::ROOT).children().len();
        let made = self.edit(
            name,
            Edit::Insert {
                parent: Scene::ROOT,
                index,
                desc: entry,
            },
        )?;
        self.select(Some(made.node), false);
        Ok(())
    }

    /// Returns the selected nodes that are not locked.
    pub(crate) fn unlocked(&self) -> anyhow::Result<Vec<NodeId>> {
        let nodes = self.movable();
        anyhow::ensure!(!nodes.is_empty(), "the selection is locked");
        Ok(nodes)
    }

    pub(crate) fn delete(&mut self, name: &str) -> anyhow::Result<()> {
        let nodes = self.unlocked()?;
        self.begin_stroke(name);
        for node in nodes {
            self.edit(name, Edit::Remove { node })?;
        }
        self.end_stroke();
        self.selection.clear();
        Ok(())
    }

    /// Inserts the clipboard's contents after the selection.
    pub(crate) fn paste(&mut self, text: &str) -> anyhow::Result<()> {
        let trees: Vec<NodeTree> = serde_json::from_str(text)
            .map_err(|_| anyhow::anyhow!("the clipboard holds no Argil brush"))?;
        let (parent, index) = self.behind_selection();
        self.begin_stroke("Paste");
        let mut made = Vec::new();
        for (i, tree) in trees.into_iter().enumerate() {
            made.push(self.insert_tree("Paste", (parent, index + i), tree)?);
        }
        self.end_stroke();
        self.selection = made;
        Ok(())
    }

    pub(crate) fn behind_selection(&self) -> (NodeId, usize) {
        let scene = self.scene();
        let last = self.outermost().last().copied();
        let place = last.and_then(|node| {
            let parent = scene.node(node).parent()?;
            let siblings = scene.node(parent).children();
            Some((parent, siblings.iter().position(|&n| n == node)? + 1))
        });
        place.unwrap_or((Scene::ROOT, scene.node(Scene::ROOT).children().len()))
    }

    pub(crate) fn duplicate(&mut self) -> anyhow::Result<()> {
        self.begin_stroke("Duplicate");
        self.duplicate_within_stroke()?;
        self.end_stroke();
        Ok(())
    }

    /// Inserts a copy after each selected node, and selects the copies.
    pub(crate) fn duplicate_within_stroke(&mut self) -> anyhow::Result<Vec<NodeId>> {
        let mut made = Vec::new();
        let nodes = self.outermost();
        let trees = self.copies(&nodes)?;
        for (node, tree) in nodes.into_iter().zip(trees) {
            let scene = self.scene();
            let Some(parent) = scene.node(node).parent() else {
                continue;
            };
            let siblings = scene.node(parent).children();
            let index = siblings.iter().position(|&n| n == node).unwrap_or(0) + 1;
            let copy = self.insert_tree("Duplicate", (parent, index), tree);
            made.push(copy?);
        }
        self.selection = made.clone();
        Ok(made)
    }

    pub(crate) fn group(&mut self) -> anyhow::Result<()> {
        let nodes = self.unlocked()?;
        let Some(&first) = nodes.first() else {
            return Ok(());
        };
        let scene = self.scene();
        let parent = scene.node(first).parent().unwrap_or(Scene::ROOT);
        let siblings = scene.node(parent).children();
        let index = siblings.iter().position(|&n| n == first).unwrap_or(0);
        self.begin_stroke("Group");
        let entry = Group::new().into();
        let insert = Edit::Insert {
            parent,
            index,
            desc: entry,
        };
        let group = self.edit("Group", insert)?.node;
        for (index, node) in nodes.into_iter().enumerate() {
            let edit = Edit::Move {
                node,
                parent: group,
                index,
            };
            self.edit("Group", edit)?;
        }
        self.end_stroke();
        self.select(Some(group), false);
        Ok(())
    }

    /// Replaces groups with their children. Reports groups with modifiers or operators that would be lost.
    pub(crate) fn ungroup(&mut self) -> anyhow::Result<()> {
        let mut groups = self.unlocked()?;
        let scene = self.scene();
        groups.retain(|&node| matches!(scene.node(node).desc().kind, NodeKind::Group));
        anyhow::ensure!(!groups.is_empty(), "no group is selected");
        self.begin_stroke("Ungroup");
        let mut freed = Vec::new();
        for group in groups {
            let scene = self.scene();
            let entry = scene.node(group).desc().clone();
            let plain: NodeDesc = Group::new().into();
            let does_more = entry.operator != plain.operator
                || entry.modifiers.iter().any(|m| !m.is_similarity());
            if does_more {
                anyhow::bail!(
                    "cannot ungroup {}: its operator or modifiers apply to the whole group",
                    self.name_of(group)
                );
            }
            let parent = scene.node(group).parent().unwrap_or(Scene::ROOT);
            let siblings = scene.node(parent).children();
            let index = siblings.iter().position(|&n| n == group).unwrap_or(0);
            for (i, node) in scene
                .node(group)
                .children()
                .to_vec()
                .into_iter()
                .enumerate()
            {
                let mut inner = self.scene().node(node).desc().clone();
                inner.modifiers.extend(entry.modifiers.iter().cloned());
                self.replace("Ungroup", node, inner)?;
                let edit = Edit::Move {
                    node,
                    parent,
                    index: index + 1 + i,
                };
                self.edit("Ungroup", edit)?;
                freed.push(node);
            }
            self.edit("Ungroup", Edit::Remove { node: group })?;
        }
        self.end_stroke();
        self.selection = freed;
        Ok(())
    }

    pub(crate) fn hide(&mut self) -> anyhow::Result<()> {
        let scene = self.scene();
        let is_shown = |&n: &NodeId| scene.node(n).desc().visible;
        let visible = !self.selection.iter().any(is_shown);
        let word = if visible { "Show" } else { "Hide" };
        self.begin_stroke(word);
        for node in self.selection.clone() {
            self.edit(word, Edit::SetVisible { node, visible })?;
        }
        self.end_stroke();
        Ok(())
    }

    pub(crate) fn lock_selection(&mut self) -> anyhow::Result<()> {
        let nodes = self.selection.clone();
        let is_open = |&node: &NodeId| !self.scene().node(node).desc().locked;
        let locked = nodes.iter().any(is_open);
        self.lock(&nodes, locked)
    }

    pub(crate) fn mirror(&mut self, axes: [bool; 3]) -> anyhow::Result<()> {
        let nodes = self.unlocked()?;
        self.begin_stroke("Mirror");
        for node in nodes {
            let mut entry = self.scene().node(node).desc().clone();
            entry.modifiers.push(Modifier::Mirror { axes });
            self.replace("Mirror", node, entry)?;
        }
        self.end_stroke();
        Ok(())
    }

    /// Returns the selected nodes that are not locked.
    pub(crate) fn movable(&self) -> Vec<NodeId> {
        let mut all = self.outermost();
        all.retain(|&node| !self.is_locked(node));
        all
    }

    /// Returns the shape of the only selected brush, if only a transform modifies it.
    pub(crate) fn plain_shape(&self, nodes: &[NodeId]) -> Option<Shape> {
        let [node] = nodes else {
            return None;
        };
        let entry = self.scene().node(*node).desc();
        match &entry.kind {
            NodeKind::Shape(shape) if entry.modifiers.iter().all(Modifier::is_similarity) => {
                Some(shape.clone())
            }
            _ => None,
        }
    }

    /// Returns the nodes that use a material.
    pub(crate) fn users_of(&self, material: &str) -> Vec<NodeId> {
        let scene = self.scene();
        let uses = |&node: &NodeId| scene.node(node).desc().material.as_deref() == Some(material);
        scene.iter().filter(uses).collect()
    }

    pub(crate) fn give_material(
        &mut self,
        what: &str,
        nodes: &[NodeId],
        material: &Option<String>,
    ) -> anyhow::Result<()> {
        let is_own = !self.is_in_stroke();
        if is_own {
            self.begin_stroke(what);
        }
        for &node in nodes {
            let mut entry = self.scene().node(node).desc().clone();
            entry.material.clone_from(material);
            self.replace(what, node, entry)?;
        }
        if is_own {
            self.end_stroke();
        }
        Ok(())
    }

    pub(crate) fn rename_material(&mut self, name: &str, new: &str) -> anyhow::Result<()> {
        let materials = self.scene().materials();
        anyhow::ensure!(!new.is_empty(), "a material needs a name");
        anyhow::ensure!(
            !materials.contains_key(new),
            "a material named {new} exists already"
        );
        let material = materials.get(name).cloned();
        let users = self.users_of(name);
        self.begin_stroke("Rename material");
        self.set_material("Rename material", new, material)?;
        self.give_material("Rename material", &users, &Some(new.to_owned()))?;
        self.set_material("Rename material", name, None)?;
        self.end_stroke();
        Ok(())
    }

    /// Removes a material, also from the nodes that use it.
    pub(crate) fn remove_material(&mut self, name: &str) -> anyhow::Result<()> {
        let users = self.users_of(name);
        self.begin_stroke("Remove material");
        self.give_material("Remove material", &users, &None)?;
        self.set_material("Remove material", name, None)?;
        self.end_stroke();
        Ok(())
    }

    /// Returns the folder that mesh paths are relative to.
    pub(crate) fn mesh_folder(&self) -> PathBuf {
        self.path().map_or(Path::new("."), folder_of).into()
    }

    /// Allows the scene to read a file, wherever it is.
    pub(crate) fn allow_file(&mut self, path: &Path) {
        self.external.allow(path);
        self.recovery.note_external(path);
    }

    /// Returns the files of all meshes that are loaded.
    pub(crate) fn loaded_mesh_places(&self) -> Vec<PathBuf> {
        let folder = self.mesh_folder();
        let missing = self.missing_meshes();
        let is_loaded = |path: &&str| missing.iter().all(|(missing_path, _)| missing_path != path);
        let loaded = self.scene.known_mesh_paths().filter(is_loaded);
        loaded.map(|path| folder.join(path)).collect()
    }

    /// Returns a mesh's path relative to the scene's folder, if it lies inside.
    pub(crate) fn mesh_name(&self, path: &Path) -> std::io::Result<String> {
        let absolute = std::path::absolute(path)?;
        let folder_of_scene = self.path().and_then(Path::parent);
        let within = match folder_of_scene.map(std::path::absolute) {
            Some(folder) => absolute.strip_prefix(folder?).ok(),
            None => None,
        };
        let named = within.unwrap_or(&absolute).to_string_lossy();
        Ok(named.replace('\\', "/"))
    }

    /// Checks that all meshes are loaded, for work that would leave out missing ones.
    pub(crate) fn ensure_whole(&self) -> anyhow::Result<()> {
        match self.missing_meshes().first() {
            None => Ok(()),
            Some((path, _)) => anyhow::bail!(
                "the mesh {path} is missing: choose its file in the inspector, or delete its brush"
            ),
        }
    }
}
