//! Which blocks a field needs, each with the list of what can matter in it.
//!
//! *Practice.* A cube around the box is cut into 4³ parts, those into 4³ again, down to blocks; each part has its own list. The
//! 64 parts of a part are measured in one run of the interpreter. A part all of which is farther from the surface than cells
//! tell has no blocks, and is not cut further.

use super::build::Bounds;
use super::layout::{BLOCK_SIDE, BrickLayout};
use super::table::BlockTable;
use argil_abi::Instr;
use argil_field::{CELLS, OperandIndex, Parts, Program, Pruner};
use argil_math::Control;
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

/// From so many operands on, parts begin with lists of what is near them.
const MANY_OPERANDS: usize = 2048;
/// Blocks along the side of such a part, and most of those parts.
const PART_SIDE: i32 = 4;
const MOST_PARTS: f32 = 1e6;

impl Level {
    /// Parts of `side` blocks that were cut out of others, as one level.
    fn joined(
        all: Vec<Self>,
        (side, [low, high]): (i32, [IVec3; 2]),
        inside: &mut Vec<[IVec3; 2]>,
    ) -> Self {
        let mut joined = Self::default();
        for part in all {
            let from = joined.instrs.len();
            joined.instrs.extend_from_slice(&part.instrs);
            let moved = |r: Range<usize>| from + r.start..from + r.end;
            let own = part.parts.into_iter();
            joined.parts.extend(own.map(|(block, r)| (block, moved(r))));
            let own = part.inside.iter();
            inside.extend(own.map(|&at| [at.max(low), (at + side).min(high)]));
        }
        joined
    }

    /// What is cut into blocks.
    fn finished(mut self, inside: Vec<[IVec3; 2]>) -> BlockPlan {
        self.parts
            .sort_by_key(|(block, _)| [block.z, block.y, block.x]);
        BlockPlan {
            blocks: self.parts,
            instrs: self.instrs,
            inside,
        }
    }
}

impl BlockPlan {
    /// Of a program, on rayon's current threads.
    pub fn of(program: &Program, layout: &BrickLayout) -> Self {
        Self::controlled(program, layout, &Control::default())
    }

    /// The same; of no use if it is cancelled.
    pub(super) fn controlled(program: &Program, layout: &BrickLayout, control: &Control) -> Self {
        let bounds = Bounds::new(program, layout);
        let [low, high] = searched(layout);
        if let Some(plan) = Self::by_operands(program, layout, &bounds, [low, high], control) {
            return plan;
        }
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
                        if control.is_cancelled() {
                            return Level::default();
                        }
                        let instrs = &level.instrs[range.clone()];
                        cut(layout, &bounds, *block, (side, [low, high]), instrs, pruner)
                    },
                )
                .collect();
            level = Level::joined(parts, (side, [low, high]), &mut inside);
        }
        level.finished(inside)
    }

    /// Of many operands: parts begin small, each with a list of what is near it.
    fn by_operands(
        program: &Program,
        layout: &BrickLayout,
        bounds: &Bounds<'_>,
        [low, high]: [IVec3; 2],
        control: &Control,
    ) -> Option<Self> {
        let side = IVec3::splat(PART_SIDE);
        let [first, last] = [low, high - 1].map(|block| block.div_euclid(side));
        let count = (last - first + 1).as_vec3().element_product();
        if program.operand_count() < MANY_OPERANDS || count > MOST_PARTS {
            return None;
        }
        let parts = Parts {
            edge: (PART_SIDE as u32 * BLOCK_SIDE) as f32 * layout.cell_length(),
            ..layout.parts(program)
        };
        let index = OperandIndex::new(program, parts)?;
        let places: Vec<IVec3> = super::table::places(first, last).collect();
        control.begin("parts", places.len() as u64);
        let parts: Vec<Level> = places
            .par_iter()
            .map_init(
                || (Pruner::new(program), Vec::new()),
                |(pruner, list), &place| {
                    list.clear();
                    index.list(program, place, list);
                    control.advance(1);
                    if list.is_empty() || control.is_cancelled() {
                        return Level::default();
                    }
                    let block = place * PART_SIDE;
                    cut(layout, bounds, block, (1, [low, high]), list, pruner)
                },
            )
            .collect();
        let mut inside = Vec::new();
        let level = Level::joined(parts, (1, [low, high]), &mut inside);
        Some(level.finished(inside))
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
