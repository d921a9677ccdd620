//! Python functions as brushes: sampled into a grid.

use crate::axes::{box_from_python, python_from_scene};
use crate::node::Node;
use crate::tree::Tree;
use crate::work;
use argil::glam::Vec3;
use argil::math::Control;
use argil::scene::{DistanceSampler, SampledGrid, Shape};
use numpy::{PyArray1, PyArrayDyn, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Mutex;

/// How many cells of a grid are asked for in one call, which takes as long as thousands of points do.
const CELLS_PER_CALL: usize = 256;

/// A function of Python that takes an (N, 3) array of float64 and returns N distances.
struct PythonFunction<'a> {
    function: &'a Py<PyAny>,
    /// The center and the half size of the box, outside of which all is cut off.
    center: Vec3,
    half: Vec3,
    inverse_lipschitz: f32,
    control: &'a Control,
    failure: &'a Mutex<Option<PyErr>>,
}

impl PythonFunction<'_> {
    fn call(&self, points: &[Vec3], out: &mut [f32]) -> PyResult<()> {
        Python::attach(|py| {
            let flat = points
                .iter()
                .flat_map(|point| python_from_scene(point.to_array()));
            let flat: Vec<f64> = flat.map(f64::from).collect();
            let array = PyArray1::from_vec(py, flat).reshape([points.len(), 3])?;
            let result = self.function.bind(py).call1((array,))?;
            let result = result.cast::<PyArrayDyn<f64>>()?;
            if result.len() != out.len() {
                return Err(PyValueError::new_err(format!(
                    "the function returned an array of shape {:?} for {} points: expected one distance per point",
                    result.shape(),
                    out.len()
                )));
            }
            let values = result.readonly();
            for (out, value) in out.iter_mut().zip(values.as_array().iter()) {
                *out = *value as f32;
            }
            Ok(())
        })
    }
}

impl DistanceSampler for PythonFunction<'_> {
    fn distances(&self, points: &[Vec3], out: &mut [f32]) {
        let has_failed = || self.failure.lock().is_ok_and(|failure| failure.is_some());
        if self.control.is_cancelled() || has_failed() {
            out.fill(1.0);
            return;
        }
        if let Err(error) = self.call(points, out)
            && let Ok(mut failure) = self.failure.lock()
        {
            failure.get_or_insert(error);
            out.fill(1.0);
            return;
        }
        for (point, out) in points.iter().zip(out) {
            let beyond = (*point - self.center).abs() - self.half;
            let of_box = beyond.max(Vec3::ZERO).length() + beyond.max_element().min(0.0);
            let distance = *out * self.inverse_lipschitz;
            // What is not finite is refused later, which a maximum would hide.
            *out = if distance < of_box && distance.is_finite() {
                of_box
            } else if distance.is_finite() {
                distance
            } else {
                f32::NAN
            };
        }
    }

    fn cells_at_once(&self) -> usize {
        CELLS_PER_CALL
    }
}

/// Samples a function of Python within a box, with a number of samples along its longest side.
///
/// Returns the solid, the distance between samples, and the slope of what was sampled.
#[pyfunction]
#[pyo3(signature = (function, bounds, resolution, lipschitz, progress=None))]
pub fn sample_function(
    py: Python<'_>,
    function: Py<PyAny>,
    bounds: [[f32; 3]; 2],
    resolution: u32,
    lipschitz: f32,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<(Node, f32, f32)> {
    let solid = box_from_python(bounds);
    let longest = solid.size().max_element();
    if !(solid.is_finite() && solid.size().min_element() > 0.0 && longest <= 1e6) {
        return Err(PyValueError::new_err(format!(
            "bounds: {bounds:?} is not a box"
        )));
    }
    if !(16..=512).contains(&resolution) {
        return Err(PyValueError::new_err(format!(
            "resolution: {resolution} is not from 16 to 512"
        )));
    }
    if !(lipschitz > 0.0 && lipschitz.is_finite()) {
        return Err(PyValueError::new_err(format!(
            "lipschitz: {lipschitz} is not a positive number"
        )));
    }
    let spacing = longest / resolution as f32;
    let failure = Mutex::new(None);
    let grid = work::run(py, progress.as_ref(), |control| {
        let sampler = PythonFunction {
            function: &function,
            center: solid.center(),
            half: 0.5 * solid.size(),
            inverse_lipschitz: 1.0 / lipschitz,
            control,
            failure: &failure,
        };
        SampledGrid::sample_around(solid, spacing, &sampler)
    })?;
    if let Some(error) = failure.into_inner().ok().flatten() {
        return Err(error);
    }
    grid.check()
        .map_err(|error| PyValueError::new_err(format!("the function's {error}")))?;
    if !grid.has_inside() {
        return Err(PyValueError::new_err(format!(
            "the function is nowhere negative within its bounds, as far as {resolution} samples find"
        )));
    }
    let slope = grid.lipschitz();
    Ok((Node::new(Tree::Shape(named(grid))), spacing, slope))
}

/// Returns the shape of a grid, with a name from its contents.
pub fn named(grid: SampledGrid) -> Shape {
    let mut hasher = DefaultHasher::new();
    bytemuck::cast_slice::<f32, u32>(grid.words()).hash(&mut hasher);
    Shape::sampled(format!("samples-{:016x}", hasher.finish()), grid)
}
