//! Worlds on a GPU.

use super::cpu::triangles;
use super::interface::{Device, EditWork, PathRequest, RenderRequest, StageTimings};
use crate::build_context::BuildContext;
use crate::field_mesh::{Stages, layout_of};
use crate::memory::{budget_on, without_budget};
use crate::still_error::StillError;
use crate::{BuildError, MeshCounts, MeshError, MeshOptions, RenderError};
use argil_field::{IncrementalProgram, Program};
use argil_gpu::{Gpu, GpuError, GpuMesh, GpuProgram, GpuVolume};
use argil_gpu::{ImageOutput, PathWork, SurfaceOptions};
use argil_mesh::marching::surface::SurfaceError;
use argil_mesh::{Mesh, MeshNormals};
use argil_render::{NormalSource, PathTables, RenderMode, RenderOutput, RenderSettings, Still};
use argil_volume::{
    BrickLayout, BrickOrdering, BrickTest, DenseFill, EditStats, Encoding, Levels, OctreeLayout,
    PendingEdits, Volume, VolumeInfo, VoxelGrid,
};
use glam::Vec3;
use std::borrow::Cow;
use std::sync::Arc;

/// What a world stores on a GPU besides its program.
#[derive(Debug)]
pub(crate) enum GpuStorage {
    Field,
    Volume(GpuVolume),
    Mesh {
        mesh: GpuMesh,
        voxel_grid: VoxelGrid,
    },
}

/// A GPU with a world's program, and what it stores.
#[derive(Debug)]
pub(crate) struct GpuDevice {
    pub(crate) program: GpuProgram,
    pub(crate) storage: GpuStorage,
}

impl GpuDevice {
    pub(super) fn new(gpu: &Arc<Gpu>, program: &Program) -> Result<Self, GpuError> {
        Ok(Self {
            program: GpuProgram::new(gpu.clone(), program, false)?,
            storage: GpuStorage::Field,
        })
    }

    fn gpu(&self) -> &Gpu {
        self.program.gpu()
    }

    fn volume(&self) -> Option<&GpuVolume> {
        match &self.storage {
            GpuStorage::Volume(volume) => Some(volume),
            _ => None,
        }
    }

    fn volume_mut(&mut self) -> Option<&mut GpuVolume> {
        match &mut self.storage {
            GpuStorage::Volume(volume) => Some(volume),
            _ => None,
        }
    }

    /// Uploads what a frame needs: the instructions of the program, if the frame evaluates it, and the levels that light reads.
    /// After edits, the program is put together only then.
    pub(crate) fn prepare<'a>(
        &self,
        settings: &RenderSettings,
        program: impl FnOnce() -> &'a Program,
        light: Option<&Arc<Levels>>,
    ) -> Result<(), GpuError> {
        let is_lit = settings.mode == RenderMode::Shaded;
        let is_stored = !matches!(self.storage, GpuStorage::Field);
        if !is_stored || is_lit || settings.normals == NormalSource::Field {
            self.program.upload_instructions(program);
        }
        // What does not fit on the device is not read.
        if is_lit
            && let Some(volume) = self.volume()
            && volume.set_light(self.gpu(), light).is_err()
        {
            volume.set_light(self.gpu(), None)?;
        }
        Ok(())
    }

    /// Renders an image, which comes to the CPU or goes into textures. Returns it, and the time in milliseconds.
    pub(crate) async fn render_to(
        &self,
        request: &RenderRequest<'_>,
        output: ImageOutput<'_>,
    ) -> Result<(RenderOutput, f64), RenderError> {
        let (program, frames) = (&self.program, request.frames);
        let light = request.light.as_ref();
        self.prepare(request.settings, request.program, light)?;
        Ok(match &self.storage {
            GpuStorage::Field => program.render(frames, output).await?,
            GpuStorage::Volume(volume) => volume.render(program, frames, output).await?,
            GpuStorage::Mesh { mesh, .. } => mesh.render(program, frames, output).await?,
        })
    }

    /// Bakes bricks of the field, extracts triangles, and moves their vertices to where the exact distance is 0.
    async fn march_field(
        &self,
        site: &BuildContext<'_>,
        voxel_grid: VoxelGrid,
        normals: MeshNormals,
        is_unindexed: bool,
    ) -> Result<(GpuMesh, StageTimings), BuildError> {
        let layout = layout_of(voxel_grid)?;
        let budget = budget_on(site.engine, None);
        let control = &site.engine.control;
        let bricks =
            GpuVolume::bricks_with_control(&self.program, site.program, layout, budget, control);
        let bricks = bricks.await.map_err(|e| without_budget(e.into(), None));
        let (bricks, mut stages) = bricks?;
        let options = SurfaceOptions {
            iso: 0.0,
            normals,
            project_to_field: true,
            is_unindexed,
        };
        let (mesh, of_mesh) = bricks.march(&self.program, &options).await?;
        stages.extend(of_mesh);
        Ok((mesh, stages))
    }

    /// Downloads a mesh. Drops its normals if all are zero.
    async fn download(&self, mesh: &GpuMesh, stages: &mut Stages) -> Result<Mesh, MeshError> {
        stages.restart();
        let mut mesh = mesh.download(self.gpu()).await.map_err(BuildError::from)?;
        if mesh.normals.iter().all(|&n| n == Vec3::ZERO) {
            mesh.normals = Vec::new();
        }
        stages.done("bring back")?;
        Ok(mesh)
    }
}

impl Device for GpuDevice {
    fn is_specialized(&self) -> bool {
        self.program.is_specialized()
    }

    fn program_bytes(&self) -> u64 {
        self.program.memory_bytes()
    }

    fn stored_bytes(&self) -> Option<u64> {
        match &self.storage {
            GpuStorage::Field => None,
            GpuStorage::Volume(volume) => Some(volume.memory_bytes()),
            GpuStorage::Mesh { mesh, .. } => Some(mesh.memory_bytes()),
        }
    }

    fn light_bytes(&self) -> u64 {
        self.volume().map_or(0, GpuVolume::light_memory_bytes)
    }

    fn has_volume(&self) -> bool {
        self.volume().is_some()
    }

    fn has_paths(&self) -> bool {
        match &self.storage {
            GpuStorage::Field => true,
            GpuStorage::Volume(volume) => volume.has_paths(),
            GpuStorage::Mesh { .. } => false,
        }
    }

    fn voxel_grid(&self) -> Option<VoxelGrid> {
        match &self.storage {
            GpuStorage::Field => None,
            GpuStorage::Volume(volume) => Some(*volume.voxel_grid()),
            GpuStorage::Mesh { voxel_grid, .. } => Some(*voxel_grid),
        }
    }

    fn brick_layout(&self) -> Option<BrickLayout> {
        self.volume()?.brick_layout()
    }

    fn levels(&self) -> Option<&Levels> {
        self.volume()?.levels()
    }

    fn mesh_counts(&self) -> Option<MeshCounts> {
        let GpuStorage::Mesh { mesh, .. } = &self.storage else {
            return None;
        };
        let [triangles, vertices] = mesh.counts();
        Some(MeshCounts {
            triangles,
            vertices,
        })
    }

    fn edits(&self) -> Option<Box<dyn PendingEdits>> {
        self.volume()?.edits()
    }

    fn has_lost_edits(&self) -> bool {
        self.volume().is_some_and(GpuVolume::has_lost_edits)
    }

    fn set_program(&mut self, program: &Program) -> Result<(), BuildError> {
        if self.is_specialized() {
            return self.specialize(program);
        }
        Ok(self.program.update(program)?)
    }

    fn follow_program(&mut self, live: &IncrementalProgram) -> Result<(), BuildError> {
        Ok(self.program.update_from(live)?)
    }

    fn specialize(&mut self, program: &Program) -> Result<(), BuildError> {
        self.program = GpuProgram::new(self.program.gpu().clone(), program, true)?;
        Ok(())
    }

    fn clear(&mut self) {
        self.storage = GpuStorage::Field;
    }

    fn store_mesh(&mut self, mesh: Mesh, voxel_grid: VoxelGrid) -> Result<(), BuildError> {
        let mesh = GpuMesh::upload(&self.program, triangles(&mesh))?;
        self.storage = GpuStorage::Mesh { mesh, voxel_grid };
        Ok(())
    }

    fn levels_mut(&mut self) -> Option<&mut Levels> {
        self.volume_mut()?.levels_mut()
    }

    fn follow_levels(&mut self) -> Result<(), RenderError> {
        if let GpuStorage::Volume(volume) = &mut self.storage {
            volume.follow_levels(self.program.gpu())?;
        }
        Ok(())
    }

    fn grow(&mut self, edits: &dyn PendingEdits) {
        if let Some(volume) = self.volume_mut() {
            volume.grow(edits);
        }
    }

    async fn info(&self) -> Result<Option<VolumeInfo>, BuildError> {
        match self.volume() {
            Some(volume) => Ok(Some(volume.info(self.gpu()).await?)),
            None => Ok(None),
        }
    }

    async fn volume(&self) -> Result<Option<Cow<'_, Volume>>, BuildError> {
        match self.volume() {
            Some(volume) => Ok(Some(Cow::Owned(volume.download(self.gpu()).await?))),
            None => Ok(None),
        }
    }

    async fn render(&self, request: RenderRequest<'_>) -> Result<(RenderOutput, f64), RenderError> {
        let output = if request.with_hits {
            ImageOutput::CpuWithHits
        } else {
            ImageOutput::Cpu
        };
        self.render_to(&request, output).await
    }

    async fn trace_paths(
        &self,
        request: PathRequest<'_>,
        still: &mut Still,
    ) -> Result<(), StillError> {
        let program = request.program;
        self.program.upload_instructions(|| program);
        let mut tables = PathTables::new(request.view, request.options);
        let voxel = self.voxel_grid().map(|grid| grid.voxel_size);
        let uniform = &mut tables.uniform;
        uniform.epsilon = request.epsilon;
        uniform.lift = request.lift;
        uniform.least_step = 0.5 * voxel.unwrap_or(0.0);
        uniform.normal_step = voxel.map_or(16.0 * uniform.epsilon, |voxel| 0.5 * voxel);
        uniform.is_stored = u32::from(!program.has_glass() && !program.has_textures());
        let work = PathWork {
            frame: request.frame,
            tables: &tables,
            program,
            options: request.options,
            control: request.control,
        };
        match self.volume() {
            Some(volume) => volume.trace_paths(&self.program, work, still).await?,
            None => self.program.trace_paths(work, still).await?,
        }
        Ok(())
    }

    async fn volume_mesh(
        &self,
        options: &MeshOptions,
        stages: &mut Stages,
    ) -> Result<Option<Mesh>, MeshError> {
        let Some(volume) = self.volume() else {
            return Ok(None);
        };
        let iso = options.iso;
        SurfaceError::check_band(iso, volume.encoding().band_width(volume.voxel_grid(), 0))?;
        let options = SurfaceOptions {
            iso,
            normals: match options.normals {
                MeshNormals::Gradient => MeshNormals::Gradient,
                // The CPU computes exact normals later, as for volumes on the CPU.
                _ => MeshNormals::None,
            },
            ..SurfaceOptions::default()
        };
        let marched = volume.march(&self.program, &options).await;
        let (mesh, timings) = marched.map_err(|error| match error {
            GpuError::NotMeshable => SurfaceError::Octree.into(),
            GpuError::UnsupportedIsoLevel => SurfaceError::Iso.into(),
            error => MeshError::from(BuildError::from(error)),
        })?;
        stages.all.extend(timings);
        Ok(Some(self.download(&mesh, stages).await?))
    }

    async fn field_mesh(
        &self,
        site: &BuildContext<'_>,
        voxel_grid: VoxelGrid,
        normals: MeshNormals,
        stages: &mut Stages,
    ) -> Result<Option<Mesh>, MeshError> {
        self.program.upload_instructions(|| site.program);
        let marched = self.march_field(site, voxel_grid, normals, false);
        let (mesh, timings) = marched.await?;
        stages.all.extend(timings);
        Ok(Some(self.download(&mesh, stages).await?))
    }

    async fn build_dense(
        &mut self,
        site: &BuildContext<'_>,
        voxel_grid: VoxelGrid,
        encoding: Encoding,
        mips: bool,
        fill: DenseFill,
    ) -> Result<StageTimings, BuildError> {
        let (field, program) = (&self.program, site.program);
        let built = GpuVolume::dense(field, program, voxel_grid, encoding, mips, fill);
        let (volume, stages) = built.await?;
        self.storage = GpuStorage::Volume(volume);
        Ok(stages)
    }

    async fn build_octree(
        &mut self,
        site: &BuildContext<'_>,
        layout: OctreeLayout,
        brick_test: BrickTest,
        order: BrickOrdering,
    ) -> Result<StageTimings, BuildError> {
        let (field, program) = (&self.program, site.program);
        let built = GpuVolume::octree(field, program, layout, brick_test, order);
        let (volume, stages) = built.await?;
        self.storage = GpuStorage::Volume(volume);
        Ok(stages)
    }

    async fn build_bricks(
        &mut self,
        site: &BuildContext<'_>,
        layout: BrickLayout,
        budget: Option<u64>,
    ) -> Result<StageTimings, BuildError> {
        let (field, program) = (&self.program, site.program);
        let control = &site.engine.control;
        let built = GpuVolume::bricks_with_control(field, program, layout, budget, control);
        let (volume, stages) = built.await?;
        self.storage = GpuStorage::Volume(volume);
        Ok(stages)
    }

    async fn build_mesh(
        &mut self,
        site: &BuildContext<'_>,
        voxel_grid: VoxelGrid,
        flat: bool,
    ) -> Result<Option<StageTimings>, BuildError> {
        let normals = if flat {
            MeshNormals::Face
        } else {
            MeshNormals::Field
        };
        let marched = self.march_field(site, voxel_grid, normals, flat);
        let (mesh, stages) = marched.await?;
        self.storage = GpuStorage::Mesh { mesh, voxel_grid };
        Ok(Some(stages))
    }

    async fn store_volume(&mut self, volume: Volume) -> Result<(), BuildError> {
        let volume = GpuVolume::upload(&self.program, &volume).await?;
        self.storage = GpuStorage::Volume(volume);
        Ok(())
    }

    async fn edit(
        &mut self,
        live: &IncrementalProgram,
        edits: &mut dyn PendingEdits,
        work: EditWork<'_>,
    ) -> Result<EditStats, BuildError> {
        if let GpuStorage::Volume(volume) = &mut self.storage {
            let within = work
                .within
                .map(|limit| limit.saturating_sub(work.start.elapsed()));
            let submission = (within, work.encoder);
            let budget = work.memory_budget;
            let edited = volume.edit(&self.program, live, edits, budget, submission);
            edited.await?;
        }
        Ok(EditStats::default())
    }

    async fn flush(&mut self) -> Result<EditStats, BuildError> {
        match &mut self.storage {
            GpuStorage::Volume(volume) => Ok(volume.flush(self.program.gpu()).await?),
            _ => Ok(EditStats::default()),
        }
    }

    async fn shrink_to_fit(&mut self) -> Result<(), BuildError> {
        if let GpuStorage::Volume(volume) = &mut self.storage {
            volume.shrink_to_fit(&self.program).await?;
        }
        Ok(())
    }
}
