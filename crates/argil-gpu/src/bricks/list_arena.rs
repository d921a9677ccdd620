//! The memory of lists: the blocks to build, the masks of cells to sample, the ranges of the blocks' lists, the
//! ranges of the cells' lists, and then the lists themselves.

use crate::storage_buffer::StorageBuffer;
use crate::{Gpu, GpuError};
use argil_abi::{self as abi, Instruction, PruneUniform};
use argil_field::Program;
use argil_volume::{BLOCK_WORDS, BrickLayout};

/// Words reserved for lists: per instruction, and per cell.
const WORDS: [u64; 2] = [16, 48];

/// Words of a cell's list: where it begins, its length, and where its words for columns begin.
const CELL_LIST_WORDS: u64 = 3;

/// Blocks with their programs.
#[derive(Default)]
pub(super) struct BlockTables {
    pub instructions: Vec<Instruction>,
    /// Their slots.
    pub slots: Vec<u32>,
    /// A bit for each cell to sample.
    pub dirty: Vec<u64>,
    /// The start and the length of each block's list among the instructions.
    pub stretches: Vec<[u32; 2]>,
    /// The bounds of distances in each block.
    pub bounds: Vec<[f32; BLOCK_WORDS]>,
}

impl BlockTables {
    /// Adds a block.
    pub(super) fn push(
        &mut self,
        slot: u32,
        dirty: u64,
        list: &[Instruction],
        bounds: [f32; BLOCK_WORDS],
    ) {
        let begin = self.instructions.len() as u32;
        self.slots.push(slot);
        self.bounds.push(bounds);
        self.dirty.push(dirty);
        self.stretches.push([begin, list.len() as u32]);
        self.instructions
            .extend(list.iter().map(|&instr| Instruction {
                // The end of a loop points at its beginning.
                operand: if instr.op == abi::OP_NEXT {
                    instr.operand + begin
                } else {
                    instr.operand
                },
                ..instr
            }));
    }

    /// Returns the number of cells to sample.
    pub(super) fn cells(&self) -> u64 {
        let counts = self.dirty.iter().map(|mask| u64::from(mask.count_ones()));
        counts.sum()
    }

    /// Returns the length of the longest list.
    pub(super) fn longest(&self) -> usize {
        let lengths = self.stretches.iter().map(|&[_, length]| length as usize);
        lengths.max().unwrap_or(0)
    }

    /// Uploads everything. Returns the uniform.
    pub(super) fn write(
        &self,
        gpu: &Gpu,
        table: &mut StorageBuffer,
        program: &Program,
        measures: &BrickLayout,
    ) -> Result<PruneUniform, GpuError> {
        let (count, cells) = (self.slots.len() as u64, self.cells());
        let [per_instr, per_cell] = WORDS;
        let bounds_first = 5 * count + CELL_LIST_WORDS * cells;
        let head = bounds_first + BLOCK_WORDS as u64 * count;
        let room = ArenaRequest {
            head,
            lists: per_instr * self.instructions.len() as u64 + per_cell * cells,
            length: self.instructions.len() as u64,
        };
        let (arena_first, arena_words) = room.reserve(gpu, table)?;
        let mut words = self.slots.clone();
        for mask in &self.dirty {
            words.extend([*mask as u32, (mask >> 32) as u32]);
        }
        let stretches = self.stretches.iter();
        words.extend(stretches.flat_map(|&[begin, length]| [arena_first + begin, length]));
        table.patch(gpu, 0, bytemuck::cast_slice(&words));
        table.patch(gpu, 4 * bounds_first, bytemuck::cast_slice(&self.bounds));
        Ok(PruneUniform {
            slack: program.rounding(measures.region()),
            blocks_at: 0,
            dirty_first: count as u32,
            blocks_first: 3 * count as u32,
            cells_first: 5 * count as u32,
            cells_room: cells as u32,
            arena_first,
            arena_words,
            count: count as u32,
            build_mode: abi::BUILD_BLOCKS,
            // Two words for each cell near the surface before it.
            freed_first: 2 * 64 * count as u32,
            bounds_first: bounds_first as u32,
        })
    }
}

/// Requested words: before lists, for lists, and the minimum for lists.
struct ArenaRequest {
    head: u64,
    lists: u64,
    length: u64,
}

impl ArenaRequest {
    /// Reserves memory. Returns where lists begin, and how many words they have.
    fn reserve(&self, gpu: &Gpu, table: &mut StorageBuffer) -> Result<(u32, u32), GpuError> {
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
