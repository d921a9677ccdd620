//! Python's exceptions for Rust's errors, with the same texts.

use argil::field::CoincidingCopies;
use argil::mesh::MeshReadError;
use argil::scene::{EditError, FileError, ValidationError};
use argil::{
    BuildError, ExportError, LoadedMesh, MeshError, MeshFileError, RenderError, VolumeFileError,
    VolumeReadError,
};
use pyo3::exceptions::{PyMemoryError, PyOSError, PyUserWarning, PyValueError};
use pyo3::prelude::*;
use std::ffi::CString;
use std::path::Path;

pyo3::create_exception!(
    argil,
    SceneError,
    PyValueError,
    "A scene that cannot be read, changed or built. The message names the place in it, such as brushes[3].shape.radius."
);

/// Conversion of an error of Rust to Python's.
pub trait ToPython {
    fn to_python(self) -> PyErr;
}

fn texts(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut source = error.source();
    while let Some(inner) = source {
        let message = inner.to_string();
        if !text.contains(&message) {
            text = format!("{text}: {message}");
        }
        source = inner.source();
    }
    text
}

/// Returns an error of the system as Python's, with its number, so that it becomes FileNotFoundError and the like.
fn of_system(error: &std::io::Error, text: String) -> PyErr {
    match error.raw_os_error() {
        Some(number) => PyOSError::new_err((number, text)),
        None => PyOSError::new_err(text),
    }
}

/// Finds the system's error behind another one.
fn system_error<'a>(error: &'a (dyn std::error::Error + 'static)) -> Option<&'a std::io::Error> {
    let mut at = Some(error);
    while let Some(cause) = at {
        if let Some(found) = cause.downcast_ref() {
            return Some(found);
        }
        at = cause.source();
    }
    None
}

/// Raises OSError where the system failed, and `other` elsewhere.
fn system_error_or(error: &(dyn std::error::Error + 'static), other: fn(String) -> PyErr) -> PyErr {
    let text = texts(error);
    match system_error(error) {
        Some(error) => of_system(error, text),
        None => other(text),
    }
}

macro_rules! raised_as {
    ($raised:ty: $($error:ty),* $(,)?) => {$(
        impl ToPython for $error {
            fn to_python(self) -> PyErr {
                system_error_or(&self, <$raised>::new_err)
            }
        }
    )*};
}

raised_as!(PyValueError:
    ValidationError,
    MeshReadError,
    RenderError,
    VolumeFileError,
    VolumeReadError,
    ExportError,
    std::io::Error,
    argil::ImageFileError
);
raised_as!(SceneError: FileError, MeshFileError, EditError);

impl ToPython for BuildError {
    fn to_python(self) -> PyErr {
        let text = texts(&self);
        if text.contains("memory") {
            return PyMemoryError::new_err(text);
        }
        match self {
            Self::Scene(_) => SceneError::new_err(text),
            _ => PyValueError::new_err(text),
        }
    }
}

impl ToPython for MeshError {
    fn to_python(self) -> PyErr {
        match self {
            Self::Build(error) => error.to_python(),
            error => system_error_or(&error, PyValueError::new_err),
        }
    }
}

impl ToPython for String {
    fn to_python(self) -> PyErr {
        PyValueError::new_err(self)
    }
}

/// Raises a warning of Python for each sentence about a file.
pub fn warn(py: Python<'_>, path: &Path, warnings: &[String]) -> PyResult<()> {
    let kind = py.get_type::<PyUserWarning>();
    for warning in warnings {
        let text = format!("{}: {warning}", path.display()).replace('\0', "");
        PyErr::warn(py, &kind, &CString::new(text)?, 2)?;
    }
    Ok(())
}

/// Raises a warning for each modifier of a scene whose copies are all in one place.
pub fn warn_of_copies(py: Python<'_>, path: &Path, all: &[CoincidingCopies]) -> PyResult<()> {
    let sentences: Vec<String> = all.iter().map(ToString::to_string).collect();
    warn(py, path, &sentences)
}

/// Raises the warnings about meshes that a scene names.
pub fn warn_of_meshes(py: Python<'_>, meshes: &[LoadedMesh]) -> PyResult<()> {
    meshes
        .iter()
        .try_for_each(|mesh| warn(py, Path::new(&mesh.path), &mesh.warnings()))
}
