//! Triangles of a field, on either device.

use crate::memory::budget_on;
use crate::{BuildError, Engine};
use argil_field::Program;
use argil_gpu::{GpuMesh, GpuProgram, GpuVolume, StageTimings, SurfaceNormals, SurfaceOptions};
use argil_math::Control;
use argil_mesh::marching::bricks::CellLoops;
use argil_mesh::{Mesh, dual_contouring, marching, project_to_field};
use argil_volume::{BrickLayout, BrickSettings, Bricks, CellPrograms, VoxelGrid};
use web_time::Instant;

/// How triangles are found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum MeshMethod {
    /// Marching cubes: corners on the grid's edges.
    #[default]
    #[cfg_attr(feature = "clap", value(name = "mc"))]
    MarchingCubes,
    /// Dual contouring: corners in the grid's cells, where the exact surface's planes meet; edges of solids come out sharp.
    #[cfg_attr(feature = "clap", value(name = "dc"))]
    DualContouring,
}

/// A field's mesh with what it was made by.
pub(crate) struct FieldMesh {
    /// With the field's normals if it is marching cubes', else without.
    pub mesh: Mesh,
    pub bricks: Bricks,
    pub lists: CellPrograms,
}

/// Triangles of the field: of bricks that are made for it, corners moved to where the exact distance is 0.
pub(crate) fn field_mesh(
    engine: &Engine,
    program: &Program,
    lattice: VoxelGrid,
    method: MeshMethod,
    stages: &mut Stages,
) -> Result<FieldMesh, BuildError> {
    let layout = layout_of(lattice)?;
    let budget = budget_on(engine, None);
    let control = &engine.control;
    let (bricks, lists, _) =
        Bricks::bake_with_programs_and_control(program, layout, budget, control)?;
    stages.done("bake")?;
    let is_dual = method == MeshMethod::DualContouring;
    let (mut marched, rings) = if is_dual {
        marching::bricks::march_with_loops(&bricks)
    } else {
        (marching::bricks::march(&bricks), CellLoops::default())
    };
    stages.done("march")?;
    project_to_field::project_to_field(program, &lists, &mut marched);
    stages.done("refine")?;
    if is_dual {
        marched.mesh = dual_contouring::contour(&lattice, &marched, &rings);
        stages.done("contour")?;
    } else {
        project_to_field::orient_normals(&mut marched);
    }
    let mesh = marched.mesh;
    Ok(FieldMesh {
        mesh,
        bricks,
        lists,
    })
}

/// The same, built, marched and left on a GPU; what the stages took.
pub(crate) async fn field_mesh_on_gpu(
    engine: &Engine,
    field: &GpuProgram,
    program: &Program,
    lattice: VoxelGrid,
    normals: SurfaceNormals,
    is_unshared: bool,
) -> Result<(GpuMesh, StageTimings), BuildError> {
    let budget = budget_on(engine, None);
    let (volume, mut stages) = GpuVolume::bricks_with_control(
        field,
        program,
        layout_of(lattice)?,
        budget,
        &engine.control,
    )
    .await?;
    let options = SurfaceOptions {
        iso: 0.0,
        normals,
        project_to_field: true,
        is_unindexed: is_unshared,
    };
    let (mesh, took) = volume.march(field, &options).await?;
    stages.extend(took);
    Ok((mesh, stages))
}

/// Cells of bricks over a lattice.
pub(crate) fn layout_of(lattice: VoxelGrid) -> Result<BrickLayout, BuildError> {
    Ok(BrickLayout::new(lattice, &BrickSettings::default())?)
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

    /// What was done since is counted elsewhere.
    pub(crate) fn restart(&mut self) {
        self.last = Instant::now();
    }

    /// A stage is done; an error if the work is to end.
    pub(crate) fn done(&mut self, stage: &'static str) -> Result<(), BuildError> {
        let now = Instant::now();
        self.all
            .push((stage, (now - self.last).as_secs_f64() * 1e3));
        self.last = now;
        // How long the next takes is not known.
        self.control.begin("mesh", 0);
        if self.control.is_cancelled() {
            return Err(BuildError::Cancelled);
        }
        Ok(())
    }
}
