//! Sparse bricks that follow the edits of a scene.

use crate::axes::box_to_python;
use crate::errors::{SceneError, ToPython};
use crate::node::{Box3, parsed};
use crate::pictures::{self, PictureOptions};
use crate::work::{self, locked};
use argil::World;
use argil::scene::Scene as Brushes;
use numpy::PyArray3;
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};

/// Sparse bricks of a scene. They change in place after its edits.
#[pyclass(frozen, module = "argil._native")]
pub struct Bricks {
    scene: Arc<Mutex<Brushes>>,
    world: Mutex<World>,
}

impl Bricks {
    pub fn new(scene: Arc<Mutex<Brushes>>, world: World) -> Self {
        Self {
            scene,
            world: Mutex::new(world),
        }
    }
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
            let bricks = info.bricks.map_or(0, |counted| counted.bricks);
            Ok((grid.voxel_size, bricks, box_to_python(grid.aabb())))
        })?
    }

    fn distances<'py>(
        &self,
        py: Python<'py>,
        array: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, numpy::PyArray1<f32>>> {
        let points = crate::arrays::points(array)?;
        let found = work::run(py, None, |_| {
            let world = locked(&self.world);
            let mut out = vec![0.0; points.len()];
            if let Some(query) = world.query_volume() {
                query.distances(&points, &mut out);
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
        let rgb = work::run(py, progress.as_ref(), |control| {
            let mut world = locked(&self.world);
            world.set_control(control);
            pictures::rendered(&world, &options, [width, height])
        })??;
        pictures::array(py, [width, height], rgb)
    }

    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        work::run(py, None, |_| {
            locked(&self.world).save(&path).map_err(ToPython::to_python)
        })?
    }
}
