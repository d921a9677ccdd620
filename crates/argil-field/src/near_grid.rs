//! The grid whose parts have lists of instructions on a GPU.

use crate::Program;
use argil_abi::{NearUniform, WORLD_LIMIT};
use argil_math::Aabb;
use glam::Vec3;

/// Parts along a block's side.
const BLOCK: f32 = 4.0;
/// Blocks along the longest side of the box.
const BLOCKS: f32 = 8.0;
/// Half a cube's diagonal for an edge of 1, and rounding.
const HALF_DIAGONAL: f32 = 0.866_1;

impl Program {
    /// Returns a grid around a box, without the memory of its lists: see
    /// [`Interpreter::near_lists_wgsl`](crate::Interpreter::near_lists_wgsl). Returns `None` if the box is empty or reaches out
    /// of the world.
    pub fn near_grid(&self, around: Aabb) -> Option<NearUniform> {
        let side = around.size().max_element();
        let edge = side / (BLOCK * BLOCKS);
        let farthest = around.min.abs().max(around.max.abs()).max_element();
        // NaN fails both comparisons.
        if !(edge > f32::MIN_POSITIVE && farthest < WORLD_LIMIT) {
            return None;
        }
        let blocks = (around.size() / (BLOCK * edge)).ceil();
        let [blocks_x, blocks_y, blocks_z] = blocks
            .clamp(Vec3::ONE, Vec3::splat(BLOCKS))
            .as_uvec3()
            .to_array();
        // Blocks may reach beyond the box.
        let region = Aabb::new(around.min, around.min + blocks * BLOCK * edge);
        Some(NearUniform {
            corner: around.min.to_array(),
            inv_edge: 1.0 / edge,
            blocks_x,
            blocks_y,
            blocks_z,
            block_margin: self.list_margin(HALF_DIAGONAL * BLOCK * edge, region),
            part_margin: self.list_margin(HALF_DIAGONAL * edge, region),
            ..NearUniform::default()
        })
    }

    /// Returns how much farther an operand must be than another at a point, so that it does not matter up to a radius around it.
    fn list_margin(&self, radius: f32, region: Aabb) -> f32 {
        let farthest = region.min.abs().max(region.max.abs()).max_element();
        let change = self.lipschitz() * radius * 1.000_01;
        2.0 * (change + self.list_slack(self.instructions(), farthest))
    }
}
