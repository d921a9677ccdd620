//! Arrays of points: read where they are if they are contiguous, and copied otherwise.

use crate::axes::scene_from_python;
use numpy::{PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

/// Points of an array, of either type.
pub enum Points<'py> {
    F32(PyReadonlyArrayDyn<'py, f32>),
    F64(PyReadonlyArrayDyn<'py, f64>),
}

/// The numbers of an array without Python.
#[derive(Clone, Copy)]
pub enum Numbers<'a> {
    F32(&'a [f32]),
    F64(&'a [f64]),
}

impl Numbers<'_> {
    /// Returns the number of points.
    pub fn len(&self) -> usize {
        match self {
            Self::F32(all) => all.len() / 3,
            Self::F64(all) => all.len() / 3,
        }
    }

    /// Copies some points into a scene's axes.
    pub fn scene_points(&self, first: usize, out: &mut [[f32; 3]]) {
        match self {
            Self::F32(all) => {
                for (point, out) in all[3 * first..].chunks_exact(3).zip(out) {
                    *out = scene_from_python([point[0], point[1], point[2]]);
                }
            }
            Self::F64(all) => {
                for (point, out) in all[3 * first..].chunks_exact(3).zip(out) {
                    *out = scene_from_python([point[0] as f32, point[1] as f32, point[2] as f32]);
                }
            }
        }
    }

    /// Returns all points in a scene's axes.
    pub fn to_scene(self) -> Vec<[f32; 3]> {
        let mut all = vec![[0.0; 3]; self.len()];
        self.scene_points(0, &mut all);
        all
    }
}

/// The front of the package has made sure of type, shape and order: see `_arrays.py`.
///
/// # Errors
/// TypeError or ValueError if it has not.
pub fn points<'py>(array: &Bound<'py, PyAny>) -> PyResult<Points<'py>> {
    let points = if let Ok(own) = array.cast::<PyArrayDyn<f32>>() {
        check_shape(own.shape())?;
        Points::F32(own.readonly())
    } else if let Ok(own) = array.cast::<PyArrayDyn<f64>>() {
        check_shape(own.shape())?;
        Points::F64(own.readonly())
    } else {
        return Err(PyTypeError::new_err(
            "points: expected an array of float32 or float64",
        ));
    };
    points.numbers()?;
    Ok(points)
}

fn check_shape(shape: &[usize]) -> PyResult<()> {
    match shape {
        [_, 3] => Ok(()),
        _ => Err(PyValueError::new_err(format!(
            "points: expected shape (N, 3), not {shape:?}"
        ))),
    }
}

impl Points<'_> {
    /// Returns the numbers, which no other thread may change meanwhile.
    ///
    /// # Errors
    /// ValueError for an array that is not contiguous.
    pub fn numbers(&self) -> PyResult<Numbers<'_>> {
        let refused = |_| PyValueError::new_err("points: expected a C-contiguous array");
        Ok(match self {
            Self::F32(own) => Numbers::F32(own.as_slice().map_err(refused)?),
            Self::F64(own) => Numbers::F64(own.as_slice().map_err(refused)?),
        })
    }
}
