//! Errors of stored distances and of surfaces.

use crate::outcome::Outcome;
use crate::scenes::SceneRng;
use anyhow::Context;
use argil::glam::Vec3;
use argil::volume::Volume;
use argil::{MeshOutput, World};
use argil_metrics::ErrorStats;
use argil_metrics::surface::{SurfaceDistance, sample_surface};

/// Returns points in the scene's box, and their exact distances.
fn points(world: &World, count: u32) -> (Vec<[f32; 3]>, Vec<f32>) {
    let focus = world.view_bounds();
    let mut numbers = SceneRng::new(7);
    let mut place = || {
        let part = Vec3::from([(); 3].map(|()| numbers.next()));
        (focus.min + part * focus.size()).to_array()
    };
    let points: Vec<[f32; 3]> = (0..count).map(|_| place()).collect();
    let mut exact = vec![0.0; points.len()];
    world.query().distances(&points, &mut exact);
    (points, exact)
}

/// Returns points of the exact surface.
pub(crate) fn surface_points(world: &World, count: u32) -> Vec<[f32; 3]> {
    let (all, exact) = points(world, 100 * count);
    let radius = world.view_bounds().half_diagonal();
    let close = all
        .into_iter()
        .zip(exact)
        .filter(|(_, d)| d.abs() < 0.05 * radius);
    let mut close: Vec<[f32; 3]> = close.map(|(p, _)| p).take(count as usize).collect();
    // Descend along the gradient a few times, because distances may be bounds.
    let mut found = vec![(0.0, [0.0; 3]); close.len()];
    for _ in 0..12 {
        world.query().gradients(&close, &mut found);
        for (p, (d, g)) in close.iter_mut().zip(&found) {
            let g = Vec3::from(*g).normalize_or_zero();
            *p = (Vec3::from(*p) - *d * g).to_array();
        }
    }
    let mut left = vec![0.0; close.len()];
    world.query().distances(&close, &mut left);
    let there = close.into_iter().zip(left);
    there
        .filter(|(_, d)| d.abs() < 1e-4 * radius)
        .map(|(p, _)| p)
        .collect()
}

/// Compares stored distances with exact ones, at a number of points.
///
/// # Errors
/// If the world stores no distances.
pub(crate) fn stored(world: &World, count: u32, out: &mut Outcome) -> anyhow::Result<()> {
    let info = world
        .volume_info()?
        .context("this configuration has no volume")?;
    let band = info.encoding.band.voxels() * info.voxel_grid.voxel_size;
    let (all, exact) = points(world, count);
    let volume = world
        .query_volume()
        .context("this configuration stores no distances")?;
    // Cells without a brick provide a bound, not a stored distance.
    let (all, exact): (Vec<_>, Vec<_>) = match world.volume()?.as_deref() {
        Some(Volume::Bricks(bricks)) => all
            .into_iter()
            .zip(exact)
            .filter(|(p, _)| bricks.has_brick((*p).into()))
            .unzip(),
        _ => (all, exact),
    };
    let mut measured = vec![0.0; all.len()];
    volume.distances(&all, &mut measured);
    // Four voxels for all, so that they are compared at the same points.
    let near = band.min(4.0 * info.voxel_grid.voxel_size);
    let errors = ErrorStats::within_band(&measured, &exact, 0.99 * near);
    out.set("points", errors.count as f64);
    out.spread(
        "error_voxels",
        &errors,
        f64::from(info.voxel_grid.voxel_size),
    );
    out.about(world)
}

/// Compares triangles with the exact surface, at a number of points of each. Zero points only count triangles.
///
/// # Errors
/// If the mesh has no area.
pub(crate) fn surface(
    world: &World,
    meshed: &MeshOutput,
    count: u32,
    out: &mut Outcome,
) -> anyhow::Result<()> {
    let mesh = &meshed.mesh;
    out.set("triangles", meshed.report.triangles as f64);
    out.set("vertices", mesh.positions.len() as f64);
    out.set("memory_bytes", mesh.memory_bytes() as f64);
    let watertight = meshed.report.is_watertight();
    out.set("watertight", f64::from(u8::from(watertight)));
    out.set("off_rms_voxels", meshed.surface_error.rms_voxels);
    if count == 0 {
        return Ok(());
    }
    let corners: Vec<[Vec3; 3]> = (0..mesh.triangles.len())
        .map(|i| mesh.triangle_vertices(i))
        .collect();
    let sampled = sample_surface(&corners, count as usize);
    let exact: Vec<Vec3> = surface_points(world, count / 4)
        .into_iter()
        .map(Vec3::from)
        .collect();
    let solid =
        argil::mesh::MeshSdf::new(mesh).context("the mesh has no triangles with an area")?;
    let apart = SurfaceDistance::of(
        (&sampled, &|p: Vec3| solid.distance(p)),
        (&exact, &|p: Vec3| world.distance(p.to_array())),
    );
    let voxel = f64::from(meshed.voxel_grid.voxel_size);
    out.set("hausdorff_voxels", apart.hausdorff() / voxel);
    out.set("chamfer_voxels", apart.chamfer() / voxel);
    Ok(())
}

/// Counts bricks with surface that are not stored.
///
/// # Errors
/// If the world has no bricks.
pub(crate) fn lost(world: &World, out: &mut Outcome) -> anyhow::Result<()> {
    out.about(world)?;
    let missing = match world.volume()?.as_deref() {
        Some(Volume::Octree(octree)) => octree.lost_bricks(world.program()),
        Some(Volume::Bricks(bricks)) => surface_points(world, 5000)
            .into_iter()
            .filter(|&p| !bricks.has_brick(p.into()))
            .count(),
        _ => anyhow::bail!("lost bricks need a representation with bricks"),
    };
    out.set("lost_bricks", missing as f64);
    Ok(())
}
