//! Where the lists of a build stand: the stretches of the parts of the grid, level by level, those of cells, then the
//! lists themselves, one after the other as they come.

use crate::table::Table;
use crate::{Gpu, GpuError};
use argil_abi::Prune;
use argil_field::Program;
use argil_volume::{BLOCK_SIDE, BrickLayout};

/// Words for lists that a build sets aside: for each instruction, for each block, and for each cell with a surface.
const WORDS: [u64; 3] = [16, 64, 32];
/// The least of them all.
const LEAST_WORDS: u64 = 1 << 20;

pub(super) struct Lists {
    pub table: Table,
    /// What each level is made with, from the greatest parts down to blocks.
    pub levels: Vec<Prune>,
}

impl Lists {
    /// For a program of `length` instructions, and so many cells with a list of their own.
    pub fn new(
        gpu: &Gpu,
        program: &Program,
        length: usize,
        measures: &BrickLayout,
        cells: u64,
    ) -> Result<Self, GpuError> {
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

        let limits = gpu.device.limits();
        let limit = limits
            .max_storage_buffer_binding_size
            .min(limits.max_buffer_size);
        let length = length as u64;
        let [per_instr, per_block, per_cell] = WORDS;
        let wanted = per_instr * length + per_block * measures.block_count() + per_cell * cells;
        let arena_words = wanted
            .max(LEAST_WORDS)
            .min((limit / 4).saturating_sub(words))
            .max(length);
        let slack = program.bounds_slack(measures.region());
        for level in &mut levels {
            *level = Prune {
                slack,
                blocks_first,
                cells_first,
                arena_first: words as u32,
                arena_words: arena_words as u32,
                cells_room: cells as u32,
                ..*level
            };
        }
        let mut table = Table::new("lists");
        table.reserve_exact(gpu, 4 * (words + arena_words))?;
        Ok(Self { table, levels })
    }
}
