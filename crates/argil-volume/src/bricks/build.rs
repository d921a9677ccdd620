//! Baking bricks on the CPU.
//!
//! *Practice.* The grid is cut into 4³ parts, those into 4³ again, down to cells; each part has its own list of what can
//! matter there. The 64 parts of a part are measured in one run of the interpreter. A part that is far is not cut
//! further: its cells' distances follow from the one at its centre. In cells where the surface can be, the samples are
//! evaluated, brick by brick, straight into the pool.

use super::Bricks;
use super::cell_lists::CellLists;
use super::filler::{Filler, Places};
use super::layout::{BLOCK_SIDE, BrickLayout, BricksError};
use super::material::PLACES;
use super::pool::owners_of_mixed;
use super::words::{Word, empty_word, lonely_word};
use crate::{Bits, Texel, Texels};
use argil_abi::{BRICK_MIXED, Instr};
use argil_field::{CELLS, ClearTerms, Program, Pruner};
use glam::{UVec3, Vec3, uvec3};
use rayon::prelude::*;
use std::ops::Range;
use web_time::Instant;

/// A part that is farther from the surface than this many of its half diagonals is not cut further.
const FAR_RADII: f32 = 4.0;

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

/// Cubes of cells with a list of instructions each.
#[derive(Default)]
struct Level {
    instrs: Vec<Instr>,
    parts: Vec<(UVec3, Range<usize>)>,
}

/// A part that is far: its first cell, its middle, and the distance there.
type Far = (UVec3, Vec3, f32);

/// Of a block: what its cells need.
enum Block {
    /// Far from the surface: the distance at the centre of a part that holds it.
    Far(Vec3, f32),
    /// The stretch of the last level's list.
    Near(Range<usize>),
}

/// Cells of a block in which the surface can be, each with its stretch of a list.
#[derive(Default)]
pub(super) struct Candidates {
    pub block: usize,
    pub cells: Vec<(u8, Range<usize>)>,
    pub instrs: Vec<Instr>,
}

/// What of distances can be relied on.
pub(super) struct Bounds {
    terms: ClearTerms,
    lipschitz: f32,
    /// The greatest distance that a cell keeps.
    far: f32,
}

impl Bounds {
    pub fn new(program: &Program, layout: &BrickLayout) -> Self {
        Self {
            terms: program.clear_terms(layout.region()),
            lipschitz: program.lipschitz(),
            far: layout.far_length(),
        }
    }

    /// Whether there is no surface within `radius`.
    pub fn is_clear(&self, d: f32, radius: f32) -> bool {
        self.terms.radius(d) > radius
    }

    /// What a cell keeps whose centre is so far, or `way` from a point that is.
    pub fn center(&self, d: f32, way: f32) -> f32 {
        let left = ((self.terms.radius(d) - way) * self.lipschitz).clamp(0.0, self.far);
        if d < 0.0 { -left } else { left }
    }
}

pub(super) fn bake(
    program: &Program,
    layout: BrickLayout,
    budget: Option<u64>,
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
    refuse(0, layout.table_bytes())?;
    let bounds = Bounds::new(program, &layout);

    let (candidates, mut words) = candidates(program, &layout, &bounds);
    let count: usize = candidates.iter().map(|c| c.cells.len()).sum();
    let needed = layout.table_bytes() + count as u64 * (layout.brick_bytes() + 8);
    refuse(count, needed)?;
    layout.check_count(count as u64)?;
    let pruned = start.elapsed();
    // Fill, drop, close the gaps.
    let (filled, at) = match layout.encoding.bits {
        Bits::Eight => fill::<i8>(program, &layout, &bounds, &candidates, count, &mut words),
        Bits::Sixteen => fill::<i16>(program, &layout, &bounds, &candidates, count, &mut words),
    };
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
        masks,
        words,
        owners: filled.owners,
        mixed_owners: owners_of_mixed(&filled.materials, &filled.mixed),
        materials: filled.materials,
        mixed: filled.mixed,
        pool: filled.pool,
    };
    // How many bricks are mixed was not known before.
    refuse(bricks.len(), bricks.memory_bytes())?;
    Ok((bricks, CellLists { layout, candidates }, stages))
}

/// The cells in which the surface can be, each with its list, and the words of those in which it cannot.
pub(super) fn candidates(
    program: &Program,
    layout: &BrickLayout,
    bounds: &Bounds,
) -> (Vec<Candidates>, Vec<u32>) {
    // Down to blocks, then to cells.
    let (level, blocks) = blocks_of(program, layout, bounds);
    let mut words = vec![0u32; layout.word_count() as usize];
    let candidates = words
        .par_chunks_mut(64)
        .zip(&blocks)
        .enumerate()
        .with_min_len(8)
        .map_init(
            || Pruner::new(program),
            |pruner, (at, (words, block))| {
                let first = layout.cell_at(at * 64);
                match block {
                    Block::Far(center, d) => {
                        far_block(layout, bounds, first, *center, *d, words);
                        Candidates::default()
                    }
                    Block::Near(range) => {
                        let instrs = &level.instrs[range.clone()];
                        let mut found = near_block(layout, bounds, first, instrs, pruner, words);
                        found.block = at;
                        found
                    }
                }
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

/// Cut the grid down to blocks. The blocks' lists are stretches of the level's.
fn blocks_of(program: &Program, layout: &BrickLayout, bounds: &Bounds) -> (Level, Vec<Block>) {
    let mut side = BLOCK_SIDE;
    while side < layout.grid.max_element() {
        side *= 4;
    }
    let everything = layout.middle(UVec3::ZERO, side);
    let mut blocks: Vec<Block> = Vec::new();
    blocks.resize_with(layout.block_count() as usize, || {
        Block::Far(everything, 0.0)
    });
    let mut level = Level {
        instrs: program.instrs().to_vec(),
        parts: vec![(UVec3::ZERO, 0..program.instrs().len())],
    };
    while side > BLOCK_SIDE {
        side /= 4;
        let parts: Vec<(Level, Vec<Far>)> = level
            .parts
            .par_iter()
            .map_init(
                || Pruner::new(program),
                |pruner, (cell, range)| {
                    let instrs = &level.instrs[range.clone()];
                    cut(layout, bounds, *cell, side, instrs, pruner)
                },
            )
            .collect();
        let mut next = Level::default();
        for (part, far) in parts {
            let from = next.instrs.len();
            next.instrs.extend_from_slice(&part.instrs);
            let moved = |r: Range<usize>| from + r.start..from + r.end;
            next.parts
                .extend(part.parts.into_iter().map(|(cell, r)| (cell, moved(r))));
            for (cell, center, d) in far {
                let (first, end) = (
                    cell / BLOCK_SIDE,
                    ((cell + side) / BLOCK_SIDE).min(layout.blocks),
                );
                for z in first.z..end.z {
                    for y in first.y..end.y {
                        for x in first.x..end.x {
                            let at = x + layout.blocks.x * (y + layout.blocks.y * z);
                            blocks[at as usize] = Block::Far(center, d);
                        }
                    }
                }
            }
        }
        level = next;
    }
    for (cell, range) in &level.parts {
        blocks[layout.word_index(*cell) / 64] = Block::Near(range.clone());
    }
    (level, blocks)
}

/// The 64 parts of `side` cells in a part, each with its own list, and those that are far.
fn cut(
    layout: &BrickLayout,
    bounds: &Bounds,
    cell: UVec3,
    side: u32,
    instrs: &[Instr],
    pruner: &mut Pruner<'_>,
) -> (Level, Vec<Far>) {
    let inner: Vec<UVec3> = (0..CELLS as u32)
        .map(|i| cell + side * uvec3(i % 4, i / 4 % 4, i / 16))
        .filter(|c| c.cmplt(layout.grid).all())
        .collect();
    let centers: Vec<Vec3> = inner.iter().map(|&c| layout.middle(c, side)).collect();
    let mut d = [0.0; CELLS];
    let d = &mut d[..inner.len()];
    let radius = layout.half_diagonal(side);
    pruner.mark(instrs, &centers, radius, d);
    let mut level = Level::default();
    let mut far = Vec::new();
    for (i, (&cell, &d)) in inner.iter().zip(d.iter()).enumerate() {
        if bounds.is_clear(d, FAR_RADII * radius) {
            far.push((cell, centers[i], d));
        } else {
            let from = level.instrs.len();
            pruner.list(instrs, i, &mut level.instrs);
            level.parts.push((cell, from..level.instrs.len()));
        }
    }
    (level, far)
}

/// The words of a block that is far, by what is known of a point.
fn far_block(
    layout: &BrickLayout,
    bounds: &Bounds,
    first: UVec3,
    center: Vec3,
    d: f32,
    words: &mut [u32],
) {
    for (i, word) in (0u32..).zip(words) {
        let cell = first + uvec3(i % 4, i / 4 % 4, i / 16);
        let way = layout.middle(cell, 1).distance(center);
        *word = empty_word(bounds.center(d, 1.000_01 * way));
    }
}

/// Measure a block's cells: the words of those that are empty, and the others.
pub(super) fn near_block(
    layout: &BrickLayout,
    bounds: &Bounds,
    first: UVec3,
    instrs: &[Instr],
    pruner: &mut Pruner<'_>,
    words: &mut [u32],
) -> Candidates {
    let cell = |i: usize| first + uvec3(i as u32 % 4, i as u32 / 4 % 4, i as u32 / 16);
    let centers: [Vec3; CELLS] = std::array::from_fn(|i| layout.middle(cell(i), 1));
    let mut d = [0.0; CELLS];
    let radius = layout.half_diagonal(1);
    pruner.mark(instrs, &centers, radius, &mut d);
    let mut found = Candidates::default();
    for (i, (word, &d)) in words.iter_mut().zip(&d).enumerate() {
        // Of a candidate, what stays if its brick is dropped.
        *word = empty_word(bounds.center(d, 0.0));
        if bounds.is_clear(d, radius) {
            continue;
        }
        if cell(i).cmplt(layout.grid).all() {
            let from = found.instrs.len();
            pruner.list(instrs, i, &mut found.instrs);
            found.cells.push((i as u8, from..found.instrs.len()));
        }
    }
    found
}

/// Sample all candidates' bricks; those in which no surface can be leave a distance in their cell.
fn fill<T: Texel>(
    program: &Program,
    layout: &BrickLayout,
    bounds: &Bounds,
    candidates: &[Candidates],
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
        let (_, rest) = words_left.split_at_mut((found.block - done) * 64);
        let (own_words, rest) = rest.split_at_mut(64);
        (words_left, done) = (rest, found.block + 1);
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
                let corner = layout.cell_at(found.block * 64);
                let bricks = pool.chunks_exact_mut(samples).zip(owners).zip(materials);
                for ((k, (inner, range)), ((out, owner), material)) in
                    (0..).zip(&found.cells).zip(bricks)
                {
                    let i = u32::from(*inner);
                    let cell = corner + uvec3(i % 4, i / 4 % 4, i / 16);
                    let least = filler.brick(&found.instrs[range.clone()], cell, out);
                    // Half of a voxel's diagonal from a sample at most.
                    let reach = 0.5 * 3f32.sqrt() * layout.lattice.voxel;
                    *owner = u32::MAX;
                    if !bounds.is_clear(least, reach) {
                        *owner = (found.block * 64) as u32 + i;
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
