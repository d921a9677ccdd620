//! Samples the solid of a scene's oldest entries.
//!
//! *Practice.* Samples are a voxel apart, at the places of a lattice. Baking again on the same lattice keeps them. Materials are
//! paint: see [`paints`].

mod lattice;
mod paints;
mod sampler;

use crate::{LowerError, Program, in_background};
use argil_math::{Aabb, Control};
use argil_scene::{Brush, HistoryBake, NodeId, SampledGrid, Scene, Shape, ValidationError};
use glam::Vec3;
use lattice::Lattice;
pub use lattice::SampleLattice;
use sampler::ProgramSampler;

/// Maximum voxels from the scene's origin to that of the samples.
const FARTHEST_ORIGIN: f32 = (1 << 22) as f32;

/// The reason why a history cannot be baked.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BakeHistoryError {
    /// The size of a voxel is not a length.
    #[error("voxel size {0}: choose a length above 0")]
    VoxelSize(f32),
    /// The origin of the lattice is no place, or so far away that places of voxels are not exact.
    #[error(
        "origin {0} of the samples: choose a finite place, fewer than {FARTHEST_ORIGIN} voxels from the scene's"
    )]
    Origin(Vec3),
    /// Samples do not move.
    #[error(
        "{0} has keyframes, and samples do not move: remove its keyframes, or bake only the entries before it"
    )]
    Animated(String),
    /// What is hidden would be lost.
    #[error(
        "{0} is hidden, and would be lost: show it or remove it, or bake only the entries before it"
    )]
    Hidden(String),
    /// The solid has no finite size.
    #[error(
        "the solid is infinite: set the view's bounds, where samples end, or bake only finite entries"
    )]
    Infinite,
    /// There are too many voxels.
    #[error(
        "voxels of {voxel_size} are too many for this solid: choose a voxel size of at least {least}"
    )]
    TooFine {
        /// The size of a voxel that was asked for.
        voxel_size: f32,
        /// One that is possible, at most a twentieth above the smallest.
        least: f32,
    },
    /// The scene exceeds a limit.
    #[error(transparent)]
    Scene(#[from] LowerError),
    /// Distances change too fast, or are no numbers.
    #[error("samples of the solid: {0}")]
    Samples(#[from] ValidationError),
    /// A [`Control`] canceled the work.
    #[error("canceled")]
    Cancelled,
}

/// Samples the solid of a scene's first `count` entries, to replace them by brushes: see [`Scene::fold_history`]. A game that digs for
/// hours bakes now and then, and its edits take as long, and as much memory, as after its first bake. An edit near samples takes longer
/// than one near a few simple brushes, and least if a world has its samples in the same places. `samples` tells them: a world's
/// `sample_lattice`, or the size of a voxel. Bakes of one scene should have the same ones: only then do later bakes keep the samples
/// of earlier ones.
///
/// Distances are those of the field at all samples near the surface, and interpolated between them. Beyond twelve voxels, they may
/// be off by a twentieth. What is thinner than a voxel may be lost. Each material keeps its part of the solid, also deep inside; the
/// borders between materials are exact at samples, too.
/// Textures that move with their brushes have the scene's frame afterwards, so that they may shift. An infinite solid is cut off at the
/// view's bounds. Saving the scene writes the samples beside it, as `history-….grid`: those of earlier saves can be deleted.
///
/// This takes about twice as long as a build of dense voxels, because it leaves half of the threads to the game: it has
/// [threads of its own](in_background). It needs no access to the scene meanwhile: a game passes a [snapshot](Scene::snapshot) to
/// another thread, and folds the result in when it is done. Edits of later entries do not interfere.
///
/// ```
/// use argil_field::{Program, bake_history};
/// use argil_math::Control;
/// use argil_scene::{Brush, Scene, Shape};
/// let mut scene = Scene::new();
/// scene.push(Shape::cuboid([1.0, 0.5, 1.0]))?;
/// for i in 0..50 {
///     let x = 0.03 * i as f32 - 0.75;
///     scene.push(Brush::new(Shape::sphere(0.2)).at([x, 0.5, 0.0]).subtract())?;
/// }
/// let before = Program::lower(&scene)?.distance([0.0, 0.25, 0.0].into());
/// let bake = bake_history(&scene, 40, 1.0 / 32.0, &Control::default())?;
/// scene.fold_history(&bake)?;
/// assert_eq!(scene.brush_count(), 12);
/// let after = Program::lower(&scene)?.distance([0.0, 0.25, 0.0].into());
/// assert!((after - before).abs() < 1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If an entry is animated or hidden, the solid is infinite, the lattice is not valid, or its voxels are too many: see
/// [`BakeHistoryError`].
pub fn bake_history(
    scene: &Scene,
    count: usize,
    samples: impl Into<SampleLattice>,
    control: &Control,
) -> Result<HistoryBake, BakeHistoryError> {
    let samples = samples.into();
    let voxel_size = samples.voxel_size;
    if !(voxel_size > 0.0 && voxel_size.is_finite()) {
        return Err(BakeHistoryError::VoxelSize(voxel_size));
    }
    let farthest = samples
        .origin
        .abs()
        .to_array()
        .map(|along| along / voxel_size);
    if !farthest.into_iter().all(|along| along < FARTHEST_ORIGIN) {
        return Err(BakeHistoryError::Origin(samples.origin));
    }
    let oldest = scene.oldest_entries(count);
    for id in oldest.iter() {
        check(&oldest, id)?;
    }
    in_background(|| sample(oldest, samples, control))
}

/// Samples the solid of all entries of a scene, and their materials.
fn sample(
    oldest: Scene,
    samples: SampleLattice,
    control: &Control,
) -> Result<HistoryBake, BakeHistoryError> {
    let voxel_size = samples.voxel_size;
    let program = Program::lower(&oldest)?;
    let mut solid = program.aabb();
    let is_cut = !solid.is_empty() && !solid.is_finite();
    if is_cut {
        let [min, max] = oldest.view.bounds.ok_or(BakeHistoryError::Infinite)?;
        solid = solid.intersection(Aabb::new(min.into(), max.into()));
    }
    if solid.is_empty() {
        return Ok(HistoryBake::new(oldest, Vec::new()));
    }
    let lattice = Lattice::around(solid, samples)
        .map_err(|least| BakeHistoryError::TooFine { voxel_size, least })?;
    let distances = ProgramSampler::new(&program, control).cut_to(is_cut.then_some(solid));
    let Lattice {
        corner,
        cell,
        cells,
        ..
    } = lattice;
    let grid = SampledGrid::sample(corner, cell, cells, solid, &distances);
    if control.is_cancelled() {
        return Err(BakeHistoryError::Cancelled);
    }
    grid.check()?;
    if !grid.has_inside() {
        return Ok(HistoryBake::new(oldest, Vec::new()));
    }
    let paints = paints::sample(&program, &oldest, lattice, control);
    if control.is_cancelled() {
        return Err(BakeHistoryError::Cancelled);
    }
    let mut all = vec![sampled("History", paints.first.as_deref(), grid)];
    for (material, grid) in paints.others {
        grid.check()?;
        // A weight is 1 on one side of the border, 0 on the other, and linear within this length.
        let brush = sampled(&format!("History: {material}"), Some(&material), grid);
        all.push(brush.paint().smooth(paints::SOFTNESS * voxel_size));
    }
    Ok(HistoryBake::new(oldest, all))
}

/// Creates a brush of samples. The name of its file depends on the samples, so that no other scene's file is replaced.
fn sampled(name: &str, material: Option<&str>, grid: SampledGrid) -> Brush {
    let file = format!("history-{:08x}", grid.checksum());
    let brush = Brush::new(Shape::sampled(file, grid)).with_name(name);
    match material {
        Some(material) => brush.with_material(material),
        None => brush,
    }
}

/// Checks that samples can hold a node.
fn check(scene: &Scene, id: NodeId) -> Result<(), BakeHistoryError> {
    let desc = scene.node(id).desc();
    if !desc.keyframes.is_empty() {
        return Err(BakeHistoryError::Animated(scene.path(id)));
    }
    if !desc.visible {
        return Err(BakeHistoryError::Hidden(scene.path(id)));
    }
    Ok(())
}
