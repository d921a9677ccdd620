//! Scenes.

use crate::axes::box_from_python;
use crate::bricks::Bricks;
use crate::errors::{ToPython, warn_of_copies, warn_of_meshes};
use crate::node::{Box3, Node, SceneText, parsed};
use crate::tree::of_scene;
use crate::work::{self, locked};
use argil::field::CoincidingCopies;
use argil::scene::{
    Edit, Material, Modifier, NodeDesc, NodeId, NodeKind, NodeTree, SampledGrid, Scene as Brushes,
};
use argil::volume::VolumeFile;
use argil::{BricksOptions, Engine, VolumeFileError};
use pyo3::exceptions::{PyKeyError, PyValueError};
use pyo3::prelude::*;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::PathBuf;
use std::sync::{Arc, Mutex};

/// Reads scene JSON with samples.
///
/// # Errors
/// SceneError if the JSON is not valid, and ValueError if samples are damaged.
pub fn read_json(json: &str, grids: Vec<(String, u32, Vec<u8>)>) -> PyResult<Brushes> {
    let mut scene = Brushes::from_json(json, "scene").map_err(ToPython::to_python)?;
    for (path, resolution, bytes) in grids {
        let grid = SampledGrid::from_bytes(&bytes);
        let grid = grid.ok_or_else(|| PyValueError::new_err(format!("{path}: damaged samples")))?;
        scene.set_mesh_grid(path, resolution, Arc::new(grid));
    }
    Ok(scene)
}

/// A brush or a group of a scene.
#[pyclass(frozen, module = "argil._native")]
#[derive(Clone)]
pub struct SceneNode {
    id: NodeId,
}

#[pymethods]
impl SceneNode {
    fn __eq__(&self, other: &Self) -> bool {
        self.id == other.id
    }

    fn __hash__(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        self.id.hash(&mut hasher);
        hasher.finish()
    }

    fn __repr__(&self) -> String {
        format!("<argil.SceneNode {}>", self.id.index())
    }
}

/// An ordered list of brushes and groups.
#[pyclass(frozen, module = "argil._native")]
pub struct Scene {
    scene: Arc<Mutex<Brushes>>,
}

/// Name, kind and visibility of a node, its material, its path and the node around it.
type NodeFacts = (
    String,
    String,
    bool,
    Option<String>,
    String,
    Option<SceneNode>,
);

impl Scene {
    fn of(scene: Brushes) -> Self {
        Self {
            scene: Arc::new(Mutex::new(scene)),
        }
    }

    fn parent_of(&self, parent: Option<&SceneNode>) -> NodeId {
        parent.map_or(Brushes::ROOT, |parent| parent.id)
    }

    fn edit(&self, edit: Edit) -> PyResult<SceneNode> {
        let outcome = locked(&self.scene)
            .apply(edit)
            .map_err(ToPython::to_python)?;
        Ok(SceneNode { id: outcome.node })
    }

    fn desc(&self, node: &SceneNode) -> PyResult<NodeDesc> {
        let scene = locked(&self.scene);
        let found = scene
            .get(node.id)
            .filter(|_| scene.iter().any(|id| id == node.id));
        Ok(found.ok_or_else(|| gone(node))?.desc().clone())
    }

    fn change(
        &self,
        node: &SceneNode,
        change: impl FnOnce(&mut NodeDesc) -> PyResult<()>,
    ) -> PyResult<()> {
        let mut desc = self.desc(node)?;
        change(&mut desc)?;
        self.edit(Edit::Replace {
            node: node.id,
            desc,
        })
        .map(|_| ())
    }
}

fn gone(node: &SceneNode) -> PyErr {
    PyKeyError::new_err(format!("node {} is not in this scene", node.id.index()))
}

#[pymethods]
impl Scene {
    #[new]
    fn new() -> Self {
        Self::of(Brushes::new())
    }

    /// Reads a scene file with the meshes that it names, or a scene of another program.
    #[staticmethod]
    #[pyo3(signature = (path, external, progress=None))]
    fn load(
        py: Python<'_>,
        path: PathBuf,
        external: crate::worlds::External,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let (scene, loaded, copies) = work::run(py, progress.as_ref(), |control| {
            // A volume holds the scene that it was made from.
            let mut scene = if VolumeFile::is_volume_file(&path) {
                let stored = VolumeFile::open(&path).map_err(VolumeFileError::from);
                let scene = stored.and_then(|stored| argil::stored_scene(&stored, &path));
                scene.map_err(ToPython::to_python)?
            } else {
                Brushes::open(&path).map_err(ToPython::to_python)?
            };
            let folder = path.parent().unwrap_or(&path);
            let loaded = argil::load_meshes_with_control(&mut scene, folder, external, control);
            let loaded = loaded.map_err(ToPython::to_python)?;
            let copies = CoincidingCopies::of(&scene);
            Ok::<_, PyErr>((scene, loaded, copies))
        })??;
        warn_of_meshes(py, &loaded)?;
        warn_of_copies(py, &path, &copies)?;
        Ok(Self::of(scene))
    }

    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let scene = locked(&self.scene).snapshot();
        work::run(py, None, |_| scene.save(&path))?.map_err(ToPython::to_python)
    }

    fn to_json(&self) -> SceneText {
        let scene = locked(&self.scene);
        let grids = scene.loaded_meshes().into_iter();
        let grids =
            grids.map(|(path, resolution, grid)| (path.to_owned(), resolution, grid.to_bytes()));
        (scene.to_json(), grids.collect())
    }

    #[staticmethod]
    fn from_json(json: &str, grids: Vec<(String, u32, Vec<u8>)>) -> PyResult<Self> {
        read_json(json, grids).map(Self::of)
    }

    /// Returns all brushes and groups as one solid.
    fn solid(&self) -> Node {
        Node::new(of_scene(&locked(&self.scene)))
    }

    /// Adds a solid to a group.
    fn add(
        &self,
        solid: &Node,
        operator: &str,
        blend: f32,
        profile: &str,
        name: Option<String>,
        parent: Option<&SceneNode>,
    ) -> PyResult<SceneNode> {
        let added = solid.tree().to_scene().map_err(ToPython::to_python)?;
        let mut nodes = match of_scene(&added) {
            crate::tree::Tree::Nodes { ref nodes, .. } => nodes.clone(),
            _ => Vec::new(),
        };
        let mut tree = match nodes.len() {
            1 => nodes.swap_remove(0),
            _ => {
                let mut group: NodeTree = argil::scene::Group::new().into();
                group.children = nodes;
                group
            }
        };
        tree.desc.operator.kind = parsed(&format!("\"{operator}\""))?;
        tree.desc.operator.profile = parsed(&format!("\"{profile}\""))?;
        tree.desc.operator.blend = blend;
        if let Some(name) = name {
            tree.desc.name = name;
        }
        let mut scene = locked(&self.scene);
        for (name, material) in added.materials() {
            let (name, mut free) = (name.clone(), name.clone());
            let mut index = 1;
            while scene
                .materials()
                .get(&free)
                .is_some_and(|known| known != material)
            {
                index += 1;
                free = format!("{name} {index}");
            }
            rename(&mut tree, &name, &free);
            scene
                .set_material(free, material.clone())
                .map_err(ToPython::to_python)?;
        }
        let parent = self.parent_of(parent);
        let outcome = scene.push_into(parent, tree);
        Ok(SceneNode {
            id: outcome.map_err(ToPython::to_python)?.node,
        })
    }

    /// Adds an empty group.
    fn group(
        &self,
        operator: &str,
        blend: f32,
        name: Option<String>,
        parent: Option<&SceneNode>,
    ) -> PyResult<SceneNode> {
        let mut desc: NodeDesc = argil::scene::Group::new().into();
        desc.operator.kind = parsed(&format!("\"{operator}\""))?;
        desc.operator.blend = blend;
        desc.name = name.unwrap_or_default();
        let parent = self.parent_of(parent);
        let index = locked(&self.scene)
            .get(parent)
            .map_or(0, |group| group.children().len());
        self.edit(Edit::Insert {
            parent,
            index,
            desc,
        })
    }

    fn remove(&self, node: &SceneNode) -> PyResult<()> {
        self.edit(Edit::Remove { node: node.id }).map(|_| ())
    }

    fn move_to(&self, node: &SceneNode, parent: Option<&SceneNode>, index: usize) -> PyResult<()> {
        let parent = self.parent_of(parent);
        self.edit(Edit::Move {
            node: node.id,
            parent,
            index,
        })
        .map(|_| ())
    }

    fn set_visible(&self, node: &SceneNode, visible: bool) -> PyResult<()> {
        self.edit(Edit::SetVisible {
            node: node.id,
            visible,
        })
        .map(|_| ())
    }

    fn rename(&self, node: &SceneNode, name: String) -> PyResult<()> {
        self.change(node, |desc| {
            desc.name = name;
            Ok(())
        })
    }

    fn set_blend(&self, node: &SceneNode, blend: f32, profile: &str) -> PyResult<()> {
        let profile = parsed(&format!("\"{profile}\""))?;
        self.change(node, |desc| {
            desc.operator.blend = blend;
            desc.operator.profile = profile;
            Ok(())
        })
    }

    fn set_operator(&self, node: &SceneNode, operator: &str) -> PyResult<()> {
        let kind = parsed(&format!("\"{operator}\""))?;
        self.change(node, |desc| {
            desc.operator.kind = kind;
            Ok(())
        })
    }

    fn paint(&self, node: &SceneNode, name: String, json: &str) -> PyResult<()> {
        let material: Material = parsed(json)?;
        locked(&self.scene)
            .set_material(name.clone(), material)
            .map_err(ToPython::to_python)?;
        self.change(node, |desc| {
            desc.material = Some(name);
            Ok(())
        })
    }

    /// Appends a translation, a rotation or a scale.
    fn transform(&self, node: &SceneNode, json: &str) -> PyResult<()> {
        let by: Modifier = parsed(json)?;
        self.edit(Edit::Transform { node: node.id, by }).map(|_| ())
    }

    /// Forgets what could be undone.
    fn forget_history(&self) {
        locked(&self.scene).forget_history(0);
    }

    fn undo(&self) -> bool {
        locked(&self.scene).undo().is_some()
    }

    fn redo(&self) -> bool {
        locked(&self.scene).redo().is_some()
    }

    #[getter]
    fn undo_depth(&self) -> usize {
        locked(&self.scene).undo_depth()
    }

    #[getter]
    fn redo_depth(&self) -> usize {
        locked(&self.scene).redo_depth()
    }

    #[getter]
    fn brush_count(&self) -> usize {
        locked(&self.scene).brush_count()
    }

    /// Returns all nodes, each before its contents.
    fn nodes(&self) -> Vec<SceneNode> {
        let scene = locked(&self.scene);
        let inner = scene.iter().filter(|&id| id != Brushes::ROOT);
        inner.map(|id| SceneNode { id }).collect()
    }

    fn facts(&self, node: &SceneNode) -> PyResult<NodeFacts> {
        let desc = self.desc(node)?;
        let scene = locked(&self.scene);
        let parent = scene
            .node(node.id)
            .parent()
            .filter(|&id| id != Brushes::ROOT);
        let kind = match &desc.kind {
            NodeKind::Shape(shape) => shape.kind().to_owned(),
            NodeKind::Group => "Group".to_owned(),
        };
        Ok((
            desc.name,
            kind,
            desc.visible,
            desc.material,
            scene.path(node.id),
            parent.map(|id| SceneNode { id }),
        ))
    }

    /// Builds sparse bricks of the scene.
    #[pyo3(signature = (resolution, voxel_size, bounds, progress=None))]
    fn bricks(
        &self,
        py: Python<'_>,
        resolution: u32,
        voxel_size: Option<f32>,
        bounds: Option<Box3>,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Bricks> {
        let shared = self.scene.clone();
        let bounds = bounds.map(box_from_python);
        let world = work::run(py, progress.as_ref(), |control| {
            // The scene itself, whose identity its edits are told by.
            let mut scene = locked(&shared);
            if let Some(bounds) = bounds {
                scene.view.bounds = Some([bounds.min.to_array(), bounds.max.to_array()]);
            }
            let options = BricksOptions {
                resolution,
                voxel_size,
                ..BricksOptions::default()
            };
            let build = Engine::cpu()
                .with_control(control)
                .build(&scene)
                .map_err(ToPython::to_python)?;
            build.bricks(options).map_err(ToPython::to_python)
        })??;
        Ok(Bricks::new(self.scene.clone(), world))
    }
}

fn rename(tree: &mut NodeTree, from: &str, to: &str) {
    if from == to {
        return;
    }
    let mut open = vec![tree];
    while let Some(tree) = open.pop() {
        if tree.desc.material.as_deref() == Some(from) {
            tree.desc.material = Some(to.to_owned());
        }
        open.extend(&mut tree.children);
    }
}
