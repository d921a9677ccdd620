//! Arrays of points. They are copied at once, because other threads of Python may write to an array while a solid is asked.

use crate::axes::scene_from_python;
use numpy::{PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

/// Returns the points of an array, in a scene's axes. The front of the package has made sure of type, shape and order: see
/// `_arrays.py`.
///
/// # Errors
/// TypeError or ValueError if it has not.
pub fn points(array: &Bound<'_, PyAny>) -> PyResult<Vec<[f32; 3]>> {
    if let Ok(single) = array.cast::<PyArrayDyn<f32>>() {
        copied(&single.readonly(), |c| c)
    } else if let Ok(double) = array.cast::<PyArrayDyn<f64>>() {
        copied(&double.readonly(), |c| c as f32)
    } else {
        let reason = "points: expected an array of float32 or float64";
        Err(PyTypeError::new_err(reason))
    }
}

fn copied<T: numpy::Element + Copy>(
    array: &PyReadonlyArrayDyn<'_, T>,
    single: impl Fn(T) -> f32,
) -> PyResult<Vec<[f32; 3]>> {
    let [_, 3] = array.shape() else {
        let reason = format!("points: expected shape (N, 3), not {:?}", array.shape());
        return Err(PyValueError::new_err(reason));
    };
    let refused = |_| PyValueError::new_err("points: expected a C-contiguous array");
    let (points, _) = array.as_slice().map_err(refused)?.as_chunks::<3>();
    let copy = |point: &[T; 3]| scene_from_python(point.map(&single));
    Ok(points.iter().map(copy).collect())
}
