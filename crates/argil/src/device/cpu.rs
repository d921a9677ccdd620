//! Worlds on the CPU.

use super::interface::{Device, EditWork, PathRequest, RenderRequest, StageTimings};
use crate::build_context::BuildContext;
use crate::field_mesh::Stages;
use crate::still_error::StillError;
use crate::{BuildError, MeshCounts, MeshError, MeshOptions, RenderError};
use argil_field::{IncrementalProgram, Program};
use argil_mesh::marching::surface::Surface;
use argil_mesh::{Mesh, MeshNormals};
use argil_render::{
    LitBricks, PrunedField, RenderOutput, RenderSource, Still, Triangles, continue_paths,
    render_with_control,
};
use argil_volume::{
    BrickLayout, BrickOrdering, BrickTest, Bricks, Dense, DenseFill, EditStats, Encoding, Levels,
    Octree, OctreeLayout, PendingEdits, Volume, VolumeInfo, VoxelGrid,
};
use std::borrow::Cow;
use web_time::Instant;

/// The share of a budget of time after which an edit samples no more. The rest is for storing what it has sampled.
const SAMPLED_SHARE: f64 = 0.85;

/// What a world stores on the CPU besides its program.
#[derive(Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "worlds are few, and hold megabytes elsewhere"
)]
pub(crate) enum CpuDevice {
    Field,
    Volume(Volume),
    Mesh { mesh: Mesh, voxel_grid: VoxelGrid },
}

/// Borrows a mesh in the form that is rendered.
pub(super) fn triangles(mesh: &Mesh) -> Triangles<'_> {
    Triangles {
        positions: &mesh.positions,
        normals: &mesh.normals,
        triangles: &mesh.triangles,
    }
}

impl CpuDevice {
    pub(crate) fn as_volume(&self) -> Option<&Volume> {
        match self {
            Self::Volume(volume) => Some(volume),
            _ => None,
        }
    }

    pub(crate) fn as_volume_mut(&mut self) -> Option<&mut Volume> {
        match self {
            Self::Volume(volume) => Some(volume),
            _ => None,
        }
    }

    /// Calls a function with what rays march through.
    pub(crate) fn with_source<T>(
        &self,
        light: Option<&Levels>,
        then: impl FnOnce(&dyn RenderSource) -> T,
    ) -> T {
        match (self, light) {
            (Self::Volume(Volume::Bricks(bricks)), Some(light)) => {
                then(&LitBricks { bricks, light })
            }
            (Self::Volume(volume), _) => then(volume),
            (Self::Mesh { mesh, .. }, _) => then(&triangles(mesh)),
            (Self::Field, _) => then(&PrunedField),
        }
    }
}

impl Device for CpuDevice {
    fn is_specialized(&self) -> bool {
        false
    }

    fn program_bytes(&self) -> u64 {
        0
    }

    fn stored_bytes(&self) -> Option<u64> {
        match self {
            Self::Field => None,
            Self::Volume(volume) => Some(volume.memory_bytes()),
            Self::Mesh { mesh, .. } => Some(mesh.memory_bytes()),
        }
    }

    fn light_bytes(&self) -> u64 {
        0
    }

    fn has_volume(&self) -> bool {
        self.as_volume().is_some()
    }

    fn has_paths(&self) -> bool {
        match self {
            Self::Field => true,
            // Their pages are there only where rays of an image needed them.
            Self::Volume(Volume::Levels(_)) | Self::Mesh { .. } => false,
            Self::Volume(volume) => {
                let center = volume.voxel_grid().aabb().center();
                volume.distance_in(center).is_some()
            }
        }
    }

    fn voxel_grid(&self) -> Option<VoxelGrid> {
        match self {
            Self::Field => None,
            Self::Volume(volume) => Some(*volume.voxel_grid()),
            Self::Mesh { voxel_grid, .. } => Some(*voxel_grid),
        }
    }

    fn brick_layout(&self) -> Option<BrickLayout> {
        match self.as_volume()? {
            Volume::Bricks(bricks) => Some(*bricks.layout()),
            _ => None,
        }
    }

    fn levels(&self) -> Option<&Levels> {
        match self.as_volume()? {
            Volume::Levels(levels) => Some(levels),
            _ => None,
        }
    }

    fn mesh_counts(&self) -> Option<MeshCounts> {
        let Self::Mesh { mesh, .. } = self else {
            return None;
        };
        Some(MeshCounts {
            triangles: mesh.triangles.len() as u64,
            vertices: mesh.positions.len() as u64,
        })
    }

    fn edits(&self) -> Option<Box<dyn PendingEdits>> {
        self.as_volume()?.edits()
    }

    fn has_lost_edits(&self) -> bool {
        false
    }

    fn set_program(&mut self, _: &Program) -> Result<(), BuildError> {
        Ok(())
    }

    fn follow_program(&mut self, _: &IncrementalProgram) -> Result<(), BuildError> {
        Ok(())
    }

    /// Has no effect: the CPU always interprets.
    fn specialize(&mut self, _: &Program) -> Result<(), BuildError> {
        Ok(())
    }

    fn clear(&mut self) {
        *self = Self::Field;
    }

    fn store_mesh(&mut self, mesh: Mesh, voxel_grid: VoxelGrid) -> Result<(), BuildError> {
        *self = Self::Mesh { mesh, voxel_grid };
        Ok(())
    }

    fn levels_mut(&mut self) -> Option<&mut Levels> {
        match self.as_volume_mut()? {
            Volume::Levels(levels) => Some(levels),
            _ => None,
        }
    }

    fn follow_levels(&mut self) -> Result<(), RenderError> {
        Ok(())
    }

    fn grow(&mut self, edits: &dyn PendingEdits) {
        if let Some(volume) = self.as_volume_mut() {
            volume.grow(edits);
        }
    }

    async fn info(&self) -> Result<Option<VolumeInfo>, BuildError> {
        Ok(self.as_volume().map(Volume::info))
    }

    async fn volume(&self) -> Result<Option<Cow<'_, Volume>>, BuildError> {
        Ok(self.as_volume().map(Cow::Borrowed))
    }

    async fn render(&self, request: RenderRequest<'_>) -> Result<(RenderOutput, f64), RenderError> {
        let program = (request.program)();
        let picture = self.with_source(request.light.as_deref(), |source| {
            let (frames, control) = (request.frames, request.control);
            render_with_control(program, source, frames, request.with_hits, control)
        });
        let picture = picture.ok_or(RenderError::Cancelled)?;
        Ok((picture, request.start.elapsed().as_secs_f64() * 1e3))
    }

    async fn trace_paths(
        &self,
        request: PathRequest<'_>,
        still: &mut Still,
    ) -> Result<(), StillError> {
        let (scene, view, frame) = (request.scene, request.view, request.frame);
        continue_paths(scene, view, frame, request.options, request.control, still);
        Ok(())
    }

    async fn volume_mesh(
        &self,
        options: &MeshOptions,
        stages: &mut Stages,
    ) -> Result<Option<Mesh>, MeshError> {
        let Some(volume) = self.as_volume() else {
            return Ok(None);
        };
        let with_normals = options.normals == MeshNormals::Gradient;
        let mesh = volume.triangles(options.iso, with_normals)?;
        stages.done("march")?;
        Ok(Some(mesh))
    }

    async fn field_mesh(
        &self,
        _: &BuildContext<'_>,
        _: VoxelGrid,
        _: MeshNormals,
        _: &mut Stages,
    ) -> Result<Option<Mesh>, MeshError> {
        Ok(None)
    }

    async fn build_dense(
        &mut self,
        site: &BuildContext<'_>,
        voxel_grid: VoxelGrid,
        encoding: Encoding,
        mips: bool,
        _: DenseFill,
    ) -> Result<StageTimings, BuildError> {
        let start = Instant::now();
        let control = &site.engine.control;
        let dense = Dense::bake_with_control(site.program, voxel_grid, encoding, mips, control);
        *self = Self::Volume(dense.ok_or(BuildError::Cancelled)?.into());
        Ok(vec![("fill", start.elapsed().as_secs_f64() * 1e3)])
    }

    async fn build_octree(
        &mut self,
        site: &BuildContext<'_>,
        layout: OctreeLayout,
        brick_test: BrickTest,
        _: BrickOrdering,
    ) -> Result<StageTimings, BuildError> {
        let control = &site.engine.control;
        let baked = Octree::bake_with_control(site.program, layout, brick_test, control);
        let (octree, stages) = baked.ok_or(BuildError::Cancelled)?;
        *self = Self::Volume(octree.into());
        Ok(vec![
            ("select", stages.select),
            ("fill", stages.fill),
            ("tree", stages.tree),
        ])
    }

    async fn build_bricks(
        &mut self,
        site: &BuildContext<'_>,
        layout: BrickLayout,
        budget: Option<u64>,
    ) -> Result<StageTimings, BuildError> {
        let control = &site.engine.control;
        let (bricks, stages) = Bricks::bake_with_control(site.program, layout, budget, control)?;
        *self = Self::Volume(bricks.into());
        Ok(vec![
            ("prune", stages.prune),
            ("fill", stages.fill),
            ("release", stages.release),
        ])
    }

    async fn build_mesh(
        &mut self,
        _: &BuildContext<'_>,
        _: VoxelGrid,
        _: bool,
    ) -> Result<Option<StageTimings>, BuildError> {
        Ok(None)
    }

    async fn store_volume(&mut self, volume: Volume) -> Result<(), BuildError> {
        *self = Self::Volume(volume);
        Ok(())
    }

    async fn edit(
        &mut self,
        live: &IncrementalProgram,
        edits: &mut dyn PendingEdits,
        work: EditWork<'_>,
    ) -> Result<EditStats, BuildError> {
        let Some(volume) = self.as_volume_mut() else {
            return Ok(EditStats::default());
        };
        let until = work
            .within
            .map(|within| work.start + within.mul_f64(SAMPLED_SHARE));
        Ok(volume.edit(live, edits, work.memory_budget, until)?)
    }

    async fn flush(&mut self) -> Result<EditStats, BuildError> {
        Ok(EditStats::default())
    }

    async fn shrink_to_fit(&mut self) -> Result<(), BuildError> {
        Ok(())
    }
}
