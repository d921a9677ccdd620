//! Pictures as arrays and files.

use crate::axes::box_from_python;
use crate::errors::ToPython;
use crate::node::Box3;
use argil::World;
use argil::render::{Camera, RenderMode, RenderSettings};
use argil::scene::{CameraPose, write_atomically};
use numpy::{PyArray1, PyArray3, PyArrayMethods, PyReadonlyArray3, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use serde::Deserialize;
use std::path::PathBuf;

/// What a picture shows, as the front of the package writes it.
#[derive(Deserialize)]
pub struct PictureOptions {
    #[serde(default)]
    look_at: Option<[[f32; 3]; 2]>,
    #[serde(default)]
    orbit: Option<[f32; 3]>,
    #[serde(default)]
    field_of_view: Option<f32>,
    show: String,
    ground: bool,
    #[serde(default)]
    sun: Option<[f32; 2]>,
    #[serde(default)]
    samples: Option<u32>,
    #[serde(default)]
    pub bounds: Option<Box3>,
}

impl PictureOptions {
    /// Returns the box that is seen.
    pub fn seen(&self) -> Option<argil::math::Aabb> {
        self.bounds.map(box_from_python)
    }

    /// Returns the camera and the settings.
    ///
    /// # Errors
    /// ValueError for an unknown mode.
    pub fn settings(&self, world: &World, size: [u32; 2]) -> PyResult<(Camera, RenderSettings)> {
        let mode = match self.show.as_str() {
            "shaded" => RenderMode::Shaded,
            "normal" => RenderMode::Normal,
            "depth" => RenderMode::Depth,
            "heat" => RenderMode::Heat,
            "bricks" => RenderMode::Bricks,
            other => {
                return Err(PyValueError::new_err(format!(
                    "show: {other:?} is none of shaded, normal, depth, heat, bricks"
                )));
            }
        };
        let pose = match (self.look_at, self.orbit) {
            (Some([eye, target]), _) => Some(CameraPose::LookAt { eye, target }),
            (None, orbit) => orbit.map(CameraPose::Orbit),
        };
        let mut camera = match pose {
            None => world.camera(),
            Some(pose) => {
                pose.check().map_err(ToPython::to_python)?;
                world.camera_at(pose)
            }
        };
        if let Some(degrees) = self.field_of_view {
            camera.field_of_view_degrees = degrees;
        }
        let mut settings = world.render_settings(size, mode);
        settings.ground |= self.ground && mode == RenderMode::Shaded;
        settings.samples = self.samples.unwrap_or(settings.samples);
        settings.sun_degrees = self.sun.unwrap_or(settings.sun_degrees);
        Ok((camera, settings))
    }
}

/// Renders a world.
///
/// # Errors
/// Returns the settings' and the renderer's errors.
pub fn rendered(world: &World, options: &PictureOptions, size: [u32; 2]) -> PyResult<Vec<u8>> {
    let (camera, settings) = options.settings(world, size)?;
    let image = world.render(&camera, &settings);
    image.map(|image| image.rgb).map_err(ToPython::to_python)
}

/// Returns a picture as an array.
pub fn array<'py>(
    py: Python<'py>,
    [width, height]: [u32; 2],
    rgb: Vec<u8>,
) -> PyResult<Bound<'py, PyArray3<u8>>> {
    PyArray1::from_vec(py, rgb).reshape([height as usize, width as usize, 3])
}

fn pixels(picture: &PyReadonlyArray3<'_, u8>) -> PyResult<([u32; 2], Vec<u8>)> {
    let &[height, width, channels] = picture.shape() else {
        return Err(PyValueError::new_err("picture: expected three axes"));
    };
    if channels != 3 || width == 0 || height == 0 {
        let text = format!(
            "picture: expected shape (height, width, 3), not {:?}",
            picture.shape()
        );
        return Err(PyValueError::new_err(text));
    }
    Ok((
        [width as u32, height as u32],
        picture.as_array().iter().copied().collect(),
    ))
}

#[pyfunction]
pub fn write_png(path: PathBuf, picture: PyReadonlyArray3<'_, u8>) -> PyResult<()> {
    let (size, rgb) = pixels(&picture)?;
    argil::save_png(&path, size, &rgb).map_err(ToPython::to_python)
}

#[pyfunction]
pub fn encode_png<'py>(
    py: Python<'py>,
    picture: PyReadonlyArray3<'_, u8>,
) -> PyResult<Bound<'py, PyBytes>> {
    let (size, rgb) = pixels(&picture)?;
    let mut bytes = Vec::new();
    argil::write_png(size, &rgb, &mut bytes).map_err(ToPython::to_python)?;
    Ok(PyBytes::new(py, &bytes))
}

/// Writes pictures of one size as an endless animation.
#[pyfunction]
pub fn write_gif(
    py: Python<'_>,
    path: PathBuf,
    pictures: Vec<PyReadonlyArray3<'_, u8>>,
    seconds: f64,
) -> PyResult<()> {
    let pictures: Vec<_> = pictures.iter().map(pixels).collect::<PyResult<_>>()?;
    let Some(&([width, height], _)) = pictures.first() else {
        return Err(PyValueError::new_err("pictures: there are none"));
    };
    if width > 65_535
        || height > 65_535
        || pictures.iter().any(|(size, _)| *size != [width, height])
    {
        return Err(PyValueError::new_err(
            "pictures: expected one size of at most 65535 pixels along a side",
        ));
    }
    // GIF counts in hundredths of a second.
    let delay = (100.0 * seconds).round().clamp(2.0, 65_535.0) as u16;
    let written = crate::work::run(py, None, |_| {
        write_atomically(&path, |out| {
            let other = |error: gif::EncodingError| std::io::Error::other(error);
            let mut encoder =
                gif::Encoder::new(out, width as u16, height as u16, &[]).map_err(other)?;
            encoder.set_repeat(gif::Repeat::Infinite).map_err(other)?;
            for (_, rgb) in &pictures {
                let mut frame = gif::Frame::from_rgb_speed(width as u16, height as u16, rgb, 10);
                frame.delay = delay;
                encoder.write_frame(&frame).map_err(other)?;
            }
            Ok(())
        })
    })?;
    written.map_err(ToPython::to_python)
}
