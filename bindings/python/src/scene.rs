//! Scenes, and sparse bricks that follow their edits.

use crate::axes::{box_from_python, box_to_python};
use crate::errors::{SceneError, ToPython};
use crate::node::{Box3, Node, parsed};
use crate::pictures::{self, PictureOptions};
use crate::tree::of_scene;
use crate::work;
use argil::scene::{
    Edit, Material, Modifier, NodeDesc, NodeId, NodeKind, NodeTree, SampledGrid, Scene as Brushes,
};
use argil::{BricksOptions, Engine, World};
use numpy::PyArray3;
use pyo3::exceptions::{PyKeyError, PyValueError};
use pyo3::prelude::*;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

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

fn locked<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
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
        let own = scene
            .get(node.id)
            .filter(|_| scene.iter().any(|id| id == node.id));
        Ok(own.ok_or_else(|| gone(node))?.desc().clone())
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
        external: bool,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let scene = work::run(py, progress.as_ref(), |control| {
            let mut scene = Brushes::open(&path).map_err(ToPython::to_python)?;
            let folder = path.parent().unwrap_or(&path);
            let loaded = argil::load_meshes_with_control(&mut scene, folder, external, control);
            loaded.map_err(ToPython::to_python)?;
            Ok::<_, PyErr>(scene)
        })??;
        Ok(Self::of(scene))
    }

    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let scene = locked(&self.scene).snapshot();
        work::run(py, None, |_| scene.save(&path))?.map_err(ToPython::to_python)
    }

    fn to_json(&self) -> (String, Vec<(String, u32, Vec<u8>)>) {
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
        let own = solid.tree().to_scene().map_err(ToPython::to_python)?;
        let mut nodes = match of_scene(&own) {
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
        for (name, material) in own.materials() {
            let (name, mut free) = (name.clone(), name.clone());
            let mut nth = 1;
            while scene
                .materials()
                .get(&free)
                .is_some_and(|known| known != material)
            {
                nth += 1;
                free = format!("{name} {nth}");
            }
            rename(&mut tree, &name, &free);
            scene
                .set_material(free, *material)
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
        let own = self.scene.clone();
        let bounds = bounds.map(box_from_python);
        let world = work::run(py, progress.as_ref(), |control| {
            // The scene itself, whose identity its edits are told by.
            let mut scene = locked(&own);
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
        Ok(Bricks {
            scene: self.scene.clone(),
            world: Mutex::new(world),
        })
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

/// Sparse bricks of a scene. They change in place after its edits.
#[pyclass(frozen, module = "argil._native")]
pub struct Bricks {
    scene: Arc<Mutex<Brushes>>,
    world: Mutex<World>,
}

#[pymethods]
impl Bricks {
    /// Applies the scene's edits since the last call. Returns the time in milliseconds, the changed box, and whether
    /// everything was built again, with the reason.
    #[pyo3(signature = (progress=None))]
    fn apply(
        &self,
        py: Python<'_>,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<(f64, Option<Box3>, bool, Option<String>)> {
        let report = work::run(py, progress.as_ref(), |control| {
            let scene = locked(&self.scene);
            let mut world = locked(&self.world);
            world.set_control(control);
            world.apply(&scene).map_err(ToPython::to_python)
        })??;
        let dirty = report.dirty_box;
        let reason = report.reason.map(|reason| reason.to_string());
        let changed = (!dirty.is_empty()).then(|| box_to_python(dirty));
        Ok((report.duration_ms, changed, report.rebuilt, reason))
    }

    /// Counts the cells that differ from bricks of the same scene that are built anew.
    fn diff_from_rebuild(&self, py: Python<'_>) -> PyResult<Option<u64>> {
        work::run(py, None, |_| {
            locked(&self.world)
                .diff_from_rebuild()
                .map_err(ToPython::to_python)
        })?
    }

    #[getter]
    fn memory_bytes(&self) -> u64 {
        locked(&self.world).memory_bytes()
    }

    /// Voxels along each of Python's axes.
    #[getter]
    fn resolution(&self) -> Option<[u32; 3]> {
        locked(&self.world).resolution().map(|[x, y, z]| [x, z, y])
    }

    /// The size of a voxel, the number of bricks, and the box.
    fn facts(&self, py: Python<'_>) -> PyResult<(f32, u64, Box3)> {
        work::run_short(py, || {
            let world = locked(&self.world);
            let info = world.volume_info().map_err(ToPython::to_python)?;
            let info =
                info.ok_or_else(|| SceneError::new_err("these bricks are gone: build them again"))?;
            let grid = info.voxel_grid;
            let bricks = info.bricks.map_or(0, |own| own.bricks);
            Ok((grid.voxel_size, bricks, box_to_python(grid.aabb())))
        })?
    }

    fn distances<'py>(
        &self,
        py: Python<'py>,
        array: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, numpy::PyArray1<f32>>> {
        let points = crate::arrays::points(array)?;
        let numbers = points.numbers()?;
        let found = work::run(py, None, |_| {
            let world = locked(&self.world);
            let mut out = vec![0.0; numbers.len()];
            if let Some(query) = world.query_volume() {
                query.distances(&numbers.to_scene(), &mut out);
            }
            out
        })?;
        Ok(numpy::PyArray1::from_vec(py, found))
    }

    fn mesh(&self, py: Python<'_>, normals: bool, colors: bool) -> PyResult<crate::mesh::Mesh> {
        let options = argil::MeshOptions {
            materials: colors,
            normals: if normals {
                argil::MeshNormals::Field
            } else {
                argil::MeshNormals::None
            },
            checks: false,
            ..argil::MeshOptions::default()
        };
        let output = work::run(py, None, |control| {
            let mut world = locked(&self.world);
            world.set_control(control);
            world.mesh(&options).map_err(ToPython::to_python)
        })??;
        Ok(crate::mesh::Mesh::new(output))
    }

    #[pyo3(signature = (width, height, options, progress=None))]
    fn render<'py>(
        &self,
        py: Python<'py>,
        width: u32,
        height: u32,
        options: &str,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Bound<'py, PyArray3<u8>>> {
        let options: PictureOptions = parsed(options)?;
        let image = work::run(py, progress.as_ref(), |control| {
            let mut world = locked(&self.world);
            world.set_control(control);
            let (camera, settings) = options.settings(&world, [width, height])?;
            world
                .render(&camera, &settings)
                .map_err(ToPython::to_python)
        })??;
        pictures::array(py, image.size, image.rgb)
    }

    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        work::run(py, None, |_| {
            locked(&self.world).save(&path).map_err(ToPython::to_python)
        })?
    }
}
