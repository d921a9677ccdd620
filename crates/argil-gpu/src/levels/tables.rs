//! The tables of levels on the device, in one buffer: the slots of the coarsest pages, a record for each page, the
//! materials of bricks, and those of mixed ones.
//!
//! *Practice.* The CPU keeps a copy of what the device has. A record that differs from it is written.

use super::pool::packed;
use crate::resources::read_table;
use crate::storage_buffer::StorageBuffer;
use crate::{Gpu, GpuError};
use argil_abi::{BRICK_MIXED, MATERIAL_SIDE, RECORD_WORDS};
use argil_volume::{BrickChanges, Levels};
use std::ops::Range;

/// Room for the coarsest pages: as many as a world has before it is built again, with more levels.
const ROOTS: usize = 4096;
const RECORD: usize = RECORD_WORDS as usize;
/// Words of a mixed brick's materials.
const MIXED: usize = 2 * MATERIAL_SIDE.pow(3) as usize;
/// Written words that are at most so far apart are written as one.
const NEAR: usize = 64;

/// Where the tables begin.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct TablePlaces {
    pub records: u32,
    pub materials: u32,
    pub mixed: u32,
}

/// The tables of levels.
#[derive(Debug)]
pub(super) struct LevelTables {
    pub buffer: StorageBuffer,
    /// What the device has.
    image: Vec<u32>,
    /// Room for pages, bricks, and mixed bricks.
    room: [usize; 3],
    /// The pool's size, on which the words of bricks depend.
    pool: [u32; 3],
}

impl Default for LevelTables {
    fn default() -> Self {
        Self {
            buffer: StorageBuffer::new("pages of levels"),
            image: Vec::new(),
            room: [0; 3],
            pool: [0; 3],
        }
    }
}

impl LevelTables {
    pub(super) fn places(&self) -> TablePlaces {
        let [slots, bricks, _] = self.room;
        let materials = ROOTS + RECORD * slots;
        TablePlaces {
            records: ROOTS as u32,
            materials: materials as u32,
            mixed: (materials + bricks) as u32,
        }
    }

    /// Uploads what changed, or everything if it needs more room.
    pub(super) fn update(
        &mut self,
        gpu: &Gpu,
        levels: &Levels,
        changed: &BrickChanges,
        pool: [u32; 3],
    ) -> Result<(), GpuError> {
        let (materials, mixed) = levels.brick_materials();
        let needed = [
            levels.pages().len(),
            materials.len(),
            mixed.len() * 2 / MIXED,
        ];
        let is_short = needed
            .iter()
            .zip(self.room)
            .any(|(&needed, room)| needed > room);
        let is_new = is_short || self.pool[..2] != pool[..2];
        self.pool = pool;
        if is_short {
            self.room = needed.map(|count| count + count / 2 + 64);
        }
        let places = self.places();
        let mut dirty: Vec<Range<usize>> = Vec::new();
        if is_new {
            let [_, _, mixed_room] = self.room;
            self.image.clear();
            self.image
                .resize(places.mixed as usize + MIXED * mixed_room, 0);
            self.buffer.reserve(gpu, 4 * self.image.len() as u64)?;
            dirty.push(0..self.image.len());
        }
        let mut put = |at: usize, words: &[u32]| {
            if self.image[at..at + words.len()] != *words {
                self.image[at..at + words.len()].copy_from_slice(words);
                dirty.push(at..at + words.len());
            }
        };
        put(0, levels.roots().2);
        let (pages, words, children) = (levels.pages(), levels.words(), levels.children());
        let mut record = [0; RECORD];
        for (slot, page) in pages.iter().enumerate() {
            let cells = 8 * slot..8 * slot + 8;
            record[..3].copy_from_slice(&page.origin.map(|c| c as u32));
            (record[3], record[4]) = (page.level, page.parent);
            for (to, &word) in record[8..16].iter_mut().zip(&words[cells.clone()]) {
                *to = packed(word, pool);
            }
            record[16..].copy_from_slice(&children[cells]);
            put(ROOTS + RECORD * slot, &record);
        }
        let all: Vec<u32>;
        let bricks = if is_new {
            all = (0..materials.len() as u32).collect();
            &all
        } else {
            &changed.bricks
        };
        for &brick in bricks {
            let material = materials[brick as usize];
            put(places.materials as usize + brick as usize, &[material]);
            if material & BRICK_MIXED != 0 {
                let block = (material & !BRICK_MIXED) as usize;
                let mixed_words: &[u32] =
                    bytemuck::cast_slice(&mixed[block * MIXED / 2..][..MIXED / 2]);
                put(places.mixed as usize + MIXED * block, mixed_words);
            }
        }
        self.write(gpu, dirty);
        Ok(())
    }

    /// Writes ranges of words, those close to each other at once.
    fn write(&self, gpu: &Gpu, mut dirty: Vec<Range<usize>>) {
        dirty.sort_unstable_by_key(|range| range.start);
        let mut ranges = dirty.into_iter();
        let Some(mut open) = ranges.next() else {
            return;
        };
        let patch = |range: Range<usize>| {
            let at = 4 * range.start as u64;
            self.buffer
                .patch(gpu, at, bytemuck::cast_slice(&self.image[range]));
        };
        for range in ranges {
            if range.start <= open.end + NEAR {
                open.end = open.end.max(range.end);
            } else {
                patch(std::mem::replace(&mut open, range));
            }
        }
        patch(open);
    }

    /// Downloads the words and the children of all cells.
    pub(super) async fn read(
        &self,
        gpu: &Gpu,
        levels: &Levels,
        pool: [u32; 3],
    ) -> Result<[Vec<u32>; 2], GpuError> {
        let end = ROOTS + RECORD * levels.pages().len();
        let bytes = read_table(gpu, &self.buffer, 4 * end as u64).await?;
        let all = bytes.as_chunks::<4>().0;
        let (mut words, mut children) = (Vec::new(), Vec::new());
        for record in all[ROOTS.min(all.len())..].chunks_exact(RECORD) {
            let word = |&bytes: &[u8; 4]| u32::from_le_bytes(bytes);
            words.extend(
                record[8..16]
                    .iter()
                    .map(word)
                    .map(|w| super::pool::unpacked(w, pool)),
            );
            children.extend(record[16..].iter().map(word));
        }
        Ok([words, children])
    }
}
