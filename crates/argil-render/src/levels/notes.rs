//! What the rays of a tile used of levels of detail, and what they lacked.

use argil_volume::{LevelLanes, LevelSampler, NO_REQUEST, PageRequest, Texel};

/// What a tile lacked.
#[derive(Default)]
pub(super) struct PageNotes {
    pub asked: Vec<PageRequest>,
    /// Hits, and how many of them were too coarse.
    pub hits: u64,
    pub coarse: u64,
}

impl PageNotes {
    /// Marks the cell of a lane as used, and notes what it lacks.
    #[inline(always)]
    pub(super) fn note<T: Texel>(
        &mut self,
        sampler: &LevelSampler<'_, T>,
        lanes: &LevelLanes,
        i: usize,
        distance: f32,
    ) {
        sampler.mark_used(lanes, i);
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
