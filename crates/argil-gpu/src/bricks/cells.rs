//! The block table on the device, and the words of its cells. They share one buffer, because bindings are few.
//!
//! ```text
//!   tree    the entries of the table, with room for more
//!   slots   the first cell of each slot's block, three numbers each
//!   words   64 for each slot
//! ```
//!
//! The CPU decides which blocks exist, and uploads changes to the table. Only the GPU writes the words.

use crate::pass_recorder::PassRecorder;
use crate::resources::read_table;
use crate::storage_buffer::StorageBuffer;
use crate::{Gpu, GpuError};
use argil_abi::CellTable;
use argil_volume::{BlockTable, empty_word, far_words};

/// The block table, and a copy of it on the device.
#[derive(Debug)]
pub(crate) struct GpuCellTable {
    pub table: BlockTable,
    pub buffer: StorageBuffer,
    /// The words of some blocks without a surface.
    blank: StorageBuffer,
    tree_room: u32,
    slot_room: u32,
    /// The largest distance that a cell stores.
    far: f32,
}

/// Blocks whose words are emptied by one command.
const BLANK: u32 = 16;

/// Returns a little more than needed, so that not every block moves the buffer.
fn with_headroom(needed: usize) -> u32 {
    (needed + needed / 4 + 64) as u32
}

impl GpuCellTable {
    /// Uploads a table with empty words in all slots, or with given words.
    pub(super) fn new(
        gpu: &Gpu,
        mut table: BlockTable,
        far: f32,
        words: Option<&[u32]>,
    ) -> Result<Self, GpuError> {
        table.take_changed();
        let mut cells = Self {
            tree_room: table.entries().len() as u32,
            slot_room: table.slots() as u32,
            table,
            buffer: StorageBuffer::new("cells"),
            blank: StorageBuffer::new("cells of a block"),
            far,
        };
        let blank = vec![empty_word(0.0); 64 * BLANK as usize];
        cells.blank.write(gpu, &blank)?;
        cells.buffer.reserve_exact(gpu, cells.bytes())?;
        cells.write_head(gpu);
        match words {
            Some(words) => cells.patch(gpu, cells.words_at(), words),
            None => cells.clear(gpu),
        }
        Ok(cells)
    }

    fn slots_at(&self) -> u32 {
        self.tree_room
    }

    fn words_at(&self) -> u32 {
        self.tree_room + 3 * self.slot_room
    }

    fn bytes(&self) -> u64 {
        4 * (u64::from(self.words_at()) + 64 * u64::from(self.slot_room))
    }

    /// Returns the bytes on the device, and of the table on the CPU.
    pub(super) fn memory_bytes(&self) -> u64 {
        self.buffer.size() + self.table.memory_bytes()
    }

    /// Returns the uniform for shaders.
    pub(super) fn described(&self) -> CellTable {
        let (low, top) = self.table.top();
        CellTable {
            tree_x: low.x,
            tree_y: low.y,
            tree_z: low.z,
            top_x: top.x,
            top_y: top.y,
            top_z: top.z,
            levels: self.table.levels(),
            slots_at: self.slots_at(),
            words_at: self.words_at(),
            cells: 64 * self.table.slots() as u32,
            ..CellTable::default()
        }
    }

    fn patch(&self, gpu: &Gpu, at: u32, words: &[u32]) {
        self.buffer
            .patch(gpu, 4 * u64::from(at), bytemuck::cast_slice(words));
    }

    fn first_cells(&self, slots: impl Iterator<Item = usize>) -> Vec<u32> {
        slots
            .flat_map(|slot| self.table.cell(slot).to_array().map(|c| c as u32))
            .collect()
    }

    fn write_head(&self, gpu: &Gpu) {
        self.patch(gpu, 0, self.table.entries());
        let cells = self.first_cells(0..self.table.slots());
        self.patch(gpu, self.slots_at(), &cells);
    }

    /// Empties all blocks.
    pub(super) fn clear(&self, gpu: &Gpu) {
        let mut words = far_words(self.far);
        words.resize(64 * self.table.slots(), empty_word(0.0));
        self.patch(gpu, self.words_at(), &words);
    }

    /// Uploads what changed in the table. Commands empty the words of slots that have a new block, after others that move them if the
    /// table needs another buffer.
    pub(super) fn follow(
        &mut self,
        new: &[u32],
        recorder: &mut PassRecorder<'_>,
    ) -> Result<(), GpuError> {
        let gpu = recorder.gpu();
        let mut new = new.to_vec();
        new.sort_unstable();
        let changed = self.table.take_changed();
        let (entries, slots) = (self.table.entries().len(), self.table.slots());
        if entries as u32 > self.tree_room || slots as u32 > self.slot_room {
            let (old_at, old_slots) = (self.words_at(), self.slot_room);
            self.tree_room = with_headroom(entries);
            self.slot_room = with_headroom(slots);
            let mut buffer = StorageBuffer::new("cells");
            buffer.reserve_exact(gpu, self.bytes())?;
            let old = std::mem::replace(&mut self.buffer, buffer);
            if let (Some(from), Some(to)) = (old.buffer(), self.buffer.buffer()) {
                let (from_at, to_at) = (4 * u64::from(old_at), 4 * u64::from(self.words_at()));
                let bytes = 256 * u64::from(old_slots);
                let encoder = recorder.encoder();
                encoder.copy_buffer_to_buffer(from, from_at, to, to_at, bytes);
            }
            self.write_head(gpu);
        } else {
            self.patch(
                gpu,
                changed.start as u32,
                &self.table.entries()[changed.clone()],
            );
        }
        for run in new.chunk_by(|a, b| a + 1 == *b) {
            let cells = self.first_cells(run.iter().map(|&slot| slot as usize));
            self.patch(gpu, self.slots_at() + 3 * run[0], &cells);
            for some in run.chunks(BLANK as usize) {
                let at = 4 * u64::from(self.words_at() + 64 * some[0]);
                let bytes = 256 * some.len() as u64;
                if let (Some(blank), Some(to)) = (self.blank.buffer(), self.buffer.buffer()) {
                    let encoder = recorder.encoder();
                    encoder.copy_buffer_to_buffer(blank, 0, to, at, bytes);
                }
            }
        }
        Ok(())
    }

    /// Downloads the words of all slots.
    pub(super) async fn read(&self, gpu: &Gpu) -> Result<Vec<u32>, GpuError> {
        let begin = self.words_at() as usize;
        let end = begin + 64 * self.table.slots();
        let bytes = read_table(gpu, &self.buffer, 4 * end as u64).await?;
        let words = bytes.chunks_exact(4).map(bytemuck::pod_read_unaligned);
        Ok(words.skip(begin).collect())
    }

    /// Returns the bytes of a number of additional slots.
    pub(super) fn bytes_for(more: u64) -> u64 {
        more * (256 + 24)
    }
}
