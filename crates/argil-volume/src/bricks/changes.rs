//! Records what edits changed, for copies of the bricks elsewhere.

/// What edits changed since it was last taken: see [`Bricks::take_changes`](super::Bricks::take_changes).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BrickChanges {
    /// Bricks with new samples or materials, ascending. Indices beyond the last brick were removed.
    pub bricks: Vec<u32>,
    /// Slots of blocks with new cell words, ascending.
    pub slots: Vec<u32>,
    /// Whether [blocks](super::BlockTable) were added, removed, or became far.
    pub blocks: bool,
}

/// Changes that were not taken yet. Volumes that differ only in them are equal.
#[derive(Clone, Debug, Default)]
pub(crate) struct ChangeLog(BrickChanges);

impl PartialEq for ChangeLog {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// Entries that are kept before duplicates are removed.
const MANY: usize = 1 << 16;

fn note(all: &mut Vec<u32>, index: u32) {
    if all.len() >= MANY && all.len().is_power_of_two() {
        tidy(all);
    }
    all.push(index);
}

fn tidy(all: &mut Vec<u32>) {
    all.sort_unstable();
    all.dedup();
}

impl ChangeLog {
    pub(crate) fn brick(&mut self, brick: u32) {
        note(&mut self.0.bricks, brick);
    }

    pub(super) fn slot(&mut self, slot: u32) {
        note(&mut self.0.slots, slot);
    }

    pub(super) fn blocks(&mut self) {
        self.0.blocks = true;
    }

    /// Takes the changes for a number of bricks.
    pub(crate) fn take(&mut self, bricks: u32) -> BrickChanges {
        let mut taken = std::mem::take(&mut self.0);
        tidy(&mut taken.bricks);
        tidy(&mut taken.slots);
        taken.bricks.retain(|&brick| brick < bricks);
        taken
    }
}
