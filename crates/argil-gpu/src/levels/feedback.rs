//! What rays used of levels, and what they lacked.
//!
//! *Practice.* The device marks bits: for each page its cells that were used, those whose brick is missing, and the
//! missing pages of its cells. So each request is there once, however many rays ask. The table is copied behind the
//! passes of the frame, and arrives with its picture.

use argil_abi::{FEEDBACK_HEAD, FEEDBACK_WORDS};
use argil_volume::{Levels, PageRequest};
use glam::Vec3;

/// Returns the bytes of the table for a number of pages.
pub(super) fn feedback_bytes(slots: usize) -> u64 {
    4 * (u64::from(FEEDBACK_HEAD) + u64::from(FEEDBACK_WORDS) * slots as u64)
}

/// From where a frame's rays asked, and for which voxels.
#[derive(Clone, Copy, Debug)]
pub(super) struct FrameSight {
    pub eye: Vec3,
    /// The edge of a voxel that a ray accepts, at length 1.
    pub size: f32,
}

/// Notes in the levels what a frame's table tells.
pub(super) fn note(levels: &Levels, sight: FrameSight, bytes: &[u8]) {
    let words: Vec<u32> = bytes
        .as_chunks::<4>()
        .0
        .iter()
        .map(|&word| u32::from_le_bytes(word))
        .collect();
    let (head, rest) = words.split_at((FEEDBACK_HEAD as usize).min(words.len()));
    let pages = levels.pages().len();
    let (mut used, mut asked) = (Vec::new(), Vec::new());
    let marks = rest.chunks_exact(FEEDBACK_WORDS as usize).take(pages);
    for (slot, marks) in (0u32..).zip(marks) {
        if marks.iter().all(|&word| word == 0) {
            continue;
        }
        for cell in 0..8u32 {
            if marks[0] >> cell & 1 != 0 {
                used.push(8 * slot + cell);
            }
            let urgency = || levels.urgency(8 * slot + cell, sight.eye, sight.size);
            if marks[0] >> (8 + cell) & 1 != 0 {
                let (gap, distance) = urgency();
                asked.push(PageRequest::of_cell(8 * slot + cell, gap, distance));
            }
            let children = marks[1 + cell as usize / 4] >> (8 * (cell % 4)) & 255;
            for child in (0..8).filter(|child| children >> child & 1 != 0) {
                let (gap, distance) = urgency();
                asked.push(PageRequest::of_child(8 * slot + cell, child, gap, distance));
            }
        }
    }
    levels.begin_frame();
    levels.note(&used, &asked);
    if let [hits, coarse] = *head {
        levels.count_hits(u64::from(hits), u64::from(coarse));
    }
}
