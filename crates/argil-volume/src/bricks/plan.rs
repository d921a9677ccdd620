//! Which blocks a field needs, each with the list of what can matter in it.
//!
//! *Practice.* A cube around the box is cut into 4³ parts, those into 4³ again, down to blocks; each part has its own list. The
//! 64 parts of a part are measured in one run of the interpreter. A part all of which is farther from the surface than cells
//! tell has no blocks, and is not cut further.

use super::build::Bounds;
use super::layout::{BLOCK_SIDE, BrickLayout};
use super::table::BlockTable;
use argil_abi::Instr;
use argil_field::{CELLS, Program, Pruner};
use glam::{IVec3, Vec3};
use rayon::prelude::*;
use std::ops::Range;

/// Which blocks a field needs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BlockPlan {
    /// The blocks, z slowest, each with its stretch of the instructions.
    pub blocks: Vec<(IVec3, Range<usize>)>,
    /// The lists.
    pub instrs: Vec<Instr>,
    /// Boxes of blocks that are not needed, as they are far inside: from one block to before another.
    pub inside: Vec<[IVec3; 2]>,
}

/// Parts of one size with a list of instructions each.
#[derive(Default)]
struct Level {
    instrs: Vec<Instr>,
    parts: Vec<(IVec3, Range<usize>)>,
    inside: Vec<IVec3>,
}

impl BlockPlan {
    /// Of a program, on rayon's current threads.
    pub fn of(program: &Program, layout: &BrickLayout) -> Self {
        let bounds = Bounds::new(program, layout);
        let [low, high] = searched(layout);
        let extent = (high - low).max_element();
        // In blocks.
        let mut side = 1;
        while side < extent {
            side *= 4;
        }
        // Parts lie where those of an edit lie, so that the lists of a cell are the same.
        let all = 0..program.instrs().len();
        let (first, last) = (
            low.div_euclid(IVec3::splat(side)),
            (high - 1).div_euclid(IVec3::splat(side)),
        );
        let mut level = Level {
            instrs: program.instrs().to_vec(),
            parts: super::table::places(first, last)
                .map(|place| (place * side, all.clone()))
                .collect(),
            inside: Vec::new(),
        };
        let mut inside = Vec::new();
        let mut is_cut = false;
        while side > 1 || !is_cut {
            side = (side / 4).max(1);
            is_cut = true;
            let parts: Vec<Level> = level
                .parts
                .par_iter()
                .map_init(
                    || Pruner::new(program),
                    |pruner, (block, range)| {
                        let instrs = &level.instrs[range.clone()];
                        cut(layout, &bounds, *block, (side, [low, high]), instrs, pruner)
                    },
                )
                .collect();
            let mut next = Level::default();
            for part in parts {
                let from = next.instrs.len();
                next.instrs.extend_from_slice(&part.instrs);
                let moved = |r: Range<usize>| from + r.start..from + r.end;
                let own = part.parts.into_iter();
                next.parts.extend(own.map(|(block, r)| (block, moved(r))));
                inside.extend(
                    part.inside
                        .iter()
                        .map(|&at| [at.max(low), (at + side).min(high)]),
                );
            }
            level = next;
        }
        level
            .parts
            .sort_by_key(|(block, _)| [block.z, block.y, block.x]);
        Self {
            blocks: level.parts,
            instrs: level.instrs,
            inside,
        }
    }
}

impl BlockTable {
    /// With the blocks of a plan, which have slots in its order, from [`FAR_SLOTS`](super::FAR_SLOTS) on.
    pub fn of(layout: &BrickLayout, plan: &BlockPlan) -> Self {
        let [low, high] = layout.block_range();
        let blocks = plan.blocks.iter();
        let (first, last) = blocks.fold((low, high), |(a, b), (block, _)| {
            (a.min(*block), b.max(*block + 1))
        });
        let mut table = Self::new(first, last);
        for &[low, high] in &plan.inside {
            table.set_far(low, high, true);
        }
        for (block, _) in &plan.blocks {
            table.insert(*block);
        }
        table
    }
}

/// The blocks that are looked at, from one to before another. A cut box is that. Otherwise what is near to the surface is found
/// wherever it is: as far from the box as cells tell. What is farther away is far from the surface, whatever distances are there.
pub(super) fn searched(layout: &BrickLayout) -> [IVec3; 2] {
    if layout.lattice.is_cut {
        return layout.block_range();
    }
    let region = layout.region();
    let reach = layout.far_length() + layout.half_diagonal(4);
    let grown = region.grown(reach);
    let side = IVec3::splat(BLOCK_SIDE as i32);
    [
        layout.cell_of(grown.min).div_euclid(side),
        layout.cell_of(grown.max).div_euclid(side) + 1,
    ]
}

/// The 64 parts of `side` blocks in a part, each with its own list, and those that are far inside.
fn cut(
    layout: &BrickLayout,
    bounds: &Bounds<'_>,
    block: IVec3,
    (side, [low, high]): (i32, [IVec3; 2]),
    instrs: &[Instr],
    pruner: &mut Pruner<'_>,
) -> Level {
    let blocks: Vec<IVec3> = (0..CELLS)
        .map(|i| block + side * super::inner_cell(i))
        .filter(|&b| b.cmplt(high).all() && (b + side).cmpgt(low).all())
        .collect();
    let cells = side as u32 * BLOCK_SIDE;
    let centers: Vec<Vec3> = blocks
        .iter()
        .map(|&b| layout.middle(b * BLOCK_SIDE as i32, cells))
        .collect();
    let mut d = [0.0; CELLS];
    let d = &mut d[..blocks.len()];
    let radius = layout.half_diagonal(cells);
    let half = 0.5 * layout.cell_length() * cells as f32;
    pruner.mark(instrs, &centers, radius, d);
    let mut level = Level::default();
    for (i, (&block, &d)) in blocks.iter().zip(d.iter()).enumerate() {
        if bounds.about(centers[i], half).is_far(d, radius) {
            if d < 0.0 {
                level.inside.push(block);
            }
            continue;
        }
        let from = level.instrs.len();
        pruner.list(instrs, i, &mut level.instrs);
        level.parts.push((block, from..level.instrs.len()));
    }
    level
}
