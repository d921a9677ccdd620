//! Methods that block until their asynchronous twin, which has the same name with `_async`, has finished. A web
//! page has no such methods, because its only thread must not wait.

use crate::mesh_error::MeshError;
use crate::mesh_options::MeshOptions;
use crate::meshing::MeshOutput;
use crate::{
    Backend, BricksOptions, Build, BuildError, DenseOptions, Engine, EngineError, OctreeOptions,
    RenderError, RenderedImage, Representation, StillError, VolumeFileError, World,
};
use crate::{EditBudget, EditReport};
use argil_math::Aabb;
use argil_render::{Camera, LiveImage, RenderMode, RenderSettings, Still, StillOptions};
use argil_scene::Scene;
use argil_volume::{EditStats, FillStats};
use argil_volume::{Volume, VolumeFile, VolumeInfo};
use pollster::block_on as wait;
use std::borrow::Cow;
use std::path::Path;

/// Declares methods that wait for their asynchronous twins.
macro_rules! blocking {
    () => {};
    (
        $(#[$meta:meta])*
        fn $name:ident = $twin:ident(&self $(, $arg:ident: $type:ty)*) -> $result:ty;
        $($rest:tt)*
    ) => {
        $(#[$meta])*
        pub fn $name(&self $(, $arg: $type)*) -> $result {
            wait(self.$twin($($arg),*))
        }
        blocking! { $($rest)* }
    };
    (
        $(#[$meta:meta])*
        fn $name:ident = $twin:ident(&mut self $(, $arg:ident: $type:ty)*) -> $result:ty;
        $($rest:tt)*
    ) => {
        $(#[$meta])*
        pub fn $name(&mut self $(, $arg: $type)*) -> $result {
            wait(self.$twin($($arg),*))
        }
        blocking! { $($rest)* }
    };
    (
        $(#[$meta:meta])*
        fn $name:ident = $twin:ident(self $(, $arg:ident: $type:ty)*) -> $result:ty;
        $($rest:tt)*
    ) => {
        $(#[$meta])*
        pub fn $name(self $(, $arg: $type)*) -> $result {
            wait(self.$twin($($arg),*))
        }
        blocking! { $($rest)* }
    };
}

impl Engine {
    /// Creates an engine on a hardware GPU if there is one, and on the CPU otherwise.
    ///
    /// # Errors
    /// If there is a GPU that does not open.
    pub fn auto() -> Result<Self, EngineError> {
        Self::with_backend(Backend::Auto)
    }

    /// Creates an engine on a given back end.
    ///
    /// # Errors
    /// If `backend` requires a GPU and there is none, or it does not open.
    pub fn with_backend(backend: Backend) -> Result<Self, EngineError> {
        wait(Self::with_backend_async(backend))
    }

    /// Lists the graphics devices of this machine, the best one first. The CPU is always available too.
    #[cfg(feature = "gpu")]
    pub fn devices() -> Vec<argil_gpu::DeviceInfo> {
        wait(Self::devices_async())
    }

    /// Creates a world from a volume file, without building it again. `path` appears in messages, and its folder is
    /// searched for the scene's meshes.
    ///
    /// # Errors
    /// If the file's contents are inconsistent, a mesh cannot be loaded, or the device does not accept the volume.
    pub fn load(
        &self,
        stored: VolumeFile,
        path: impl AsRef<Path>,
    ) -> Result<(Scene, World), VolumeFileError> {
        wait(self.load_async(stored, path, false))
    }

    /// Creates a world from a volume file, and also loads meshes from outside the file's folder: see
    /// [`Engine::load`].
    ///
    /// # Errors
    /// If the file's contents are inconsistent, a mesh cannot be loaded, or the device does not accept the volume.
    pub fn load_with_external_meshes(
        &self,
        stored: VolumeFile,
        path: impl AsRef<Path>,
    ) -> Result<(Scene, World), VolumeFileError> {
        wait(self.load_async(stored, path, true))
    }
}

impl Build<'_> {
    /// Builds a world of sparse bricks. A number sets the voxels along the longest side.
    ///
    /// # Errors
    /// If an option is out of range, or the bricks exceed the memory budget or the device's limits.
    pub fn bricks(self, options: impl Into<BricksOptions>) -> Result<World, BuildError> {
        self.with_representation(options.into())
    }

    /// Builds a world that stores one dense volume. A number sets the voxels along the longest side.
    ///
    /// # Errors
    /// If an option is out of range, or the volume exceeds the free memory or the device's limits.
    pub fn dense(self, options: impl Into<DenseOptions>) -> Result<World, BuildError> {
        self.with_representation(options.into())
    }

    /// Builds a world that stores an octree of bricks. A number sets the voxels along the longest side.
    ///
    /// # Errors
    /// If an option is out of range, or the octree exceeds the free memory or the device's limits.
    pub fn octree(self, options: impl Into<OctreeOptions>) -> Result<World, BuildError> {
        self.with_representation(options.into())
    }

    /// Builds a world with a representation chosen at run time.
    ///
    /// # Errors
    /// If an option is out of range, or the result exceeds the memory budget or the device's limits.
    pub fn with_representation(
        self,
        representation: impl Into<Representation>,
    ) -> Result<World, BuildError> {
        wait(self.with_representation_async(representation))
    }
}

impl World {
    blocking! {
        /// Builds this world again with another representation, or from another scene, on the same device and with the
        /// same shaders.
        ///
        /// # Errors
        /// If the scene cannot be compiled, an option is out of range, or the result exceeds the memory budget or the
        /// device's limits.
        fn rebuilt_as = rebuilt_as_async(self, scene: &Scene, representation: Representation)
            -> Result<Self, BuildError>;

        /// Describes the volume. Returns `None` for a world without one.
        ///
        /// # Errors
        /// If the device fails.
        fn volume_info = volume_info_async(&self) -> Result<Option<VolumeInfo>, BuildError>;

        /// Updates the world after its scene was edited.
        /// Sparse bricks and levels change in place, at the cost of what the edits touch. `scene` must be the scene that the
        /// world was built from. The result equals a fresh build. Other representations are rebuilt with voxels of the same
        /// size. So is everything if an edit changes what all of it relies on: [`EditReport::reason`] tells which.
        /// On a GPU the call submits work and does not wait for it. It compiles nothing, unless the world is
        /// specialized or a software device lacks an opcode.
        ///
        /// # Errors
        /// If the scene cannot be compiled, or the result exceeds the memory budget. A later call with a
        /// valid scene can succeed.
        fn apply = apply_async(&mut self, scene: &Scene) -> Result<EditReport, BuildError>;

        /// Updates the world as [`World::apply`] does, within a time budget. Blocks near [`EditBudget::priority_point`]
        /// come first. Later calls, or [`World::flush`], process the remaining ones. Until then, [`World::query`] sees the
        /// new scene. [`World::query_volume`] and pictures see each cell in its old or its new state.
        ///
        /// The budget is checked before each brick. Of two calls, at least one samples a brick. What cannot change in place is built again
        /// on another thread, beside this world, which has its old shapes until then ([`World::is_rebuilding`]). A later call takes
        /// the new world over, and applies what was edited since. Both worlds are in memory until then. A page has no threads, so there a rebuild
        /// exceeds the budget.
        ///
        /// # Errors
        /// If the scene cannot be compiled, or the result exceeds the memory budget. If that is found on the other thread, a later call
        /// returns it, and the call after that builds again.
        fn apply_within = apply_within_async(&mut self, scene: &Scene, budget: EditBudget)
            -> Result<EditReport, BuildError>;

        /// Updates the world after its scene was edited, as [`World::apply`] does, with commands in the encoder of a host.
        ///
        /// Edits of bricks are encoded: nothing is submitted, waited for or read back, and once the edits of a few frames were
        /// submitted, nothing is created, unless the world grows. Levels are written before the submission. Other representations
        /// are built again, which submits and waits, as do bricks where [`EditReport::reason`] says so.
        ///
        /// Encode edits before the frames that show them, and submit encoders in the order in which they were written to. A frame that was
        /// encoded before the edits of its submission may be wrong where they are. If an encoder with edits is dropped, the next
        /// update builds the world again.
        ///
        /// ```no_run
        /// use argil::gpu::{HostFrame, wgpu};
        /// use argil::prelude::*;
        /// # fn draw(world: &mut World, scene: &mut Scene, frame: &mut HostFrame, settings: &RenderSettings,
        /// #         view: [[f32; 4]; 4], device: &wgpu::Device, queue: &wgpu::Queue)
        /// # -> Result<(), Box<dyn std::error::Error>> {
        /// scene.push(Shape::sphere(0.2).at([0.5, 0.0, 0.0]).subtract())?;
        /// let mut encoder = device.create_command_encoder(&Default::default());
        /// world.encode_edits(&scene, &mut encoder)?;
        /// world.encode_frame(frame, view, settings, &mut encoder)?;
        /// // The host's render pass, with `frame.composite(&mut pass)`, and then:
        /// queue.submit([encoder.finish()]);
        /// # Ok(())
        /// # }
        /// ```
        ///
        /// # Errors
        /// If the world is on the CPU, the scene cannot be compiled, the result exceeds the memory budget, or the device fails.
        #[cfg(feature = "gpu")]
        fn encode_edits = encode_edits_async(&mut self, scene: &Scene, encoder: &mut argil_gpu::wgpu::CommandEncoder)
            -> Result<EditReport, BuildError>;

        /// Processes the remaining blocks of earlier edits and waits for the device. Returns what all edits did since
        /// the last call. A rebuild counts all bricks as filled.
        ///
        /// # Errors
        /// If the result exceeds the memory budget, or the device fails.
        fn flush = flush_async(&mut self) -> Result<EditStats, BuildError>;

        /// Renders an image with a camera and settings. [`World::render_settings`] returns settings that suit the
        /// scene.
        ///
        /// # Errors
        /// If a setting is out of range, the mode needs bricks that the world does not have, or the device fails.
        fn render = render_async(&self, camera: &Camera, settings: &RenderSettings)
            -> Result<RenderedImage, RenderError>;

        /// Renders an image into textures of the world's GPU: no pixel comes to the CPU.
        ///
        /// ```no_run
        /// use argil::gpu::{Gpu, ImageTextures, wgpu};
        /// use argil::prelude::*;
        /// # fn draw(device: wgpu::Device, queue: wgpu::Queue, scene: &Scene) -> Result<(), Box<dyn std::error::Error>> {
        /// let textures = ImageTextures::new(&device, [1280, 720])?;
        /// let engine = Engine::on_gpu(Gpu::from_wgpu(device, queue)?);
        /// let world = engine.build(scene)?.bricks(256)?;
        /// let settings = world.render_settings(textures.size(), RenderMode::Shaded);
        /// let report = world.render_into(&world.camera(), &settings, &textures)?;
        /// println!("{:.1} ms", report.duration_ms);
        /// # Ok(())
        /// # }
        /// ```
        ///
        /// # Errors
        /// If the world is on the CPU, the textures have another size than the image, a setting is out of range, the mode needs bricks
        /// that the world does not have, or the device fails.
        #[cfg(feature = "gpu")]
        fn render_into = render_into_async(&self, camera: &Camera, settings: &RenderSettings, textures: &argil_gpu::ImageTextures)
            -> Result<crate::RenderReport, RenderError>;

        /// Makes a still by path tracing: the field's or the volume's surfaces, lit by the view's lights, its environment, and materials
        /// that emit light, directly and by way of each other, through its fog and its lens. Work that is canceled returns what is
        /// there.
        ///
        /// Of the settings, the size and the ground count, and the sun's direction, if the view has no lights.
        ///
        /// Textures are those of the field at each point, also where a volume stores coarser colors.
        ///
        /// # Errors
        /// If a setting is out of range, paths cannot pass through the representation, or the device fails.
        ///
        /// ```
        /// use argil::prelude::*;
        /// use argil::render::{Development, StillOptions, developed};
        /// let mut scene = Scene::new();
        /// scene.push(Shape::sphere(0.5))?;
        /// let world = Engine::cpu().build(&scene)?.bricks(64)?;
        /// let settings = world.render_settings([32, 18], RenderMode::Shaded);
        /// let options = StillOptions { samples: 4, ..StillOptions::default() };
        /// let still = world.still(&world.camera(), &settings, &options)?;
        /// assert_eq!(developed(&still.radiance(), 32, &Development::default()).len(), 3 * 32 * 18);
        /// # Ok::<(), Box<dyn std::error::Error>>(())
        /// ```
        fn still = still_async(&self, camera: &Camera, settings: &RenderSettings, options: &StillOptions)
            -> Result<Still, StillError>;

        /// Adds paths to a still, with the same arguments as before: see [`World::still`]. Of the options, `samples` is how many are added.
        ///
        /// # Errors
        /// If a setting is out of range, the still has another size, paths cannot pass through the representation, or the device
        /// fails.
        fn refine_still = refine_still_async(&self, still: &mut Still, camera: &Camera, settings: &RenderSettings, options: &StillOptions)
            -> Result<(), StillError>;

        /// Draws an image that is kept, after edits. Only the parts that something in `dirty_box` can affect are drawn again:
        /// see [`EditReport::dirty_box`](crate::EditReport). The first image, one of another view, and one of more than four
        /// samples are drawn whole. Returns the number of pixels drawn.
        ///
        /// For worlds of sparse bricks on the CPU. The others draw the whole image.
        ///
        /// ```
        /// use argil::{math::Aabb, prelude::*};
        /// let mut scene = Scene::new();
        /// scene.push(Shape::sphere(1.0))?;
        /// let mut world = Engine::cpu().build(&scene)?.bricks(64)?;
        /// let camera = world.camera();
        /// let settings = world.render_settings([320, 240], RenderMode::Shaded);
        /// let mut image = LiveImage::default();
        /// world.redraw(&mut image, &camera, &settings, Aabb::ALL)?;
        /// scene.push(Shape::sphere(0.1).at([0.6, 0.6, 0.6]))?;
        /// let report = world.apply(&scene)?;
        /// let pixels = world.redraw(&mut image, &camera, &settings, report.dirty_box)?;
        /// assert!(pixels < 320 * 240);
        /// # Ok::<(), Box<dyn std::error::Error>>(())
        /// ```
        ///
        /// # Errors
        /// If a setting is out of range, the mode needs bricks that the world does not have, or the device fails.
        fn redraw = redraw_async(&self, image: &mut LiveImage, camera: &Camera, settings: &RenderSettings, dirty_box: Aabb)
            -> Result<usize, RenderError>;

        /// Asks for the bricks that a view will need, without baking them: [`World::fill_pages`] does. Call it with a camera
        /// ahead of the motion. It traces one ray for 64 pixels. Does nothing for a representation other than levels.
        ///
        /// # Errors
        /// If a setting is out of range, or the work was canceled.
        fn prefetch = prefetch_async(&mut self, camera: &Camera, settings: &RenderSettings)
            -> Result<(), RenderError>;

        /// Renders and bakes until all bricks that the view needs are resident, or the budget is full. Does nothing for a
        /// representation other than levels.
        ///
        /// # Errors
        /// If a setting is out of range, or the work was canceled.
        fn refine = refine_async(&mut self, camera: &Camera, settings: &RenderSettings)
            -> Result<FillStats, RenderError>;

        /// Returns the volume, downloaded from the GPU if it is there, or `None` for a world without one.
        ///
        /// # Errors
        /// If the device fails.
        fn volume = volume_async(&self) -> Result<Option<Cow<'_, Volume>>, BuildError>;

        /// Compiles shaders for this scene, instead of interpreting it. Has no effect on the CPU, which always
        /// interprets.
        ///
        /// # Errors
        /// If the device does not accept the shaders.
        fn specialize = specialize_async(&mut self) -> Result<(), BuildError>;

        /// Frees the memory that edits left unused on a GPU, and waits for it. Does nothing on the CPU, which leaves
        /// none.
        ///
        /// # Errors
        /// If the device fails.
        fn shrink_to_fit = shrink_to_fit_async(&mut self) -> Result<(), BuildError>;

        /// Counts the cells in which sparse bricks differ from a fresh bake of the same scene with the same voxels, on
        /// the same device. Compares which cells have bricks, the samples, and the materials. Returns `None` unless the
        /// world stores bricks. This is a check for tests.
        ///
        /// # Errors
        /// If the scene cannot be baked.
        fn diff_from_rebuild = diff_from_rebuild_async(&self) -> Result<Option<u64>, BuildError>;

        /// Extracts the surface as triangles.
        /// For the field, it bakes sparse bricks, runs marching cubes, and moves the vertices to where the exact
        /// distance is 0. For bricks and dense volumes, it meshes the stored samples. On a GPU it runs there, and only
        /// triangles are downloaded.
        ///
        /// # Errors
        /// If the representation cannot be meshed, an option is out of range, or the mesh would be too large.
        fn mesh = mesh_async(&self, options: &MeshOptions) -> Result<MeshOutput, MeshError>;

        /// Writes the volume and its [scene](World::scene) to a file, atomically. The scene is the one that was applied
        /// last, without its undo history. After [`World::apply_within`], call [`World::flush`] first.
        ///
        /// # Errors
        /// If the world has no volume, blocks of an edit remain, or the file cannot be written.
        fn save = save_async(&self, path: impl AsRef<Path>) -> Result<(), VolumeFileError>;

        /// Writes the contents of [`World::save`] to a stream.
        ///
        /// # Errors
        /// If the world has no volume, blocks of an edit remain, or `out` fails.
        fn write = write_async(&self, out: &mut (impl std::io::Write + ?Sized)) -> std::io::Result<()>;
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

    /// Returns the length of each pixel's ray until it hits a solid, in the scene's unit, row by row from the top.
    /// A ray that hits nothing has length infinity. With several samples per pixel, it is the first sample's ray.
    ///
    /// # Errors
    /// If a setting is out of range, the mode needs bricks that the world does not have, or the device fails.
    pub fn ray_distances(
        &self,
        camera: &Camera,
        settings: &RenderSettings,
    ) -> Result<Vec<f32>, RenderError> {
        let (_, lengths) = wait(self.render_with_distances_async(camera, settings))?;
        Ok(lengths)
    }
}
