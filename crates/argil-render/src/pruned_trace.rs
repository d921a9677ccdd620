//! Primary rays through the field, with pruned programs.
//!
//! *Theory.* Between two lengths, the rays of a block of pixels lie in a sphere around the middle one. The
//! instructions that can matter in that sphere are few, and where its center is far from the surface, nothing needs
//! to be evaluated. Barbier et al., "Lipschitz pruning" (2025), prune a grid in the same way. Spheres along the
//! view's own frusta need no more of them than there are pixels.
//!
//! *Practice.* A group of 64×64 pixels is cut along its rays into slabs, which one run of the interpreter measures.
//! Slab by slab, as long as rays are left, one more run measures its blocks of 16×16 pixels. Each block's rays
//! march to the end of the slab with their own program, which also gives the normals of those that hit. A scene of
//! many brushes uses the program near each point instead.

mod block;

use crate::camera::{bounds_of, slope_of, through};
use crate::probe::FieldProbe;
use crate::pruned_trace::block::{BLOCK, RAYS, RayBlock, RayLanes};
use crate::source::{RayTracer, RenderSource};
use crate::tile::Tile;
use crate::tile_buffers::TileScratch;
use crate::trace::{intersect_ground, trace_tile};
use argil_abi::{FrameUniform, Hit, Instruction};
use argil_field::{CELLS_PER_BATCH, ClearanceModel, LANES};
use glam::Vec3;

/// Pixels along a group's side.
const GROUP: u32 = 64;
/// Blocks of a group.
const BLOCKS: usize = ((GROUP / BLOCK) * (GROUP / BLOCK)) as usize;
/// Slabs of a group.
const SLABS: usize = 18;

const _: () =
    assert!(RAYS.is_multiple_of(LANES) && BLOCKS <= CELLS_PER_BATCH && SLABS <= CELLS_PER_BATCH);

/// The field itself as a source for rendering. With many operands, each point uses the program near it; otherwise
/// slabs of rays have programs.
#[derive(Debug)]
pub struct PrunedField;

impl RenderSource for PrunedField {
    fn tracer<'a>(&'a self, _: &FrameUniform) -> Option<Box<dyn RayTracer + 'a>> {
        Some(Box::new(Self))
    }
}

impl RayTracer for PrunedField {
    fn needs_field(&self, _: u32) -> bool {
        true
    }

    fn trace(
        &self,
        frame: &FrameUniform,
        tile: Tile,
        probe: &mut FieldProbe<'_>,
        scratch: &mut TileScratch,
        out: &mut [Hit],
    ) {
        if probe.is_near() {
            trace_tile(frame, tile, probe, scratch, out);
        } else {
            trace_pruned(frame, tile, probe, scratch, out);
        }
    }
}

/// A group's rays, block by block, and programs.
#[derive(Default)]
pub(crate) struct Slabs {
    blocks: Vec<RayBlock>,
    group_list: Vec<Instruction>,
    block_list: Vec<Instruction>,
    lanes: Box<RayLanes>,
}

/// Traces the primary ray of each pixel of a tile into `out`, row by row.
fn trace_pruned(
    frame: &FrameUniform,
    tile: Tile,
    probe: &mut FieldProbe<'_>,
    scratch: &mut TileScratch,
    out: &mut [Hit],
) {
    let TileScratch { starts, source, .. } = scratch;
    let slabs: &mut Slabs = source.of();
    starts.fill(frame, tile);
    out[..tile.area()].fill(Hit::default());
    slabs.blocks.resize_with(BLOCKS, RayBlock::new);
    let bias = frame.normal_bias;
    let around = bounds_of(frame).grown(bias);
    let terms = probe.program.clearance_model(around);
    for row in (0..tile.rows).step_by(GROUP as usize) {
        for column in (0..tile.width).step_by(GROUP as usize) {
            let Some(span) = slabs.load_rays(frame, tile, starts, column, row) else {
                continue;
            };
            slabs.march(frame, tile, span, &terms, probe, out);
        }
    }
    intersect_ground(frame, tile, out);
}

impl Slabs {
    /// Loads the rays of a group that meet the box, with their ranges.
    fn load_rays(
        &mut self,
        frame: &FrameUniform,
        tile: Tile,
        starts: &crate::ray_batch::RaySetup,
        column: u32,
        row: u32,
    ) -> Option<(Vec3, f32, f32)> {
        let (mut first, mut last) = (f32::INFINITY, f32::NEG_INFINITY);
        let across = GROUP / BLOCK;
        for (k, block) in (0u32..).zip(&mut self.blocks) {
            let (x, y) = (column + k % across * BLOCK, row + k / across * BLOCK);
            let place = [tile.first_x + x, tile.first_row + y].map(|c| c as f32);
            block.aim(frame, place);
            if x >= tile.width {
                continue;
            }
            for py in y..(y + BLOCK).min(tile.rows) {
                let from = (py * tile.width + x) as usize;
                let row = from..from + BLOCK.min(tile.width - x) as usize;
                let (near, far) = (&starts.near[row.clone()], &starts.far[row.clone()]);
                let mut meet = 0;
                for (&near, &far) in near.iter().zip(far) {
                    if near <= far {
                        (first, last) = (first.min(near), last.max(far));
                        meet += 1;
                    }
                }
                if meet == row.len() {
                    block.push_row(starts, row, [0, py - y]);
                } else if meet > 0 {
                    for i in row.filter(|&i| starts.near[i] <= starts.far[i]) {
                        block.push_row(starts, i..i + 1, [(i - from) as u32, py - y]);
                    }
                }
            }
        }
        for block in &mut self.blocks {
            // Places without a ray: none advances there.
            block.t[block.count..].fill(f32::INFINITY);
        }
        let middle = 0.5 * GROUP as f32;
        let axis = through(
            frame,
            (tile.first_x + column) as f32 + middle,
            (tile.first_row + row) as f32 + middle,
        );
        (first <= last).then_some((axis, first, last))
    }

    fn march(
        &mut self,
        frame: &FrameUniform,
        tile: Tile,
        (axis, first, last): (Vec3, f32, f32),
        terms: &ClearanceModel,
        probe: &mut FieldProbe<'_>,
        out: &mut [Hit],
    ) {
        let eye = Vec3::new(frame.eye[0], frame.eye[1], frame.eye[2]);
        let bias = frame.normal_bias;
        let thick = (last - first) / SLABS as f32;
        let begin_of = |slab: usize| first + thick * slab as f32;
        // The spheres that contain a slab's rays, and the points around hits.
        let group_slope = slope_of(frame, GROUP);
        let radius = |slope: f32, end: f32| (0.5 * thick + slope * end + 2.0 * bias) * 1.000_1;
        let group_radius = radius(group_slope, last);
        let centers: [Vec3; SLABS] =
            std::array::from_fn(|slab| eye + axis * (begin_of(slab) + 0.5 * thick));
        let mut group_d = [0.0; SLABS];
        let instructions = probe.program.instructions();
        probe
            .pruner
            .classify_cells(instructions, &centers, group_radius, &mut group_d);
        // A classification holds for one run, so the programs come first.
        let mut stretches: [(usize, usize); SLABS] = [(0, 0); SLABS];
        self.group_list.clear();
        for (slab, stretch) in stretches.iter_mut().enumerate() {
            let end = begin_of(slab + 1);
            if terms.radius(group_d[slab]) > radius(group_slope, end) {
                continue;
            }
            let from = self.group_list.len();
            probe
                .pruner
                .prune_into(instructions, slab, &mut self.group_list);
            *stretch = (from, self.group_list.len());
        }

        for slab in 0..SLABS {
            let end = if slab + 1 == SLABS {
                f32::INFINITY
            } else {
                begin_of(slab + 1)
            };
            let center = begin_of(slab) + 0.5 * thick;
            let block_end = begin_of(slab + 1);
            let block_radius = radius(slope_of(frame, BLOCK), block_end);
            let (from, to) = stretches[slab];
            let is_clear = terms.radius(group_d[slab]) > radius(group_slope, block_end);
            if is_clear {
                continue;
            }
            let mut centers = [Vec3::ZERO; BLOCKS];
            for (place, block) in centers.iter_mut().zip(&self.blocks) {
                *place = eye + block.axis * center;
            }
            let mut d = [0.0; BLOCKS];
            let list = &self.group_list[from..to];
            probe
                .pruner
                .classify_cells(list, &centers, block_radius, &mut d);
            let mut is_left = false;
            for (k, block) in self.blocks.iter_mut().enumerate() {
                if block.count == 0 {
                    continue;
                }
                if terms.radius(d[k]) <= block_radius {
                    self.block_list.clear();
                    probe.pruner.prune_into(list, k, &mut self.block_list);
                    let lanes = &mut self.lanes;
                    let span = (begin_of(slab), end);
                    block.march(
                        frame,
                        tile,
                        span,
                        &self.block_list,
                        &mut probe.evaluator,
                        lanes,
                        out,
                    );
                }
                is_left |= block.t[..block.count].iter().any(|&t| t < f32::INFINITY);
            }
            if !is_left {
                break;
            }
        }
        for block in &self.blocks {
            block.finish(out);
        }
    }
}
