//! The tables of sparse bricks on the device, and the size of their pool.

use super::build_tables::BuildTables;
use super::cells::GpuCellTable;
use super::light::GpuLight;
use super::pool_accounting::PoolAccounting;
use crate::resources::{extent, texture_of};
use crate::storage_buffer::StorageBuffer;
use crate::submission::Submission;
use crate::{Gpu, GpuError};
use argil_abi::{self as abi, BrickUniform};
use argil_volume::BrickLayout;
use glam::IVec3;

/// Points of a mixed brick.
pub(super) const PLACES: u64 = (abi::MATERIAL_SIDE as u64).pow(3);

/// Sparse bricks besides the pool's texture.
#[derive(Debug)]
pub(crate) struct BrickTables {
    pub layout: BrickLayout,
    pub cells: GpuCellTable,
    /// The material of each brick of the pool, then the materials of mixed ones.
    pub materials: StorageBuffer,
    pub mixed: u64,
    /// Bricks of the pool along each axis.
    pub pool: [u32; 3],
    pub accounting: PoolAccounting,
    pub lipschitz: f32,
    /// What edits write besides, each until its commands are done.
    pub making: Vec<(Box<BuildTables>, Submission)>,
    /// Blocks that are far from everything, with their side. They leave the table once the device has freed their bricks.
    pub gone: Vec<(IVec3, bool, Submission)>,
    /// The levels from which light reads distances.
    pub light: GpuLight,
    /// The uniform for shaders.
    pub uniform: BrickUniform,
}

impl BrickTables {
    /// Updates the uniform.
    pub(super) fn describe(&mut self) {
        self.uniform = march_words(&self.layout, &self.cells, self.pool, self.lipschitz);
    }

    /// Waits for edits. Returns the number of bricks.
    pub(super) async fn count(&self, gpu: &Gpu) -> Result<u64, GpuError> {
        Ok(self.accounting.read(gpu).await?.bricks())
    }
}

/// Returns the bytes of a pool, its tables, and the materials of a number of mixed bricks.
pub(super) fn bytes_of(
    gpu: &Gpu,
    measures: &BrickLayout,
    cells: &GpuCellTable,
    pool: [u32; 3],
    mixed: u64,
) -> u64 {
    let bricks: u64 = pool.map(u64::from).iter().product();
    // With a stack of free slots.
    let of_mixed = (8 * PLACES + 4) * mixed;
    let brick = gpu.texture_bytes(measures.encoding().format, measures.brick_bytes());
    cells.memory_bytes() + bricks * (brick + 8) + of_mixed
}

/// Returns the bricks along the sides of a pool with room for `bricks`.
pub(super) fn pool_for(
    gpu: &Gpu,
    measures: &BrickLayout,
    bricks: u64,
) -> Result<[u32; 3], GpuError> {
    let limit = gpu.device.limits().max_texture_dimension_3d;
    let most = limit / (measures.brick_size_voxels() + 1);
    let bricks = bricks.max(1);
    let side = ((bricks as f64).cbrt().ceil() as u32).clamp(1, most.max(1));
    let depth = bricks.div_ceil(u64::from(side) * u64::from(side));
    if depth > u64::from(most) {
        return Err(GpuError::TooManyBricks {
            name: gpu.info.name.clone(),
            bricks,
            limit: u64::from(most).pow(3),
        });
    }
    Ok([side, side, depth as u32])
}

pub(super) fn pool_texture(
    gpu: &Gpu,
    measures: &BrickLayout,
    pool: [u32; 3],
) -> Result<wgpu::Texture, GpuError> {
    let [x, y, z] = pool.map(|n| n * (measures.brick_size_voxels() + 1));
    texture_of(gpu, extent(x, y, z), measures.encoding().format, 1)
}

/// The uniform that reads of bricks need, which has nothing of the field.
pub(super) fn march_words(
    measures: &BrickLayout,
    cells: &GpuCellTable,
    pool: [u32; 3],
    lipschitz: f32,
) -> BrickUniform {
    let voxel_grid = &measures.voxel_grid();
    let [low, high] = [measures.first_cell(), measures.end_cell()];
    BrickUniform {
        corner: voxel_grid.corner.to_array(),
        band_width: measures.encoding().band_width(voxel_grid, 0),
        extent: voxel_grid.extent().to_array(),
        voxel_size: voxel_grid.voxel_size,
        inv_pool_size: pool.map(|n| 1.0 / (n * (measures.brick_size_voxels() + 1)) as f32),
        slope: 1.000_01 * lipschitz * voxel_grid.voxel_size,
        size_x: voxel_grid.size.x,
        size_y: voxel_grid.size.y,
        size_z: voxel_grid.size.z,
        brick_size_voxels: measures.brick_size_voxels(),
        begin_x: voxel_grid.begin.x,
        begin_y: voxel_grid.begin.y,
        begin_z: voxel_grid.begin.z,
        capacity: pool.iter().product(),
        low_x: low.x,
        low_y: low.y,
        low_z: low.z,
        pool_x: pool[0],
        high_x: high.x,
        high_y: high.y,
        high_z: high.z,
        pool_y: pool[1],
        table: cells.described(),
        max_code: measures.encoding().format.max_code(),
        ..BrickUniform::default()
    }
}
