//! Solids as Python holds them.
//!
//! *Length.* PyO3 takes one block of methods for a class.

use crate::arrays::points;
use crate::ask;
use crate::axes::{box_from_python, box_to_python};
use crate::errors::{ToPython, warn_of_copies, warn_of_meshes};
use crate::mesh::Mesh;
use crate::pictures::{self, PictureOptions};
use crate::solid::Solid;
use crate::tree::{Tree, complement, of_scene, within};
use crate::work;
use argil::field::CoincidingCopies;
use argil::math::Control;
use argil::scene::{Material, Modifier, Operator, Ramp, Scene, Shape};
use argil::{BricksOptions, Engine, ExportOptions, MeshMethod, MeshOptions};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

/// A solid: a tree of shapes, operators and modifiers, which never changes.
#[pyclass(frozen, module = "argil._native")]
pub struct Node {
    tree: Arc<Tree>,
    solid: OnceLock<Arc<Solid>>,
}

impl Node {
    pub fn new(tree: Tree) -> Self {
        Self {
            tree: Arc::new(tree),
            solid: OnceLock::new(),
        }
    }

    pub fn tree(&self) -> &Arc<Tree> {
        &self.tree
    }

    /// Returns the solid's field, built when it is first asked for.
    ///
    /// # Errors
    /// SceneError if it exceeds a limit.
    pub fn solid(&self, py: Python<'_>) -> PyResult<Arc<Solid>> {
        if let Some(solid) = self.solid.get() {
            return Ok(solid.clone());
        }
        let (built, copies) = work::run_short(py, || {
            let scene = self.tree.to_scene().map_err(ToPython::to_python)?;
            let copies = CoincidingCopies::of(&scene);
            let built = Solid::new(scene).map_err(ToPython::to_python)?;
            Ok::<_, PyErr>((built, copies))
        })??;
        warn_of_copies(py, Path::new("solid"), &copies)?;
        Ok(self.solid.get_or_init(|| Arc::new(built)).clone())
    }
}

/// Parses what the front of the package wrote.
pub fn parsed<T: serde::de::DeserializeOwned>(json: &str) -> PyResult<T> {
    serde_json::from_str(json).map_err(|error| PyValueError::new_err(error.to_string()))
}

pub type Box3 = [[f32; 3]; 2];

/// Scene JSON, and the path, the resolution and the bytes of each grid of samples that it refers to.
pub type SceneText = (String, Vec<(String, u32, Vec<u8>)>);

#[pymethods]
impl Node {
    /// Creates a shape from its JSON.
    #[staticmethod]
    fn shape(json: &str) -> PyResult<Self> {
        let shape: Shape = parsed(json)?;
        shape.check().map_err(ToPython::to_python)?;
        Ok(Self::new(Tree::Shape(shape)))
    }

    /// Applies a modifier from its JSON.
    fn modified(&self, json: &str) -> PyResult<Self> {
        let modifier: Modifier = parsed(json)?;
        modifier.check().map_err(ToPython::to_python)?;
        Ok(Self::new(Tree::Modified {
            modifier,
            inner: self.tree.clone(),
        }))
    }

    /// Combines this solid with another one.
    fn joined(
        &self,
        other: &Self,
        kind: &str,
        blend: f32,
        profile: &str,
        amount: f32,
        ramp: Option<&str>,
    ) -> PyResult<Self> {
        let text = |name: &str| format!("\"{name}\"");
        let operator = Operator {
            kind: parsed(&text(kind))?,
            blend,
            profile: parsed(&text(profile))?,
            morph_amount: amount,
        };
        let ramp: Option<Ramp> = ramp.map(parsed).transpose()?;
        let tree = Tree::Join {
            operator,
            ramp,
            left: self.tree.clone(),
            right: other.tree.clone(),
        };
        Ok(Self::new(tree))
    }

    fn complement(&self) -> Self {
        Self::new(complement(self.tree.clone()))
    }

    fn painted(&self, json: &str) -> PyResult<Self> {
        let material: Material = parsed(json)?;
        material.check().map_err(ToPython::to_python)?;
        Ok(Self::new(Tree::Painted {
            material,
            inner: self.tree.clone(),
        }))
    }

    fn named(&self, name: String) -> Self {
        Self::new(Tree::Named {
            name,
            inner: self.tree.clone(),
        })
    }

    /// Reads a solid from a file: a mesh, a volume, or a heightmap's image.
    #[staticmethod]
    #[pyo3(signature = (path, resolution, progress=None))]
    fn from_file(
        py: Python<'_>,
        path: PathBuf,
        resolution: u32,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let (scene, loaded) = work::run(py, progress.as_ref(), |control| {
            let absolute = std::path::absolute(&path).map_err(ToPython::to_python)?;
            let mut shape = Shape::mesh(absolute.to_string_lossy());
            if let Shape::Mesh {
                resolution: voxels, ..
            } = &mut shape
            {
                *voxels = resolution;
            }
            shape.check().map_err(ToPython::to_python)?;
            let mut scene = Scene::new();
            scene.push(shape).map_err(ToPython::to_python)?;
            let folder = absolute.parent().unwrap_or(&absolute);
            let loaded = argil::load_meshes_with_control(&mut scene, folder, true, control);
            let loaded = loaded.map_err(ToPython::to_python)?;
            Ok::<_, PyErr>((scene, loaded))
        })??;
        warn_of_meshes(py, &loaded)?;
        let id = scene.node(Scene::ROOT).children()[0];
        let grid = scene
            .node(id)
            .desc()
            .kind
            .file()
            .and_then(|(_, _, grid)| grid.0.clone());
        let grid = grid.ok_or_else(|| PyValueError::new_err("the file holds no solid"))?;
        Ok(Self::new(Tree::Shape(crate::function::named(
            (*grid).clone(),
        ))))
    }

    /// Reads a volume of another program, from a file or from its bytes.
    #[staticmethod]
    #[pyo3(signature = (path, content, grid, fog, iso, voxel_size, origin, progress=None))]
    #[expect(clippy::too_many_arguments, reason = "keyword arguments of Python")]
    fn from_volume(
        py: Python<'_>,
        path: PathBuf,
        content: Option<Vec<u8>>,
        grid: Option<String>,
        fog: Option<bool>,
        iso: Option<f32>,
        voxel_size: Option<f32>,
        origin: Option<[f32; 3]>,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let options = argil::VolumeReadOptions {
            grid,
            is_fog: fog,
            iso,
            raw: argil::RawLayout {
                voxel_size,
                origin,
                ..Default::default()
            },
        };
        let read = work::run(py, progress.as_ref(), |_| match &content {
            Some(bytes) => argil::read_volume_bytes(bytes, &path, &options),
            None => argil::read_volume(&path, &options),
        })?;
        let read = read.map_err(|error| argil::MeshFileError::from(error).to_python())?;
        Ok(Self::new(Tree::Shape(crate::function::named(read.grid))))
    }

    /// Reads ground from an image. The half size is along Python's x and y.
    #[staticmethod]
    fn heightmap(
        py: Python<'_>,
        path: PathBuf,
        half_size: [f32; 2],
        height: f32,
        base: f32,
    ) -> PyResult<Self> {
        let (scene, loaded) = work::run(py, None, |control| {
            let absolute = std::path::absolute(&path).map_err(ToPython::to_python)?;
            let mut shape = Shape::heightmap(absolute.to_string_lossy(), half_size, height);
            if let Shape::Heightmap { base: foot, .. } = &mut shape {
                *foot = base;
            }
            shape.check().map_err(ToPython::to_python)?;
            let mut scene = Scene::new();
            scene.push(shape).map_err(ToPython::to_python)?;
            let folder = absolute.parent().unwrap_or(&absolute);
            let loaded = argil::load_meshes_with_control(&mut scene, folder, true, control);
            let loaded = loaded.map_err(ToPython::to_python)?;
            Ok::<_, PyErr>((scene, loaded))
        })??;
        warn_of_meshes(py, &loaded)?;
        Ok(Self::new(of_scene(&scene)))
    }

    #[getter]
    fn brush_count(&self, py: Python<'_>) -> PyResult<usize> {
        Ok(self.solid(py)?.scene.brush_count())
    }

    /// Whether the mesh gets colors.
    #[getter]
    fn has_materials(&self, py: Python<'_>) -> PyResult<bool> {
        Ok(!self.solid(py)?.scene.materials().is_empty())
    }

    fn bounds(&self, py: Python<'_>) -> PyResult<Option<Box3>> {
        let solid = self.solid(py)?;
        let extent = work::run(py, None, |_| solid.aabb())?;
        Ok((!extent.is_empty()).then(|| box_to_python(extent)))
    }

    /// Returns the finite box to sample, or raises ValueError.
    fn finite_bounds(&self, py: Python<'_>) -> PyResult<Box3> {
        let solid = self.solid(py)?;
        work::run(py, None, |_| solid.finite_box(None))?.map(box_to_python)
    }

    #[pyo3(signature = (array, progress=None))]
    fn distances<'py>(
        &self,
        py: Python<'py>,
        array: &Bound<'py, PyAny>,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Bound<'py, PyArray1<f32>>> {
        let solid = self.solid(py)?;
        let points = points(array)?;
        // A thread of its own costs as much as a few thousand points.
        let found = if points.len() < 50_000 && progress.is_none() {
            work::run_short(py, || ask::distances(&solid, &points, &Control::default()))?
        } else {
            work::run(py, progress.as_ref(), |control| {
                ask::distances(&solid, &points, control)
            })?
        };
        Ok(PyArray1::from_vec(py, found))
    }

    #[pyo3(signature = (array, progress=None))]
    fn gradients<'py>(
        &self,
        py: Python<'py>,
        array: &Bound<'py, PyAny>,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let solid = self.solid(py)?;
        let points = points(array)?;
        let found = work::run(py, progress.as_ref(), |control| {
            ask::gradients(&solid, &points, control)
        })?;
        PyArray1::from_vec(py, found).reshape([points.len(), 3])
    }

    #[pyo3(signature = (array, max_distance, progress=None))]
    fn closest_points<'py>(
        &self,
        py: Python<'py>,
        array: &Bound<'py, PyAny>,
        max_distance: f32,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let solid = self.solid(py)?;
        let points = points(array)?;
        let found = work::run(py, progress.as_ref(), |control| {
            ask::closest_points(&solid, &points, max_distance, control)
        })?;
        PyArray1::from_vec(py, found).reshape([points.len(), 4])
    }

    #[pyo3(signature = (origins, directions, max_distance, progress=None))]
    fn cast_rays<'py>(
        &self,
        py: Python<'py>,
        origins: &Bound<'py, PyAny>,
        directions: &Bound<'py, PyAny>,
        max_distance: f32,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let solid = self.solid(py)?;
        let (origins, directions) = (points(origins)?, points(directions)?);
        let (from, along) = (&origins, &directions);
        if from.len() != along.len() {
            return Err(PyValueError::new_err(format!(
                "{} origins and {} directions: expected as many",
                from.len(),
                along.len()
            )));
        }
        let found = work::run(py, progress.as_ref(), |control| {
            ask::cast_rays(&solid, from, along, max_distance, control)
        })?;
        PyArray1::from_vec(py, found).reshape([from.len(), 7])
    }

    #[pyo3(signature = (voxel_size, bounds=None, method="mc", max_triangles=None, normals=true, colors=true, progress=None))]
    #[expect(clippy::too_many_arguments, reason = "keyword arguments of Python")]
    fn mesh(
        &self,
        py: Python<'_>,
        voxel_size: f32,
        bounds: Option<Box3>,
        method: &str,
        max_triangles: Option<usize>,
        normals: bool,
        colors: bool,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Mesh> {
        let solid = self.solid(py)?;
        let bounds = bounds.map(box_from_python);
        let options = MeshOptions {
            method: match method {
                "mc" => MeshMethod::MarchingCubes,
                "dc" => MeshMethod::DualContouring,
                other => {
                    return Err(PyValueError::new_err(format!(
                        "method: {other:?} is neither \"mc\" (marching cubes) nor \"dc\" (dual contouring)"
                    )));
                }
            },
            voxel_size: Some(voxel_size),
            max_triangles,
            materials: colors,
            normals: if normals {
                argil::MeshNormals::Field
            } else {
                argil::MeshNormals::None
            },
            checks: false,
            ..MeshOptions::default()
        };
        let output = work::run(py, progress.as_ref(), |control| {
            let limits = solid.mesh_limits(bounds, voxel_size)?;
            let cut;
            let scene = match limits {
                // What a box cuts is closed there.
                Some(limits) => {
                    let part = within(self.tree.clone(), limits);
                    cut = part.to_scene().map_err(ToPython::to_python)?;
                    &cut
                }
                None => &solid.scene,
            };
            let engine = Engine::cpu().with_control(control);
            let world = engine.build(scene).map_err(ToPython::to_python)?.field();
            world.mesh(&options).map_err(ToPython::to_python)
        })??;
        Ok(Mesh::new(output))
    }

    /// Returns distances at the points of a grid, as an array [x, y, z] of Python's axes.
    #[pyo3(signature = (first, spacing, counts, progress=None))]
    fn grid<'py>(
        &self,
        py: Python<'py>,
        first: [f32; 3],
        spacing: f32,
        counts: [usize; 3],
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let solid = self.solid(py)?;
        let [nx, ny, nz] = counts;
        let total = nx.checked_mul(ny).and_then(|n| n.checked_mul(nz));
        let Some(total) = total.filter(|&total| total <= 1 << 32) else {
            return Err(PyValueError::new_err(format!(
                "{nx} × {ny} × {nz} samples are too many: at most 2³²"
            )));
        };
        // Python's y runs against the scene's z.
        let last_y = first[1] + spacing * (ny.max(1) - 1) as f32;
        let grid = argil::field::Grid {
            min: [first[0], first[2], -last_y].into(),
            spacing: argil::glam::Vec3::splat(spacing),
            begin: argil::glam::UVec3::ZERO,
            size: argil::glam::UVec3::new(nx as u32, nz as u32, ny as u32),
        };
        let values = work::run(py, progress.as_ref(), |_| {
            let mut values = Vec::new();
            values.try_reserve_exact(total).map_err(|error| {
                pyo3::exceptions::PyMemoryError::new_err(format!("{total} samples: {error}"))
            })?;
            values.resize(total, 0.0);
            solid
                .world
                .sample_grid(&grid, &mut values)
                .map_err(|error| error.to_string().to_python())?;
            Ok::<_, PyErr>(values)
        })??;
        // The scene's array is [z, y, x], which is Python's [-y, z, x].
        let array = PyArray1::from_vec(py, values).reshape([ny, nz, nx])?;
        let flipped = array.call_method1(
            "__getitem__",
            (pyo3::types::PySlice::new(py, isize::MAX, isize::MIN, -1),),
        )?;
        flipped.call_method1("transpose", (1, 0, 2))
    }

    /// Renders a picture.
    #[pyo3(signature = (width, height, options, progress=None))]
    fn render<'py>(
        &self,
        py: Python<'py>,
        width: u32,
        height: u32,
        options: &str,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Bound<'py, numpy::PyArray3<u8>>> {
        let solid = self.solid(py)?;
        let options: PictureOptions = parsed(options)?;
        let seen = options.seen();
        let rgb = work::run(py, progress.as_ref(), |control| {
            if seen.is_none() {
                solid.finite_box(None)?;
            }
            let world = solid
                .world_within(seen, control)
                .map_err(ToPython::to_python)?;
            pictures::rendered(&world, &options, [width, height])
        })??;
        pictures::array(py, [width, height], rgb)
    }

    /// Writes a scene file.
    fn save_scene(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let mut scene = self.solid(py)?.scene.snapshot();
        scene.view.bounds = None;
        work::run(py, None, |_| scene.save(&path))?.map_err(ToPython::to_python)
    }

    /// Writes a volume: sparse bricks for .argil, and other programs' formats. The axis z of these points up.
    #[pyo3(signature = (path, voxel_size, bounds, half_width, progress=None))]
    fn save_volume(
        &self,
        py: Python<'_>,
        path: PathBuf,
        voxel_size: f32,
        bounds: Option<Box3>,
        half_width: f32,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let solid = self.solid(py)?;
        let within_box = bounds.map(box_from_python);
        let is_own = path
            .extension()
            .is_some_and(|ending| ending.eq_ignore_ascii_case("argil"));
        work::run(py, progress.as_ref(), |control| {
            let held = solid.finite_box(within_box)?;
            let engine = Engine::cpu().with_control(control);
            let part = match within_box {
                Some(limits) => Arc::new(within(self.tree.clone(), limits)),
                None => self.tree.clone(),
            };
            if is_own {
                let mut scene = part.to_scene().map_err(ToPython::to_python)?;
                scene.view.bounds = Some([held.min.to_array(), held.max.to_array()]);
                let options = BricksOptions {
                    voxel_size: Some(voxel_size),
                    ..BricksOptions::default()
                };
                let build = engine.build(&scene).map_err(ToPython::to_python)?;
                let world = build.bricks(options).map_err(ToPython::to_python)?;
                return world.save(&path).map_err(ToPython::to_python);
            }
            let tree = Tree::Modified {
                modifier: Modifier::Rotate {
                    axis: [1.0, 0.0, 0.0],
                    degrees: 90.0,
                },
                inner: part,
            };
            let mut scene = tree.to_scene().map_err(ToPython::to_python)?;
            let [low, high] = box_to_python(held);
            scene.view.bounds = Some([low, high]);
            let world = engine.build(&scene).map_err(ToPython::to_python)?.field();
            let options = ExportOptions {
                voxel_size: Some(voxel_size),
                half_width_voxels: half_width,
                ..ExportOptions::default()
            };
            world
                .export(&path, &options)
                .map(|_| ())
                .map_err(ToPython::to_python)
        })?
    }

    /// What the solid consists of.
    #[getter]
    fn description(&self) -> String {
        self.tree.description()
    }

    /// Returns the solid as scene JSON, and the samples that it refers to.
    fn to_json(&self, py: Python<'_>) -> PyResult<SceneText> {
        let scene = &self.solid(py)?.scene;
        let grids = scene.loaded_meshes().into_iter();
        let grids =
            grids.map(|(path, resolution, grid)| (path.to_owned(), resolution, grid.to_bytes()));
        let mut copy = scene.snapshot();
        copy.view.bounds = None;
        Ok((copy.to_json(), grids.collect()))
    }

    /// Creates a solid from what `to_json` returned.
    #[staticmethod]
    fn from_json(json: &str, grids: Vec<(String, u32, Vec<u8>)>) -> PyResult<Self> {
        let scene = crate::scene::read_json(json, grids)?;
        Ok(Self::new(of_scene(&scene)))
    }
}
