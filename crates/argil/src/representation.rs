//! How a world is kept, and building that on either device.

use crate::mesh::{MeshMethod, Stages, field_mesh, field_mesh_on_gpu};
use crate::{BuildError, Engine, Scene};
use argil_field::Program;
use argil_gpu::{DenseFill, GpuField, GpuMesh, GpuVolume, MarchNormals, Order};
use argil_march::{Descent, Triangles};
use argil_math::Aabb;
use argil_mesh::{Mesh, exact};
use argil_volume::{
    BrickLayout, BrickSettings, Bricks, Dense, Encoding, Keep, Lattice, Layout, MOST_SPARSE,
    Octree, OctreeSettings, Volume,
};
#[cfg(all(not(target_arch = "wasm32"), feature = "memory"))]
use std::sync::{LazyLock, Mutex, PoisonError};
use web_time::Instant;

/// A dense volume to be built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DenseOptions {
    /// Voxels along the longest side.
    pub resolution: u32,
    /// How distances are stored.
    pub encoding: Encoding,
    /// Whether levels of detail are built whose band doubles.
    pub mips: bool,
    /// How a GPU fills it.
    pub fill: DenseFill,
}

impl Default for DenseOptions {
    fn default() -> Self {
        Self {
            resolution: 256,
            encoding: Encoding::default(),
            mips: false,
            fill: DenseFill::default(),
        }
    }
}

/// An octree to be built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OctreeOptions {
    /// Voxels along the longest side.
    pub resolution: u32,
    /// Bricks, levels, encoding.
    pub settings: OctreeSettings,
    /// How a GPU puts bricks in order.
    pub order: Order,
    /// Where a ray's look-ups begin.
    pub descent: Descent,
}

impl Default for OctreeOptions {
    fn default() -> Self {
        Self {
            resolution: 256,
            settings: OctreeSettings::default(),
            order: Order::default(),
            descent: Descent::default(),
        }
    }
}

/// Sparse bricks to be built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BricksOptions {
    /// Voxels along the longest side.
    pub resolution: u32,
    /// The edge of a voxel in the scene's unit, in place of that.
    pub voxel: Option<f32>,
    /// Bricks and encoding.
    pub settings: BrickSettings,
    /// Bytes that bricks and tables may take; as much as there is without it.
    pub memory_budget: Option<u64>,
}

impl Default for BricksOptions {
    fn default() -> Self {
        Self {
            resolution: 256,
            voxel: None,
            settings: BrickSettings::default(),
            memory_budget: None,
        }
    }
}

/// Triangles to be drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshViaOptions {
    /// Voxels along the longest side.
    pub resolution: u32,
    /// How triangles are found.
    pub method: MeshMethod,
    /// Whether each has its own normal, the 2023 study's true ones; else corners have the exact field's.
    pub flat: bool,
}

impl Default for MeshViaOptions {
    fn default() -> Self {
        Self {
            resolution: 256,
            method: MeshMethod::default(),
            flat: false,
        }
    }
}

/// A mesh as it is drawn.
pub(crate) fn triangles(mesh: &Mesh) -> Triangles<'_> {
    Triangles {
        positions: &mesh.positions,
        normals: &mesh.normals,
        triangles: &mesh.triangles,
    }
}

/// How a world is kept.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Via {
    /// As it is: every distance is evaluated when it is asked for.
    #[default]
    Field,
    /// As one texture.
    Dense(DenseOptions),
    /// As bricks under a tree.
    Octree(OctreeOptions),
    /// As sparse bricks.
    Bricks(BricksOptions),
    /// As triangles.
    Mesh(MeshViaOptions),
}

/// What a build took.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BuildTimes {
    /// In all: on a GPU by its time stamps, compiling apart; on the CPU, or a GPU in software, by the clock.
    pub duration_ms: f64,
    /// By stage.
    pub stages_ms: Vec<(&'static str, f64)>,
}

impl BuildTimes {
    fn of_stages(stages_ms: Vec<(&'static str, f64)>) -> Self {
        Self {
            duration_ms: stages_ms.iter().map(|(_, ms)| ms).sum(),
            stages_ms,
        }
    }
}

/// What a volume is, without its texels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeInfo {
    /// Where the voxels lie.
    pub lattice: Lattice,
    /// What texels mean.
    pub encoding: Encoding,
    /// Levels of detail.
    pub levels: u32,
    /// Bytes of everything that it holds.
    pub memory_bytes: u64,
    /// Of an octree, what its bricks are.
    pub tree: Option<TreeInfo>,
    /// Of sparse bricks, what they are.
    pub sparse: Option<SparseInfo>,
}

/// What sparse bricks are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SparseInfo {
    /// Cells and bricks.
    pub layout: BrickLayout,
    /// Number of bricks.
    pub bricks: u64,
}

/// What an octree's bricks are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreeInfo {
    /// Bricks and levels of nodes.
    pub layout: Layout,
    /// Number of bricks.
    pub bricks: u64,
    /// Number of nodes.
    pub nodes: u64,
}

impl VolumeInfo {
    /// Of a volume in memory or in a file.
    pub fn of(volume: &Volume) -> Self {
        let mut sparse = None;
        let (levels, tree) = match volume {
            Volume::Dense(dense) => (dense.levels().len() as u32, None),
            Volume::Bricks(bricks) => {
                sparse = Some(SparseInfo {
                    layout: *bricks.layout(),
                    bricks: bricks.len() as u64,
                });
                (1, None)
            }
            Volume::Octree(octree) => {
                let tree = TreeInfo {
                    layout: *octree.layout(),
                    bricks: octree.tree().codes().len() as u64,
                    nodes: octree.tree().nodes().len() as u64,
                };
                (1, Some(tree))
            }
        };
        Self {
            lattice: *volume.lattice(),
            encoding: *volume.encoding(),
            levels,
            memory_bytes: volume.memory_bytes(),
            tree,
            sparse,
        }
    }

    pub(crate) async fn of_gpu(volume: &GpuVolume, field: &GpuField) -> Result<Self, BuildError> {
        let size = volume.tree_size(field.gpu()).await?;
        let tree = volume.layout().zip(size);
        Ok(Self {
            lattice: *volume.lattice(),
            encoding: *volume.encoding(),
            levels: volume.levels(),
            memory_bytes: volume.memory_bytes(),
            tree: tree.map(|(layout, (bricks, nodes))| TreeInfo {
                layout: *layout,
                bricks,
                nodes,
            }),
            sparse: volume
                .sparse(field.gpu())
                .await?
                .map(|(layout, bricks)| SparseInfo { layout, bricks }),
        })
    }
}

/// Where the distances are.
pub(crate) enum Kept {
    Field,
    Cpu(Volume),
    Gpu(GpuVolume),
    Mesh(Drawable),
}

/// Triangles, and where their voxels lay.
pub(crate) struct Drawable {
    pub mesh: Triangulated,
    pub lattice: Lattice,
}

/// Triangles on either device.
pub(crate) enum Triangulated {
    Cpu(Mesh),
    Gpu(GpuMesh),
}

/// The lattice of a scene's volume: of so many voxels, or of sparse ones of a size.
pub(crate) fn lattice_of(
    scene: &Scene,
    program: &Program,
    resolution: u32,
    voxel: Option<f32>,
) -> Result<Lattice, BuildError> {
    let frame = scene
        .view
        .frame
        .map(|[min, max]| Aabb::new(min.into(), max.into()));
    let solid = reach(scene, program);
    Ok(match voxel {
        Some(voxel) => Lattice::of_voxels(solid, frame, voxel, MOST_SPARSE)?,
        None => Lattice::holding(solid, frame, resolution)?,
    })
}

/// Times at which it is looked how far an animated scene reaches.
const LOOKS: u16 = 16;

/// The box of the solid; of a scene that moves, of what it is at times of equal distance.
pub(crate) fn reach(scene: &Scene, program: &Program) -> Aabb {
    let Some(duration) = scene.duration() else {
        return program.aabb();
    };
    let mut moved = scene.clone();
    let boxes = (0..=LOOKS).filter_map(|look| {
        moved.set_time(duration * f32::from(look) / f32::from(LOOKS));
        // What cannot be lowered then is told when it is to be drawn.
        Program::lower(&moved).ok().map(|program| program.aabb())
    });
    boxes.fold(program.aabb(), |all, own| all.union(own))
}

/// Build on the engine's device, on a lattice or on the scene's own.
pub(crate) async fn build(
    engine: &Engine,
    field: Option<&GpuField>,
    scene: &Scene,
    program: &Program,
    via: Via,
    lattice: Option<Lattice>,
) -> Result<(Kept, BuildTimes), BuildError> {
    let lattice_of = |resolution, voxel| match lattice {
        // Only sparse bricks count voxels from elsewhere than the box's corner.
        Some(lattice) if matches!(via, Via::Bricks(_)) => Ok(lattice),
        Some(lattice) => Ok(lattice.rebased()),
        None => self::lattice_of(scene, program, resolution, voxel),
    };
    match via {
        Via::Field => Ok((Kept::Field, BuildTimes::default())),
        Via::Dense(options) => {
            let lattice = lattice_of(options.resolution, None)?;
            let encoding = checked(options.encoding)?;
            let bytes = Dense::bytes_of(&lattice, encoding.bits, options.mips);
            check_memory(engine, bytes)?;
            if let Some(field) = field {
                let (mips, fill) = (options.mips, options.fill);
                let (volume, stages) =
                    GpuVolume::dense(field, program, lattice, encoding, mips, fill).await?;
                return Ok((Kept::Gpu(volume), BuildTimes::of_stages(stages)));
            }
            let start = Instant::now();
            let control = &engine.control;
            let dense = Dense::bake_controlled(program, lattice, encoding, options.mips, control);
            let dense = dense.ok_or(BuildError::Cancelled)?;
            let ms = start.elapsed().as_secs_f64() * 1e3;
            let times = BuildTimes::of_stages(vec![("fill", ms)]);
            Ok((Kept::Cpu(dense.into()), times))
        }
        Via::Bricks(options) => {
            let lattice = lattice_of(options.resolution, options.voxel)?;
            checked(options.settings.encoding)?;
            let layout = BrickLayout::new(lattice, &options.settings)?;
            if let Some(field) = field {
                let budget = budget_on(engine, &options);
                let (volume, stages) =
                    GpuVolume::bricks_controlled(field, program, layout, budget, &engine.control)
                        .await?;
                return Ok((Kept::Gpu(volume), BuildTimes::of_stages(stages)));
            }
            let budget = budget_on(engine, &options);
            let (bricks, stages) =
                Bricks::bake_controlled(program, layout, budget, &engine.control)?;
            let stages = vec![
                ("prune", stages.prune),
                ("fill", stages.fill),
                ("settle", stages.settle),
            ];
            let times = BuildTimes::of_stages(stages);
            Ok((Kept::Cpu(bricks.into()), times))
        }
        Via::Mesh(options) => {
            let lattice = lattice_of(options.resolution, None)?;
            if let Some(field) = field
                && options.method == MeshMethod::MarchingCubes
            {
                let normals = if options.flat {
                    MarchNormals::Face
                } else {
                    MarchNormals::Field
                };
                let (mesh, stages) =
                    field_mesh_on_gpu(engine, field, program, lattice, normals, options.flat)
                        .await?;
                let mesh = Triangulated::Gpu(mesh);
                let times = BuildTimes::of_stages(stages);
                return Ok((Kept::Mesh(Drawable { mesh, lattice }), times));
            }
            let mut stages = Stages::of(engine);
            let made = field_mesh(engine, program, lattice, options.method, &mut stages)?;
            let mut mesh = made.mesh;
            if options.flat {
                mesh = mesh.unshared(true);
                stages.done("unshare")?;
            } else if mesh.normals.is_empty() {
                exact::normals(program, &made.lists, &mut mesh);
                stages.done("normals")?;
            }
            let mesh = match field {
                Some(field) => Triangulated::Gpu(GpuMesh::upload(field, triangles(&mesh))?),
                None => Triangulated::Cpu(mesh),
            };
            let times = BuildTimes::of_stages(stages.all);
            Ok((Kept::Mesh(Drawable { mesh, lattice }), times))
        }
        Via::Octree(options) => {
            let lattice = lattice_of(options.resolution, None)?;
            checked(options.settings.encoding)?;
            let layout = Layout::new(lattice, &options.settings)?;
            let bits = layout.encoding.bits;
            let cells = 12 * u64::from(layout.code_count());
            check_memory(engine, Dense::bytes_of(&lattice, bits, false) + cells)?;
            let keep: Keep = options.settings.keep;
            if let Some(field) = field {
                let (mut volume, stages) =
                    GpuVolume::octree(field, program, layout, keep, options.order).await?;
                volume.set_descent(options.descent);
                return Ok((Kept::Gpu(volume), BuildTimes::of_stages(stages)));
            }
            let baked = Octree::bake_controlled(program, layout, keep, &engine.control);
            let (octree, stages) = baked.ok_or(BuildError::Cancelled)?;
            let stages = vec![
                ("select", stages.select),
                ("fill", stages.fill),
                ("tree", stages.tree),
            ];
            Ok((Kept::Cpu(octree.into()), BuildTimes::of_stages(stages)))
        }
    }
}

/// What is left of the budget, and of the machine's memory where bricks are kept there.
pub(crate) fn budget_on(engine: &Engine, options: &BricksOptions) -> Option<u64> {
    if engine.gpu_kind().is_some_and(|kind| kind.is_real_gpu()) {
        return options.memory_budget;
    }
    let free = available_memory();
    match (options.memory_budget, free) {
        (Some(budget), Some(free)) => Some(budget.min(free)),
        (budget, free) => budget.or(free),
    }
}

fn checked(encoding: Encoding) -> Result<Encoding, BuildError> {
    let voxels = encoding.range.voxels();
    if (0.5..=4096.0).contains(&voxels) {
        Ok(encoding)
    } else {
        Err(BuildError::Range(voxels))
    }
}

/// Refuse what the machine has no memory for before it is asked for.
fn check_memory(engine: &Engine, needed: u64) -> Result<(), BuildError> {
    if engine.gpu_kind().is_some_and(|kind| kind.is_real_gpu()) {
        return Ok(());
    }
    // A software GPU keeps its own in the same memory, beside what is brought back.
    let needed = needed.saturating_mul(if engine.gpu_kind().is_some() { 2 } else { 1 });
    match available_memory() {
        Some(available) if needed > available => Err(BuildError::Memory { needed, available }),
        // Where the system does not tell, trust it.
        _ => Ok(()),
    }
}

/// Bytes of memory that are free; not known in a browser.
fn available_memory() -> Option<u64> {
    #[cfg(any(target_arch = "wasm32", not(feature = "memory")))]
    return None;
    #[cfg(all(not(target_arch = "wasm32"), feature = "memory"))]
    free_memory()
}

#[cfg(all(not(target_arch = "wasm32"), feature = "memory"))]
fn free_memory() -> Option<u64> {
    // Each edit asks, and a new `System` takes longer than a look.
    static SYSTEM: LazyLock<Mutex<sysinfo::System>> =
        LazyLock::new(|| Mutex::new(sysinfo::System::new()));
    let mut system = SYSTEM.lock().unwrap_or_else(PoisonError::into_inner);
    system.refresh_memory();
    Some(system.available_memory()).filter(|&bytes| bytes > 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_machine_has_is_refused() {
        let refused = check_memory(&Engine::cpu(), u64::MAX);
        assert!(matches!(refused, Err(BuildError::Memory { .. })));
        assert!(check_memory(&Engine::cpu(), 1 << 20).is_ok());
    }
}
