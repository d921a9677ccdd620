//! Plans the blocks that a field needs, each with its pruned program.
//!
//! *Practice.* A cube around the box is cut into 4³ parts, those into 4³ again, down to blocks. Each part has its
//! own program. One run of the interpreter measures the 64 parts of a part. A part that is farther from the surface
//! than cells store needs no blocks, and is not cut further.
//!
//! A long program that a part does not shorten to half is shared, and not copied. With many operands, a grid finds what can matter in each block. A block whose cells are all near the surface
//! gets a program for such small distances, which is several times shorter.

use super::bounds::{CellBounds, SLOT_BYTES};
use super::layout::{BLOCK_SIDE, BrickLayout, BricksError};
use super::table::{BlockTable, FAR_SLOTS};
use argil_abi::Instruction;
use argil_field::{CELLS_PER_BATCH, Evaluator, OperandIndex, PartGrid, Program, Pruner};
use argil_math::Control;
use glam::{IVec3, Vec3};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

/// The blocks that a field needs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BlockPlan {
    /// The blocks, z slowest, each with its range of the instructions.
    pub blocks: Vec<(IVec3, Range<usize>)>,
    /// The programs.
    pub instructions: Vec<Instruction>,
    /// Boxes of blocks that are far inside the solid, from one block to before another.
    pub inside: Vec<[IVec3; 2]>,
}

/// Maximum blocks: 32 bits number the words of their cells.
const MAX_BLOCKS: u64 = (1 << 32) / CELLS_PER_BATCH as u64 - FAR_SLOTS as u64;

/// Counts the parts of one size near the surface. There are about sixteen times as many of the next size, so too
/// many of these mean too many blocks.
struct BlockCount {
    most: u64,
    found: AtomicU64,
}

impl BlockCount {
    /// Starts to count parts of another size.
    fn begin(&self) {
        if !self.is_too_much() {
            self.found.store(0, Ordering::Relaxed);
        }
    }

    fn add(&self, parts: usize) {
        self.found.fetch_add(parts as u64, Ordering::Relaxed);
    }

    fn is_too_much(&self) -> bool {
        self.found.load(Ordering::Relaxed) > self.most
    }
}

/// Parts of one size, each with a program.
#[derive(Default)]
struct PlanLevel {
    instructions: Vec<Instruction>,
    parts: Vec<(IVec3, Range<usize>)>,
    /// Parts with programs of the level that these parts were cut out of.
    shared: Vec<(IVec3, Range<usize>)>,
    inside: Vec<IVec3>,
}

/// A program of more instructions is copied for a part only if that shortens it to half.
pub(super) const LONG: usize = 1 << 15;

/// From this many operands on, blocks start with programs of what is near them.
const MANY_OPERANDS: usize = 2048;
/// Blocks along the side of such a part, and the maximum number of those parts.
const PART_SIDE: i32 = 4;
const MAX_PARTS: f32 = 1e6;
/// Maximum entries per operand if each block has its own list.
const MAX_ENTRIES: u64 = 40;

impl PlanLevel {
    /// Returns parts of `side` blocks that were cut out of others, as one level. `outer` returns the programs that they
    /// were cut out of.
    fn joined(
        all: Vec<Self>,
        (side, [low, high]): (i32, [IVec3; 2]),
        inside: &mut Vec<[IVec3; 2]>,
        outer: impl FnOnce() -> Vec<Instruction>,
    ) -> Self {
        let mut joined = Self::default();
        if all.iter().any(|part| !part.shared.is_empty()) {
            joined.instructions = outer();
        }
        let count = all.iter().map(|part| part.instructions.len()).sum();
        joined.instructions.reserve_exact(count);
        for part in all {
            joined.parts.extend(part.shared);
            let from = joined.instructions.len();
            joined.instructions.extend_from_slice(&part.instructions);
            let moved = |r: Range<usize>| from + r.start..from + r.end;
            let own = part.parts.into_iter();
            joined.parts.extend(own.map(|(block, r)| (block, moved(r))));
            let own = part.inside.iter();
            inside.extend(own.map(|&at| [at.max(low), (at + side).min(high)]));
        }
        joined
    }

    /// Returns the plan of a level of blocks.
    fn finished(mut self, inside: Vec<[IVec3; 2]>) -> BlockPlan {
        self.parts
            .sort_by_key(|(block, _)| [block.z, block.y, block.x]);
        BlockPlan {
            blocks: self.parts,
            instructions: self.instructions,
            inside,
        }
    }
}

impl BlockPlan {
    /// Plans the blocks of a program, on rayon's current threads. The result is useless if the work was canceled.
    ///
    /// # Errors
    /// If the blocks alone exceed `budget` bytes, or are too many to number. That is detected early.
    pub fn of(
        program: &Program,
        layout: &BrickLayout,
        budget: Option<u64>,
        control: &Control,
    ) -> Result<Self, BricksError> {
        let most = MAX_BLOCKS.min(budget.map_or(MAX_BLOCKS, |budget| budget / SLOT_BYTES));
        let count = BlockCount {
            most,
            found: AtomicU64::new(0),
        };
        let plan = Self::counted(program, layout, &count, control);
        let blocks = count.found.into_inner();
        if blocks > most && !control.is_cancelled() {
            return Err(BricksError::Blocks {
                blocks,
                needed: SLOT_BYTES * blocks,
                budget: SLOT_BYTES * most,
            });
        }
        Ok(plan)
    }

    fn counted(
        program: &Program,
        layout: &BrickLayout,
        count: &BlockCount,
        control: &Control,
    ) -> Self {
        let bounds = CellBounds::new(program, layout);
        let [low, high] = searched(layout);
        if let Some(plan) =
            Self::by_operands(program, layout, &bounds, [low, high], (count, control))
        {
            return plan;
        }
        let extent = (high - low).max_element();
        // In blocks.
        let mut side = 1;
        while side < extent {
            side *= 4;
        }
        // Parts have the same positions as in an edit, so that a cell's program is the same.
        let all = 0..program.instructions().len();
        let (first, last) = (
            low.div_euclid(IVec3::splat(side)),
            (high - 1).div_euclid(IVec3::splat(side)),
        );
        let mut level = PlanLevel {
            instructions: program.instructions().to_vec(),
            parts: super::table::places(first, last)
                .map(|place| (place * side, all.clone()))
                .collect(),
            ..PlanLevel::default()
        };
        let mut inside = Vec::new();
        let mut is_cut = false;
        while side > 1 || !is_cut {
            side = (side / 4).max(1);
            is_cut = true;
            control.begin("parts", level.parts.len() as u64);
            count.begin();
            let parts: Vec<PlanLevel> = level
                .parts
                .par_iter()
                .map_init(
                    || Pruner::new(program),
                    |pruner, (block, range)| {
                        if control.is_cancelled() || count.is_too_much() {
                            return PlanLevel::default();
                        }
                        let instructions = &level.instructions[range.clone()];
                        let blocks = parts_of(*block, (side, [low, high]));
                        let mut own = PlanLevel::default();
                        let list = (instructions, range);
                        own.cut(layout, &bounds, &blocks, side, list, pruner);
                        count.add(own.parts.len() + own.shared.len());
                        control.advance(1);
                        own
                    },
                )
                .collect();
            let outer = || std::mem::take(&mut level.instructions);
            level = PlanLevel::joined(parts, (side, [low, high]), &mut inside, outer);
        }
        level.finished(inside)
    }

    /// Plans many operands: blocks start with programs of what is near them.
    fn by_operands(
        program: &Program,
        layout: &BrickLayout,
        bounds: &CellBounds<'_>,
        [low, high]: [IVec3; 2],
        (block_count, control): (&BlockCount, &Control),
    ) -> Option<Self> {
        let side = IVec3::splat(PART_SIDE);
        let [first, last] = [low, high - 1].map(|block| block.div_euclid(side));
        let count = (last - first + 1).as_vec3().element_product();
        if program.operand_count() < MANY_OPERANDS || count > MAX_PARTS {
            return None;
        }
        let parts = layout.parts(program);
        let edge = BLOCK_SIDE as f32 * layout.cell_length();
        let of_parts = PartGrid {
            edge: PART_SIDE as f32 * edge,
            ..parts
        };
        let index = OperandIndex::new(program, of_parts)?;
        let near_parts = PartGrid {
            // Far from the origin, rounding adds a little.
            far: 1.01 * bounds.near_length(layout),
            ..parts
        };
        let (far, near) = rayon::join(
            || BlockIndex::new(program, parts, edge),
            || BlockIndex::new(program, near_parts, edge),
        );
        let blocks = BlockLists {
            program,
            layout,
            bounds,
            far: far?,
            near: near?,
        };
        let places: Vec<IVec3> = super::table::places(first, last).collect();
        control.begin("parts", places.len() as u64);
        block_count.begin();
        let parts: Vec<PlanLevel> = places
            .par_iter()
            .map_init(
                || (Pruner::new(program), Evaluator::new(program), Vec::new()),
                |(pruner, evaluator, list), &place| {
                    let mut level = PlanLevel::default();
                    control.advance(1);
                    if index.is_empty(place) {
                        return level;
                    }
                    for block in parts_of(place * PART_SIDE, (1, [low, high])) {
                        if control.is_cancelled() || block_count.is_too_much() {
                            return PlanLevel::default();
                        }
                        if !blocks.near(block, evaluator, &mut level) {
                            list.clear();
                            blocks.far.append(program, block, list);
                            let list = (&list[..], &(0..program.instructions().len()));
                            level.cut(layout, bounds, &[block], 1, list, pruner);
                        }
                    }
                    block_count.add(level.parts.len() + level.shared.len());
                    level
                },
            )
            .collect();
        // They take as much memory as the programs.
        drop((index, blocks));
        let mut inside = Vec::new();
        let outer = || program.instructions().to_vec();
        let level = PlanLevel::joined(parts, (1, [low, high]), &mut inside, outer);
        Some(level.finished(inside))
    }
}

impl BlockTable {
    /// Creates the table of a plan's blocks. Their slots follow its order, from [`FAR_SLOTS`] on.
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

/// Returns the range of blocks to examine. For a clipping box, it is the box. Otherwise, blocks near the surface
/// are found as far from the box as cells store distances. What lies farther away is far from the surface.
pub(super) fn searched(layout: &BrickLayout) -> [IVec3; 2] {
    if layout.voxel_grid.is_clipped {
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

/// Returns the parts of `side` blocks in a part, within the examined range.
fn parts_of(block: IVec3, (side, [low, high]): (i32, [IVec3; 2])) -> Vec<IVec3> {
    (0..CELLS_PER_BATCH)
        .map(|i| block + side * super::inner_cell(i))
        .filter(|&b| b.cmplt(high).all() && (b + side).cmpgt(low).all())
        .collect()
}

impl PlanLevel {
    /// Adds parts of `side` blocks that share a program, each with its pruned program, and those far inside the
    /// solid. `outer` is the range of a program of the level before that gives the same distances.
    fn cut(
        &mut self,
        layout: &BrickLayout,
        bounds: &CellBounds<'_>,
        blocks: &[IVec3],
        side: i32,
        (instructions, outer): (&[Instruction], &Range<usize>),
        pruner: &mut Pruner<'_>,
    ) {
        let cells = side as u32 * BLOCK_SIDE;
        let centers: Vec<Vec3> = blocks
            .iter()
            .map(|&b| layout.center(b * BLOCK_SIDE as i32, cells))
            .collect();
        let mut d = [0.0; CELLS_PER_BATCH];
        let d = &mut d[..blocks.len()];
        let radius = layout.half_diagonal(cells);
        let half = 0.5 * layout.cell_length() * cells as f32;
        pruner.classify_cells(instructions, &centers, radius, d);
        for (i, (&block, &d)) in blocks.iter().zip(d.iter()).enumerate() {
            if bounds.about(centers[i], half).is_far(d, radius) {
                if d < 0.0 {
                    self.inside.push(block);
                }
                continue;
            }
            let from = self.instructions.len();
            pruner.prune_into(instructions, i, &mut self.instructions);
            self.add(block, from, outer);
        }
    }

    /// Adds a part whose program is at the end, from an instruction on. If that is hardly shorter than the program of the
    /// level before, the part shares that one.
    fn add(&mut self, part: IVec3, from: usize, outer: &Range<usize>) {
        let own = self.instructions.len() - from;
        if own > LONG && 2 * own > outer.len() {
            self.instructions.truncate(from);
            self.shared.push((part, outer.clone()));
        } else {
            self.parts.push((part, from..self.instructions.len()));
        }
    }
}

/// Programs of blocks with many operands.
struct BlockLists<'a> {
    program: &'a Program,
    layout: &'a BrickLayout,
    bounds: &'a CellBounds<'a>,
    /// What can matter for the distances that cells store.
    far: BlockIndex,
    /// What can matter for the distances that determine bricks.
    near: BlockIndex,
}

/// An index with parts of a number of blocks along a side.
struct BlockIndex {
    index: OperandIndex,
    side: i32,
}

impl BlockIndex {
    /// Creates an index of single blocks, unless operands are so large that they would be in too many.
    fn new(program: &Program, parts: PartGrid, edge: f32) -> Option<Self> {
        let most = MAX_ENTRIES * program.operand_count() as u64;
        let of_side = |side: i32| PartGrid {
            edge: side as f32 * edge,
            ..parts
        };
        let mut sides = [1, 2].into_iter();
        let side = sides.find(|&side| OperandIndex::entries(program, of_side(side)) <= most);
        let side = side.unwrap_or(PART_SIDE);
        let index = OperandIndex::new(program, of_side(side))?;
        Some(Self { index, side })
    }

    /// Appends what can matter in a block.
    fn append(&self, program: &Program, block: IVec3, out: &mut Vec<Instruction>) {
        let part = block.div_euclid(IVec3::splat(self.side));
        self.index.part_program(program, part, out);
    }
}

impl BlockLists<'_> {
    /// Adds a block whose cells are all near the surface, with what is near enough to determine its bricks. With
    /// many operands, that is far less.
    fn near(&self, block: IVec3, evaluator: &mut Evaluator<'_>, level: &mut PlanLevel) -> bool {
        let first = block * BLOCK_SIDE as i32;
        let bounds = self.bounds.of_block(self.layout, first);
        let far = self.near.index.parts().far;
        if !bounds.is_steady() || bounds.near_length(self.layout) > far {
            return false;
        }
        let from = level.instructions.len();
        self.near
            .append(self.program, block, &mut level.instructions);
        let [mut x, mut y, mut z, mut d] = [[0.0; CELLS_PER_BATCH]; 4];
        for i in 0..CELLS_PER_BATCH {
            let center = self.layout.center(first + super::inner_cell(i), 1);
            (x[i], y[i], z[i]) = (center.x, center.y, center.z);
        }
        evaluator.distances_with(&level.instructions[from..], &x, &y, &z, &mut d);
        // What is omitted is farther away, and changes none of these distances.
        let is_near = d.iter().all(|d| d.abs() <= far);
        if is_near {
            level.add(block, from, &(0..self.program.instructions().len()));
        } else {
            level.instructions.truncate(from);
        }
        is_near
    }
}
