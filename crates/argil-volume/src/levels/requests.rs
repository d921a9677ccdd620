//! Requests for missing bricks and pages.

use rustc_hash::FxHashMap;
use std::sync::{Mutex, PoisonError};

/// A request for a cell's brick, or for one of the finer cells in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PageRequest {
    /// 16 times the cell, plus 8 and the place of the finer cell, if that is asked for.
    pub key: u64,
    /// By how many levels the resident brick is too coarse.
    pub gap: f32,
    /// The distance from the camera.
    pub distance: f32,
    /// What asked for it, if that is known: what is finer is baked at the same time.
    pub aim: Option<PageAim>,
}

/// A point that needs a level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PageAim {
    /// The voxel of level 0.
    pub voxel: [i32; 3],
    /// The level.
    pub level: u32,
}

impl PageRequest {
    /// Creates a request for a cell's brick.
    #[inline(always)]
    pub fn of_cell(cell: u32, gap: f32, distance: f32) -> Self {
        Self {
            key: 16 * u64::from(cell),
            gap,
            distance,
            aim: None,
        }
    }

    /// Creates a request for a finer cell in a cell, and its brick.
    #[inline(always)]
    pub fn of_child(cell: u32, child: u32, gap: f32, distance: f32) -> Self {
        Self {
            key: 16 * u64::from(cell) + 8 + u64::from(child),
            gap,
            distance,
            aim: None,
        }
    }

    /// Returns the cell, and the finer cell if that is asked for.
    pub fn place(&self) -> (u32, Option<u32>) {
        let child = (self.key & 8 != 0).then_some((self.key & 7) as u32);
        ((self.key / 16) as u32, child)
    }

    /// Orders requests, the most urgent first.
    pub(super) fn sort(all: &mut [Self]) {
        all.sort_unstable_by(|a, b| {
            let urgency = b.gap.total_cmp(&a.gap);
            urgency
                .then(a.distance.total_cmp(&b.distance))
                .then(a.key.cmp(&b.key))
        });
    }
}

/// Requests that no fill has taken yet.
#[derive(Debug, Default)]
pub(super) struct Requests(Mutex<FxHashMap<u64, PageRequest>>);

impl Requests {
    pub(super) fn add(&self, asked: &[PageRequest]) {
        if asked.is_empty() {
            return;
        }
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        for one in asked {
            let own = all.entry(one.key).or_insert(*one);
            if one.distance < own.distance {
                (own.distance, own.aim) = (one.distance, one.aim.or(own.aim));
            }
            own.gap = own.gap.max(one.gap);
        }
    }

    /// Returns the number of bricks that are asked for.
    pub(super) fn len(&self) -> usize {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).len()
    }

    /// Takes all requests, the most urgent first: by how much the resident brick is too coarse, then by distance.
    pub(super) fn take(&mut self) -> Vec<PageRequest> {
        let all = self.0.get_mut().unwrap_or_else(PoisonError::into_inner);
        let mut taken: Vec<PageRequest> = all.drain().map(|(_, request)| request).collect();
        PageRequest::sort(&mut taken);
        taken
    }
}
