//! What the rays of a tile used of levels of detail, and what they lacked.

use argil_volume::{LevelLanes, LevelSampler, PageRequest, Texel};

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
        if let Some(request) = sampler.request_of(lanes, i, distance)
            && self.asked.last().is_none_or(|last| last.key != request.key)
        {
            self.asked.push(request);
        }
    }
}
