//! What waits in place for futures: each method here is the one of the same name with `_async`, waited for. On a page, where nothing can
//! be waited for in place, there are only those.

use crate::meshing::{MeshError, MeshOptions, MeshOutput};
use crate::{
    Backend, BricksOptions, Build, BuildError, DenseOptions, Engine, EngineError, OctreeOptions,
    RenderError, RenderedImage, Representation, VolumeFileError, World,
};
use crate::{EditBudget, EditReport};
use argil_gpu::DeviceInfo;
use argil_render::{Camera, RenderMode, RenderSettings};
use argil_scene::Scene;
use argil_volume::EditStats;
use argil_volume::{Volume, VolumeFile, VolumeInfo};
use pollster::block_on as wait;
use std::borrow::Cow;
use std::path::Path;

impl Engine {
    /// A GPU where there is a real one, else the CPU.
    ///
    /// # Errors
    /// Only if a GPU is there but refuses to open.
    pub fn auto() -> Result<Self, EngineError> {
        Self::with_backend(Backend::Auto)
    }

    /// The given back end, or why it is not there.
    ///
    /// # Errors
    /// If `backend` asks for a GPU and there is none, or it refuses to open.
    pub fn with_backend(backend: Backend) -> Result<Self, EngineError> {
        wait(Self::with_backend_async(backend))
    }

    /// The graphics devices of this machine, the best first; the CPU path is always there besides.
    pub fn devices() -> Vec<DeviceInfo> {
        wait(Self::devices_async())
    }

    /// A world of what a volume file holds, drawn from there. `path` stands in messages.
    ///
    /// # Errors
    /// If what it holds makes no sense, or a device does not take it.
    pub fn load(
        &self,
        stored: VolumeFile,
        path: impl AsRef<Path>,
    ) -> Result<(Scene, World), VolumeFileError> {
        wait(self.load_async(stored, path, false))
    }

    /// The same, where the scene's meshes may be anywhere.
    ///
    /// # Errors
    /// As [`Engine::load`].
    pub fn load_with_external_meshes(
        &self,
        stored: VolumeFile,
        path: impl AsRef<Path>,
    ) -> Result<(Scene, World), VolumeFileError> {
        wait(self.load_async(stored, path, true))
    }
}

impl Build<'_> {
    /// Kept as sparse bricks, of options or of so many voxels along the longest side.
    ///
    /// # Errors
    /// If the options make no sense, or what they ask for takes too much.
    pub fn bricks(self, options: impl Into<BricksOptions>) -> Result<World, BuildError> {
        self.with_representation(options.into())
    }

    /// Kept as a dense volume, of options or of so many voxels along the longest side.
    ///
    /// # Errors
    /// As [`Build::bricks`].
    pub fn dense(self, options: impl Into<DenseOptions>) -> Result<World, BuildError> {
        self.with_representation(options.into())
    }

    /// Kept as an octree of bricks, of options or of so many voxels along the longest side.
    ///
    /// # Errors
    /// As [`Build::bricks`].
    pub fn octree(self, options: impl Into<OctreeOptions>) -> Result<World, BuildError> {
        self.with_representation(options.into())
    }

    /// Kept in some way.
    ///
    /// # Errors
    /// As [`Build::bricks`].
    pub fn with_representation(self, via: impl Into<Representation>) -> Result<World, BuildError> {
        wait(self.with_representation_async(via))
    }
}

impl World {
    /// The same world, made anew of a scene and kept in some way, on the same device and by the same shaders.
    ///
    /// # Errors
    /// As [`Build::bricks`](crate::Build::bricks).
    pub fn rebuilt_as(self, scene: &Scene, via: Representation) -> Result<Self, BuildError> {
        wait(self.rebuilt_as_async(scene, via))
    }

    /// What the volume is; `None` of a field.
    ///
    /// # Errors
    /// If the device fails.
    pub fn volume_info(&self) -> Result<Option<VolumeInfo>, BuildError> {
        wait(self.volume_info_async())
    }

    /// Follow a scene that was edited. Sparse bricks are changed in place, at the cost of what the edits touch, if the scene
    /// is the one that the world was built from. Otherwise, and where an edit changes what all distances are relied on for, everything is made again, of voxels of the same size; the
    /// result is that of a fresh bake. On a GPU edits are submitted and not waited for, and nothing is compiled unless the world is
    /// specialized, or a software device lacks an opcode.
    ///
    /// # Errors
    /// If the scene cannot be built, or takes too much; the next scene that can be is followed all the same.
    pub fn apply(&mut self, scene: &Scene) -> Result<EditReport, BuildError> {
        wait(self.apply_async(scene))
    }

    /// The same at a pace: as much as there is time for, what is near to the eye first. What is left is told, and done by
    /// calls that follow, or by [`World::flush`]. A picture in between shows each cell as it was or as it will be.
    ///
    /// # Errors
    /// As [`World::apply`].
    pub fn apply_within(
        &mut self,
        scene: &Scene,
        pace: EditBudget,
    ) -> Result<EditReport, BuildError> {
        wait(self.apply_within_async(scene, pace))
    }

    /// Do what edits at a pace have left to be done, and wait for the device; what edits did since the last time, all bricks counted as
    /// filled where everything was made again.
    ///
    /// # Errors
    /// As [`World::apply`].
    pub fn flush(&mut self) -> Result<EditStats, BuildError> {
        wait(self.flush_async())
    }

    /// Renders the scene's own view, shaded: see [`World::camera`] and [`World::render_settings`]. `size` is in pixels.
    ///
    /// # Errors
    /// If the size is 0 or too large, or the device fails.
    pub fn render_view(&self, size: [u32; 2]) -> Result<RenderedImage, RenderError> {
        self.render(
            &self.camera(),
            &self.render_settings(size, RenderMode::Shaded),
        )
    }

    /// A picture by settings.
    ///
    /// # Errors
    /// If a setting is out of range, the mode needs bricks that the world does not have, or the device fails.
    pub fn render(
        &self,
        camera: &Camera,
        settings: &RenderSettings,
    ) -> Result<RenderedImage, RenderError> {
        wait(self.render_async(camera, settings))
    }

    /// How far the ray of each pixel goes until it hits a solid, row by row from the top, of the first sample where there are
    /// several; infinite where it hits none.
    ///
    /// # Errors
    /// See [`World::render`].
    pub fn ray_distances(
        &self,
        camera: &Camera,
        settings: &RenderSettings,
    ) -> Result<Vec<f32>, RenderError> {
        let (_, lengths) = wait(self.render_with_distances_async(camera, settings))?;
        Ok(lengths)
    }

    /// The volume, brought from the GPU where it is there; `None` of a field.
    ///
    /// # Errors
    /// If the device does not give it.
    pub fn volume(&self) -> Result<Option<Cow<'_, Volume>>, BuildError> {
        wait(self.volume_async())
    }

    /// Compile shaders for this very scene, in place of the interpreter. The CPU always interprets.
    ///
    /// # Errors
    /// If the device does not take them.
    pub fn specialize(&mut self) -> Result<(), BuildError> {
        wait(self.specialize_async())
    }

    /// Give back the room for bricks that edits have left on a GPU, after a wait. On the CPU none is left.
    ///
    /// # Errors
    /// If the device does not do it.
    pub fn shrink_to_fit(&mut self) -> Result<(), BuildError> {
        wait(self.shrink_to_fit_async())
    }

    /// In how many cells sparse bricks differ from those of a fresh bake on the same device with the same voxels, whose box is
    /// found anew: whether there is a
    /// brick, its samples, its materials. Nothing of a world that is kept in another way.
    ///
    /// # Errors
    /// If the scene cannot be baked.
    pub fn diff_from_rebuild(&self) -> Result<Option<u64>, BuildError> {
        wait(self.diff_from_rebuild_async())
    }

    /// The world's surface as triangles: of the field by marching cubes over sparse bricks that are made for it, its corners
    /// moved to where the exact distance is 0; of a dense volume or bricks of what they store. Where the world is on a GPU it
    /// is marched there, and triangles alone are brought back.
    ///
    /// # Errors
    /// If there is no mesh of what the world is kept as.
    pub fn mesh(&self, options: &MeshOptions) -> Result<MeshOutput, MeshError> {
        wait(self.mesh_async(options))
    }

    /// Write the volume with its [scene](World::scene) as it was applied last (its name, view and meshes too), beside its place and then
    /// renamed into it.
    ///
    /// # Errors
    /// If there is no volume, or the file cannot be written.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), VolumeFileError> {
        wait(self.save_async(path))
    }

    /// Write what [`World::save`] does, wherever it goes.
    ///
    /// # Errors
    /// If there is no volume, or `out` does not take it.
    pub fn write(&self, out: &mut (impl std::io::Write + ?Sized)) -> std::io::Result<()> {
        wait(self.write_async(out))
    }
}
