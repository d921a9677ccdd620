//! Baking bricks on the CPU.
//!
//! *Practice.* The plan tells which blocks there are, each with its list (`plan.rs`). The 64 cells of a block are measured in one
//! run of the interpreter. In those where the surface can be, the samples are evaluated, brick by brick, straight into the pool.

use super::Bricks;
use super::cell_lists::CellLists;
use super::filler::{Filler, Places};
use super::inner_cell;
use super::layout::{BrickLayout, BricksError};
use super::material::PLACES;
use super::plan::BlockPlan;
use super::pool::owners_of_mixed;
use super::table::{BlockTable, FAR_SLOTS, far_words};
use super::words::{Word, empty_word, lonely_word};
use crate::{Bits, Texel, Texels};
use argil_abi::{BRICK_MIXED, Instr};
use argil_field::{CELLS, ClearTerms, NearJumps, Program, Pruner};
use argil_math::{Aabb, Control};
use glam::{IVec3, Vec3};
use rayon::prelude::*;
use std::ops::Range;
use web_time::Instant;

/// What the stages of a build took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BrickStagesMs {
    /// Pruning, and choosing cells.
    pub prune: f64,
    /// Sampling bricks.
    pub fill: f64,
    /// Closing the gaps of bricks that were dropped again, and marking what is empty.
    pub settle: f64,
}

/// Cells of a block in which the surface can be, each with its stretch of a list.
#[derive(Default)]
pub(super) struct Candidates {
    pub slot: usize,
    pub cells: Vec<(u8, Range<usize>)>,
    pub instrs: Vec<Instr>,
}

/// What of distances can be relied on.
#[derive(Clone, Copy)]
pub(super) struct Bounds<'a> {
    program: &'a Program,
    terms: ClearTerms,
    jumps: NearJumps,
    base: f32,
    lipschitz: f32,
    /// The greatest distance that a cell keeps.
    far: f32,
}

impl<'a> Bounds<'a> {
    /// Near the origin, where nothing jumps.
    pub fn new(program: &'a Program, layout: &BrickLayout) -> Self {
        Self {
            program,
            terms: program.clear_terms_about(layout.base_length()),
            jumps: NearJumps::NONE,
            base: layout.base_length(),
            lipschitz: program.lipschitz(),
            far: layout.far_length(),
        }
    }

    /// In a cube with a middle: of what those tell that are for the origin.
    pub fn about(&self, center: Vec3, half: f32) -> Self {
        let farthest = center.abs().max_element() + 3f32.sqrt() * half;
        let cube = Aabb::new(center - half, center + half);
        Self {
            terms: self.terms.at(self.base, farthest),
            jumps: self.program.jumps_near(cube, self.far),
            ..*self
        }
    }

    /// Of a block with a first cell.
    pub fn of_block(&self, layout: &BrickLayout, first: IVec3) -> Self {
        let center = layout.middle(first, super::BLOCK_SIDE);
        self.about(
            center,
            0.5 * layout.cell_length() * super::BLOCK_SIDE as f32,
        )
    }

    /// For shaders, where a list gives the distances: what rounding adds to them, how far away what jumps is, and how it does;
    /// then by how much the list can jump.
    fn words(&self, instrs: &[Instr]) -> [f32; BLOCK_WORDS] {
        let jumps = &self.jumps;
        [
            self.terms.slack,
            jumps.gap,
            jumps.slack,
            jumps.hidden,
            jumps.isolation,
            self.program.jump_of(instrs),
        ]
    }

    /// Whether there is no surface within `radius`, as far as that is within the cube.
    pub fn is_clear(&self, d: f32, radius: f32) -> bool {
        let terms = if self.jumps.gap > 0.0 {
            self.terms
        } else {
            self.terms.with(&self.jumps)
        };
        // Lists of edits do not tell what is farther.
        terms.radius(d.abs().min(self.far)) > radius
    }

    /// Whether it is only for what jumps that it is not [clear](Self::is_clear).
    fn is_doubtful(&self, d: f32, radius: f32) -> bool {
        self.jumps.gap <= 0.0 && self.terms.radius(d.abs().min(self.far)) > radius
    }

    /// Whether all of the cube, which is within `radius`, is farther from the surface than cells tell.
    pub fn is_far(&self, d: f32, radius: f32) -> bool {
        self.is_steady() && (self.terms.radius(d) - 1.000_01 * radius) * self.lipschitz >= self.far
    }

    /// The greatest length of a distance that is not [clear](Self::is_clear), where nothing jumps.
    pub fn unclear_length(&self, radius: f32) -> f32 {
        1.000_01 * (radius * self.terms.steepness + self.terms.slack)
    }

    /// The length up to which distances at cells' centres decide what their bricks hold, where nothing jumps: those of the others
    /// are clear of the surface, or stored as the end of the range. Materials count nearer to the surface only.
    pub fn near_length(&self, layout: &BrickLayout) -> f32 {
        let range = layout.encoding.range_length(&layout.lattice, 0);
        self.unclear_length(layout.half_diagonal(1)).max(range)
    }

    /// Whether nothing jumps as far away as cells tell.
    pub fn is_steady(&self) -> bool {
        self.jumps.gap == f32::MAX
    }

    /// The lengths that a distance can have of which a cell [keeps](Self::center) so much, where nothing jumps.
    pub fn lengths(&self, center: f32) -> [f32; 2] {
        let least = center.abs().min(self.far);
        if least > 0.999 * self.far {
            return [least, f32::MAX];
        }
        let steepness = self.terms.steepness / self.lipschitz;
        [least, 1.000_01 * (least * steepness + self.terms.slack)]
    }

    /// What a cell keeps whose centre is so far.
    pub fn center(&self, d: f32) -> f32 {
        let plain = self.terms.radius(d);
        let clear = if self.is_steady() {
            plain
        } else {
            let jumping = self.terms.with(&self.jumps);
            plain.min(jumping.radius(d.abs().min(self.far)).max(self.jumps.gap))
        };
        let left = (clear * self.lipschitz).clamp(0.0, self.far);
        if d < 0.0 { -left } else { left }
    }
}

/// Words that shaders need of a block besides its list.
pub const BLOCK_WORDS: usize = 6;

impl BrickLayout {
    /// What shaders need of a block with a first cell, besides its list.
    pub fn block_words(
        &self,
        program: &Program,
        first: IVec3,
        instrs: &[Instr],
    ) -> [f32; BLOCK_WORDS] {
        Bounds::new(program, self)
            .of_block(self, first)
            .words(instrs)
    }
}

/// Bytes that a slot takes: its words, its mask, and which block it has.
pub(super) const SLOT_BYTES: u64 = 64 * 4 + 8 + 12;

pub(super) fn bake(
    program: &Program,
    layout: BrickLayout,
    budget: Option<u64>,
    control: &Control,
) -> Result<(Bricks, CellLists, BrickStagesMs), BricksError> {
    let start = Instant::now();
    let refuse = |bricks: usize, needed: u64| match budget {
        Some(budget) if needed > budget => Err(BricksError::Budget {
            bricks: bricks as u64,
            needed,
            budget,
        }),
        _ => Ok(()),
    };
    let bounds = Bounds::new(program, &layout);
    let plan = BlockPlan::of(program, &layout, budget, control)?;
    check(control)?;
    let slots = u64::from(FAR_SLOTS) + plan.blocks.len() as u64;
    refuse(0, SLOT_BYTES * slots)?;
    let table = BlockTable::of(&layout, &plan);
    let tables = table.memory_bytes() + (SLOT_BYTES - 12) * slots;

    control.begin("blocks", plan.blocks.len() as u64);
    let (candidates, mut words) = candidates(program, &layout, &bounds, &plan, control);
    check(control)?;
    drop(plan);
    let count: usize = candidates.iter().map(|c| c.cells.len()).sum();
    let needed = tables + count as u64 * (layout.brick_bytes() + 8);
    refuse(count, needed)?;
    layout.check_count(count as u64)?;
    let pruned = start.elapsed();
    // Fill, drop, close the gaps.
    control.begin("bricks", count as u64);
    let (filled, at) = match layout.encoding.bits {
        Bits::Eight => fill::<i8>(
            program,
            &layout,
            &bounds,
            (&candidates, &table, control),
            count,
            &mut words,
        ),
        Bits::Sixteen => fill::<i16>(
            program,
            &layout,
            &bounds,
            (&candidates, &table, control),
            count,
            &mut words,
        ),
    };
    check(control)?;
    let masks: Vec<u64> = words
        .par_chunks_mut(64)
        .with_min_len(256)
        .map(settle)
        .collect();
    let ms = |d: std::time::Duration| d.as_secs_f64() * 1e3;
    let stages = BrickStagesMs {
        prune: ms(pruned),
        fill: ms(at.duration_since(start) - pruned),
        settle: ms(at.elapsed()),
    };
    let bricks = Bricks {
        layout,
        lipschitz: program.lipschitz(),
        table: table.clone(),
        masks,
        words,
        owners: filled.owners,
        mixed_owners: owners_of_mixed(&filled.materials, &filled.mixed),
        changes: Default::default(),
        materials: filled.materials,
        mixed: filled.mixed,
        pool: filled.pool,
    };
    // How many bricks are mixed was not known before.
    refuse(bricks.len(), bricks.memory_bytes())?;
    Ok((bricks, CellLists::new(layout, table, candidates), stages))
}

fn check(control: &Control) -> Result<(), BricksError> {
    if control.is_cancelled() {
        Err(BricksError::Cancelled)
    } else {
        Ok(())
    }
}

/// The cells in which the surface can be, each with its list, and the words of all slots.
pub(super) fn candidates(
    program: &Program,
    layout: &BrickLayout,
    bounds: &Bounds<'_>,
    plan: &BlockPlan,
    control: &Control,
) -> (Vec<Candidates>, Vec<u32>) {
    let mut words = far_words(layout.far_length());
    let first_slot = words.len() / CELLS;
    words.resize(words.len() + CELLS * plan.blocks.len(), 0);
    let candidates = words[first_slot * CELLS..]
        .par_chunks_mut(CELLS)
        .zip(&plan.blocks)
        .enumerate()
        .with_min_len(8)
        .map_init(
            || Pruner::new(program),
            |pruner, (at, (words, (block, range)))| {
                control.advance(1);
                if control.is_cancelled() {
                    return Candidates::default();
                }
                let first = *block * super::BLOCK_SIDE as i32;
                let bounds = bounds.of_block(layout, first);
                let instrs = &plan.instrs[range.clone()];
                let mut found = near_block(
                    layout,
                    &bounds,
                    first,
                    (instrs, u64::MAX),
                    pruner,
                    words,
                    |_| u64::MAX,
                );
                found.slot = first_slot + at;
                found
            },
        )
        .filter(|c| !c.cells.is_empty())
        .collect();
    (candidates, words)
}

/// A block's mask; its words say whether it is empty.
pub(super) fn settle(words: &mut [u32]) -> u64 {
    let mut mask = 0u64;
    for (i, &word) in words.iter().enumerate() {
        mask |= u64::from(matches!(Word::of(word), Word::Brick(_))) << i;
    }
    if mask == 0 {
        words.iter_mut().for_each(|word| *word = lonely_word(*word));
    }
    mask
}

/// Measure some of a block's cells: the words of those that are empty, and the others with their lists, of the cells that are
/// wanted once the pruner has marked them, in their order.
pub(super) fn near_block(
    layout: &BrickLayout,
    bounds: &Bounds<'_>,
    first: IVec3,
    (instrs, some): (&[Instr], u64),
    pruner: &mut Pruner<'_>,
    words: &mut [u32],
    wanted: impl FnOnce(&Pruner<'_>) -> u64,
) -> Candidates {
    let cell = |i: usize| first + inner_cell(i);
    let mut cells = [0; CELLS];
    let count = some.count_ones() as usize;
    let all = (0..CELLS).filter(|i| some >> i & 1 != 0);
    cells.iter_mut().zip(all).for_each(|(own, i)| *own = i);
    let centers: [Vec3; CELLS] = std::array::from_fn(|nth| layout.middle(cell(cells[nth]), 1));
    let mut d = [0.0; CELLS];
    let radius = layout.half_diagonal(1);
    pruner.mark(instrs, &centers[..count], radius, &mut d[..count]);
    let wanted = wanted(pruner);
    let mut found = Candidates::default();
    let mut doubtful = 0u64;
    for (nth, (&i, &d)) in cells.iter().zip(&d).enumerate().take(count) {
        // Of a candidate, what stays if its brick is dropped.
        words[i] = empty_word(bounds.center(d));
        if bounds.is_clear(d, radius) {
            continue;
        }
        if wanted >> nth & 1 != 0 && layout.may_hold(cell(i)) {
            let from = found.instrs.len();
            pruner.list(instrs, nth, &mut found.instrs);
            found.cells.push((i as u8, from..found.instrs.len()));
            doubtful |= u64::from(bounds.is_doubtful(d, radius)) << i;
        }
    }
    if doubtful != 0 {
        // The marks of all cells are needed still.
        let mut pruner = Pruner::new(bounds.program);
        let Candidates { cells, instrs, .. } = &mut found;
        cells.retain(|(i, range)| {
            let list = &instrs[range.clone()];
            doubtful >> i & 1 == 0
                || !is_clear_in_parts(layout, bounds, cell(usize::from(*i)), list, &mut pruner)
        });
    }
    found
}

/// Parts of a cell along each axis that are measured where something jumps: a long way from the surface that is, and farther than
/// copies are isolated.
const PARTS: i32 = 4;

/// Whether no part of a cell has a surface, by its list.
fn is_clear_in_parts(
    layout: &BrickLayout,
    bounds: &Bounds<'_>,
    cell: IVec3,
    instrs: &[Instr],
    pruner: &mut Pruner<'_>,
) -> bool {
    let edge = layout.cell_length();
    let corner = layout.lattice.corner + cell.as_vec3() * edge;
    let centers: [Vec3; CELLS] =
        std::array::from_fn(|i| corner + (inner_cell(i).as_vec3() + 0.5) * (edge / PARTS as f32));
    let radius = layout.half_diagonal(1) / PARTS as f32;
    let mut d = [0.0; CELLS];
    pruner.mark(instrs, &centers, radius, &mut d);
    d.iter().all(|&d| bounds.is_clear(d, radius))
}

/// Sample all candidates' bricks; those in which no surface can be leave a distance in their cell.
fn fill<T: Texel>(
    program: &Program,
    layout: &BrickLayout,
    bounds: &Bounds<'_>,
    (candidates, table, control): (&[Candidates], &BlockTable, &Control),
    count: usize,
    words: &mut [u32],
) -> (Filled, Instant) {
    let samples = layout.brick_samples() as usize;
    let fill = layout.encoding.fill(program, &layout.lattice, 0);
    let mut pool = vec![T::default(); count.max(1) * samples];
    let mut owners = vec![0u32; count];
    let mut materials = vec![0u32; count];

    // Each block's own parts of the pool and of the words.
    let (mut pool_left, mut words_left, mut done) = (&mut pool[..], &mut *words, 0);
    let mut owners_left = &mut owners[..];
    let mut materials_left = &mut materials[..];
    let mut brick = 0u32;
    let mut jobs = Vec::with_capacity(candidates.len());
    for found in candidates {
        let n = found.cells.len();
        let (own_pool, rest) = pool_left.split_at_mut(n * samples);
        pool_left = rest;
        let (own_owners, rest) = owners_left.split_at_mut(n);
        owners_left = rest;
        let (own_materials, rest) = materials_left.split_at_mut(n);
        materials_left = rest;
        let (_, rest) = words_left.split_at_mut((found.slot - done) * 64);
        let (own_words, rest) = rest.split_at_mut(64);
        (words_left, done) = (rest, found.slot + 1);
        jobs.push((
            found,
            brick,
            own_pool,
            (own_owners, own_materials),
            own_words,
        ));
        brick += n as u32;
    }
    let places = Places::new(layout);
    let mixed: Vec<Vec<[u32; 2]>> = jobs
        .into_par_iter()
        .map_init(
            || Filler::new(program, layout, &fill, &places),
            |filler, (found, first, pool, (owners, materials), words)| {
                let mut mixed = Vec::new();
                control.advance(found.cells.len() as u64);
                if control.is_cancelled() {
                    return mixed;
                }
                let corner = table.cell(found.slot);
                let bounds = bounds.of_block(layout, corner);
                let bricks = pool.chunks_exact_mut(samples).zip(owners).zip(materials);
                for ((k, (inner, range)), ((out, owner), material)) in
                    (0..).zip(&found.cells).zip(bricks)
                {
                    let cell = corner + inner_cell(usize::from(*inner));
                    let least = filler.brick(&found.instrs[range.clone()], cell, out);
                    // Half of a voxel's diagonal from a sample at most.
                    let reach = 0.5 * 3f32.sqrt() * layout.lattice.voxel;
                    *owner = u32::MAX;
                    if !bounds.is_clear(least, reach) {
                        *owner = (found.slot * 64) as u32 + u32::from(*inner);
                        words[usize::from(*inner)] = first + k;
                        *material = filler.material(&found.instrs[range.clone()], cell, &mut mixed);
                    }
                }
                mixed
            },
        )
        .collect();

    // Each block of cells has counted its mixed bricks from 0.
    let (mut brick, mut before) = (0, 0);
    for (found, own) in candidates.iter().zip(&mixed) {
        for material in &mut materials[brick..brick + found.cells.len()] {
            if *material & BRICK_MIXED != 0 {
                *material += before;
            }
        }
        brick += found.cells.len();
        before += (own.len() / PLACES) as u32;
    }
    let at = Instant::now();
    close_gaps(&mut pool, &mut owners, &mut materials, samples, words);
    let filled = Filled {
        pool: Texels::from_vec(pool),
        owners,
        materials,
        mixed: mixed.concat(),
    };
    (filled, at)
}

/// Bricks as they were filled.
struct Filled {
    pool: Texels,
    owners: Vec<u32>,
    materials: Vec<u32>,
    mixed: Vec<[u32; 2]>,
}

/// Move the last bricks into the places of those that were dropped.
fn close_gaps<T: Texel>(
    pool: &mut Vec<T>,
    owners: &mut Vec<u32>,
    materials: &mut Vec<u32>,
    samples: usize,
    words: &mut [u32],
) {
    let mut gap = 0;
    while gap < owners.len() {
        if owners[gap] != u32::MAX {
            gap += 1;
            continue;
        }
        let last = owners.len() - 1;
        if last > gap && owners[last] != u32::MAX {
            pool.copy_within(last * samples..(last + 1) * samples, gap * samples);
            owners[gap] = owners[last];
            materials[gap] = materials[last];
            words[owners[gap] as usize] = gap as u32;
            gap += 1;
        }
        owners.truncate(last);
    }
    pool.truncate(owners.len().max(1) * samples);
    pool.shrink_to_fit();
    owners.shrink_to_fit();
    materials.truncate(owners.len());
    materials.shrink_to_fit();
}
