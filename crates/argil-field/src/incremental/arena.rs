//! Places among the parameters that all operands share.

use std::collections::HashMap;

/// See the module's page.
#[derive(Debug, Default)]
pub(super) struct Arena {
    /// Stretches of the parameters that are free, by length.
    free: HashMap<u32, Vec<u32>>,
    /// Stretches of parameters that this update has written, each from one to before another.
    pub written: Vec<(u32, u32)>,
}

impl Arena {
    /// Begin an update: nothing is written yet, and stretches, by begin and length, are free.
    pub(super) fn begin(&mut self, free: impl Iterator<Item = (u32, u32)>) {
        self.written.clear();
        for (at, length) in free {
            self.free.entry(length).or_default().push(at);
        }
    }

    /// Put words among the parameters: where they begin.
    pub(super) fn put(&mut self, params: &mut Vec<f32>, own: &[f32]) -> u32 {
        let length = own.len() as u32;
        let at = match self.free.get_mut(&length).and_then(Vec::pop) {
            Some(at) => {
                params[at as usize..(at + length) as usize].copy_from_slice(own);
                at
            }
            None => {
                let at = params.len() as u32;
                params.extend_from_slice(own);
                at
            }
        };
        self.written.push((at, at + length));
        at
    }
}
