//! What the rays of a tile used of levels of detail, and what they lacked.

use argil_volume::{LevelLanes, NO_REQUEST, PageRequest};

/// What a tile used and lacked.
#[derive(Default)]
pub(super) struct PageNotes {
    pub used: Vec<u32>,
    pub asked: Vec<PageRequest>,
    /// Hits, and how many of them were too coarse.
    pub hits: u64,
    pub coarse: u64,
}

impl PageNotes {
    /// Notes the cell of a lane, and what it lacks.
    #[inline(always)]
    pub(super) fn note(&mut self, lanes: &LevelLanes, i: usize, distance: f32) {
        let cell = lanes.at.index[i];
        if self.used.last() != Some(&cell) {
            self.used.push(cell);
        }
        let key = lanes.key[i];
        if key != NO_REQUEST && self.asked.last().is_none_or(|last| last.key != key) {
            self.asked.push(PageRequest {
                key,
                gap: lanes.gap[i],
                distance,
            });
        }
    }
}
