//! Requests for missing pages.

use rustc_hash::FxHashMap;
use std::sync::{Mutex, PoisonError};

/// A request for the page of an octant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PageRequest {
    /// Eight times the slot of the resident page, plus the octant.
    pub key: u32,
    /// By how many levels the resident page is too coarse.
    pub gap: f32,
    /// The distance from the camera.
    pub distance: f32,
}

impl PageRequest {
    /// Creates a request for an octant of a resident page.
    #[inline(always)]
    pub fn new(slot: u32, octant: u32, gap: f32, distance: f32) -> Self {
        Self {
            key: 8 * slot + octant,
            gap,
            distance,
        }
    }

    /// Returns the slot and the octant.
    pub fn place(&self) -> (u32, u32) {
        (self.key / 8, self.key % 8)
    }

    /// Merges requests for the same page, the most urgent of them first.
    pub(super) fn merged(all: &mut Vec<Self>) {
        let urgency = |a: &Self, b: &Self| {
            b.gap
                .total_cmp(&a.gap)
                .then(a.distance.total_cmp(&b.distance))
        };
        all.sort_unstable_by(|a, b| a.key.cmp(&b.key).then(urgency(a, b)));
        all.dedup_by_key(|one| one.key);
        all.sort_unstable_by(|a, b| urgency(a, b).then(a.key.cmp(&b.key)));
    }
}

/// Requests that no fill has taken yet.
#[derive(Debug, Default)]
pub(super) struct Requests(Mutex<FxHashMap<u32, [f32; 2]>>);

impl Requests {
    pub(super) fn add(&self, asked: &[PageRequest]) {
        if asked.is_empty() {
            return;
        }
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        for one in asked {
            let own = all.entry(one.key).or_insert([one.gap, one.distance]);
            *own = [own[0].max(one.gap), own[1].min(one.distance)];
        }
    }

    /// Returns the number of pages that are asked for.
    pub(super) fn len(&self) -> usize {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).len()
    }

    /// Takes all requests, the most urgent first: by how much the resident page is too coarse, then by distance.
    pub(super) fn take(&mut self) -> Vec<PageRequest> {
        let all = self.0.get_mut().unwrap_or_else(PoisonError::into_inner);
        let mut taken: Vec<PageRequest> = all
            .drain()
            .map(|(key, [gap, distance])| PageRequest { key, gap, distance })
            .collect();
        PageRequest::merged(&mut taken);
        taken
    }
}
