//! Distances to the surface of a lattice, which files store only in a band around it.

use super::lattice::Lattice;
use argil_field::Program;
use argil_mesh::{Mesh, MeshSdf, marching, project_to_field};
use argil_scene::{DistanceSampler, SAMPLED_SIDE, SampledBlock, SampledGrid, Scene, Shape};
use argil_volume::{BrickLayout, BrickSettings, Bricks, RESOLUTION_RANGE, VoxelGrid};
use glam::Vec3;

/// Most cells of a box whose distances are rebuilt, which takes a search for each.
const MAX_CELLS: u32 = 1 << 18;

/// Up to this many voxels from the surface, distances are those of the file. They end at twice as many.
const BAND: f32 = 2.0;

/// Samples the distances of a lattice again, given samples that are right near its surface. Returns `None` if the lattice is too
/// large, or its surface has no triangles.
pub(super) fn rebuilt(lattice: &Lattice, near: &SampledGrid) -> Option<SampledGrid> {
    let region = near.region();
    let cell = near.spacing() * SAMPLED_SIDE as f32;
    let cells = (region.size() / cell).round().as_uvec3();
    if cells.element_product() > MAX_CELLS {
        return None;
    }
    let surface = surface_of(near, lattice.voxel_size)?;
    let solid = MeshSdf::new(&surface).ok()?;
    let distances = RebuiltDistances { lattice, solid };
    let grid = SampledGrid::sample(region.min, cell, cells, near.solid(), &distances);
    grid.check().is_ok().then_some(grid)
}

/// Returns the triangles of the surface between samples.
fn surface_of(samples: &SampledGrid, voxel_size: f32) -> Option<Mesh> {
    let mut scene = Scene::new();
    scene.push(Shape::sampled("volume", samples.clone())).ok()?;
    let program = Program::lower(&scene).ok()?;
    let grid =
        VoxelGrid::with_voxel_size(program.aabb(), None, voxel_size, *RESOLUTION_RANGE.end())
            .ok()?;
    let layout = BrickLayout::new(grid, &BrickSettings::default()).ok()?;
    let (bricks, programs, _) = Bricks::bake_with_programs(&program, layout, None).ok()?;
    let mut marched = marching::bricks::march(&bricks);
    project_to_field::project_to_field(&program, &programs, &mut marched, false);
    Some(marched.mesh)
}

/// Distances to triangles, except near the surface.
struct RebuiltDistances<'a> {
    lattice: &'a Lattice,
    solid: MeshSdf,
}

impl RebuiltDistances<'_> {
    /// Returns the distance of a point, given the distance to the triangles: near the surface, the file's.
    fn corrected(&self, p: Vec3, d: f32) -> f32 {
        let voxel = self.lattice.voxel_size;
        if d.abs() > 2.0 * BAND * voxel {
            return d;
        }
        let index = ((p - self.lattice.origin) / voxel).round().as_ivec3();
        let (value, is_known) = self.lattice.value(index);
        if !is_known {
            return d;
        }
        let share = (value.abs() / (BAND * voxel) - 1.0).clamp(0.0, 1.0);
        value + (d - value) * share
    }
}

impl DistanceSampler for RebuiltDistances<'_> {
    fn distances(&self, points: &[Vec3], out: &mut [f32]) {
        self.solid.distances(points, out);
        for (&p, d) in points.iter().zip(out) {
            *d = self.corrected(p, *d);
        }
    }

    fn unsigned_distance(&self, point: Vec3) -> f32 {
        self.solid.unsigned_distance(point)
    }

    fn sample_block(&self, block: &SampledBlock, out: &mut [f32]) {
        self.solid.sample_block(block, out);
        for (index, d) in out.iter_mut().enumerate() {
            *d = self.corrected(block.position(index), *d);
        }
    }
}
