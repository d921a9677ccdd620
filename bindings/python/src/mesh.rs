//! Triangle meshes as arrays.

use crate::axes::{python_from_scene, scene_from_python};
use crate::errors::{ToPython, warn};
use crate::function::named;
use crate::node::Node;
use crate::tree::Tree;
use crate::work::run_short;
use argil::MeshOutput;
use argil::glam::Vec3;
use argil::mesh::{Mesh as Triangles, MeshFormat, MeshReport, MeshSdf, MeshWriteOptions, UpAxis};
use numpy::{PyArray2, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;
use rayon::prelude::*;
use std::path::PathBuf;
use std::sync::OnceLock;

/// Triangles with shared vertices. The axis z points up.
#[pyclass(frozen, module = "argil._native")]
pub struct Mesh {
    triangles: Triangles,
    report: OnceLock<MeshReport>,
    #[pyo3(get)]
    voxel_size: f32,
    #[pyo3(get)]
    duration_ms: f64,
    #[pyo3(get)]
    simplification_error: f32,
}

impl Mesh {
    pub fn new(output: MeshOutput) -> Self {
        let mut triangles = output.mesh;
        let turn = |all: &mut Vec<Vec3>| {
            all.par_iter_mut()
                .with_min_len(1 << 14)
                .for_each(|v| *v = python_from_scene((*v).into()).into());
        };
        turn(&mut triangles.positions);
        turn(&mut triangles.normals);
        Self {
            triangles,
            report: OnceLock::new(),
            voxel_size: output.voxel_grid.voxel_size,
            duration_ms: output.duration_ms,
            simplification_error: output.simplification_error,
        }
    }

    fn of(triangles: Triangles) -> Self {
        Self {
            triangles,
            report: OnceLock::new(),
            voxel_size: 0.0,
            duration_ms: 0.0,
            simplification_error: 0.0,
        }
    }

    fn report(&self, py: Python<'_>) -> PyResult<&MeshReport> {
        if let Some(report) = self.report.get() {
            return Ok(report);
        }
        let report = run_short(py, || MeshReport::of(&self.triangles))?;
        Ok(self.report.get_or_init(|| report))
    }
}

fn rows<'py>(py: Python<'py>, all: &[f32], width: usize) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let flat = numpy::PyArray1::from_slice(py, all);
    flat.reshape([all.len() / width, width])
}

#[pymethods]
impl Mesh {
    /// Reads triangles from a file. Files with y up by definition are turned.
    #[staticmethod]
    fn from_file(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let file = run_short(py, || argil::mesh::read(&path))?.map_err(ToPython::to_python)?;
        warn(py, &path, &file.warnings)?;
        let mut triangles = file.mesh;
        if MeshFormat::from_path(&path).is_some_and(MeshFormat::is_turned) {
            for v in triangles.positions.iter_mut().chain(&mut triangles.normals) {
                *v = python_from_scene((*v).into()).into();
            }
        }
        Ok(Self::of(triangles))
    }

    /// Makes a mesh of arrays, which the front of the package has checked.
    #[staticmethod]
    fn from_arrays(
        vertices: PyReadonlyArray2<'_, f32>,
        triangles: PyReadonlyArray2<'_, u32>,
    ) -> PyResult<Self> {
        let refused = |error: numpy::AsSliceError| error.to_string().to_python();
        let corners = bytemuck::cast_slice::<f32, [f32; 3]>(vertices.as_slice().map_err(refused)?);
        let indices = bytemuck::cast_slice::<u32, [u32; 3]>(triangles.as_slice().map_err(refused)?);
        let count = corners.len() as u32;
        if indices.as_flattened().iter().any(|&index| index >= count) {
            return Err(format!("triangles: an index is not below {count}").to_python());
        }
        Ok(Self::of(Triangles {
            positions: corners.iter().map(|&corner| corner.into()).collect(),
            triangles: indices.to_vec(),
            ..Triangles::default()
        }))
    }

    /// Returns the solid that the triangles enclose.
    fn solid(&self, py: Python<'_>, resolution: u32) -> PyResult<Node> {
        if !(16..=512).contains(&resolution) {
            return Err(format!("resolution: {resolution} is not from 16 to 512").to_python());
        }
        let grid = crate::work::run(py, None, |control| {
            let mut turned = self.triangles.clone();
            let turn = |v: &mut Vec3| *v = scene_from_python((*v).into()).into();
            turned.positions.iter_mut().for_each(turn);
            let solid = MeshSdf::new(&turned)?;
            solid.sample_with_control(resolution, control)
        })?;
        let grid = grid.map_err(ToPython::to_python)?;
        Ok(Node::new(Tree::Shape(named(grid))))
    }

    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        rows(py, bytemuck::cast_slice(&self.triangles.positions), 3)
    }

    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        let flat = numpy::PyArray1::from_slice(py, self.triangles.triangles.as_flattened());
        flat.reshape([self.triangles.triangles.len(), 3])
    }

    #[getter]
    fn normals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        rows(py, bytemuck::cast_slice(&self.triangles.normals), 3)
    }

    /// Linear base colors, or an array without rows.
    #[getter]
    fn colors<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let colors = self.triangles.materials.iter();
        let flat: Vec<f32> = colors
            .flat_map(|material| material.base_roughness[..3].to_vec())
            .collect();
        rows(py, &flat, 3)
    }

    #[getter]
    fn vertex_count(&self) -> usize {
        self.triangles.positions.len()
    }

    #[getter]
    fn triangle_count(&self) -> usize {
        self.triangles.triangles.len()
    }

    #[getter]
    fn is_watertight(&self, py: Python<'_>) -> PyResult<bool> {
        Ok(self.report(py)?.is_watertight())
    }

    #[getter]
    fn volume(&self, py: Python<'_>) -> PyResult<f64> {
        Ok(self.report(py)?.volume)
    }

    #[getter]
    fn area(&self, py: Python<'_>) -> PyResult<f64> {
        Ok(self.report(py)?.area)
    }

    /// The center of mass, from the tetrahedra between triangles and the box's center.
    fn center_of_mass(&self, py: Python<'_>) -> PyResult<[f64; 3]> {
        run_short(py, || {
            let mesh = &self.triangles;
            let origin = mesh.aabb().center().as_dvec3();
            let sum =
                |a: (f64, argil::glam::DVec3), b: (f64, argil::glam::DVec3)| (a.0 + b.0, a.1 + b.1);
            let tetrahedra = (0..mesh.triangles.len())
                .into_par_iter()
                .with_min_len(1 << 12);
            let (volume, moment) = tetrahedra
                .map(|index| {
                    let [a, b, c] = mesh.triangle_vertices(index).map(|v| v.as_dvec3() - origin);
                    let volume = a.dot(b.cross(c)) / 6.0;
                    (volume, (a + b + c) * (0.25 * volume))
                })
                .reduce(Default::default, sum);
            (origin + moment / volume).to_array()
        })
    }

    fn save(&self, py: Python<'_>, path: PathBuf, y_up: bool, scale: f32) -> PyResult<()> {
        let options = MeshWriteOptions {
            axes: UpAxis::YUp,
            scale,
        };
        let format = MeshFormat::from_path(&path)
            .ok_or_else(|| argil::MeshError::UnknownFormat(path.clone()).to_python())?;
        run_short(py, || {
            if y_up {
                let mut turned = self.triangles.clone();
                let turn = |v: &mut Vec3| *v = Vec3::new(v.x, v.z, -v.y);
                turned.positions.iter_mut().for_each(turn);
                turned.normals.iter_mut().for_each(turn);
                return argil::save_mesh(&turned, format, &options, &path);
            }
            argil::save_mesh(&self.triangles, format, &options, &path)
        })?
        .map_err(ToPython::to_python)
    }
}
