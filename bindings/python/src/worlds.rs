//! Worlds as tiles: plans, and the shards that workers bake.

use crate::errors::ToPython;
use crate::work;
use argil::ExternalFiles;
use argil::scene::Scene;
use argil::volume::{BrickSettings, Encoding, SampleFormat};
use argil_world::{
    PlanOptions, Shard, Store, StoredWorld, TileCacheOptions, WorldError, WorldExportReport,
    WorldPlan,
};
use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;
use serde_json::json;
use std::path::{Path, PathBuf};

impl ToPython for WorldError {
    fn to_python(self) -> PyErr {
        match self {
            Self::Build(error) => error.to_python(),
            Self::Io { ref reason, .. } if reason.raw_os_error().is_none() => {
                PyOSError::new_err(self.to_string())
            }
            Self::Io { path, reason } => {
                let error = reason.to_python();
                Python::attach(|py| {
                    let _ = error.value(py).setattr("filename", path);
                });
                error
            }
            Self::Store { .. } => PyOSError::new_err(self.to_string()),
            Self::Plan { .. } | Self::Changed(_) => {
                crate::errors::SceneError::new_err(self.to_string())
            }
            _ => PyValueError::new_err(self.to_string()),
        }
    }
}

/// Files outside of a scene's folder that it may read: all, none, or some.
#[derive(FromPyObject)]
pub enum External {
    /// All, or none.
    All(bool),
    /// Some.
    Files(Vec<PathBuf>),
}

impl From<External> for ExternalFiles {
    fn from(external: External) -> Self {
        match external {
            External::All(all) => all.into(),
            External::Files(files) => files.into_iter().collect(),
        }
    }
}

fn scene_at(path: &Path, external: External, control: &argil::math::Control) -> PyResult<Scene> {
    let mut scene = Scene::open(path).map_err(ToPython::to_python)?;
    let folder = path.parent().unwrap_or(path);
    argil::load_meshes_with_control(&mut scene, folder, external, control)
        .map_err(ToPython::to_python)?;
    Ok(scene)
}

/// Reads a plan, and the meshes of its scene from a folder or from external files.
fn planned(
    plan: &str,
    (folder, external): (&Path, External),
    control: &argil::math::Control,
) -> PyResult<(WorldPlan, Scene)> {
    let plan = WorldPlan::from_json(plan, "plan").map_err(ToPython::to_python)?;
    let mut scene = plan.scene().map_err(ToPython::to_python)?;
    argil::load_meshes_with_control(&mut scene, folder, external, control)
        .map_err(ToPython::to_python)?;
    Ok((plan, scene))
}

/// A world that is being made, and where.
struct Site<'a> {
    plan: &'a WorldPlan,
    scene: &'a Scene,
    store: &'a Store,
}

/// How a store is opened.
type Open = fn(&str) -> Result<Store, WorldError>;

/// Reads a plan, opens a store, and works on both without the interpreter's lock.
fn with_store<T: Send>(
    py: Python<'_>,
    progress: Option<Bound<'_, PyAny>>,
    (plan, folder, external): (&str, &Path, External),
    (store, open): (&str, Open),
    what: impl FnOnce(&Site<'_>, &argil::math::Control) -> Result<T, WorldError> + Send,
) -> PyResult<T> {
    work::run(py, progress.as_ref(), |control| {
        let (plan, scene) = planned(plan, (folder, external), control)?;
        let store = open(store).map_err(ToPython::to_python)?;
        let site = Site {
            plan: &plan,
            scene: &scene,
            store: &store,
        };
        what(&site, control).map_err(ToPython::to_python)
    })?
}

/// Plans the world of a scene file. Returns the plan, its hash, and the number of tiles that there can be.
#[pyfunction]
#[pyo3(signature = (path, voxel_size, bits, external, progress=None))]
pub fn plan_world(
    py: Python<'_>,
    path: PathBuf,
    voxel_size: f32,
    bits: u32,
    external: External,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<(String, String, u64)> {
    let format = match bits {
        8 => SampleFormat::Snorm8,
        16 => SampleFormat::Snorm16,
        _ => {
            return Err(PyValueError::new_err(format!(
                "bits: {bits} is neither 8 nor 16"
            )));
        }
    };
    let options = PlanOptions {
        voxel_size,
        encoding: Encoding {
            format,
            ..BrickSettings::default().encoding
        },
    };
    let plan = work::run(py, progress.as_ref(), |control| {
        let scene = scene_at(&path, external, control)?;
        WorldPlan::with_control(&scene, &options, control).map_err(ToPython::to_python)
    })??;
    let tiles = plan.tile_count();
    Ok((plan.to_json(), plan.hash().to_owned(), tiles))
}

/// Returns the hash of a plan and the number of tiles that there can be, or raises SceneError.
#[pyfunction]
pub fn read_world_plan(text: &str, place: &str) -> PyResult<(String, u64)> {
    let plan = WorldPlan::from_json(text, place).map_err(ToPython::to_python)?;
    Ok((plan.hash().to_owned(), plan.tile_count()))
}

/// Bakes a shard of a world. Returns counts as JSON.
#[pyfunction]
#[pyo3(signature = (plan, folder, external, store, index, count, progress=None))]
#[expect(clippy::too_many_arguments, reason = "Python's arguments")]
pub fn bake_world(
    py: Python<'_>,
    plan: &str,
    folder: PathBuf,
    external: External,
    store: &str,
    index: u64,
    count: u64,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<String> {
    let open = |store: &str| Store::create(store);
    let shard = Shard { index, count };
    let done = with_store(
        py,
        progress,
        (plan, &folder, external),
        (store, open),
        |job, control| argil_world::bake(job.plan, job.scene, job.store, shard, control),
    )?;
    serde_json::to_string(&done).map_err(|error| PyValueError::new_err(error.to_string()))
}

/// Counts what a store has of a world, as JSON.
#[pyfunction]
#[pyo3(signature = (plan, folder, external, store, verify, progress=None))]
pub fn world_status(
    py: Python<'_>,
    plan: &str,
    folder: PathBuf,
    external: External,
    store: &str,
    verify: bool,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<String> {
    let open = |store: &str| Store::open(store);
    let found = with_store(
        py,
        progress,
        (plan, &folder, external),
        (store, open),
        |job, control| argil_world::status(job.plan, job.scene, job.store, verify, control),
    )?;
    let damaged: Vec<String> = found
        .damaged
        .iter()
        .map(|(address, _)| address.to_string())
        .collect();
    let report = json!({
        "tiles": found.tiles,
        "present": found.present,
        "damaged": damaged,
        "bytes": found.bytes,
        "finished": found.is_finished,
    });
    Ok(report.to_string())
}

/// Writes a world's manifest if nothing is missing. Returns the address of its folder.
#[pyfunction]
#[pyo3(signature = (plan, folder, external, store, verify, progress=None))]
pub fn finish_world(
    py: Python<'_>,
    plan: &str,
    folder: PathBuf,
    external: External,
    store: &str,
    verify: bool,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<String> {
    let open = |store: &str| Store::open(store);
    with_store(
        py,
        progress,
        (plan, &folder, external),
        (store, open),
        |job, control| {
            argil_world::finish(job.plan, job.scene, job.store, verify, control)?;
            Ok(job.store.within(job.plan.hash()).place().to_owned())
        },
    )
}

/// Saves edits beside a finished world. Returns the name of the new object.
#[pyfunction]
pub fn edit_world(py: Python<'_>, world: &str, lines: &str) -> PyResult<String> {
    py.detach(|| {
        let mut world = StoredWorld::open(world, &TileCacheOptions::default())?;
        world.save_edits(lines, "edits")
    })
    .map_err(ToPython::to_python)
}

/// Writes a finished world into a folder, as OME-Zarr if its name ends in .zarr, and as 3D Tiles else. Returns counts as JSON.
#[pyfunction]
#[pyo3(signature = (world, output, voxel_size, progress=None))]
pub fn export_world(
    py: Python<'_>,
    world: &str,
    output: PathBuf,
    voxel_size: Option<f32>,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<String> {
    let done: WorldExportReport = work::run(py, progress.as_ref(), |control| {
        let world = StoredWorld::open(world, &TileCacheOptions::from_environment())?;
        if output
            .extension()
            .is_some_and(|ending| ending.eq_ignore_ascii_case("zarr"))
        {
            zarr(&world, &output, voxel_size, control)
        } else {
            world.export_3d_tiles(&output, voxel_size, control)
        }
    })?
    .map_err(ToPython::to_python)?;
    let report = json!({
        "levels": done.levels,
        "files": done.files,
        "bytes": done.bytes,
        "triangles": done.triangles,
        "missing": done.missing,
        "edits_left_out": done.edits_left_out,
    });
    Ok(report.to_string())
}

#[cfg(feature = "zarr")]
fn zarr(
    world: &StoredWorld,
    output: &Path,
    voxel_size: Option<f32>,
    control: &argil::math::Control,
) -> Result<WorldExportReport, WorldError> {
    world.export_zarr(output, voxel_size, control)
}

#[cfg(not(feature = "zarr"))]
fn zarr(
    _: &StoredWorld,
    output: &Path,
    _: Option<f32>,
    _: &argil::math::Control,
) -> Result<WorldExportReport, WorldError> {
    Err(WorldError::Io {
        path: output.into(),
        reason: std::io::Error::other("this wheel was built without OME-Zarr (the feature `zarr`)"),
    })
}
