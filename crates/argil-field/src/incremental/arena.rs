//! Allocates ranges in the table of parameters.

use std::collections::HashMap;

/// The free and the written ranges of the table of parameters.
#[derive(Debug, Default)]
pub(super) struct Arena {
    /// Free ranges by length.
    free: HashMap<u32, Vec<u32>>,
    /// Ranges that this update wrote, each from one index to before another.
    pub written: Vec<(u32, u32)>,
}

impl Arena {
    /// Begins an update: nothing is written yet, and the given ranges are free.
    pub(super) fn begin(&mut self, free: impl Iterator<Item = (u32, u32)>) {
        self.written.clear();
        for (at, length) in free {
            self.free.entry(length).or_default().push(at);
        }
    }

    /// Stores words in the table. Returns their index.
    pub(super) fn put(&mut self, params: &mut Vec<f32>, words: &[f32]) -> u32 {
        let length = words.len() as u32;
        let at = match self.free.get_mut(&length).and_then(Vec::pop) {
            Some(at) => {
                params[at as usize..(at + length) as usize].copy_from_slice(words);
                at
            }
            None => {
                let at = params.len() as u32;
                params.extend_from_slice(words);
                at
            }
        };
        self.written.push((at, at + length));
        at
    }
}
