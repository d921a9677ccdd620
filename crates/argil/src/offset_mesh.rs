//! Meshes the surface at a distance from a solid.
//!
//! *Theory.* Most fields are only lower bounds of the distance: where space is stretched, bent or displaced, and inside of unions.
//! Their level sets are no offsets, and reach out of any box that grows by the level. So the surface is meshed first, and
//! offset by the distance to its triangles.

use crate::World;
use crate::field_mesh::{MeshMethod, Stages};
use crate::mesh_error::MeshError;
use crate::mesh_options::MeshOptions;
use crate::representation::clip_box;
use argil_field::Grid;
use argil_math::Control;
use argil_mesh::{Mesh, MeshNormals, MeshSdf, marching};
use argil_scene::{Extents, Scene};
use argil_volume::{CellPrograms, VoxelGrid};
use glam::{UVec3, Vec3};
use rayon::prelude::*;

/// Samples along a side of a block that is sampled or skipped.
const BLOCK: u32 = 8;

/// Intervals from a block's center to a crossing of the surface beside one of its samples, at most: half of its diagonal, and
/// one interval.
const REACH: f32 = 7.1;

/// Maximum samples of a grid that is made only for a mesh.
const MAX_SAMPLES: u64 = 1 << 31;

/// Triangles, their voxels, and the solid that they are offset from.
type OffsetSurface = (Mesh, VoxelGrid, Option<MeshSdf>);

impl World {
    /// Whether another iso level is meshed as a level set of the field: the field is a distance, or a box clips the solid.
    pub(crate) fn is_level_set(&self, iso: f32) -> bool {
        clip_box(&self.scene, self.program().aabb()).is_some() || is_distance_to(&self.scene, iso)
    }

    /// Meshes the surface, and then the surface at a distance from its triangles.
    pub(crate) fn of_offset(
        &self,
        options: &MeshOptions,
        stages: &mut Stages,
    ) -> Result<OffsetSurface, MeshError> {
        let iso = options.iso;
        // Cut edges would cut the surface around them, by more than a voxel far away.
        let at_zero = MeshOptions {
            method: MeshMethod::DualContouring,
            iso: 0.0,
            normals: MeshNormals::None,
            ..*options
        };
        let (surface, voxel_grid, _) = self.of_field(&at_zero, &mut None, stages)?;
        if surface.triangles.is_empty() {
            return Ok((surface, voxel_grid, None));
        }
        let solid = MeshSdf::new(&surface).map_err(|source| MeshError::Offset { iso, source })?;
        let voxel_grid = self.grid_around(solid.aabb().grown(iso.max(0.0)), options)?;
        let grid = grid_of(&voxel_grid)?;
        let with_normals = !matches!(options.normals, MeshNormals::None | MeshNormals::Face);
        let control = &self.engine().control;
        let mesh = offset_mesh(&solid, &grid, iso, with_normals, control);
        stages.done("offset")?;
        Ok((mesh, voxel_grid, Some(solid)))
    }

    /// Meshes another iso level of the field, through a dense grid.
    pub(crate) fn of_level(
        &self,
        options: &MeshOptions,
        stages: &mut Stages,
    ) -> Result<(Mesh, VoxelGrid, Option<CellPrograms>), MeshError> {
        let voxel_grid = self.mesh_grid(options)?;
        let grid = grid_of(&voxel_grid)?;
        let count = grid.size.as_usizevec3().element_product();
        let mut samples = vec![0.0; count];
        self.program().distances(&grid, &mut samples);
        stages.done("sample")?;
        let gradient = options.normals == MeshNormals::Gradient;
        let mesh = marching::dense::march(&samples, &grid, options.iso, gradient);
        stages.done("march")?;
        Ok((mesh, voxel_grid, None))
    }
}

/// Returns the corners of all voxels.
fn grid_of(voxel_grid: &VoxelGrid) -> Result<Grid, MeshError> {
    let grid = Grid {
        min: voxel_grid.corner,
        spacing: Vec3::splat(voxel_grid.voxel_size),
        begin: glam::UVec3::ZERO,
        size: voxel_grid.size + 1,
    };
    let count = grid.size.to_array().map(u64::from).iter().product::<u64>();
    match count > MAX_SAMPLES {
        true => Err(MeshError::TooMany(count)),
        false => Ok(grid),
    }
}

/// Whether a scene's field is a distance as far as a level, so that its level set is the offset surface.
fn is_distance_to(scene: &Scene, level: f32) -> bool {
    let extent = Extents::of(scene).node_bounds(Scene::ROOT);
    level >= 0.0 && extent.max_underestimate == 0.0
}

/// Extracts the surface at a distance from a mesh. Normals are gradients of the distance if they are wanted.
fn offset_mesh(
    solid: &MeshSdf,
    grid: &Grid,
    level: f32,
    with_normals: bool,
    control: &Control,
) -> Mesh {
    let size = grid.size.as_usizevec3();
    let layer = size.x * size.y;
    let mut samples = vec![0.0; layer * size.z];
    let slabs = samples.par_chunks_mut(layer * BLOCK as usize).enumerate();
    slabs.for_each(|(slab, samples)| {
        if !control.is_cancelled() {
            sample_slab(solid, grid, level, slab as u32 * BLOCK, samples);
        }
    });
    let mut mesh = marching::dense::march(&samples, grid, level, false);
    if with_normals {
        mesh.normals = normals(solid, &mesh.positions, grid.spacing.x);
    }
    mesh
}

/// Samples the layers of a slab from `begin` on. Blocks that the surface does not cross get one distance.
fn sample_slab(solid: &MeshSdf, grid: &Grid, level: f32, begin: u32, samples: &mut [f32]) {
    let layer = (grid.size.x * grid.size.y) as usize;
    let depth = (samples.len() / layer) as u32;
    let at = |place: UVec3| grid.min + grid.spacing * place.as_vec3();
    let mut points = Vec::with_capacity(BLOCK.pow(3) as usize);
    let mut places = Vec::with_capacity(BLOCK.pow(3) as usize);
    let mut distances = Vec::with_capacity(BLOCK.pow(3) as usize);
    for y in (0..grid.size.y).step_by(BLOCK as usize) {
        for x in (0..grid.size.x).step_by(BLOCK as usize) {
            let first = UVec3::new(x, y, begin);
            points.clear();
            places.clear();
            for z in 0..depth {
                for y in y..(y + BLOCK).min(grid.size.y) {
                    for x in x..(x + BLOCK).min(grid.size.x) {
                        points.push(at(UVec3::new(x, y, begin + z)));
                        places.push(
                            (z * grid.size.y + y) as usize * grid.size.x as usize + x as usize,
                        );
                    }
                }
            }
            let center = at(first) + 0.5 * (BLOCK - 1) as f32 * grid.spacing;
            let middle = solid.distance(center);
            distances.clear();
            distances.resize(points.len(), middle);
            if (middle - level).abs() <= REACH * grid.spacing.max_element() {
                solid.distances(&points, &mut distances);
            }
            for (&place, &d) in places.iter().zip(&distances) {
                samples[place] = d;
            }
        }
    }
}

/// Returns the directions in which the distance grows.
fn normals(solid: &MeshSdf, positions: &[Vec3], spacing: f32) -> Vec<Vec3> {
    let half = 0.25 * spacing;
    let normal = |&p: &Vec3| {
        let [x, y, z] = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| half * axis);
        let mut d = [0.0; 6];
        solid.distances(&[p + x, p - x, p + y, p - y, p + z, p - z], &mut d);
        Vec3::new(d[0] - d[1], d[2] - d[3], d[4] - d[5]).normalize_or_zero()
    };
    positions.par_iter().map(normal).collect()
}
