#[cfg(not(target_arch = "wasm32"))]
mod background_rebuild;
mod edits;
mod levels;
mod rebuild;
mod take_over;

use crate::MeshCounts;
use crate::build_context::BuildContext;
use crate::device::{AnyDevice, CpuDevice, Device};
use crate::edit_session::EditSession;
use crate::framing::{Framing, lowest_point};
use crate::light::Light;
use crate::observers::Observers;
use crate::program_cache::ProgramCache;
use crate::{BuildError, BuildTimings, Engine, GridError, Representation};
use argil_field::{Grid, IncrementalProgram, OperandIndex, Program, ProgramTree};
use argil_math::{Aabb, Control, Interval};
use argil_scene::Scene;
use argil_volume::BrickChanges;
use argil_volume::{Volume, VolumeInfo};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering};
use web_time::Instant;

/// With fewer queries than this between two edits, preparing pruned programs does not pay.
const FEW_QUERIES: u32 = 64;

/// A scene that an engine has built: its exact field, and a volume or a mesh if its representation has one.
///
/// A world does not borrow its scene. After an edit of the scene, [`World::apply`] updates the world.
///
/// ```
/// use argil::prelude::*;
/// let mut scene = Scene::new();
/// scene.push(Brush::new(Shape::sphere(0.5)))?;
/// let options = DenseOptions { resolution: 64, mips: true, ..Default::default() };
/// let world = Engine::cpu().build(&scene)?.dense(options)?;
/// assert_eq!(world.resolution(), Some([64, 64, 64]));
/// let picture = world.render_view([64, 48])?;
/// # assert!(picture.hit_pixels > 0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct World {
    pub(crate) engine: Engine,
    program: OnceLock<ProgramCache>,
    pub(crate) edits: EditSession,
    /// Queries since the last edit.
    query_count: AtomicU32,
    observers: Observers,
    /// How the world was seen when it was built, once that is needed. It stays while edits apply in place.
    framing: OnceLock<Framing>,
    /// Height of the lowest point of the surface, once it is needed.
    ground: OnceLock<f32>,
    /// The scene at the last edit that was applied.
    pub(crate) scene: Scene,
    pub(crate) representation: Representation,
    pub(crate) device: AnyDevice,
    pub(crate) light: Light,
    build_timings: BuildTimings,
    /// How long the last build of everything took, in milliseconds.
    rebuild_ms: f64,
    /// Whether memory was too small for another world beside this one.
    lacks_room_beside: bool,
    #[cfg(not(target_arch = "wasm32"))]
    rebuild: Option<background_rebuild::BackgroundRebuild>,
}

impl World {
    pub(crate) fn new(engine: Engine, scene: &Scene) -> Result<Self, BuildError> {
        let start = Instant::now();
        let program = Program::lower(scene)?;
        let device = AnyDevice::new(&engine, &program)?;
        Ok(Self {
            rebuild_ms: start.elapsed().as_secs_f64() * 1e3,
            lacks_room_beside: false,
            #[cfg(not(target_arch = "wasm32"))]
            rebuild: None,
            engine,
            program: OnceLock::from(ProgramCache::from(program)),
            edits: EditSession::of(scene),
            query_count: AtomicU32::new(0),
            observers: Observers::default(),
            framing: OnceLock::new(),
            ground: OnceLock::new(),
            scene: scene.snapshot(),
            representation: Representation::Field,
            device,
            light: Light::default(),
            build_timings: BuildTimings::default(),
        })
    }

    /// Builds this world again, as a future: see [`World::rebuilt_as`].
    ///
    /// # Errors
    /// If the scene cannot be compiled, an option is out of range, or the result exceeds the memory budget.
    pub async fn rebuilt_as_async(
        mut self,
        scene: &Scene,
        representation: Representation,
    ) -> Result<Self, BuildError> {
        let start = Instant::now();
        self.stop_rebuild();
        // Free the old volume before the new one is built.
        self.device.clear();
        self.light.forget();
        let is_same = self.edits.has_seen_all(scene);
        if !is_same {
            self.program = OnceLock::from(ProgramCache::from(Program::lower(scene)?));
        }
        // Also takes over what is not an edit: name, view, and the paths of meshes.
        self.scene = scene.snapshot();
        let program = &ProgramCache::of(&self.program, &self.edits).program;
        self.framing = OnceLock::new();
        self.ground = OnceLock::new();
        // Earlier edits left the tables in another order, but no edit leaves specialized shaders.
        if !(is_same && self.device.is_specialized()) {
            self.device.set_program(program)?;
        }
        let site = BuildContext {
            engine: &self.engine,
            scene,
            program,
        };
        let built = representation.build(&mut self.device, &site, None);
        self.build_timings = built.await?;
        self.rebuild_ms = start.elapsed().as_secs_f64() * 1e3;
        self.begin_following(scene);
        self.representation = representation;
        Ok(self)
    }

    /// Returns how the world stores its geometry.
    pub fn representation(&self) -> Representation {
        self.representation
    }

    /// Returns the timings of the last build.
    pub fn build_timings(&self) -> &BuildTimings {
        &self.build_timings
    }

    /// Returns the voxels along each axis of the volume, or `None` for a world without one.
    pub fn resolution(&self) -> Option<[u32; 3]> {
        self.device
            .voxel_grid()
            .map(|voxel_grid| voxel_grid.size.to_array())
    }

    /// Describes the volume, as a future: see [`World::volume_info`].
    ///
    /// # Errors
    /// If the device fails.
    pub async fn volume_info_async(&self) -> Result<Option<VolumeInfo>, BuildError> {
        self.device.info().await
    }

    /// Returns the numbers of triangles and vertices, or `None` unless the world is represented as a mesh.
    pub fn mesh_counts(&self) -> Option<MeshCounts> {
        self.device.mesh_counts()
    }

    pub(crate) fn volume_on_cpu(&self) -> Option<&Volume> {
        self.device.on_cpu().and_then(CpuDevice::as_volume)
    }

    /// Returns the scene's view: camera, ground, sun and bounds.
    pub fn view(&self) -> &argil_scene::View {
        &self.scene.view
    }

    /// Returns the scene as it was built or [applied](World::apply) last.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Renames the paths of meshes in files that this world saves: see [`Scene::rename_meshes`].
    pub fn rename_meshes(&mut self, paths: &BTreeMap<String, String>) {
        self.scene.rename_meshes(paths);
    }

    /// Returns the volume, as a future: see [`World::volume`].
    ///
    /// # Errors
    /// If the device fails.
    pub async fn volume_async(&self) -> Result<Option<Cow<'_, Volume>>, BuildError> {
        self.device.volume().await
    }

    /// Takes the list of what edits changed in sparse bricks on the CPU, since the last call or the build. A
    /// renderer with its own copy updates it from this list. Returns `None` unless the world stores bricks on the
    /// CPU. After a [rebuild](crate::EditReport::rebuilt), everything is new.
    pub fn take_brick_changes(&mut self) -> Option<BrickChanges> {
        match self.device.on_cpu_mut()?.as_volume_mut()? {
            Volume::Bricks(bricks) => Some(bricks.take_changes()),
            _ => None,
        }
    }

    /// Compiles shaders for this scene, as a future: see [`World::specialize`].
    ///
    /// # Errors
    /// If the device does not accept the shaders.
    pub async fn specialize_async(&mut self) -> Result<(), BuildError> {
        self.flush_async().await?;
        let program = &ProgramCache::of(&self.program, &self.edits).program;
        self.device.specialize(program)
    }

    /// Drops the program. It is put together again when it is needed.
    fn forget_program(&mut self) {
        self.program = OnceLock::new();
        self.query_count = AtomicU32::new(0);
    }

    /// Returns the program, with what queries derive from it.
    fn lowered(&self) -> &ProgramCache {
        ProgramCache::of(&self.program, &self.edits)
    }

    /// Returns the incremental program, if edits have been applied.
    pub(crate) fn live_program(&self) -> Option<&IncrementalProgram> {
        self.edits.program()
    }

    /// Returns what holds for the whole scene, such as materials and bounds. Its list of instructions may be empty.
    pub(crate) fn tables(&self) -> &Program {
        self.edits.tables().unwrap_or_else(|| self.program())
    }

    /// Returns the tree of pruned programs, for a program that is neither short nor very long.
    pub(crate) fn list_tree(&self) -> Option<&ProgramTree> {
        self.lowered().list_tree(|| self.view_bounds())
    }

    /// Counts a query. Returns whether there were few since the last edit.
    pub(crate) fn has_few_queries(&self) -> bool {
        self.query_count.fetch_add(1, Ordering::Relaxed) < FEW_QUERIES
    }

    /// Returns the index over operands, for a program of many pieces.
    pub(crate) fn operand_index(&self) -> Option<&OperandIndex> {
        self.lowered().operand_index(|| self.view_bounds())
    }

    /// Returns the program that the scene was compiled to.
    pub fn program(&self) -> &Program {
        // While edits apply in place, the program is put together when it is asked for.
        &self.lowered().program
    }

    /// Returns the bytes that the representation holds: samples and tables of a volume, or the program's tables,
    /// including those on the GPU.
    pub fn memory_bytes(&self) -> u64 {
        let of_program = || self.program().memory_bytes() as u64 + self.device.program_bytes();
        self.device.stored_bytes().unwrap_or_else(of_program)
    }

    /// Returns the bytes of the coarse levels from which light through sparse bricks reads distances, on the CPU and on the
    /// GPU. They are not part of [`World::memory_bytes`] and its budget. 0 before the first shaded image.
    pub fn light_memory_bytes(&self) -> u64 {
        self.light.memory_bytes() + self.device.light_bytes()
    }

    /// Replaces the [`Control`] that long work of this world reports to: rebuilds, meshes, and images on the CPU. A
    /// canceled control stays canceled.
    pub fn set_control(&mut self, control: &Control) {
        self.engine = self.engine.with_control(control);
    }

    /// Returns the engine that built the world.
    pub fn engine(&self) -> &Engine {
        &self.engine
    }

    /// Returns the box that the scene is viewed in: the view's bounds, or else the box of the surface when the world was built.
    pub fn view_bounds(&self) -> Aabb {
        self.framing().bounds
    }

    /// Returns the view's bounds, or a box that contains the solid. No surface is searched for it.
    pub(crate) fn rough_bounds(&self) -> Aabb {
        let known = self.tables().aabb();
        match self.scene.view.bounds {
            Some([min, max]) => Aabb::new(min.into(), max.into()),
            None if known.is_finite() => known,
            None => self.view_bounds(),
        }
    }

    /// Returns how the world is seen at first.
    pub(crate) fn framing(&self) -> &Framing {
        let frame = || Framing::of(&self.scene, self.program());
        self.framing.get_or_init(frame)
    }

    /// Returns the height of the ground under the scene: the view's, or that of the lowest point of the surface.
    pub fn ground_height(&self) -> f32 {
        let lowest = || lowest_point(self.program(), self.view_bounds());
        let height = self.scene.view.ground_height;
        height.unwrap_or_else(|| *self.ground.get_or_init(lowest))
    }

    /// Forgets the height of the ground, if something that touches it changed in a box.
    fn note_ground(&mut self, dirty_box: Aabb) {
        // It was found about as precisely.
        let near = self.rough_bounds().size().max_element() / 128.0;
        let is_near = |ground: &f32| dirty_box.min.y <= *ground + near;
        if self.ground.get().is_some_and(is_near) {
            self.ground = OnceLock::new();
        }
    }

    /// Returns the signed distance at a point, in the scene's unit, negative inside. It comes from the exact field.
    pub fn distance(&self, point: [f32; 3]) -> f32 {
        self.program().distance(point.into())
    }

    /// Returns the distance and its gradient at a point, from the exact field.
    pub fn gradient(&self, point: [f32; 3]) -> (f32, [f32; 3]) {
        let (d, g) = self.program().gradient(point.into());
        (d, g.to_array())
    }

    /// Samples the exact field at a grid's points into `out`, x fastest, on rayon's current threads. Distances are
    /// exact everywhere, and each point evaluates only the brushes near it.
    ///
    /// ```
    /// use argil::prelude::*;
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
            return Err(GridError::Length {
                points,
                len: numbers,
            });
        }
        if !(grid.min.is_finite() && grid.spacing.is_finite()) {
            return Err(GridError::NotFinite);
        }
        self.program().distances_pruned(grid, out);
        Ok(())
    }

    /// Returns an interval that contains the distances of all points in a box.
    pub fn bounds(&self, min: [f32; 3], max: [f32; 3]) -> Interval {
        self.program().bounds(Aabb::new(min.into(), max.into()))
    }
}
