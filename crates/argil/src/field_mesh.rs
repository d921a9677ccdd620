//! Meshes of a field on the CPU, and what all ways to mesh share.

use crate::memory::{budget_on, without_budget};
use crate::{BuildError, Engine};
use argil_field::Program;
use argil_math::Control;
use argil_mesh::marching::bricks::CellLoops;
use argil_mesh::{Mesh, dual_contouring, marching, project_to_field};
use argil_volume::{BrickLayout, BrickSettings, Bricks, CellPrograms, VoxelGrid};
use web_time::Instant;

/// The algorithm that extracts triangles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[doc(alias = "marching cubes")]
#[doc(alias = "isosurface")]
#[doc(alias = "polygonize")]
pub enum MeshMethod {
    /// Marching cubes: vertices on the edges of the voxel grid (Lorensen and Cline 1987).
    #[default]
    #[cfg_attr(feature = "clap", value(name = "mc"))]
    MarchingCubes,
    /// Dual contouring: vertices inside cells, where the planes of the exact surface meet (Ju et al. 2002). It
    /// keeps sharp edges.
    #[cfg_attr(feature = "clap", value(name = "dc"))]
    DualContouring,
}

/// A mesh of a field, with the bricks that it was extracted from.
pub(crate) struct FieldMesh {
    /// The mesh. Marching cubes gives it the field's normals, if they are wanted.
    pub mesh: Mesh,
    pub bricks: Bricks,
    pub lists: CellPrograms,
}

/// Bakes bricks, extracts triangles, and moves their vertices to where the exact distance is 0. Dual contouring needs
/// normals in any case.
pub(crate) fn field_mesh(
    engine: &Engine,
    program: &Program,
    voxel_grid: VoxelGrid,
    method: MeshMethod,
    with_normals: bool,
    stages: &mut Stages,
) -> Result<FieldMesh, BuildError> {
    let layout = layout_of(voxel_grid)?;
    let budget = budget_on(engine, None);
    let control = &engine.control;
    let (bricks, lists, _) =
        Bricks::bake_with_programs_and_control(program, layout, budget, control)
            .map_err(|e| without_budget(e.into(), None))?;
    stages.done("bake")?;
    let is_dual = method == MeshMethod::DualContouring;
    let (mut marched, rings) = if is_dual {
        marching::bricks::march_with_loops(&bricks)
    } else {
        (marching::bricks::march(&bricks), CellLoops::default())
    };
    stages.done("march")?;
    let with_normals = with_normals || is_dual;
    project_to_field::project_to_field(program, &lists, &mut marched, with_normals);
    stages.done("refine")?;
    if is_dual {
        marched.mesh = dual_contouring::contour(&voxel_grid, &marched, &rings);
        stages.done("contour")?;
    } else if with_normals {
        project_to_field::orient_normals(&mut marched);
    } else {
        marched.mesh.normals = Vec::new();
    }
    let mesh = marched.mesh;
    Ok(FieldMesh {
        mesh,
        bricks,
        lists,
    })
}

/// Returns the brick layout on a voxel grid.
pub(crate) fn layout_of(voxel_grid: VoxelGrid) -> Result<BrickLayout, BuildError> {
    Ok(BrickLayout::new(voxel_grid, &BrickSettings::default())?)
}

pub(crate) struct Stages {
    control: Control,
    last: Instant,
    pub all: Vec<(&'static str, f64)>,
}

impl Stages {
    pub(crate) fn of(engine: &Engine) -> Self {
        Self {
            control: engine.control.clone(),
            last: Instant::now(),
            all: Vec::new(),
        }
    }

    /// Restarts the clock, because the work since the last stage is counted elsewhere.
    #[cfg(feature = "gpu")]
    pub(crate) fn restart(&mut self) {
        self.last = Instant::now();
    }

    /// Ends a stage.
    ///
    /// # Errors
    /// If the work was canceled.
    pub(crate) fn done(&mut self, stage: &'static str) -> Result<(), BuildError> {
        let now = Instant::now();
        self.all
            .push((stage, (now - self.last).as_secs_f64() * 1e3));
        self.last = now;
        // The number of steps of the next stage is not known.
        self.control.begin("mesh", 0);
        if self.control.is_cancelled() {
            return Err(BuildError::Cancelled);
        }
        Ok(())
    }
}
