use crate::listeners::{Listener, Listeners};
use crate::live::{Applied, Editable, Followed, Live, Pace, Rebuilt};
use crate::lowered::Lowered;
use crate::representation::{
    Drawable, Kept, Site, Triangulated, focus, following, found_again, triangles,
};
use crate::wait::wait;
use crate::{
    BuildError, BuildTimes, Drawn, Engine, GridError, Placement, RenderError, Scene, Stored, Via,
    Volume, VolumeFileError, VolumeInfo,
};
use argil_abi::{HIT_INSIDE, HIT_OUTSIDE, Hit};
use argil_field::{Grid, ListTree, LiveProgram, OperandIndex, Program};
use argil_gpu::{GpuField, GpuVolume};
use argil_march::{Camera, Picture, Settings, Show, Through, frames};
use argil_math::{Aabb, Control, Interval};
use argil_volume::{BrickChanges, BrickEdit};
use std::borrow::Cow;
use std::path::Path;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering};
use web_time::Instant;

/// Longest side of a picture in pixels.
pub const MAX_SIDE: u32 = 16_384;

/// Most steps of a ray, unless it is asked for otherwise: through the field, and through a volume, where a step is short.
const FIELD_STEPS: u32 = 256;
const VOLUME_STEPS: u32 = 4096;

/// So few questions between two edits are no reason to make lists for them.
const SELDOM: u32 = 64;

/// Most pixels of a picture: it takes 76 bytes a pixel while it is drawn.
pub const MAX_PIXELS: u64 = 1 << 26;

/// A scene that an engine has built: its exact field on the engine's device and, once asked for, a volume of it.
///
/// ```
/// use argil::{Brush, DenseOptions, Engine, Scene, Shape};
/// let mut scene = Scene::new();
/// scene.push(Brush::new(Shape::sphere(0.5)))?;
/// let options = DenseOptions { resolution: 64, mips: true, ..Default::default() };
/// let world = Engine::cpu().build(&scene)?.dense(options)?;
/// assert_eq!(world.resolution(), Some([64, 64, 64]));
/// let picture = world.render(&world.camera(), [64, 48])?;
/// # assert!(picture.hit_pixels > 0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct World {
    engine: Engine,
    program: OnceLock<Lowered>,
    live: Live,
    /// Questions since the program was put together or an edit was followed.
    asked: AtomicU32,
    gpu: Option<GpuField>,
    listeners: Listeners,
    focus: Aabb,
    view: crate::View,
    via: Via,
    kept: Kept,
    times: BuildTimes,
}

impl World {
    pub(crate) fn new(engine: Engine, scene: &Scene) -> Result<Self, BuildError> {
        let program = Program::lower(scene)?;
        let gpu = match &engine.gpu {
            Some(gpu) => Some(GpuField::new(gpu.clone(), &program, false)?),
            None => None,
        };
        let focus = focus(scene, &program);
        Ok(Self {
            engine,
            program: OnceLock::from(Lowered::from(program)),
            live: Live::of(scene),
            asked: AtomicU32::new(0),
            gpu,
            listeners: Listeners::default(),
            focus,
            view: scene.view.clone(),
            via: Via::Field,
            kept: Kept::Field,
            times: BuildTimes::default(),
        })
    }

    pub(crate) fn load(
        engine: Engine,
        stored: Stored,
        path: &Path,
        outside: bool,
    ) -> Result<(Scene, Self), VolumeFileError> {
        let mut scene = crate::stored_scene(&stored, path)?;
        // Files of version 1 have no meshes.
        let folder = path.parent().unwrap_or(Path::new("."));
        let control = &engine.control;
        crate::load_meshes_controlled(&mut scene, folder, outside, control)?;
        let mut world = Self::new(engine, &scene)?;
        let mut stored = stored;
        let solid = world.program().aabb();
        stored
            .volume
            .set_cut(!solid.is_finite() && !solid.is_empty());
        world.via = Via::of(&stored.volume);
        world.kept = match &world.gpu {
            Some(gpu) => {
                let volume =
                    wait(GpuVolume::upload(gpu, &stored.volume)).map_err(BuildError::from)?;
                Kept::Gpu(volume)
            }
            None => Kept::Cpu(stored.volume),
        };
        world.begin_following(&scene);
        Ok((scene, world))
    }

    /// The same world, made anew of a scene and kept in some way, on the same device and by the same shaders.
    ///
    /// # Errors
    /// As [`Build::bricks`](crate::Build::bricks).
    pub fn kept_anew(self, scene: &Scene, via: Via) -> Result<Self, BuildError> {
        wait(self.kept_anew_async(scene, via))
    }

    /// [`World::kept_anew`] as a future; see [`Build::via_async`](crate::Build::via_async).
    ///
    /// # Errors
    /// As there.
    pub async fn kept_anew_async(mut self, scene: &Scene, via: Via) -> Result<Self, BuildError> {
        // What was there before is not needed while the new volume is made.
        self.kept = Kept::Field;
        if !self.live.has_seen_all(scene) {
            self.program = OnceLock::from(Lowered::from(Program::lower(scene)?));
            self.view = scene.view.clone();
        }
        let program = &Lowered::of(&self.program, &self.live).program;
        self.focus = focus(scene, program);
        // Edits that were followed have left tables in an order of their own.
        if let Some(gpu) = &mut self.gpu
            && !gpu.is_specialized()
        {
            gpu.update(program)?;
        }
        (self.kept, self.times) = via.build(&self.site(scene, self.program()), None).await?;
        self.begin_following(scene);
        self.via = via;
        Ok(self)
    }

    /// Where what the world is kept as is built anew.
    fn site<'a>(&'a self, scene: &'a Scene, program: &'a Program) -> Site<'a> {
        Site {
            engine: &self.engine,
            field: self.gpu.as_ref(),
            scene,
            program,
        }
    }

    /// How the world is kept.
    pub fn kept_via(&self) -> Via {
        self.via
    }

    /// What building the volume took.
    pub fn build_times(&self) -> &BuildTimes {
        &self.times
    }

    /// Voxels along each axis of the volume; `None` of a field.
    pub fn resolution(&self) -> Option<[u32; 3]> {
        self.kept.lattice().map(|lattice| lattice.size.to_array())
    }

    /// What the volume is; `None` of a field.
    pub fn volume_info(&self) -> Result<Option<VolumeInfo>, BuildError> {
        wait(self.volume_info_async())
    }

    /// [`World::volume_info`] in a browser.
    ///
    /// # Errors
    /// As there.
    pub async fn volume_info_async(&self) -> Result<Option<VolumeInfo>, BuildError> {
        match (&self.kept, &self.gpu) {
            (Kept::Cpu(volume), _) => Ok(Some(volume.info())),
            (Kept::Gpu(volume), Some(field)) => Ok(Some(volume.info(field.gpu()).await?)),
            _ => Ok(None),
        }
    }

    pub(crate) fn kept(&self) -> &Kept {
        &self.kept
    }

    pub(crate) fn field_on_gpu(&self) -> Option<&GpuField> {
        self.gpu.as_ref()
    }

    /// Numbers of triangles and of their corners, where that is how the world is kept.
    pub fn triangle_counts(&self) -> Option<[u64; 2]> {
        let Kept::Mesh(drawable) = &self.kept else {
            return None;
        };
        Some(match &drawable.mesh {
            Triangulated::Cpu(mesh) => {
                [mesh.triangles.len(), mesh.positions.len()].map(|n| n as u64)
            }
            Triangulated::Gpu(mesh) => mesh.counts(),
        })
    }

    pub(crate) fn volume_on_cpu(&self) -> Option<&Volume> {
        match &self.kept {
            Kept::Cpu(volume) => Some(volume),
            _ => None,
        }
    }

    /// How the scene is looked at.
    pub fn view(&self) -> &crate::View {
        &self.view
    }

    /// The volume, brought from the GPU where it is there; `None` of a field.
    pub fn volume(&self) -> Result<Option<Cow<'_, Volume>>, BuildError> {
        match (&self.kept, &self.gpu) {
            (Kept::Cpu(volume), _) => Ok(Some(Cow::Borrowed(volume))),
            (Kept::Gpu(volume), Some(field)) => {
                Ok(Some(Cow::Owned(wait(volume.read(field.gpu()))?)))
            }
            _ => Ok(None),
        }
    }

    /// Write the volume with the scene that it was built from, beside its place and then renamed into it.
    pub fn save(&self, scene: &Scene, path: impl AsRef<Path>) -> Result<(), VolumeFileError> {
        let path = path.as_ref();
        let volume = self.volume()?.ok_or(VolumeFileError::NoVolume)?;
        let scene_json = at_time_0(scene);
        let meshes = crate::meshes::meshes_to_store(scene);
        argil_scene::replace_file(path, |out| volume.write(&scene_json, &meshes, out)).map_err(
            |source| VolumeFileError::Write {
                path: path.into(),
                source,
            },
        )
    }

    /// Write what [`World::save`] does, wherever it goes.
    ///
    /// # Errors
    /// If there is no volume, or `out` does not take it.
    pub fn write(&self, scene: &Scene, out: &mut dyn std::io::Write) -> std::io::Result<()> {
        let volume = self.volume().map_err(std::io::Error::other)?;
        let volume = volume.ok_or_else(|| std::io::Error::other(VolumeFileError::NoVolume))?;
        let meshes = crate::meshes::meshes_to_store(scene);
        volume.write(&at_time_0(scene), &meshes, out)
    }

    /// What edits have changed of sparse bricks on the CPU since this was last called, or since they were built: what a copy of them
    /// elsewhere has to bring over. Nothing of worlds that are kept in another way; after a [rebuild](Applied::rebuilt)
    /// everything is new.
    pub fn take_brick_changes(&mut self) -> Option<BrickChanges> {
        match &mut self.kept {
            Kept::Cpu(Volume::Bricks(bricks)) => Some(bricks.take_changes()),
            _ => None,
        }
    }

    /// Follow a scene from now on, whose changes are all known.
    fn begin_following(&mut self, scene: &Scene) {
        self.live = Live::of(scene);
        let edits = match &self.kept {
            Kept::Cpu(volume) => volume.edits(),
            Kept::Gpu(volume) => volume.edits(),
            Kept::Field | Kept::Mesh(_) => None,
        };
        if let Some(edits) = edits {
            let program = &Lowered::of(&self.program, &self.live).program;
            self.live.watch(scene, edits, program);
        }
    }

    /// Follow a scene that was edited. Sparse bricks are changed in place, at the cost of what the edits touch, if the scene
    /// is the one that the world was built from. Otherwise, and where an edit changes what all distances are relied on for, everything is made again, of voxels of the same size; the
    /// result is that of a fresh bake. On a GPU edits are submitted and not waited for, and nothing is compiled unless the world is
    /// specialised, or a software device lacks an opcode.
    ///
    /// # Errors
    /// If the scene cannot be built, or takes too much; the next scene that can be is followed all the same.
    pub fn apply(&mut self, scene: &Scene) -> Result<Applied, BuildError> {
        wait(self.follow(scene, None))
    }

    /// [`World::apply`] as a future; see [`Build::via_async`](crate::Build::via_async).
    ///
    /// # Errors
    /// As there.
    pub async fn apply_async(&mut self, scene: &Scene) -> Result<Applied, BuildError> {
        self.follow(scene, None).await
    }

    /// The same at a pace: as much as there is time for, what is near to the eye first. What is left is told, and done by
    /// calls that follow, or by [`World::finish`]. A picture in between shows each cell as it was or as it will be.
    ///
    /// # Errors
    /// As [`World::apply`].
    pub fn apply_at(&mut self, scene: &Scene, pace: Pace) -> Result<Applied, BuildError> {
        wait(self.follow(scene, Some(pace)))
    }

    async fn follow(&mut self, scene: &Scene, pace: Option<Pace>) -> Result<Applied, BuildError> {
        let start = Instant::now();
        let mut reason = Rebuilt::Kept;
        if self.live.is_in_place() {
            reason = Rebuilt::Specialized;
        }
        if let Some(kept) = Editable::of(&mut self.kept, self.gpu.as_mut()) {
            let machine = (&self.engine, self.via.memory_budget());
            let before = self.program.get().map(|lowered| &lowered.program);
            let followed = self.live.follow(scene, kept, before, machine, pace).await;
            // The field on a GPU has the parameters of what was followed, even where the volume could not be.
            if self.gpu.is_some() && self.live.tables().is_some() {
                self.forget_program();
            }
            match followed? {
                Followed::InPlace(applied) => {
                    self.forget_program();
                    self.view = scene.view.clone();
                    let boxes = self.live.told();
                    self.listeners.tell(&boxes);
                    return Ok(applied);
                }
                Followed::Not(why) => reason = why,
            }
        }
        let program = Program::lower(scene)?;
        match &mut self.gpu {
            Some(gpu) if !gpu.is_specialized() => gpu.update(&program)?,
            Some(gpu) => *gpu = GpuField::new(gpu.gpu().clone(), &program, true)?,
            None => {}
        }
        let lattice = match self.kept.lattice() {
            Some(old) => {
                let new = following(&old, scene, &program)?;
                if new != old && reason == Rebuilt::Kept {
                    reason = Rebuilt::Box;
                }
                Some(new)
            }
            None => None,
        };
        let site = self.site(scene, &program);
        let (kept, times) = self.via.build(&site, lattice).await?;
        (self.kept, self.times) = (kept, times);
        self.focus = focus(scene, &program);
        self.view = scene.view.clone();
        self.program = OnceLock::from(Lowered::from(program));
        let done = self.live.take_done();
        self.begin_following(scene);
        self.listeners.tell(&[Aabb::ALL]);
        let bricks = self
            .volume_info_async()
            .await?
            .and_then(|info| info.sparse)
            .map_or(0, |s| s.bricks);
        self.live.made(bricks, done);
        Ok(Applied {
            blocks_left: 0,
            dirty_box: Aabb::ALL,
            duration_ms: start.elapsed().as_secs_f64() * 1e3,
            rebuilt: true,
            reason: Some(reason),
        })
    }

    /// Do what edits at a pace have left to be done, and wait for the device; what edits did since the last time, all bricks counted as
    /// filled where everything was made again.
    ///
    /// # Errors
    /// As [`World::apply`].
    pub fn finish(&mut self) -> Result<BrickEdit, BuildError> {
        wait(self.finish_async())
    }

    /// [`World::finish`] in a browser.
    ///
    /// # Errors
    /// As there.
    pub async fn finish_async(&mut self) -> Result<BrickEdit, BuildError> {
        let Some(kept) = Editable::of(&mut self.kept, self.gpu.as_mut()) else {
            return Ok(self.live.take_done());
        };
        let machine = (&self.engine, self.via.memory_budget());
        let edit = self.live.finish(kept, machine).await?;
        let boxes = self.live.told();
        self.listeners.tell(&boxes);
        Ok(edit)
    }

    /// Give back the room for bricks that edits have left on a GPU, after a wait. On the CPU none is left.
    ///
    /// # Errors
    /// If the device does not do it.
    pub fn trim(&mut self) -> Result<(), BuildError> {
        if let (Kept::Gpu(volume), Some(field)) = (&mut self.kept, &self.gpu) {
            wait(volume.trim(field))?;
        }
        Ok(())
    }

    /// Call `listener` whenever edits are done, with the boxes outside of which no distance near a surface changed: the
    /// box of everything where all was made again. It is called by the thread that applies edits, after they were applied;
    /// of a GPU, after they were submitted.
    pub fn listen(&mut self, listener: impl FnMut(&[Aabb]) + Send + Sync + 'static) -> Listener {
        self.listeners.add(Box::new(listener))
    }

    /// Call a listener no more; whether it was there.
    pub fn unlisten(&mut self, listener: Listener) -> bool {
        self.listeners.remove(listener)
    }

    /// In how many cells sparse bricks differ from those of a fresh bake on the same device with the same voxels, whose box is
    /// found anew: whether there is a
    /// brick, its samples, its materials. `scene` is the one that was applied last. Nothing of a world that is kept in
    /// another way.
    ///
    /// # Errors
    /// If the scene cannot be baked.
    pub fn differing_cells(&self, scene: &Scene) -> Result<Option<u64>, BuildError> {
        let volume = self.volume()?;
        let Some(Volume::Bricks(bricks)) = volume.as_deref() else {
            return Ok(None);
        };
        let program = Program::lower(scene)?;
        // The world's own field follows edits, with tables in another order.
        let field = match &self.gpu {
            Some(own) => Some(GpuField::new(own.gpu().clone(), &program, false)?),
            None => None,
        };
        let field = field.as_ref();
        // The box is found anew: what an edit has put outside of the old one must be there.
        let lattice = match self.kept.lattice() {
            Some(lattice) => Some(found_again(&lattice, scene, &program)?),
            None => None,
        };
        let site = Site {
            field,
            ..self.site(scene, &program)
        };
        let (fresh, _) = wait(self.via.build(&site, lattice))?;
        let fresh = match (fresh, field) {
            (Kept::Cpu(volume), _) => volume,
            (Kept::Gpu(volume), Some(field)) => wait(volume.read(field.gpu()))?,
            _ => return Ok(None),
        };
        Ok(match &fresh {
            Volume::Bricks(fresh) => Some(bricks.differing_cells(fresh)),
            _ => None,
        })
    }

    /// Compile shaders for this very scene, in place of the interpreter. The CPU always interprets.
    pub fn specialize(&mut self) -> Result<(), BuildError> {
        self.finish()?;
        if let Some(gpu) = &self.gpu {
            let specialized = GpuField::new(gpu.gpu().clone(), self.program(), true)?;
            self.gpu = Some(specialized);
        }
        Ok(())
    }

    /// Another program is to be put together when it is asked for.
    fn forget_program(&mut self) {
        self.program = OnceLock::new();
        self.asked = AtomicU32::new(0);
    }

    /// The program, with what is made of it for queries.
    fn lowered(&self) -> &Lowered {
        Lowered::of(&self.program, &self.live)
    }

    /// The program as edits are followed, if they are.
    pub(crate) fn live_program(&self) -> Option<&LiveProgram> {
        self.live.program()
    }

    /// The tables that hold of all of the scene: its materials, how steep it is. They have no list.
    pub(crate) fn tables(&self) -> &Program {
        self.live.tables().unwrap_or_else(|| self.program())
    }

    /// What can matter near a point, of a program that is neither short nor very long.
    pub(crate) fn list_tree(&self) -> Option<&ListTree> {
        self.lowered().list_tree(self.focus)
    }

    /// Whether few questions were asked since the last edit: then lists that follow edits cost less than to make others.
    pub(crate) fn is_seldom_asked(&self) -> bool {
        self.asked.fetch_add(1, Ordering::Relaxed) < SELDOM
    }

    /// What is near where in the program, of one with many pieces.
    pub(crate) fn operand_index(&self) -> Option<&OperandIndex> {
        self.lowered().operand_index(self.focus)
    }

    /// The program that the scene was lowered to.
    pub fn program(&self) -> &Program {
        // While edits are followed in place, it is put together when it is asked for.
        &self.lowered().program
    }

    /// Bytes that the way in which the world is kept takes: a volume's texels and tables; of a field the program's
    /// tables, on the GPU too where there is one.
    pub fn memory_bytes(&self) -> u64 {
        match &self.kept {
            Kept::Field => {
                let on_gpu = self.gpu.as_ref().map_or(0, GpuField::memory_bytes);
                self.program().memory_bytes() as u64 + on_gpu
            }
            Kept::Cpu(volume) => volume.memory_bytes(),
            Kept::Gpu(volume) => volume.memory_bytes(),
            Kept::Mesh(drawable) => match &drawable.mesh {
                Triangulated::Gpu(mesh) => mesh.memory_bytes(),
                Triangulated::Cpu(mesh) => mesh.memory_bytes(),
            },
        }
    }

    /// Lets long work of the world (what [`World::apply`] builds anew, meshes, pictures on the CPU) be told of and stopped by another
    /// control from now on: one that is cancelled stays so.
    pub fn set_control(&mut self, control: &Control) {
        self.engine = self.engine.with_control(control);
    }

    /// The engine that built the world.
    pub fn engine(&self) -> &Engine {
        &self.engine
    }

    /// The box that the scene is looked at in.
    pub fn focus(&self) -> Aabb {
        self.focus
    }

    /// The signed distance at a point, negative inside.
    pub fn distance(&self, point: [f32; 3]) -> f32 {
        self.program().distance(point.into())
    }

    /// The distance and its gradient at a point.
    pub fn gradient(&self, point: [f32; 3]) -> (f32, [f32; 3]) {
        let (d, g) = self.program().gradient(point.into());
        (d, g.to_array())
    }

    /// The field's distances at a grid's points, x fastest, on rayon's current threads: exact everywhere, not cut off at a band, and
    /// each evaluated by the brushes that can matter near it.
    ///
    /// ```
    /// use argil::{Brush, Engine, Grid, Scene, Shape};
    /// let mut scene = Scene::new();
    /// scene.push(Brush::new(Shape::sphere(0.5)))?;
    /// let world = Engine::cpu().build(&scene)?.field();
    /// let grid = Grid::spanning([-1.0; 3].into(), [1.0; 3].into(), 65);
    /// let mut distances = vec![0.0; grid.len()];
    /// world.sample_grid(&grid, &mut distances)?;
    /// assert_eq!(distances[32 + 65 * (32 + 65 * 32)], -0.5);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If `out` has another length than the grid has points, or these are no numbers.
    pub fn sample_grid(&self, grid: &Grid, out: &mut [f32]) -> Result<(), GridError> {
        if out.len() != grid.len() {
            let (points, numbers) = (grid.len(), out.len());
            return Err(GridError::Length { points, numbers });
        }
        if !(grid.min.is_finite() && grid.spacing.is_finite()) {
            return Err(GridError::NotFinite);
        }
        self.program().distances_pruned(grid, out);
        Ok(())
    }

    /// An interval that holds the distances of all points of a box.
    pub fn bounds(&self, min: [f32; 3], max: [f32; 3]) -> Interval {
        self.program().bounds(Aabb::new(min.into(), max.into()))
    }

    /// The scene's own camera.
    pub fn camera(&self) -> Camera {
        self.camera_at(self.view.camera)
    }

    /// A camera with the scene's field of view.
    pub fn camera_at(&self, placement: Placement) -> Camera {
        let field_of_view_degrees = self.view.field_of_view_degrees;
        match placement {
            Placement::Orbit(orbit) => Camera::orbit(self.focus, orbit, field_of_view_degrees),
            Placement::Look { eye, target } => Camera {
                eye: eye.into(),
                target: target.into(),
                field_of_view_degrees,
            },
        }
    }

    /// How the scene wants to be drawn, for a size; four samples a pixel when shaded.
    pub fn settings(&self, size: [u32; 2], show: Show) -> Settings {
        Settings {
            size,
            show,
            samples: if show == Show::Shaded { 4 } else { 1 },
            ground: self.view.ground && show == Show::Shaded,
            sun_degrees: self.view.sun_degrees,
            max_steps: match self.via {
                Via::Field => FIELD_STEPS,
                _ => VOLUME_STEPS,
            },
            ..Settings::default()
        }
    }

    /// A shaded picture.
    pub fn render(&self, camera: &Camera, size: [u32; 2]) -> Result<Drawn, RenderError> {
        self.draw(camera, &self.settings(size, Show::Shaded))
    }

    /// A picture by settings.
    pub fn draw(&self, camera: &Camera, settings: &Settings) -> Result<Drawn, RenderError> {
        wait(self.draw_async(camera, settings))
    }

    /// [`World::draw`] as a future; see [`Build::via_async`](crate::Build::via_async).
    ///
    /// # Errors
    /// As there.
    pub async fn draw_async(
        &self,
        camera: &Camera,
        settings: &Settings,
    ) -> Result<Drawn, RenderError> {
        let (picture, duration_ms) = self.picture(camera, settings, false).await?;
        Ok(Drawn::new(picture, duration_ms))
    }

    /// How far the ray of each pixel goes until it hits a solid, row by row from the top, of the first sample where there are
    /// several; infinite where it hits none.
    pub fn lengths(&self, camera: &Camera, settings: &Settings) -> Result<Vec<f32>, RenderError> {
        let (_, lengths) = wait(self.draw_with_lengths_async(camera, settings))?;
        Ok(lengths)
    }

    /// [`World::draw_async`] and [`World::lengths`] in one.
    ///
    /// # Errors
    /// As there.
    pub async fn draw_with_lengths_async(
        &self,
        camera: &Camera,
        settings: &Settings,
    ) -> Result<(Drawn, Vec<f32>), RenderError> {
        let (picture, duration_ms) = self.picture(camera, settings, true).await?;
        let length = |hit: &Hit| match hit.kind {
            HIT_OUTSIDE | HIT_INSIDE => hit.normal_t[3],
            _ => f32::INFINITY,
        };
        let lengths = picture.hits.iter().map(length).collect();
        Ok((Drawn::new(picture, duration_ms), lengths))
    }

    async fn picture(
        &self,
        camera: &Camera,
        settings: &Settings,
        with_hits: bool,
    ) -> Result<(Picture, f64), RenderError> {
        check(camera, settings)?;
        if !self.via.shows(settings.show) {
            return Err(RenderError::NoBricks);
        }
        let lattice = self.kept.lattice();
        let frames = frames(
            settings,
            camera,
            self.program(),
            lattice.as_ref(),
            self.focus,
        );
        if let Some(field) = &self.gpu {
            field.complete(|| self.program());
            let (picture, duration_ms) = match &self.kept {
                Kept::Gpu(volume) => volume.render(field, &frames, with_hits).await?,
                Kept::Mesh(Drawable {
                    mesh: Triangulated::Gpu(mesh),
                    ..
                }) => mesh.render(field, &frames, with_hits).await?,
                _ => field.render(&frames, with_hits).await?,
            };
            return Ok((picture, duration_ms));
        }
        let drawn;
        let through: &dyn Through = match &self.kept {
            Kept::Cpu(volume) => volume,
            Kept::Mesh(Drawable {
                mesh: Triangulated::Cpu(mesh),
                ..
            }) => {
                drawn = triangles(mesh);
                &drawn
            }
            _ => &argil_march::Field,
        };
        let start = Instant::now();
        let control = &self.engine.control;
        let picture =
            argil_march::render_controlled(self.program(), through, &frames, with_hits, control);
        let picture = picture.ok_or(RenderError::Cancelled)?;
        Ok((picture, start.elapsed().as_secs_f64() * 1e3))
    }
}

/// The cameras of an orbit: the first as given, the others turned about the vertical by equal angles.
pub struct Orbit;

impl Orbit {
    /// `count` cameras around `camera`'s target.
    pub fn around(camera: Camera, count: u32) -> impl Iterator<Item = Camera> {
        (0..count).map(move |i| camera.turned(360.0 * i as f32 / count as f32))
    }
}

/// A scene's text for a file: what is read again stands at time 0.
fn at_time_0(scene: &Scene) -> String {
    if scene.time() == 0.0 {
        scene.to_json()
    } else {
        scene.frozen().to_json()
    }
}

fn check(camera: &Camera, settings: &Settings) -> Result<(), RenderError> {
    let [width, height] = settings.size;
    if u64::from(width) * u64::from(height) > MAX_PIXELS {
        return Err(RenderError::Size { width, height });
    }
    if !(1..=MAX_SIDE).contains(&width) || !(1..=MAX_SIDE).contains(&height) {
        return Err(RenderError::Size { width, height });
    }
    let fault = |name, value: f32, expected| {
        Err(RenderError::Setting {
            name,
            value: f64::from(value),
            expected,
        })
    };
    if !(1..=100_000).contains(&settings.max_steps) {
        return fault("max_steps", settings.max_steps as f32, "from 1 to 100000");
    }
    if !(1..=64).contains(&settings.samples) {
        return fault("samples", settings.samples as f32, "from 1 to 64");
    }
    for (name, value) in [
        ("epsilon", settings.epsilon),
        ("normal_bias", settings.normal_bias),
    ] {
        if let Some(v) = value
            && !(v.is_finite() && v > 0.0)
        {
            return fault(name, v, "a positive number");
        }
    }
    if !camera.eye.is_finite() || !camera.target.is_finite() {
        return fault("camera", f32::NAN, "at finite coordinates");
    }
    if !(1.0..=170.0).contains(&camera.field_of_view_degrees) {
        return fault(
            "field_of_view_degrees",
            camera.field_of_view_degrees,
            "from 1 to 170",
        );
    }
    Ok(())
}
