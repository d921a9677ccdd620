mod edits;

use crate::MeshCounts;
use crate::edit_session::EditSession;
use crate::observers::Observers;
use crate::program_cache::ProgramCache;
use crate::representation::{BuildContext, Storage, StoredTriangles, view_bounds_of};
use crate::{BuildError, BuildTimings, Engine, GridError, Representation};
use argil_field::{Grid, IncrementalProgram, OperandIndex, Program, ProgramTree};
use argil_gpu::GpuProgram;
use argil_math::{Aabb, Control, Interval};
use argil_scene::Scene;
use argil_volume::BrickChanges;
use argil_volume::{Volume, VolumeInfo};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering};

/// So few questions between two edits are no reason to make lists for them.
const FEW_QUERIES: u32 = 64;

/// A scene that an engine has built: its exact field on the engine's device and, once asked for, a volume of it.
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
    edits: EditSession,
    /// Questions since the program was put together or an edit was followed.
    query_count: AtomicU32,
    pub(crate) gpu: Option<GpuProgram>,
    observers: Observers,
    pub(crate) view_bounds: Aabb,
    /// The scene as it was followed last.
    pub(crate) scene: Scene,
    pub(crate) representation: Representation,
    pub(crate) storage: Storage,
    build_timings: BuildTimings,
}

impl World {
    pub(crate) fn new(engine: Engine, scene: &Scene) -> Result<Self, BuildError> {
        let program = Program::lower(scene)?;
        let gpu = match &engine.gpu {
            Some(gpu) => {
                let field = GpuProgram::new(gpu.clone(), &program, false)?;
                field.prepare()?;
                Some(field)
            }
            None => None,
        };
        let focus = view_bounds_of(scene, &program);
        Ok(Self {
            engine,
            program: OnceLock::from(ProgramCache::from(program)),
            edits: EditSession::of(scene),
            query_count: AtomicU32::new(0),
            gpu,
            observers: Observers::default(),
            view_bounds: focus,
            scene: scene.snapshot(),
            representation: Representation::Field,
            storage: Storage::Field,
            build_timings: BuildTimings::default(),
        })
    }

    /// [`World::rebuilt_as`] as a future; see [`Build::with_representation_async`](crate::Build::with_representation_async).
    ///
    /// # Errors
    /// As there.
    pub async fn rebuilt_as_async(
        mut self,
        scene: &Scene,
        via: Representation,
    ) -> Result<Self, BuildError> {
        // What was there before is not needed while the new volume is made.
        self.storage = Storage::Field;
        if !self.edits.has_seen_all(scene) {
            self.program = OnceLock::from(ProgramCache::from(Program::lower(scene)?));
        }
        // Also for what is no edit: its name, view and the names of its meshes.
        self.scene = scene.snapshot();
        let program = &ProgramCache::of(&self.program, &self.edits).program;
        self.view_bounds = view_bounds_of(scene, program);
        // Edits that were followed have left tables in an order of their own.
        if let Some(gpu) = &mut self.gpu
            && !gpu.is_specialized()
        {
            gpu.update(program)?;
        }
        (self.storage, self.build_timings) =
            via.build(&self.site(scene, self.program()), None).await?;
        self.begin_following(scene);
        self.representation = via;
        Ok(self)
    }

    /// Where what the world is kept as is built anew.
    fn site<'a>(&'a self, scene: &'a Scene, program: &'a Program) -> BuildContext<'a> {
        BuildContext {
            engine: &self.engine,
            field: self.gpu.as_ref(),
            scene,
            program,
        }
    }

    /// How the world is kept.
    pub fn representation(&self) -> Representation {
        self.representation
    }

    /// What building the volume took.
    pub fn build_timings(&self) -> &BuildTimings {
        &self.build_timings
    }

    /// Voxels along each axis of the volume; `None` of a field.
    pub fn resolution(&self) -> Option<[u32; 3]> {
        self.storage
            .voxel_grid()
            .map(|lattice| lattice.size.to_array())
    }

    /// [`World::volume_info`] as a future.
    ///
    /// # Errors
    /// As there.
    pub async fn volume_info_async(&self) -> Result<Option<VolumeInfo>, BuildError> {
        match (&self.storage, &self.gpu) {
            (Storage::Cpu(volume), _) => Ok(Some(volume.info())),
            (Storage::Gpu(volume), Some(field)) => Ok(Some(volume.info(field.gpu()).await?)),
            _ => Ok(None),
        }
    }

    pub(crate) fn storage(&self) -> &Storage {
        &self.storage
    }

    pub(crate) fn field_on_gpu(&self) -> Option<&GpuProgram> {
        self.gpu.as_ref()
    }

    /// Returns the numbers of triangles and vertices, or `None` unless the world is represented as a mesh.
    pub fn mesh_counts(&self) -> Option<MeshCounts> {
        let Storage::Mesh(stored) = &self.storage else {
            return None;
        };
        Some(match &stored.mesh {
            StoredTriangles::Cpu(mesh) => MeshCounts {
                triangles: mesh.triangles.len() as u64,
                vertices: mesh.positions.len() as u64,
            },
            StoredTriangles::Gpu(mesh) => {
                let [triangles, vertices] = mesh.counts();
                MeshCounts {
                    triangles,
                    vertices,
                }
            }
        })
    }

    pub(crate) fn volume_on_cpu(&self) -> Option<&Volume> {
        match &self.storage {
            Storage::Cpu(volume) => Some(volume),
            _ => None,
        }
    }

    /// How the scene is looked at.
    pub fn view(&self) -> &argil_scene::View {
        &self.scene.view
    }

    /// The scene that the world is of, as it was when it was built or [applied](World::apply) last.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Name the scene's meshes by other paths in files that the world is saved to: see [`Scene::rename_meshes`].
    pub fn rename_meshes(&mut self, paths: &BTreeMap<String, String>) {
        self.scene.rename_meshes(paths);
    }

    /// [`World::volume`] as a future.
    ///
    /// # Errors
    /// As there.
    pub async fn volume_async(&self) -> Result<Option<Cow<'_, Volume>>, BuildError> {
        match (&self.storage, &self.gpu) {
            (Storage::Cpu(volume), _) => Ok(Some(Cow::Borrowed(volume))),
            (Storage::Gpu(volume), Some(field)) => {
                Ok(Some(Cow::Owned(volume.read(field.gpu()).await?)))
            }
            _ => Ok(None),
        }
    }

    /// What edits have changed of sparse bricks on the CPU since this was last called, or since they were built: what a copy of them
    /// elsewhere has to bring over. Nothing of worlds that are kept in another way; after a [rebuild](crate::EditReport::rebuilt)
    /// everything is new.
    pub fn take_brick_changes(&mut self) -> Option<BrickChanges> {
        match &mut self.storage {
            Storage::Cpu(Volume::Bricks(bricks)) => Some(bricks.take_changes()),
            _ => None,
        }
    }

    /// [`World::specialize`] as a future.
    ///
    /// # Errors
    /// As there.
    pub async fn specialize_async(&mut self) -> Result<(), BuildError> {
        self.flush_async().await?;
        if let Some(gpu) = &self.gpu {
            let specialized = GpuProgram::new(gpu.gpu().clone(), self.program(), true)?;
            self.gpu = Some(specialized);
        }
        Ok(())
    }

    /// Another program is to be put together when it is asked for.
    fn forget_program(&mut self) {
        self.program = OnceLock::new();
        self.query_count = AtomicU32::new(0);
    }

    /// The program, with what is made of it for queries.
    fn lowered(&self) -> &ProgramCache {
        ProgramCache::of(&self.program, &self.edits)
    }

    /// The program as edits are followed, if they are.
    pub(crate) fn live_program(&self) -> Option<&IncrementalProgram> {
        self.edits.program()
    }

    /// The tables that hold of all of the scene: its materials, how steep it is. They have no list.
    pub(crate) fn tables(&self) -> &Program {
        self.edits.tables().unwrap_or_else(|| self.program())
    }

    /// What can matter near a point, of a program that is neither short nor very long.
    pub(crate) fn list_tree(&self) -> Option<&ProgramTree> {
        self.lowered().list_tree(self.view_bounds)
    }

    /// Whether few questions were asked since the last edit: then lists that follow edits cost less than to make others.
    pub(crate) fn has_few_queries(&self) -> bool {
        self.query_count.fetch_add(1, Ordering::Relaxed) < FEW_QUERIES
    }

    /// What is near where in the program, of one with many pieces.
    pub(crate) fn operand_index(&self) -> Option<&OperandIndex> {
        self.lowered().operand_index(self.view_bounds)
    }

    /// The program that the scene was lowered to.
    pub fn program(&self) -> &Program {
        // While edits are followed in place, it is put together when it is asked for.
        &self.lowered().program
    }

    /// Bytes that the way in which the world is kept takes: a volume's texels and tables; of a field the program's
    /// tables, on the GPU too where there is one.
    pub fn memory_bytes(&self) -> u64 {
        match &self.storage {
            Storage::Field => {
                let on_gpu = self.gpu.as_ref().map_or(0, GpuProgram::memory_bytes);
                self.program().memory_bytes() as u64 + on_gpu
            }
            Storage::Cpu(volume) => volume.memory_bytes(),
            Storage::Gpu(volume) => volume.memory_bytes(),
            Storage::Mesh(drawable) => match &drawable.mesh {
                StoredTriangles::Gpu(mesh) => mesh.memory_bytes(),
                StoredTriangles::Cpu(mesh) => mesh.memory_bytes(),
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
    pub fn view_bounds(&self) -> Aabb {
        self.view_bounds
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
}
