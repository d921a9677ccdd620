//! Options of meshes to render.

use super::options::RepresentationOptions;
use crate::BuildError;
use crate::build_context::BuildContext;
use crate::device::{AnyDevice, Device, StageTimings};
use crate::field_mesh::{MeshMethod, Stages, field_mesh};
use argil_mesh::project_to_field;
use argil_volume::{Volume, VoxelGrid};

/// Options of a mesh that is rendered. To export a mesh, use [`World::mesh`](crate::World::mesh).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshRenderOptions {
    /// Voxels along the longest side of the scene's box.
    pub resolution: u32,
    /// The algorithm that extracts triangles.
    pub method: MeshMethod,
    /// Whether each triangle is shaded with its own normal, the 2023 study's true normal. Otherwise, vertices have
    /// the exact field's normals.
    pub flat: bool,
}

impl Default for MeshRenderOptions {
    fn default() -> Self {
        Self {
            resolution: 256,
            method: MeshMethod::default(),
            flat: false,
        }
    }
}

impl RepresentationOptions for MeshRenderOptions {
    const NAME: &'static str = "mesh";
    const DESCRIPTION: &'static str = "Triangles, rasterized with a depth test";

    fn with_resolution(resolution: u32) -> Self {
        Self {
            resolution,
            ..Self::default()
        }
    }

    fn resolution(&self) -> u32 {
        self.resolution
    }

    fn of(_: &Volume) -> Option<Self> {
        None
    }

    async fn build(
        &self,
        device: &mut AnyDevice,
        site: &BuildContext<'_>,
        voxel_grid: VoxelGrid,
    ) -> Result<StageTimings, BuildError> {
        let BuildContext {
            engine, program, ..
        } = *site;
        if self.method == MeshMethod::MarchingCubes
            && let Some(stages) = device.build_mesh(site, voxel_grid, self.flat).await?
        {
            return Ok(stages);
        }
        let mut stages = Stages::of(engine);
        let made = field_mesh(
            engine,
            program,
            voxel_grid,
            self.method,
            !self.flat,
            &mut stages,
        )?;
        let mut mesh = made.mesh;
        if self.flat {
            mesh = mesh.unindexed(true);
            stages.done("unindex")?;
        } else if mesh.normals.is_empty() {
            project_to_field::normals(program, &made.lists, &mut mesh);
            stages.done("normals")?;
        }
        device.store_mesh(mesh, voxel_grid)?;
        Ok(stages.all)
    }
}
