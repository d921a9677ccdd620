//! Which bricks edits have changed, for those who keep a copy of them elsewhere.

/// What edits have changed since it was last asked for: see [`Bricks::take_changes`](super::Bricks::take_changes).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BrickChanges {
    /// Bricks whose samples or materials are others now, ascending. Those that are behind the last brick are gone.
    pub bricks: Vec<u32>,
    /// Slots of blocks whose cells have other words now, ascending.
    pub slots: Vec<u32>,
    /// Whether [blocks](super::BlockTable) came, went, or are known to be far.
    pub blocks: bool,
}

/// What has changed and was not asked for. Volumes that differ in nothing else are equal.
#[derive(Clone, Debug, Default)]
pub(super) struct ChangeLog(BrickChanges);

impl PartialEq for ChangeLog {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// Notes that are kept before doubles are taken out.
const MANY: usize = 1 << 16;

fn note(all: &mut Vec<u32>, nth: u32) {
    if all.len() >= MANY && all.len().is_power_of_two() {
        tidy(all);
    }
    all.push(nth);
}

fn tidy(all: &mut Vec<u32>) {
    all.sort_unstable();
    all.dedup();
}

impl ChangeLog {
    pub(super) fn brick(&mut self, brick: u32) {
        note(&mut self.0.bricks, brick);
    }

    pub(super) fn slot(&mut self, slot: u32) {
        note(&mut self.0.slots, slot);
    }

    pub(super) fn blocks(&mut self) {
        self.0.blocks = true;
    }

    /// What there is of so many bricks.
    pub(super) fn take(&mut self, bricks: u32) -> BrickChanges {
        let mut taken = std::mem::take(&mut self.0);
        tidy(&mut taken.bricks);
        tidy(&mut taken.slots);
        taken.bricks.retain(|&brick| brick < bricks);
        taken
    }
}
