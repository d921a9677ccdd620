//! Changing bricks in place.
//!
//! *Practice.* An edit tells two boxes: outside of the first nothing changed within the stored band, outside of the
//! second nothing within what empty cells tell. Blocks that the second touches are pruned and measured again, from the
//! operands that can matter near them; of their cells, those that the first touches are sampled again. Where it is known
//! which instructions were touched, a cell is left alone in whose pruned lists, as they are and as they were, there is none
//! of those: it has the same distances, to the bit. That is far less than the boxes hold where blends are wide. Any number of
//! edits go in one pass. What was made is put into the pool at the end, so that nothing is changed if it does not fit.

use super::block_list::{BlockList, emptied_around};
use super::bounds::{Bounds, SLOT_BYTES};
use super::candidates::{Candidates, near_block, settle};
use super::filler::{Filler, Places, only_material};
use super::inner_cell;
use super::material::PLACES;
use super::octants::{self, OCTANTS};
use super::pool::Pool;
use super::reached::ReachedBlock;
use super::table::FAR_SLOTS;
use super::words::{center_of, empty_word, is_brick};
use super::work::{EditWork, Unit};
use super::{BLOCK_SIDE, BrickLayout, Bricks, BricksError};
use crate::texels::OF_THIS_TYPE;
use crate::{Bits, Texel};
use argil_abi::{Fill, Instr};
use argil_field::{CELLS, HardBrush, LiveProgram, Parts, Program, Pruner, Touched};
use glam::{IVec3, Vec3};
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use std::ops::Range;
use web_time::Instant;

/// Blocks along the side of a part that shares a list: where brushes are many, its list should not be of all of them.
const PART_SIDE: u32 = 4;
const SMALL_PART_SIDE: u32 = 2;
/// A brick of which more octants changed is sampled as a whole: an octant's samples are more than an eighth of a brick's.
const MOST_OCTANTS: u32 = 5;
/// From so many instructions in a block's list on, octants are measured by the lists of their cells.
const LONG_LIST: usize = 64;
/// More brushes than this, or instructions, are many.
const MANY: usize = 500;

/// What an edit of bricks did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BrickEdit {
    /// Bricks that were sampled again or anew.
    pub filled: u64,
    /// Bricks that there were not before.
    pub added: u64,
    /// Bricks that there are no more.
    pub removed: u64,
    /// Cells that were measured again.
    pub cells: u64,
}

impl std::ops::AddAssign for BrickEdit {
    fn add_assign(&mut self, other: Self) {
        self.filled += other.filled;
        self.added += other.added;
        self.removed += other.removed;
        self.cells += other.cells;
    }
}

/// A block that is to be made.
enum Job {
    /// Some cells, by what can matter in all of it.
    Listed(u64, BlockList),
    /// By what can matter in cells where something can have changed.
    Reached(ReachedBlock),
}

/// A block's new words and bricks.
struct Made<T> {
    /// The block's first cell.
    first: IVec3,
    /// Whether it is far from everything now, and then whether it is inside.
    far: Option<bool>,
    words: [u32; CELLS],
    /// Cells with a brick: which, and what it looks like.
    bricks: Vec<(u8, u32)>,
    texels: Vec<T>,
    mixed: Vec<[u32; 2]>,
    /// Bricks among them of which anything was sampled.
    sampled: u64,
}

impl BrickLayout {
    /// The parts in which a [`LiveProgram`] of these bricks tells lists.
    pub fn parts(&self, program: &Program) -> Parts {
        let blocks = if program.brush_count() > MANY {
            SMALL_PART_SIDE
        } else {
            PART_SIDE
        };
        let side = blocks * BLOCK_SIDE;
        Parts {
            corner: self.lattice.corner,
            edge: side as f32 * self.cell_length(),
            far: self.bands(program)[1],
            base: self.base_length(),
        }
    }

    /// The distances up to which edits must tell their boxes: what bricks hold, and what empty cells tell.
    pub fn bands(&self, program: &Program) -> [f32; 2] {
        self.least_bands(program).map(|band| 1.1 * band)
    }

    /// The least of them that will do. A world that grows needs a little more than before, which [`BrickLayout::bands`] has
    /// room for.
    pub fn least_bands(&self, program: &Program) -> [f32; 2] {
        let region = self.region();
        let farthest = region.min.abs().max(region.max.abs()).max_element();
        let rounding = program.rounding_at(self.base_length(), farthest);
        let near = program.lipschitz() * self.half_diagonal(1) + rounding;
        let range = self.encoding.range_length(&self.lattice, 0);
        [near.max(range), (self.far_length() + rounding).max(near)]
    }
}

impl Bricks {
    /// Do what edits have left to be done, on rayon's current threads: all of it, or as much as can be done until a point in
    /// time, and at least a little.
    ///
    /// # Errors
    /// If the bricks would take more than `budget` bytes; what was taken out of the work last is then not done.
    pub fn edit(
        &mut self,
        live: &LiveProgram,
        work: &mut EditWork,
        budget: Option<u64>,
        until: Option<Instant>,
    ) -> Result<BrickEdit, BricksError> {
        let mut done = BrickEdit::default();
        let mut count = if until.is_some() {
            2 * rayon::current_num_threads()
        } else {
            usize::MAX
        };
        while !work.is_done() {
            let start = Instant::now();
            let units = work.next(count);
            done += match self.layout.encoding.bits {
                Bits::Eight => self.do_units::<i8>(live, work, units, budget)?,
                Bits::Sixteen => self.do_units::<i16>(live, work, units, budget)?,
            };
            if let Some(until) = until {
                let now = Instant::now();
                let left = until.saturating_duration_since(now).as_secs_f64();
                if left == 0.0 {
                    break;
                }
                // Half of what there seems to be time for: what comes next may be dearer.
                let fits = 0.5 * left / (now - start).as_secs_f64().max(1e-6);
                count = ((count as f64 * fits.min(4.0)) as usize).max(1);
            }
        }
        Ok(done)
    }

    fn do_units<T: Texel>(
        &mut self,
        live: &LiveProgram,
        work: &EditWork,
        units: Vec<Unit>,
        budget: Option<u64>,
    ) -> Result<BrickEdit, BricksError> {
        let bounds = Bounds::new(live.program(), &self.layout);
        let encoding = &self.layout.encoding;
        let fill = encoding.fill(live.program(), &self.layout.lattice, 0);
        let (mut jobs, mut hard) = (Vec::new(), Vec::new());
        match self.reached::<T>(live, work, &units, (&bounds, &fill)) {
            Some((reached, own)) => {
                hard = own;
                // Boxes tell less than marks: of few brushes, a list that is cut by marks is shorter.
                let are_many = live.length() > MANY;
                let is_near = |block: &ReachedBlock| are_many && block.is_near(&self.layout);
                let (near, others): (Vec<_>, Vec<_>) = reached.into_iter().partition(is_near);
                jobs.extend(near.into_iter().map(Job::Reached));
                let lists = work.lists(&self.layout, live, ReachedBlock::units(&others));
                let cells: FxHashMap<IVec3, u64> = others
                    .iter()
                    .map(|block| (block.first, block.cells))
                    .collect();
                let listed = |list: BlockList| Job::Listed(cells[&list.first], list);
                jobs.extend(lists.into_iter().map(listed));
            }
            None => {
                let lists = work.lists(&self.layout, live, units);
                jobs.extend(lists.into_iter().map(|list| Job::Listed(u64::MAX, list)));
            }
        }
        let edit = Editing {
            layout: self.layout,
            live,
            touched: work.touched(live),
            hard,
            bounds,
            fill,
            places: Places::new(&self.layout),
            work,
        };
        let bricks = &*self;
        let made: Vec<Made<T>> = jobs
            .into_par_iter()
            .map_init(
                || edit.worker(),
                |worker, job| match job {
                    Job::Listed(cells, lists) => edit.make(worker, &lists, cells, bricks),
                    Job::Reached(block) => {
                        let lists = block.list(&edit.layout, live);
                        edit.make(worker, &lists, block.cells, bricks)
                    }
                },
            )
            .collect();
        self.check_budget(&made, budget)?;

        let mut result = BrickEdit::default();
        let samples = self.layout.brick_samples() as usize;
        let before = self.owners.len() as u64;
        // Blocks come first, so that there are words for their bricks. The order in which that is done is the same for all
        // numbers of threads.
        let slots: Vec<usize> = made.iter().map(|own| self.slot_for(own)).collect();
        let mut pool = Pool::<T>::open(self);
        // What is freed can then be taken.
        for (own, &slot) in made.iter().zip(&slots) {
            let first = slot * CELLS;
            for (i, &word) in own.words.iter().enumerate() {
                if !is_brick(word) && slot >= FAR_SLOTS as usize {
                    let old = pool.bricks().words[first + i];
                    result.removed += u64::from(is_brick(old));
                    pool.clear((first + i) as u32, word);
                }
            }
            result.cells += CELLS as u64;
        }
        for (own, &slot) in made.iter().zip(&slots) {
            let mut mixed = own.mixed.chunks_exact(PLACES);
            for (&(i, material), texels) in own.bricks.iter().zip(own.texels.chunks_exact(samples))
            {
                let own_mixed = if material & argil_abi::BRICK_MIXED != 0 {
                    mixed.next().expect("places of each mixed brick")
                } else {
                    &[]
                };
                pool.put(
                    (slot * CELLS) as u32 + u32::from(i),
                    texels,
                    material,
                    own_mixed,
                );
            }
            result.filled += own.sampled;
        }
        pool.close();
        let mut gone = Vec::new();
        for (own, &slot) in made.iter().zip(&slots) {
            self.changes.slot(slot as u32);
            let words = &mut self.words[slot * CELLS..(slot + 1) * CELLS];
            match own.far {
                None => self.masks[slot] = settle(words),
                Some(inside) => {
                    if slot >= FAR_SLOTS as usize {
                        self.masks[slot] = 0;
                    }
                    gone.push((own.first / BLOCK_SIDE as i32, inside));
                }
            }
        }
        if !gone.is_empty() {
            gone.extend(emptied_around(&self.table, &self.layout, live, &gone));
        }
        for (block, inside) in gone {
            self.changes.blocks();
            self.table.set_far(block, block + 1, inside);
        }
        result.added = (self.owners.len() as u64 + result.removed) - before;
        Ok(result)
    }

    /// The slot of a block, which gets one if it needs one.
    fn slot_for<T>(&mut self, made: &Made<T>) -> usize {
        let block = made.first / BLOCK_SIDE as i32;
        if made.far.is_some() {
            return self.table.slot(block) as usize;
        }
        if self.table.find(block).is_none() {
            self.changes.blocks();
        }
        let slot = self.table.insert(block) as usize;
        if slot >= self.masks.len() {
            self.masks.resize(slot + 1, 0);
            self.words.resize((slot + 1) * CELLS, empty_word(0.0));
        }
        slot
    }

    fn check_budget<T>(&self, made: &[Made<T>], budget: Option<u64>) -> Result<(), BricksError> {
        let budget = budget.unwrap_or(u64::MAX);
        let mut bricks = self.owners.len() as u64;
        let (mut mixed, mut slots) = (0, self.table.slots() as u64);
        for own in made {
            let slot = self.table.slot(own.first / BLOCK_SIDE as i32);
            let old = self.masks[slot as usize].count_ones();
            slots += u64::from(slot < FAR_SLOTS && own.far.is_none());
            let new = own.words.iter().filter(|&&word| is_brick(word)).count();
            bricks = bricks + new as u64 - u64::from(old);
            mixed += size_of_val(&own.mixed[..]) as u64;
        }
        self.layout.check_count(bricks)?;
        let of_each = self.layout.brick_bytes() + 8;
        let needed = SLOT_BYTES * slots + bricks * of_each + size_of_val(&self.mixed[..]) as u64;
        if needed + mixed > budget && needed + mixed > self.memory_bytes() {
            return Err(BricksError::Budget {
                bricks,
                needed: needed + mixed,
                budget,
            });
        }
        Ok(())
    }
}

/// The lowest bits of `bits`, each at the place of one of the bits of `places`, in their order.
fn scattered(bits: u64, places: u64) -> u64 {
    if places == u64::MAX {
        return bits;
    }
    let all = (0..CELLS).filter(|i| places >> i & 1 != 0).enumerate();
    all.fold(0, |out, (nth, i)| out | (bits >> nth & 1) << i)
}

/// The other way round.
fn gathered(bits: u64, places: u64) -> u64 {
    if places == u64::MAX {
        return bits;
    }
    let all = (0..CELLS).filter(|i| places >> i & 1 != 0).enumerate();
    all.fold(0, |out, (nth, i)| out | (bits >> i & 1) << nth)
}

/// What all blocks of an edit share.
struct Editing<'a> {
    layout: BrickLayout,
    live: &'a LiveProgram,
    bounds: Bounds<'a>,
    fill: Fill,
    places: Places,
    /// What can have changed, where that is known.
    touched: Option<&'a Touched>,
    /// Brushes that alone tell how bricks that there were have changed; none where more must be known.
    hard: Vec<HardBrush>,
    work: &'a EditWork,
}

/// What a thread keeps.
struct Worker<'a> {
    pruner: Pruner<'a>,
    filler: Filler<'a>,
}

impl Editing<'_> {
    fn worker(&self) -> Worker<'_> {
        Worker {
            pruner: Pruner::new(self.live.program()),
            filler: Filler::new(self.live.program(), &self.layout, &self.fill, &self.places),
        }
    }

    /// In which of a block's cells something that was touched can have mattered: a bit for each. Takes the pruner's marks.
    fn mattered(&self, first: IVec3, lists: &BlockList, pruner: &mut Pruner<'_>) -> u64 {
        let (Some(before), Some(touched)) = (&lists.before, self.touched) else {
            return u64::MAX;
        };
        if !touched.any(before) {
            return 0;
        }
        let centers: [Vec3; CELLS] =
            std::array::from_fn(|i| self.layout.middle(first + inner_cell(i), 1));
        let mut d = [0.0; CELLS];
        pruner.mark(before, &centers, self.layout.half_diagonal(1), &mut d);
        pruner.needed(before, |instr| touched.has(instr))
    }

    /// Of some cells of a block that have a brick and are near the surface, which octants edits can have changed: a bit for
    /// each. All of them elsewhere.
    fn octants(
        &self,
        first: IVec3,
        lists: &BlockList,
        some: u64,
        (found, old): (&Candidates, &[u32]),
        pruner: &mut Pruner<'_>,
    ) -> [u8; CELLS] {
        let mut octants = [u8::MAX; CELLS];
        let (Some(before), Some(touched)) = (&lists.before, self.touched) else {
            return octants;
        };
        let has_brick = |i: u8| some >> i & 1 != 0 && is_brick(old[usize::from(i)]);
        let near: Vec<&(u8, Range<usize>)> =
            found.cells.iter().filter(|(i, _)| has_brick(*i)).collect();
        let in_block = touched.count(&lists.now);
        let had_any = touched.any(before);
        for near in near.chunks(octants::CELLS_AT_ONCE) {
            let cells: Vec<IVec3> = near
                .iter()
                .map(|(i, _)| first + inner_cell(usize::from(*i)))
                .collect();
            let mut changed = |list: &[Instr], cells: &[IVec3]| {
                octants::changed(&self.layout, pruner, touched, list, cells)
            };
            let mut bits = if had_any { changed(before, &cells) } else { 0 };
            if lists.now.len() > LONG_LIST {
                for (nth, (_, range)) in near.iter().enumerate() {
                    let own = &found.instrs[range.clone()];
                    // One that may matter in the cell can be missing in its list, as another takes its place.
                    let is_whole = touched.count(own) == in_block;
                    let list = if is_whole { own } else { &lists.now[..] };
                    bits |= changed(list, &cells[nth..=nth]) << (nth * OCTANTS);
                }
            } else if in_block > 0 {
                bits |= changed(&lists.now, &cells);
            }
            for (nth, (i, _)) in near.iter().enumerate() {
                octants[usize::from(*i)] = (bits >> (nth * OCTANTS)) as u8;
            }
        }
        octants
    }

    /// Whether a brick whose samples and places of materials cannot have changed looks as before. A list that has one
    /// material gives that, else the places tell, which a mixed brick has kept.
    fn looks_the_same(&self, list: &[Instr], look: u32) -> bool {
        match only_material(list, self.live.program().materials()) {
            Some(only) => only == look,
            None => look & argil_abi::BRICK_MIXED != 0,
        }
    }

    /// Measure some of a block's cells, a bit for each, and sample what is dirty.
    fn make<T: Texel>(
        &self,
        worker: &mut Worker<'_>,
        lists: &BlockList,
        some: u64,
        bricks: &Bricks,
    ) -> Made<T> {
        let (first, instrs) = (lists.first, &lists.now);
        let mut made = Made {
            first,
            far: lists.far,
            words: [empty_word(0.0); CELLS],
            bricks: Vec::new(),
            texels: Vec::new(),
            mixed: Vec::new(),
            sampled: 0,
        };
        if made.far.is_some() {
            return made;
        }
        let bounds = self.bounds.of_block(&self.layout, first);
        let Worker { pruner, filler } = worker;
        // The cells that edits can have changed: a bit for each.
        let mut changed = self.mattered(first, lists, pruner);
        let wanted = |pruner: &Pruner<'_>| {
            if let Some(touched) = self.touched.filter(|_| changed != u64::MAX) {
                let needed = pruner.needed(instrs, |instr| touched.has(instr));
                changed |= scattered(needed, some);
                return gathered(changed, some);
            }
            changed
        };
        let words = &mut made.words;
        let listed = (&instrs[..], some);
        let found = near_block(&self.layout, &bounds, first, listed, pruner, words, wanted);
        // The others are as they were.
        changed &= some;
        let reach = 0.5 * 3f32.sqrt() * self.layout.lattice.voxel;
        let samples = self.layout.brick_samples() as usize;
        // Of a block that there was not, far words.
        let slot = bricks.table.slot(first / BLOCK_SIDE as i32) as usize;
        let old = &bricks.words[slot * CELLS..(slot + 1) * CELLS];
        let pool = bricks.pool.of::<T>().expect(OF_THIS_TYPE);
        let dirty = self.work.dirty_cells(&self.layout, self.live, first);
        let octants = if self.hard.is_empty() {
            self.octants(first, lists, changed & dirty, (&found, old), pruner)
        } else {
            [u8::MAX; CELLS]
        };
        // No more bricks than that, so that they are moved once.
        let near = found.cells.iter().filter(|&&(i, _)| {
            let i = usize::from(i);
            (changed & dirty) >> i & 1 != 0 && octants[i] != 0
        });
        made.texels.reserve_exact(near.count() * samples);
        let mut next = found.cells.iter().peekable();
        for (i, &old) in old.iter().enumerate() {
            let is_changed = changed >> i & 1 != 0;
            let list: Option<Range<usize>> = next
                .next_if(|&&(inner, _)| usize::from(inner) == i)
                .map(|(_, range)| range.clone());
            let cell = first + inner_cell(i);
            if !is_changed {
                // Whether the block is empty is found out anew.
                made.words[i] = if is_brick(old) {
                    old
                } else {
                    empty_word(center_of(old))
                };
                continue;
            }
            if dirty >> i & 1 == 0 {
                // Nothing changed that a brick holds.
                if is_brick(old) {
                    made.words[i] = old;
                }
                continue;
            }
            let Some(list) = list else { continue };
            let list = &found.instrs[list];
            if octants[i] == 0 && self.looks_the_same(list, bricks.materials[old as usize]) {
                made.words[i] = old;
                continue;
            }
            let begin = made.texels.len();
            let look = is_brick(old).then(|| bricks.materials[old as usize]);
            let was = is_brick(old).then(|| &pool[old as usize * samples..][..samples]);
            let mut changed = octants[i];
            let stays = match was {
                Some(was) if !self.hard.is_empty() => {
                    made.texels.extend_from_slice(was);
                    let out = &mut made.texels[begin..];
                    let least = filler.joined(&self.hard, cell, out);
                    // Where it is not certain, the whole list tells.
                    let stays = least.is_finite() && !bounds.is_clear(least, reach);
                    if out == was {
                        changed = 0;
                        // Places of materials can have changed all the same.
                        let palette = self.live.program().materials();
                        if stays && look.is_some() && look == only_material(list, palette) {
                            made.texels.truncate(begin);
                            made.words[i] = old;
                            continue;
                        }
                    }
                    stays
                }
                Some(was) if changed.count_ones() <= MOST_OCTANTS => {
                    made.texels.extend_from_slice(was);
                    let out = &mut made.texels[begin..];
                    // What is near enough in a part is near enough in the whole.
                    let mut again = || filler.octants(list, cell, changed, out);
                    changed == 0 || !bounds.is_clear(again(), reach)
                }
                _ => false,
            };
            if !stays {
                made.texels.resize(begin + samples, T::default());
                let least = filler.brick(list, cell, &mut made.texels[begin..]);
                if bounds.is_clear(least, reach) {
                    made.texels.truncate(begin);
                    continue;
                }
            }
            made.sampled += u64::from(changed != 0);
            let material = filler.material(list, cell, &mut made.mixed);
            made.bricks.push((i as u8, material));
            // Any brick: which one is known when it is put into the pool.
            made.words[i] = 0;
        }
        made
    }
}
