//! Where lists stand. Of all blocks: the stretches of the parts of the grid, level by level; of some: which they are, which
//! of their cells are to be sampled, and their stretches. Then the stretches of cells, and the lists themselves, one after
//! the other as they come.

use crate::table::Table;
use crate::{Gpu, GpuError};
use argil_abi::{self as abi, Instr, Prune};
use argil_field::Program;
use argil_volume::{BLOCK_SIDE, BrickLayout};

/// Words for lists that a build sets aside: for each instruction, for each block, and for each cell with a surface.
const WORDS: [u64; 3] = [16, 64, 32];
/// The least of them all.
const LEAST_WORDS: u64 = 1 << 20;

/// Of all blocks, with a program of `length` instructions, and so many cells with a list of their own: what each level is
/// made with, from the greatest parts down to blocks.
pub(super) fn of_all(
    gpu: &Gpu,
    table: &mut Table,
    program: &Program,
    length: usize,
    measures: &BrickLayout,
    cells: u64,
) -> Result<Vec<Prune>, GpuError> {
    let mut side = BLOCK_SIDE;
    while side < measures.grid.max_element() {
        side *= 4;
    }
    let mut levels: Vec<Prune> = Vec::new();
    let mut words = 0u64;
    while side > BLOCK_SIDE || levels.is_empty() {
        side = (side / 4).max(BLOCK_SIDE);
        let parts = measures.grid.to_array().map(|n| n.div_ceil(side));
        let mut level = Prune {
            side,
            parts_x: parts[0],
            parts_y: parts[1],
            parts_z: parts[2],
            first: words as u32,
            ..Prune::default()
        };
        if let Some(outer) = levels.last() {
            level.outer_side = outer.side;
            level.outer_x = outer.parts_x;
            level.outer_y = outer.parts_y;
            level.outer_first = outer.first;
        }
        levels.push(level);
        words += 2 * parts.map(u64::from).iter().product::<u64>();
    }
    let blocks_first = levels.last().map_or(0, |level| level.first);
    let cells_first = words as u32;
    words += 2 * cells;

    let [per_instr, per_block, per_cell] = WORDS;
    let wanted = per_instr * length as u64 + per_block * measures.block_count() + per_cell * cells;
    let room = Room {
        head: words,
        lists: wanted.max(LEAST_WORDS),
        length: length as u64,
    };
    let (arena_first, arena_words) = room.reserve(gpu, table)?;
    let slack = program.bounds_slack(measures.region());
    for level in &mut levels {
        *level = Prune {
            slack,
            blocks_first,
            cells_first,
            arena_first,
            arena_words,
            cells_room: cells as u32,
            count: measures.block_count() as u32,
            make: abi::MAKE_ALL,
            ..*level
        };
    }
    Ok(levels)
}

/// Some blocks, with what can matter in them.
#[derive(Default)]
pub(super) struct Blocks {
    pub instrs: Vec<Instr>,
    /// Their places in the grid.
    pub places: Vec<u32>,
    /// A bit for each cell that is to be sampled.
    pub dirty: Vec<u64>,
    /// Where each one's list begins among the instructions, and its length.
    pub stretches: Vec<[u32; 2]>,
}

impl Blocks {
    /// Add a block.
    pub fn push(&mut self, place: usize, dirty: u64, list: &[Instr]) {
        let begin = self.instrs.len() as u32;
        self.places.push(place as u32);
        self.dirty.push(dirty);
        self.stretches.push([begin, list.len() as u32]);
        self.instrs.extend(list.iter().map(|&instr| Instr {
            // The end of a loop points at its beginning.
            operand: if instr.op == abi::OP_NEXT {
                instr.operand + begin
            } else {
                instr.operand
            },
            ..instr
        }));
    }

    /// Cells that are to be sampled.
    pub fn cells(&self) -> u64 {
        let counts = self.dirty.iter().map(|mask| u64::from(mask.count_ones()));
        counts.sum()
    }

    /// The length of the longest list.
    pub fn longest(&self) -> usize {
        let lengths = self.stretches.iter().map(|&[_, length]| length as usize);
        lengths.max().unwrap_or(0)
    }

    /// Bring them over; what they are made with.
    pub fn write(
        &self,
        gpu: &Gpu,
        table: &mut Table,
        program: &Program,
        measures: &BrickLayout,
    ) -> Result<Prune, GpuError> {
        let (count, cells) = (self.places.len() as u64, self.cells());
        let [per_instr, _, per_cell] = WORDS;
        let head = 5 * count + 2 * cells;
        let room = Room {
            head,
            lists: per_instr * self.instrs.len() as u64 + per_cell * cells,
            length: self.instrs.len() as u64,
        };
        let (arena_first, arena_words) = room.reserve(gpu, table)?;
        let mut words = self.places.clone();
        for mask in &self.dirty {
            words.extend([*mask as u32, (mask >> 32) as u32]);
        }
        let stretches = self.stretches.iter();
        words.extend(stretches.flat_map(|&[begin, length]| [arena_first + begin, length]));
        table.patch(gpu, 0, bytemuck::cast_slice(&words));
        Ok(Prune {
            slack: program.bounds_slack(measures.region()),
            side: BLOCK_SIDE,
            blocks_at: 0,
            dirty_first: count as u32,
            blocks_first: 3 * count as u32,
            cells_first: 5 * count as u32,
            cells_room: cells as u32,
            arena_first,
            arena_words,
            count: count as u32,
            make: abi::MAKE_SOME,
            // Two words for each cell near the surface before it.
            freed_first: 2 * 64 * count as u32,
            ..Prune::default()
        })
    }
}

/// Words that are wanted: those before lists, those of lists, and the least of them that will do.
struct Room {
    head: u64,
    lists: u64,
    length: u64,
}

impl Room {
    /// Make room; where lists begin, and how many words there are for them.
    fn reserve(&self, gpu: &Gpu, table: &mut Table) -> Result<(u32, u32), GpuError> {
        let limits = gpu.device.limits();
        let limit = limits
            .max_storage_buffer_binding_size
            .min(limits.max_buffer_size);
        let most = (limit / 4).saturating_sub(self.head);
        let words = self.lists.min(most).max(self.length);
        table.reserve(gpu, 4 * (self.head + words))?;
        Ok((self.head as u32, words as u32))
    }
}
